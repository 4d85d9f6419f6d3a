//! The sizing field: what the limits ask for at every place of a panel.
//!
//! Facets are shaped by it; whether they keep the limits is for the error bounder to prove.

use super::local_model::LocalModel;
use super::tuning::TUNING;
use crate::geom::{DVec2, Outline, Precision, Rect};
use crate::mesh::bound::deviation::{Triangle, largest_deviation};
use crate::mesh::bound::error_bound::Limits;
use crate::mesh::bound::flat_facet::gradient_of;
use crate::mesh::bound::imaging_problem::ImagingProblem;
use crate::mesh::bound::vertex::SurfaceVertex;
use crate::num::max_or_nan;
use crate::parallel;
use std::sync::Arc;

/// Node intervals per side of the table.
const CELLS: usize = TUNING.table_cells;

/// Share of a disc's radius within which the model is that of a place beside the centre.
const CENTRE: f64 = 1e-3;

/// Local models over a panel, interpolated between the nodes of a table, and the limits.
#[derive(Clone)]
pub(crate) struct SizingField {
    domain: Rect,
    table: Arc<Vec<LocalModel>>,
    pub(super) limits: Limits,
}

impl SizingField {
    /// The field over the part `domain` of a mirror.
    pub(crate) fn new(problem: &ImagingProblem, domain: Rect, limits: Limits) -> Self {
        let outline = &problem.mirror.outline;
        let nodes: Vec<DVec2> = domain.grid(CELLS, CELLS).map(|(q, _)| q).collect();
        let model = |&q: &DVec2| LocalModel::new(problem, into(outline, q), limits.precision);
        let table = Arc::new(parallel::map_slice(&nodes, 1, model));
        Self { domain, table, limits }
    }

    /// The field with other limits, or none if these are for another precision.
    pub(crate) fn with_limits(self, limits: Limits) -> Option<Self> {
        (self.limits.precision == limits.precision).then_some(Self { limits, ..self })
    }

    /// Whether there is a limit of the facet error.
    pub(crate) fn limits_image(&self) -> bool {
        self.limits.facet_mm.is_some()
    }

    /// The part of the mirror's chart that the field covers.
    pub(crate) fn domain(&self) -> Rect {
        self.domain
    }

    /// The centres of the table's cells, mm.
    pub(crate) fn cell_centres(&self) -> impl Iterator<Item = DVec2> {
        let (min, step) = (self.domain.min, self.domain.size() / CELLS as f64);
        (0..CELLS * CELLS).map(move |k| {
            min + step * DVec2::new((k % CELLS) as f64 + 0.5, (k / CELLS) as f64 + 0.5)
        })
    }

    /// The model at `q`.
    pub(crate) fn at(&self, q: DVec2) -> LocalModel {
        let last = CELLS as f64;
        let share = (q - self.domain.min) / self.domain.size() * last;
        let share = share.clamp(DVec2::ZERO, DVec2::splat(last));
        // Truncation is floor for what is not negative, and quicker.
        let [i, j] = share.to_array().map(|x| (x as usize).min(CELLS - 1));
        let f = share - DVec2::new(i as f64, j as f64);
        let k = j * (CELLS + 1) + i;
        let mut model = LocalModel::ZERO;
        model.add(&self.table[k], (1.0 - f.x) * (1.0 - f.y));
        model.add(&self.table[k + 1], f.x * (1.0 - f.y));
        model.add(&self.table[k + CELLS + 1], (1.0 - f.x) * f.y);
        model.add(&self.table[k + CELLS + 2], f.x * f.y);
        model
    }

    /// Oversize of a facet with edges `a` and `b`: its area over the one that the limits allow, without rounding.
    pub(crate) fn oversize(&self, model: &LocalModel, a: DVec2, b: DVec2) -> f64 {
        let Limits { chord_mm, facet_mm, .. } = self.limits;
        let by_chord =
            chord_mm.map_or(0.0, |limit| model.chord(a, b) / (limit - model.rounding_mm));
        let by_facet = facet_mm.map_or(0.0, |limit| model.facet_squared(a, b) / (limit * limit));
        by_chord.max(by_facet)
    }

    /// Oversize of a facet by the mirror's values at its vertices.
    pub(crate) fn oversize_by_vertices(&self, model: &LocalModel, t: [&SurfaceVertex; 3]) -> f64 {
        let Limits { chord_mm, facet_mm, precision } = self.limits;
        let q = t.map(|v| v.q);
        let by_chord = chord_mm.map_or(0.0, |limit| {
            let [ab, bc, ca] = Triangle::new(q).edge_curvatures(t.map(|v| v.gradient));
            largest_deviation(ab, bc, ca) * model.ray_per_h / (limit - model.rounding_mm)
        });
        let by_facet = facet_mm.map_or(0.0, |limit| {
            let shift = |h: [f64; 3]| {
                let flat = gradient_of(q, h);
                let of = |v: &SurfaceVertex| {
                    (model.image_per_gradient * (flat - v.gradient)).length_squared()
                };
                t.map(of).into_iter().fold(0.0, max_or_nan)
            };
            let exact = shift(t.map(|v| v.h));
            let largest = match precision {
                Precision::Single => max_or_nan(exact, shift(t.map(|v| v.h + v.rounding))),
                Precision::Double => exact,
            };
            largest / (limit * limit)
        });
        max_or_nan(
            max_or_nan(by_chord, by_facet),
            TUNING.model_share * self.oversize(model, q[1] - q[0], q[2] - q[0]),
        )
    }

    /// Factor by which a facet with edges `a` and `b` may be enlarged, rounding included.
    pub(crate) fn enlargement(&self, model: &LocalModel, a: DVec2, b: DVec2) -> f64 {
        let by_chord = self.limits.chord_mm.map_or(f64::INFINITY, |limit| {
            ((limit - model.rounding_mm) / model.chord(a, b)).sqrt()
        });
        // facet t + tilt / t <= limit
        let by_facet = self.limits.facet_mm.map_or(f64::INFINITY, |limit| {
            let facet = model.facet_squared(a, b).sqrt();
            let tilt = TUNING.likely_tilt * model.tilt(a, b);
            let root = (limit * limit - 4.0 * facet * tilt).max(0.0).sqrt();
            (limit + root) / (2.0 * facet)
        });
        by_chord.min(by_facet)
    }

    /// Factor by which the edge `d` may be enlarged.
    pub(crate) fn edge_enlargement(&self, model: &LocalModel, d: DVec2) -> f64 {
        let chord = model.hessian.times(d).dot(d).abs() / 8.0 * model.ray_per_h;
        let by_chord = self
            .limits
            .chord_mm
            .map_or(f64::INFINITY, |limit| ((limit - model.rounding_mm) / chord).sqrt());
        let image = (model.image_per_gradient * model.hessian.times(d)).length() / 2.0;
        by_chord.min(self.limits.facet_mm.map_or(f64::INFINITY, |limit| limit / image))
    }
}

/// The point of the outline that is nearest to `q`; not the very centre of a disc, where laws may have no derivative.
fn into(outline: &Outline, q: DVec2) -> DVec2 {
    let Outline::Ring { inner, outer } = *outline else { return q };
    let r = q.length();
    let clamped = r.clamp(inner.max(CENTRE * outer), outer);
    if r > 0.0 { q * (clamped / r) } else { DVec2::X * clamped }
}
