//! Machining: what a ball cutter on a raster makes of a mirror.
//!
//! # Definitions
//!
//! - The **ball** of radius R comes from above (+Z) and touches the mirror along **lines** that are
//!   straight in the plan (X, Y); neighbours are one **stepover** w apart there, which is w / cos of the slope on
//!   a mirror that slopes across them. (Of a program that spaces the *axes* of the tool by w the lines of
//!   contact are w / (1 + k R) apart on a mirror of curvature k: its scallops are lower on domes, higher in
//!   bowls.)
//! - Curvature is positive where the mirror bulges towards the tool.
//! - A **scallop** is what stays between two lines ([`Scallop`]). Its slope, not its height, moves pixels:
//!   the image moves by the derivative of the view's content by the slope ([`SurfaceAnalysis`]), in an orthographic
//!   camera's ray error 2 dp / (1 + |p|^2).
//! - The ball **fits** where the mirror is hollow by no more than 1/R in any direction, and on a folded mirror
//!   no nearer to a valley than where it touches both panels ([`Gouge`], [`Fillet`]).
//! - The **as-cut** surface is the lowest place of all balls of all lines ([`Passes`], [`as_cut_face`]).

mod as_cut_mesh;
mod closing;
mod cusps;
mod drop_cutter;
mod fillet;
mod gouge;
mod passes;
mod scallop;
mod surface_analysis;

pub use as_cut_mesh::{
    FaceLattice, ROWS, as_cut_face, bounding_corners, face_of_cut, facet_estimate, plan_outlines,
    rim_distances,
};
pub use drop_cutter::surface_on_face;
pub use fillet::{Fillet, clears_ridge, fillet_foot};
pub use gouge::{FLOOR_MM, Gouge};
pub use passes::{BallPath, BallPaths, MOST_POINTS, Passes};
pub use scallop::{BallRaster, Scallop};
pub use surface_analysis::{
    Extreme, RasterDirection, ScallopFigures, SurfaceAnalysis, TurnSpacing,
};

use crate::geom::DVec2;
use thiserror::Error;

/// Why a raster cannot be worked out.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MachiningError {
    /// A number that makes no sense.
    #[error("{option} must be {must}, found {found}")]
    Input {
        /// Which.
        option: &'static str,
        /// What it must be.
        must: String,
        /// What it is.
        found: f64,
    },
    /// Walls between panels.
    #[error(
        "a mirror of panels has walls between them, beside which a ball leaves material that is not foreseen here; have \
         each panel made apart, or give one view alone"
    )]
    Panels,
    /// A forming tool in the place of the mirror.
    #[error(
        "a {form} is cut along its own face, not along the mirror; leave part.form out for what a cutter makes of the mirror"
    )]
    Tool {
        /// The tool.
        form: &'static str,
    },
    /// Lines too far apart for the ball.
    #[error(
        "with a stepover of {stepover_mm} mm the lines are {apart_mm:.3} mm apart on the mirror at X {:.3} \
         mm, Y {:.3} mm, too far for a ball of {ball_mm} mm radius; take a smaller stepover or a larger ball",
        at.x, at.y
    )]
    Apart {
        /// Stepover, mm.
        stepover_mm: f64,
        /// Radius of the ball, mm.
        ball_mm: f64,
        /// Distance of the lines there, mm.
        apart_mm: f64,
        /// X and Y.
        at: DVec2,
    },
    /// The as-cut surface would have too many facets or points.
    #[error(
        "with a stepover of {stepover_mm} mm the as-cut surface takes about {count:.1e} {what}, too many; \
         {}leave the surface out (--no-as-cut)",
        least_mm.map_or(String::new(), |mm| format!("take a stepover of at least {mm} mm, or "))
    )]
    TooFine {
        /// Stepover, mm.
        stepover_mm: f64,
        /// How many.
        count: f64,
        /// Of what.
        what: &'static str,
        /// A stepover that will do, mm, if there is one.
        least_mm: Option<f64>,
    },
    /// A line leaves the mirror.
    #[error(
        "the mirror has no place over X {:.3} mm, Y {:.3} mm; turn the raster or take a smaller stepover",
        at.x, at.y
    )]
    Lost {
        /// X and Y.
        at: DVec2,
    },
    /// A place that no pass comes over.
    #[error(
        "no pass cuts the mirror at X {:.3} mm, Y {:.3} mm; take a smaller stepover or a smaller ball",
        at.x, at.y
    )]
    Uncut {
        /// X and Y.
        at: DVec2,
    },
}
