//! The low terms in which form errors are told: departures of one millimetre from peak to valley over a mirror.

use super::extent::extent;
use super::form_field::FormField;
use crate::geom::Outline;
use crate::mirror::Mirror;
use crate::tolerance_terms::{ErrorSourceRow, FormMeasure, Perturbation};

/// The low terms of a mirror: Legendre's over a rectangle, Zernike's over a disc or a ring.
#[derive(Debug, Clone)]
pub struct LowFormTerms {
    terms: Vec<(Perturbation, FormField)>,
}

impl LowFormTerms {
    /// The terms that are error sources of `mirror`.
    #[must_use]
    pub fn new(mirror: &Mirror) -> Self {
        let extent = extent(mirror);
        let round = matches!(mirror.outline, Outline::Ring { .. });
        let terms = ErrorSourceRow::of_form(round).filter_map(|row| {
            let term = row.perturbation.form_term()?;
            Some((row.perturbation, FormField::of_term(term, extent, FormMeasure::Pv)))
        });
        Self { terms: terms.collect() }
    }

    /// The error source of each term.
    pub fn terms(&self) -> impl Iterator<Item = Perturbation> {
        self.terms.iter().map(|(term, _)| *term)
    }

    /// The departure along Z of each term at X and Y, mm.
    pub fn heights(&self, at: [f64; 2]) -> impl Iterator<Item = f64> {
        self.terms.iter().map(move |(_, field)| field.at(at)[0])
    }
}
