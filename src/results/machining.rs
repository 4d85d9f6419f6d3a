//! What a ball cutter makes of a mirror, as JSON.

use super::{FileFacts, ProfileId, Reason, TraceFacts, Verdict};
use crate::machining::{Extreme, Fillet, RasterDirection, ScallopFigures};
use crate::num::stats::{Summary, or_null};
use serde::{Serialize, Serializer};

/// Machining of a mirror with a ball cutter: `machining.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MachiningReport {
    /// The version of the report's schema, whose rules hold for these keys too.
    pub schema: u32,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// Radius of the ball, mm.
    pub ball_mm: f64,
    /// Distance of the raster's lines in the plan, mm.
    pub stepover_mm: f64,
    /// Direction of the lines, from X towards Y, degrees.
    pub angle_deg: f64,
    /// The steepest place of the face, degrees from the horizontal plane.
    pub steepest_deg: Extreme,
    /// Least radius of curvature of hollow ground, mm; none where there is none.
    pub least_hollow_mm: Option<Extreme>,
    /// Where the ball does not fit.
    pub gouge: GougeFacts,
    /// What it leaves of a valley; none where there is none.
    pub fillet: Option<Fillet>,
    /// Scallops of the unpolished face, where the ball fits; none where it fits nowhere.
    #[serde(flatten, serialize_with = "or_nulls")]
    #[cfg_attr(test, schemars(with = "ScallopFigures"))]
    pub scallops: Option<ScallopFigures>,
    /// The designed mirror against the projection, pixels.
    #[serde(serialize_with = "or_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub design_pixel_error_px: Option<Summary>,
    /// Directions of the raster.
    pub best: BestFacts,
    /// Stepovers for the budgets that were given.
    pub budget: BudgetFacts,
    /// How deep the tool goes.
    pub reach: ReachFacts,
    /// What the part is cut from.
    pub stock: StockFacts,
    /// The as-cut part as the witness saw it; none when none was made.
    pub as_cut: Option<AsCutFacts>,
    /// The files written but for this one.
    pub files: Vec<FileFacts>,
    /// Pass or fail.
    pub verdict: Verdict,
    /// Reasons of a fail, each with figures; empty for a pass.
    pub reasons: Vec<Reason>,
    /// Other remarks; no part of the verdict.
    pub warnings: Vec<String>,
}

/// The figures, or the same keys without values.
fn or_nulls<S: Serializer>(
    figures: &Option<ScallopFigures>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match figures {
        Some(figures) => figures.serialize(serializer),
        None => {
            const KEYS: [&str; 6] = [
                "scallop_um",
                "slope_rms",
                "slope_max",
                "pixels",
                "pixels_unbounded",
                "pixel_error_px",
            ];
            serializer.collect_map(KEYS.map(|key| (key, ())))
        }
    }
}

/// Where the ball does not fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct GougeFacts {
    /// Whether it fits everywhere, in a valley too.
    pub fits: bool,
    /// Most that it leaves, um; 0 where it fits everywhere.
    pub left_max_um: f64,
    /// X and Y of the place where it leaves most, mm; null where it fits everywhere.
    pub at_mm: Option<[f64; 2]>,
    /// Share of the face's area in the plan where it leaves something.
    pub share: f64,
    /// Distance of the places that were looked at, mm.
    pub step_mm: f64,
}

/// The best directions of the raster.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BestFacts {
    /// For the root mean square of the pixel error; none without a projection.
    pub pixels: Option<RasterDirection>,
    /// For the height of the highest scallop.
    pub height: RasterDirection,
}

/// Budgets and the stepovers that keep them, at the raster's direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BudgetFacts {
    /// Pixel error that 95 % of the unpolished face may not exceed.
    pub p95_px: Option<f64>,
    /// The largest stepover for it, mm.
    pub stepover_for_px_mm: Option<f64>,
    /// Height that no scallop may exceed, um.
    pub scallop_um: Option<f64>,
    /// The largest stepover for it, mm.
    pub stepover_for_scallop_mm: Option<f64>,
}

/// How deep the tool goes from the mirror's highest place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ReachFacts {
    /// To the lowest place of the face, mm.
    pub face_mm: f64,
    /// To the foot of the wall around it, on the flat rim or the base, mm.
    pub wall_mm: f64,
}

/// The box that the part is cut from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct StockFacts {
    /// Along X, Y and Z, mm, with the allowance.
    pub size_mm: [f64; 3],
    /// What stands over the part on each side and on top, mm.
    pub allowance_mm: f64,
    /// Volume of the box, mm^3.
    pub volume_mm3: f64,
    /// Volume of the part, mm^3.
    pub part_mm3: f64,
    /// What is cut away, mm^3.
    pub removed_mm3: f64,
}

/// The as-cut part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AsCutFacts {
    /// Facets of its optical face.
    pub optical_triangles: usize,
    /// The witness: `pixel_error_px` against the projection, `facet_error_px` against the designed mirror, which
    /// is what the scallops do.
    pub trace: TraceFacts,
}
