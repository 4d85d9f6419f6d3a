//! The design stage: `Profile` -> `Mirror`, with what the design can and cannot do.

mod barrier;
mod basis;
mod best;
mod broyden;
mod cause;
mod conic;
mod facing;
mod facts;
mod given;
mod heights;
mod layout;
mod minimax;
mod mixing;
mod mounting;
mod remedy;
mod residual;
mod solve;
mod stock;
mod strip;
mod surface;
#[cfg(test)]
mod trial;

pub use best::SearchError;
pub use cause::{Cause, Goal, Trouble};
pub use facts::{Curl, Facts};
pub use mounting::Mounting;
pub use remedy::{Change, MOST_TRIALS, Remedy, Value};
pub use solve::SolveError;

use crate::geom::{Border, Outline};
use crate::mirror::Mirror;
use crate::optics::{Camera, ImagingTask, Target};
use crate::profile::{Method, Profile, SagGrid, Shape};
use broyden::Broyden;
use layout::{Plan, Ties};
use thiserror::Error;

/// A mirror, designed or given, with the picture it is meant to give and the camera that takes it.
#[derive(Debug, Clone)]
pub struct Design {
    /// The surface.
    pub mirror: Mirror,
    /// What the picture should show; a given mirror may be meant for nothing in particular.
    pub view: Option<ImagingTask>,
    /// The camera.
    pub camera: Camera,
    /// What the part has around the mirror.
    pub stock: Option<Border>,
    /// Where camera and target are, and how large the part is.
    pub mounting: Mounting,
    /// Figures of merit.
    pub facts: Facts,
}

impl Design {
    /// Volume of the part, mm^3, with true circles where a mesh has polygons.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let around = self.stock.as_ref().map(|stock| stock.volume(self.mirror.footprint()));
        self.mirror.volume() + around.unwrap_or(0.0)
    }

    /// How many holes go through the part.
    #[must_use]
    pub fn holes(&self) -> usize {
        self.stock.as_ref().map_or(0, |stock| stock.through().count())
    }
}

/// Why no mirror could be designed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DesignError {
    /// What is asked of the mirror, or of the picture in a given one, has no answer.
    #[error("{cause}; {remedy}")]
    Unsolved {
        /// Why.
        cause: Cause,
        /// What helps.
        remedy: Remedy,
    },
    /// A given conic is not the polynomial of any degree that is tried.
    #[error(
        "the conic is too steep at the outline's farthest point, {reach_mm:.4} mm from the axis, to \
         be represented (with degree {degree} it is missed by {error:.1e} of its height); take a \
         larger radius_mm or a conic closer to -1"
    )]
    Steep {
        /// Distance from the axis, mm.
        reach_mm: f64,
        /// The highest degree that is tried.
        degree: usize,
        /// What it misses, as a share of the conic's height.
        error: f64,
    },
    /// A grid of heights does not cover the mirror.
    #[error(
        "the grid of heights must cover the mirror, X from {} to {} and Y from {} to {} mm; it has \
         X from {} to {} and Y from {} to {} mm; give mirror.grid.file heights over all of it",
        outline[0][0], outline[0][1], outline[1][0], outline[1][1],
        grid[0][0], grid[0][1], grid[1][0], grid[1][1]
    )]
    BeyondGrid {
        /// Least and largest X and Y of the mirror.
        outline: [[f64; 2]; 2],
        /// Least and largest X and Y of the grid.
        grid: [[f64; 2]; 2],
    },
    /// A hole, a mark or rounded corners do not fit around the mirror.
    #[error("{message}; {hint}")]
    Border {
        /// What must hold and what was found.
        message: String,
        /// What to do about it.
        hint: String,
    },
    /// The grid of heights that the profile names was not handed over.
    #[error("the heights of {file} are needed for this mirror")]
    NoGrid {
        /// The file, as in the profile.
        file: String,
    },
}

impl From<Cause> for DesignError {
    fn from(cause: Cause) -> Self {
        Self::Unsolved { cause, remedy: Remedy::default() }
    }
}

/// By how much a last step changed something, in words where that is no number.
fn by(step: f64, unit: &str) -> String {
    match step.is_finite() {
        true => format!("{step:e}{unit}"),
        false => "more than numbers can say".into(),
    }
}

/// Rounds of solving and placing before giving up.
const MOST_ROUNDS: usize = 100;

