//! The design stage: `Profile` -> `Mirror`, with what the design can and cannot do.

mod barrier;
mod basis;
mod best;
mod broyden;
mod conic;
mod facing;
mod facts;
mod given;
mod layout;
mod lowest;
mod minimax;
mod mixing;
mod residual;
mod solve;
mod stock;
mod strip;
mod surface;
#[cfg(test)]
mod trial;

pub use best::SearchError;
pub use facts::{Curl, Facts};
pub use solve::SolveError;

use crate::geom::{Outline, Stock};
use crate::mirror::Mirror;
use crate::optics::{Camera, Target, View};
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
    pub view: Option<View>,
    /// The camera.
    pub camera: Camera,
    /// What the part has around the mirror.
    pub stock: Option<Stock>,
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
    /// The fit has no unique answer, or was not found.
    #[error("the fit of degree {degree} has no answer: {source}; {remedy}")]
    Fit {
        /// Degree asked for.
        degree: usize,
        /// The solver's account.
        source: SolveError,
        /// What may help.
        remedy: &'static str,
    },
    /// The law of least curl was not found.
    #[error(
        "the law of least curl was not found: {0}; move the camera or the target further from the \
         mirror, bring the elevations further from +-90 degrees, or choose another law"
    )]
    Law(SearchError),
    /// Rows or elevations of a table differ by no more than rounding.
    #[error("the rows and elevations of the table are too close to each other; leave some out")]
    Table,
    /// The place of the mirror in its target surface was not found.
    #[error(
        "the place of the mirror before its target did not settle in {rounds} rounds (the last \
         moved it by {}); move the target further away",
        by(*last_step_mm, " mm")
    )]
    Unsettled {
        /// Rounds of solving and placing.
        rounds: usize,
        /// Last change, mm.
        last_step_mm: f64,
    },
    /// What is wanted lies behind the mirror: it would have to turn its back to the camera.
    #[error(
        "the mirror turns its back to the camera {from_axis_mm:.3} mm from the axis: there what it \
         should show lies behind it, seen from the camera; show less far down, or move the camera \
         away"
    )]
    Back {
        /// Where, mm.
        from_axis_mm: f64,
    },
    /// Filling the frame asks for elevations that there are not.
    #[error(
        "filling the frame takes the law beyond +-90 degrees of elevation, to {beyond:.3} of its \
         image coordinate where {most:.3} is the pole; leave fill_frame out, widen azimuth_deg, or \
         take a frame that is less high for its width"
    )]
    Overfilled {
        /// Image coordinate at the rim, paper's units.
        beyond: f64,
        /// That of the pole.
        most: f64,
    },
    /// The numbers leave the range of double precision.
    #[error(
        "the mirror's {what} is not finite; bring the elevations further from +-90 degrees, or \
         the target further from the mirror"
    )]
    NotFinite {
        /// Which quantity.
        what: &'static str,
    },
    /// A given conic is not the polynomial of any degree that is tried.
    #[error(
        "the conic is too steep at the outline's farthest point, {reach_mm:.4} mm from the axis, to \
         be represented; take a larger radius_mm, a conic closer to -1 or a smaller part (with \
         degree {degree} it is missed by {error:.1e} of its height)"
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
         X from {} to {} and Y from {} to {} mm",
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
fn settled(profile: &Profile, method: &Method) -> Result<(Plan, Mirror, Facts), DesignError> {
    let mut ties = guess(profile, method)?;
    let mut last_step_mm = f64::NAN;
    let mut learnt = Broyden::new(0.05 * profile.part.width_mm);
    for round in 1..=MOST_ROUNDS {
        let plan = Plan::new(profile, &ties)?.expect("a designed mirror has a projection");
        let (mirror, facts) = surface::solved(&plan, method)?;
        let found = ties.after(profile, &plan, &mirror);
        last_step_mm = found.distance(&ties);
        if last_step_mm <= 1e-13 * profile.part.width_mm {
            return Ok((plan, mirror, facts));
        }
        if !last_step_mm.is_finite() {
            return Err(DesignError::Unsettled { rounds: round, last_step_mm });
        }
        let [inner_mm, origin_mm] = learnt.next(ties.to_array(), found.to_array());
        ties = Ties { inner_mm, origin_mm };
    }
    Err(DesignError::Unsettled { rounds: MOST_ROUNDS, last_step_mm })
}

/// The geometry of the mirror for a target at infinity, which is near that for any other.
fn guess(profile: &Profile, method: &Method) -> Result<Ties, DesignError> {
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
    mut view: Option<View>,
    mut mirror: Mirror,
    facts: Facts,
) -> Result<Design, DesignError> {
    let lift = profile.part.base_mm - lowest::lowest(&mirror);
    if !lift.is_finite() {
        return Err(DesignError::NotFinite { what: "sag" });
    }
    if let Some(at) = facing::back(&mirror, &camera) {
        return Err(DesignError::Back { from_axis_mm: at.length() });
    }
    mirror.chart.plane_mm += lift;
    camera.chart.plane_mm += lift;
    let facts = match &mut view {
        None => facts,
        Some(view) => {
            view.origin_mm += lift;
            facts
                .against(&mirror, &camera, view)
                .ok_or(DesignError::NotFinite { what: "image error" })?
        }
    };
    let stock = stock::around(profile, &mirror)?;
    Ok(Design { mirror, view, camera, stock, facts })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_without_a_number_are_told_in_words() {
        let fit = SolveError::NotConverged { steps: 25, last_step_mm: f64::NAN };
        let law = SearchError::NotConverged { steps: 9, last_step: f64::INFINITY };
        let place = DesignError::Unsettled { rounds: 3, last_step_mm: f64::NAN };
        for text in [fit.to_string(), law.to_string(), place.to_string()] {
            assert!(text.contains("by more than numbers can say)"), "{text}");
        }
        let fit = SolveError::NotConverged { steps: 25, last_step_mm: 2.5e-3 };
        assert!(fit.to_string().ends_with("changed the mirror by 2.5e-3 mm)"), "{fit}");
    }
}
