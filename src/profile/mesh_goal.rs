//! How closely facets must follow the mirror.

use crate::num::units::{Px, Um};

/// What a mesh must keep: limits, or a number of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeshGoal {
    /// One limit or two, of which the stricter rules at each place.
    Limits {
        /// Largest height between a facet and the mirror.
        chord: Option<Um>,
        /// Largest pixel error that the flatness of a facet may cause.
        facet: Option<Px>,
    },
    /// As closely as so many triangles of the whole part allow.
    Budget(usize),
}

impl MeshGoal {
    /// Limits in their units: at least one.
    pub fn limits(chord_um: Option<f64>, facet_px: Option<f64>) -> Self {
        Self::Limits { chord: chord_um.map(Um), facet: facet_px.map(Px) }
    }

    /// The chord limit, um; none where there is none.
    pub fn chord_um(self) -> Option<f64> {
        match self {
            Self::Limits { chord, .. } => chord.map(|um| um.0),
            Self::Budget(_) => None,
        }
    }

    /// The facet limit, pixels; none where there is none.
    pub fn facet_px(self) -> Option<f64> {
        match self {
            Self::Limits { facet, .. } => facet.map(|px| px.0),
            Self::Budget(_) => None,
        }
    }

    /// The number of triangles; none where limits rule.
    pub fn max_triangles(self) -> Option<usize> {
        match self {
            Self::Limits { .. } => None,
            Self::Budget(triangles) => Some(triangles),
        }
    }
}