/// Designs the mirror that `profile` asks for, or makes the one that it gives; `sag` is the content
/// of the file that a [`Shape::Grid`] names.
///
/// # Errors
/// [`DesignError`] when the problem has no answer in finite numbers, or a given mirror cannot be
/// represented or does not cover its outline.
pub fn design(profile: &Profile, sag: Option<&SagGrid>) -> Result<Design, DesignError> {
    designed(profile, sag).map_err(|error| match error {
        DesignError::Unsolved { cause, .. } => {
            let remedy = remedy::remedy(profile, sag, &cause);
            DesignError::Unsolved { cause, remedy }
        }
        other => other,
    })
}

/// [`design`] without a search for what helps.
fn designed(profile: &Profile, sag: Option<&SagGrid>) -> Result<Design, DesignError> {
    match &profile.shape {
        Shape::Designed(method) => {
            let (plan, mirror, facts) = settled(profile, method)?;
            finished(profile, plan.camera, Some(plan.view), mirror, facts)
        }
        Shape::Polynomial(polynomial) => given::polynomial(profile, polynomial),
        Shape::Grid { file } => {
            let sag = sag.ok_or_else(|| DesignError::NoGrid { file: file.clone() })?;
            given::grid(profile, sag)
        }
    }
}

/// Solves until the geometry that depends on the answer does not change any more. Repeating alone
/// runs away before near targets; Broyden's method learns from the last round how the answer
/// follows the geometry.
fn settled(profile: &Profile, method: &Method) -> Result<(Plan, Mirror, Facts), Cause> {
    let mut ties = guess(profile, method)?;
    let mut last_step_mm = f64::NAN;
    let mut learnt = Broyden::new(0.05 * profile.part.width_mm);
    for round in 1..=MOST_ROUNDS {
        let plan = Plan::new(profile, &ties)?.expect("a designed mirror has a projection");
        let (mirror, facts) =
            surface::solved(&plan, method).map_err(|cause| plan.hidden_rim().unwrap_or(cause))?;
        let found = ties.after(profile, &plan, &mirror);
        last_step_mm = found.distance(&ties);
        if last_step_mm <= 1e-13 * profile.part.width_mm {
            return Ok((plan, mirror, facts));
        }
        if !last_step_mm.is_finite() {
            return Err(Cause::Unsettled { rounds: round, last_step_mm });
        }
        let [inner_mm, origin_mm] = learnt.next(ties.to_array(), found.to_array());
        ties = Ties { inner_mm, origin_mm };
    }
    Err(Cause::Unsettled { rounds: MOST_ROUNDS, last_step_mm })
}

/// The geometry of the mirror for a target at infinity, which is near that for any other.
fn guess(profile: &Profile, method: &Method) -> Result<Ties, Cause> {
    let ties = Ties::new(profile);
    let Some(mut plan) = Plan::new(profile, &ties)? else { return Ok(ties) };
    let ring = matches!(plan.domain, Outline::Ring { .. });
    if !ring || plan.view.target == Target::Infinity {
        return Ok(ties);
    }
    plan.view.target = Target::Infinity;
    let (mirror, _) = surface::solved(&plan, method)?;
    Ok(ties.after(profile, &plan, &mirror))
}

/// Puts the part on its base and measures the design.
fn finished(
    profile: &Profile,
    mut camera: Camera,
    mut view: Option<ImagingTask>,
    mut mirror: Mirror,
    facts: Facts,
) -> Result<Design, DesignError> {
    let [lowest, highest] = heights::heights(&mirror);
    let lift = profile.part.base_mm - lowest;
    if !lift.is_finite() {
        return Err(Cause::NotFinite { what: "sag" }.into());
    }
    if let Some(at) = facing::back(&mirror, &camera) {
        return Err(Cause::Back { from_axis_mm: at.length() }.into());
    }
    mirror.chart.plane_mm += lift;
    camera.chart.plane_mm += lift;
    let facts = match &mut view {
        None => facts,
        Some(view) => {
            view.origin_mm += lift;
            facts.against(&mirror, &camera, view)?
        }
    };
    let stock = stock::around(profile, &mirror)?;
    let mounting = Mounting::new(&mirror, &camera, view.as_ref(), stock.as_ref(), highest + lift);
    Ok(Design { mirror, view, camera, stock, mounting, facts })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_without_a_number_are_told_in_words() {
        let fit = SolveError::NotConverged { steps: 25, last_step_mm: f64::NAN };
        let law = SearchError::NotConverged { steps: 9, last_step: f64::INFINITY };
        let place = Cause::Unsettled { rounds: 3, last_step_mm: f64::NAN };
        for text in [fit.to_string(), law.to_string(), place.to_string()] {
            assert!(text.contains("by more than numbers can say)"), "{text}");
        }
        let fit = SolveError::NotConverged { steps: 25, last_step_mm: 2.5e-3 };
        assert!(fit.to_string().ends_with("changed the mirror by 2.5e-3 mm)"), "{fit}");
    }
}
