//! What a check can find, in words.

use crate::geom::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A defect of a mesh as a boundary of a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Defect {
    /// Only one facet has this edge.
    OpenEdge {
        /// That facet.
        facet: usize,
        /// The edge's ends.
        edge: [DVec3; 2],
    },
    /// More than two facets have this edge.
    NonManifoldEdge {
        /// One of them.
        facet: usize,
        /// The edge's ends.
        edge: [DVec3; 2],
        /// How many.
        facets: usize,
    },
    /// Two facets run along this edge in the same direction.
    InconsistentEdge {
        /// One of them.
        facet: usize,
        /// The edge's ends.
        edge: [DVec3; 2],
    },
    /// The facets at this vertex form more than one fan.
    NonManifoldVertex {
        /// A facet there.
        facet: usize,
        /// The vertex.
        at: DVec3,
    },
    /// The facet has no area, or a coordinate that is not a number.
    DegenerateFacet {
        /// The facet.
        facet: usize,
        /// One of its corners.
        at: DVec3,
    },
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |v: DVec3| format!("({}, {}, {})", v.x, v.y, v.z);
        match *self {
            Self::OpenEdge { facet, edge: [a, b] } => {
                write!(f, "open: only facet {facet} has the edge {}-{}", place(a), place(b))
            }
            Self::NonManifoldEdge { facet, edge: [a, b], facets } => write!(
                f,
                "not manifold: facet {facet} and {} more share the edge {}-{}",
                facets - 1,
                place(a),
                place(b)
            ),
            Self::InconsistentEdge { facet, edge: [a, b] } => write!(
                f,
                "not oriented: facet {facet} and its neighbour run the same way along {}-{}",
                place(a),
                place(b)
            ),
            Self::NonManifoldVertex { facet, at } => {
                write!(f, "not manifold: facet {facet} touches another fan at vertex {}", place(at))
            }
            Self::DegenerateFacet { facet, at } => {
                write!(f, "degenerate: facet {facet} at {} has no area", place(at))
            }
        }
    }
}

/// Boundary of a mesh that is not closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OpenBoundary {
    /// Edges without a second facet.
    pub edges: usize,
    /// Loops that they form; those that meet in a vertex count as one.
    pub loops: usize,
}

/// Result of checking a mesh as a boundary of a solid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SolidCheck {
    /// Every edge has a facet on both sides.
    pub closed: bool,
    /// Neighbours agree on what is outside.
    pub oriented: bool,
    /// No edge or vertex joins more than one sheet.
    pub manifold: bool,
    /// Its rims, where it is not closed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub open: Option<OpenBoundary>,
    /// Pieces that hang together by vertices.
    pub components: usize,
    /// Vertices - edges + facets: 2 for a body without handles, 2 less for each through hole.
    pub euler: i64,
    /// How many through holes there are to be.
    #[serde(skip)]
    pub holes: usize,
    /// Enclosed volume, mm^3; negative when inside out.
    pub volume_mm3: f64,
    /// The first few defects.
    #[serde(skip)]
    pub defects: Vec<Defect>,
    /// How many defects there are.
    #[serde(skip)]
    pub defect_count: usize,
}

impl SolidCheck {
    /// The check of a body that is to have so many through holes.
    #[must_use]
    pub fn through(self, holes: usize) -> Self {
        Self { holes, ..self }
    }

    /// Whether the mesh is one solid body with no other handles than the holes it is to have.
    #[must_use]
    pub fn is_solid(&self) -> bool {
        self.reasons().is_empty()
    }

    /// Every reason why it is not, readable.
    #[must_use]
    pub fn reasons(&self) -> Vec<String> {
        let mut reasons: Vec<String> = self.defects.iter().map(ToString::to_string).collect();
        if self.defect_count > self.defects.len() {
            reasons.push(format!("and {} more defects", self.defect_count - self.defects.len()));
        }
        if self.components != 1 {
            reasons.push(format!("{} separate pieces instead of one", self.components));
        }
        let wanted = 2 - 2 * self.holes as i64;
        if reasons.is_empty() && self.euler != wanted {
            let why = match self.holes {
                0 => "it has handles".to_owned(),
                holes => format!("its through holes are not {holes}"),
            };
            let euler = self.euler;
            reasons.push(format!("Euler characteristic {euler} instead of {wanted}: {why}"));
        }
        if !(self.volume_mm3 > 0.0) {
            reasons.push(format!("volume {} mm^3: inside out or empty", self.volume_mm3));
        }
        reasons
    }
}
