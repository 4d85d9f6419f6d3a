//! The cavity of a hollow part.

use crate::design::Design;
use crate::geom::Hole;
use serde::{Deserialize, Serialize};

/// The cavity of a hollow part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CavityFacts {
    /// Least thickness of the material around it, mm: of base and walls, and square to the mirror.
    pub wall_mm: f64,
    /// What its roof is below the mirror along Z, mm: the largest thickness under the mirror.
    pub roof_mm: f64,
    /// Volume of the cavity and its drains, mm^3.
    pub volume_mm3: f64,
    /// Volume of the material over that of the same part without a cavity.
    pub material_share: f64,
    /// The drains through its floor.
    pub drains: Vec<DrainFacts>,
}

/// A drain of a cavity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct DrainFacts {
    /// X and Y of its axis, mm.
    pub at_mm: [f64; 2],
    /// Its diameter, mm.
    pub diameter_mm: f64,
}

impl CavityFacts {
    /// That of the part of `design`; none of a solid one.
    pub(crate) fn of(design: &Design) -> Option<Self> {
        let cavity = design.cavity.as_ref()?;
        let drain = |drain: &Hole| DrainFacts {
            at_mm: drain.at.to_array(),
            diameter_mm: drain.diameter_mm,
        };
        Some(Self {
            wall_mm: cavity.wall_mm,
            roof_mm: cavity.drop_mm,
            volume_mm3: cavity.volume_mm3,
            material_share: 1.0 - cavity.volume_mm3 / design.volume(),
            drains: cavity.floor.drains.iter().map(drain).collect(),
        })
    }
}
