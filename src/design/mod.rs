//! The design stage: `Profile` -> `Mirror`, with what the design can and cannot do.

mod anderson;
mod barrier_hessian;
mod basis;
mod blind_holes;
mod border;
mod broyden;
mod cause;
mod cavity;
mod conic;
mod faceted_target;
mod facts;
mod given;
mod heights;
mod layout;
mod least_curl_law;
mod least_error;
mod minimax;
mod mirror_point;
mod mounting;
mod obstacles;
mod panel_joint;
mod panels;
#[cfg(test)]
mod paper_mirrors;
mod remedy;
mod residual;
mod residual_sample;
mod rising_law;
mod solve;
mod straightness;
mod strip;
mod surface;
mod tool;
mod visibility;

pub use cause::{FailureCause, FitStage, LocalFailure};
pub use cavity::Cavity;
pub use facts::{CurlFacts, DesignFacts, DividingLineFacts, MapFacts};
pub use least_curl_law::LeastCurlError;
pub use least_error::{LeastError, SQUARE, WorstPart, own_errors_px};
pub use mirror_point::MirrorPoint;
pub use mounting::Mounting;
pub use remedy::{KeyChange, KeyValue, LesserError, MOST_TRIALS, Remedy, lesser_errors};
pub use solve::SolveError;
pub use straightness::Straightness;

use crate::forming::{FormingFault, FormingTool};
use crate::geom::{BlindHole, Border, Contour, DatumScheme, Obstacle, Outline, PartFeatures, Rect};
use crate::mirror::Mirror;
use crate::optics::{Camera, ImagingTask, Target};
use crate::profile::{Method, MethodKind, Profile, ProjectionSpec, ShapeSpec};
use broyden::Broyden;
use layout::{DesignProblem, SelfConsistentGeometry};
use std::sync::Arc;
use thiserror::Error;

/// A mirror, designed or given, with the picture it is meant to give and the camera that takes it.
#[derive(Debug, Clone)]
pub struct Design {
    /// What is asked.
    pub profile: Arc<Profile>,
    /// The surface.
    pub mirror: Mirror,
    /// The imaging task; a given mirror may have none.
    pub view: Option<ImagingTask>,
    /// The camera.
    pub camera: Camera,
    /// The border around the mirror.
    pub border: Option<Border>,
    /// Holes from the base that end below the mirror or the border, each of them with the material above it that it needs.
    pub blind_holes: Vec<BlindHole>,
    /// The room inside a hollow part.
    pub cavity: Option<Cavity>,
    /// The tool that is made in the part's place, on which a piece with the mirror alone is formed; none for the part
    /// itself.
    pub tool: Option<FormingTool>,
    /// Places of camera and target, and the size of the part.
    pub mounting: Mounting,
    /// What stands beside the mirror and may hide what rays would show: the profile's obstacles in its order and
    /// last, where it has one, the camera's body; mm of the part's frame.
    pub obstacles: Vec<Obstacle>,
    /// Figures of merit; of a mirror that was not measured those of its fit alone.
    pub facts: DesignFacts,
}

impl Design {
    /// Volume of the part without its cavity, mm^3, with true circles where a mesh has polygons.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let volume = |border: &Border| border.volume(self.mirror.footprint(border.top_mm));
        let around = self.border.as_ref().map(volume);
        self.mirror.volume() + around.unwrap_or(0.0) - self.features().blind_mm3()
    }

    /// The rectangle along X and Y around the part, mm.
    #[must_use]
    pub fn plan_bounds(&self) -> Rect {
        border::plan_bounds(&self.mirror, self.border.as_ref())
    }

    /// The faces of the part from which a shop sets it up.
    #[must_use]
    pub fn datums(&self) -> DatumScheme {
        let half = 0.5 * border::extent(&self.mirror, 0.0).size();
        let walls = match self.mirror.outline {
            Outline::Ring { .. } => Some(Contour::Circle { radius_mm: half.x }),
            // Under a pinhole walls are upright below curves, or lean.
            Outline::Rect(_) => {
                self.mirror.chart.is_plan().then_some(Contour::Rect { half, corner_mm: 0.0 })
            }
        };
        DatumScheme::new(self.border.as_ref(), walls)
    }

    /// The same mirror under a camera with so many columns and rows, in as wide a frame.
    #[must_use]
    pub fn with_pixels(&self, pixels: [u32; 2]) -> Self {
        Self { camera: self.camera.with_pixels(pixels), ..self.clone() }
    }

    /// The same with all figures of merit.
    fn measured(mut self) -> Result<Self, DesignError> {
        if let Some(view) = &self.view {
            self.facts = self.facts.against(&self.mirror, &self.camera, view)?;
        }
        Ok(self)
    }

    /// The imaging task by which the displacement of the picture by facets is bounded; none where it has no bounds, or
    /// nothing is wanted.
    #[must_use]
    pub fn bounded_view(&self) -> Option<&ImagingTask> {
        self.view.as_ref().filter(|view| view.has_bounds())
    }

    /// The least error that any single mirror has for this camera and picture; none without a projection.
    fn least_error(&self) -> Option<LeastError> {
        LeastError::of(&self.mirror, &self.camera, self.view.as_ref()?)
    }

    /// Border, holes, a cavity's floor and volume, mm^3, of the body that files hold: the tool's, or the part's.
    #[must_use]
    pub fn made_body(&self) -> (PartFeatures<'_>, f64) {
        match &self.tool {
            Some(tool) => (tool.features(), tool.volume_mm3),
            None => {
                let hollow_mm3 = self.cavity.as_ref().map_or(0.0, |cavity| cavity.volume_mm3);
                let floor = self.cavity.as_ref().map(|cavity| &cavity.floor);
                (PartFeatures { floor, ..self.features() }, self.volume() - hollow_mm3)
            }
        }
    }

    /// The same without a tool: of the part, or of what is formed.
    #[must_use]
    pub fn formed(&self) -> Self {
        Self { tool: None, ..self.clone() }
    }

    /// Border and blind holes of the part.
    #[must_use]
    pub fn features(&self) -> PartFeatures<'_> {
        let (border, blind_holes) = (self.border.as_ref(), &self.blind_holes[..]);
        PartFeatures { border, blind_holes, floor: None }
    }

    /// Number of holes through the part.
    #[must_use]
    pub fn holes(&self) -> usize {
        self.features().through()
    }
}

/// Reason why no mirror could be designed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DesignError {
    /// The design problem, or the picture in a given mirror, has no solution.
    #[error("{cause}; {remedy}")]
    Unsolved {
        /// The cause.
        cause: FailureCause,
        /// The remedy.
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
        /// Its error, as a share of the conic's height.
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
    /// No sheet follows the mirror.
    #[error(transparent)]
    Forming(#[from] FormingFault),
    /// A hole, a mark or rounded corners do not fit around the mirror.
    #[error("{message}; {hint}")]
    Border {
        /// The rule, and the value found.
        message: String,
        /// The remedy.
        hint: String,
    },
    /// The grid of heights that the profile names was not handed over.
    #[error("the heights of {file} are needed for this mirror")]
    NoGrid {
        /// The file, as in the profile.
        file: String,
    },
}

impl From<FailureCause> for DesignError {
    fn from(cause: FailureCause) -> Self {
        Self::Unsolved { cause, remedy: Remedy::default() }
    }
}

/// Size of a last step in words.
fn by(step: f64, unit: &str) -> String {
    match step.is_finite() {
        true => format!("{step:e}{unit}"),
        false => "more than numbers can say".into(),
    }
}

/// Rounds of solving and placing before giving up.
const MOST_ROUNDS: usize = 100;

/// Designs the mirror that `profile` asks for, or makes the one that it gives.
///
/// # Errors
/// [`DesignError`] when the problem has no answer in finite numbers, or a given mirror cannot be
/// represented or does not cover its outline.
pub fn design(profile: &Profile) -> Result<Design, DesignError> {
    let mut design = design_alone(profile)?;
    design.facts.least_error = design.least_error();
    Ok(design)
}

/// [`design`] without the least error of any other mirror, which takes as long as the mirror.
///
/// # Errors
/// As of [`design`].
pub fn design_alone(profile: &Profile) -> Result<Design, DesignError> {
    try_design(profile).map_err(|error| remedied(profile, error))
}

/// [`design`] without the figures that compare the mirror with what it is to show, which take longer than a
/// mirror of low degree. A mirror whose errors are not finite is none for [`design`], and may be one here.
///
/// # Errors
/// [`DesignError`] when the problem has no answer in finite numbers, or a given mirror cannot be
/// represented or does not cover its outline.
pub fn design_unmeasured(profile: &Profile) -> Result<Design, DesignError> {
    solve(profile).map_err(|error| remedied(profile, error))
}

/// The least error that any single mirror has for the camera and the picture of `profile`, before its mirror is designed;
/// none without a projection. Heights, which matter before near targets alone, are those of the vector field's fit.
///
/// # Errors
/// [`DesignError`] when that fit, or a given mirror, has no answer.
pub fn least_error(profile: &Profile) -> Result<Option<LeastError>, DesignError> {
    let mut profile = profile.clone();
    if let ShapeSpec::Designed(method) = &mut profile.shape {
        *method = Method { kind: MethodKind::VectorField, minimax: false, ..*method };
    }
    Ok(solve(&profile)?.least_error())
}

/// The error with what helps.
fn remedied(profile: &Profile, error: DesignError) -> DesignError {
    match error {
        DesignError::Unsolved { cause, .. } => {
            let remedy = remedy::remedy(profile, &cause);
            DesignError::Unsolved { cause, remedy }
        }
        other => other,
    }
}

/// [`design`] without a search for what helps.
fn try_design(profile: &Profile) -> Result<Design, DesignError> {
    solve(profile)?.measured()
}

/// The mirror on its base, not measured.
fn solve(profile: &Profile) -> Result<Design, DesignError> {
    match &profile.shape {
        ShapeSpec::Designed(method) => {
            if let Some(ProjectionSpec::Panels(wanted)) = &profile.projection {
                let found = panels::solved(profile, wanted, method)?;
                return place_on_base(
                    profile,
                    found.camera,
                    Some(found.view),
                    found.mirror,
                    found.facts,
                );
            }
            let (problem, mirror, facts) = solve_self_consistently(profile, method)?;
            place_on_base(profile, problem.camera, Some(problem.view), mirror, facts)
        }
        ShapeSpec::Polynomial(polynomial) => given::polynomial(profile, polynomial),
        ShapeSpec::Grid { file } => {
            let heights = profile.heights.as_ref();
            let heights = heights.ok_or_else(|| DesignError::NoGrid { file: file.clone() })?;
            given::grid(profile, heights)
        }
    }
}

/// Solves until the geometry that depends on the answer does not change any more. Repeating alone
/// runs away before near targets; Broyden's method learns from the last round how the answer
/// follows the geometry.
fn solve_self_consistently(
    profile: &Profile,
    method: &Method,
) -> Result<(DesignProblem, Mirror, DesignFacts), FailureCause> {
    let mut geometry = initial_geometry(profile, method)?;
    let mut last_step_mm = f64::NAN;
    let mut learnt = Broyden::new(0.05 * profile.part.width_mm);
    for round in 1..=MOST_ROUNDS {
        let problem =
            DesignProblem::new(profile, &geometry)?.expect("a designed mirror has a projection");
        faceted_target::check(profile, &problem)?;
        let (mirror, facts) = surface::solved(&problem, method)
            .map_err(|cause| problem.occluded_rim().unwrap_or(cause))?;
        let found = geometry.updated(profile, &problem, &mirror);
        last_step_mm = found.distance(&geometry);
        if last_step_mm <= 1e-13 * profile.part.width_mm {
            return Ok((problem, mirror, facts));
        }
        if !last_step_mm.is_finite() {
            return Err(FailureCause::NotSelfConsistent { rounds: round, last_step_mm });
        }
        let [inner_mm, origin_mm] = learnt.next(geometry.to_array(), found.to_array());
        geometry = SelfConsistentGeometry { inner_mm, origin_mm };
    }
    Err(FailureCause::NotSelfConsistent { rounds: MOST_ROUNDS, last_step_mm })
}

/// The geometry of the mirror for a target at infinity, which is near that for any other.
fn initial_geometry(
    profile: &Profile,
    method: &Method,
) -> Result<SelfConsistentGeometry, FailureCause> {
    let geometry = SelfConsistentGeometry::initial(profile);
    let Some(mut problem) = DesignProblem::new(profile, &geometry)? else { return Ok(geometry) };
    let ring = matches!(problem.domain, Outline::Ring { .. });
    if !ring || problem.view.target == Target::Infinity {
        return Ok(geometry);
    }
    problem.view.target = Target::Infinity;
    let (mirror, _) = surface::solved(&problem, method)?;
    Ok(geometry.updated(profile, &problem, &mirror))
}

/// Puts the part on its base.
fn place_on_base(
    profile: &Profile,
    mut camera: Camera,
    mut view: Option<ImagingTask>,
    mut mirror: Mirror,
    facts: DesignFacts,
) -> Result<Design, DesignError> {
    let [min_height, max_height] = heights::height_range(&mirror);
    let lift = profile.part.base_mm - min_height;
    if !lift.is_finite() {
        return Err(FailureCause::NotFinite { what: "sag" }.into());
    }
    if let Some(at) = visibility::back_facing_point(&mirror, &camera) {
        return Err(FailureCause::BackFacing { from_axis_mm: at.length() }.into());
    }
    mirror.chart.plane_mm += lift;
    camera.chart.plane_mm += lift;
    if let Some(view) = &mut view {
        view.origin_mm += lift;
    }
    if let Some(view) = &view {
        faceted_target::check_mirror(&mirror, view)?;
    }
    let tool = tool::wanted(profile, &mirror)?;
    let border = if tool.is_some() { None } else { border::around(profile, &mirror)? };
    let top_mm = max_height + lift;
    let blind_holes = match tool {
        Some(_) => Vec::new(),
        None => blind_holes::below(profile, &mirror, border.as_ref(), top_mm)?,
    };
    let has_land_holes = border.as_ref().is_some_and(|border| border.land.is_some());
    let cavity = cavity::below(profile, &mirror, &blind_holes, has_land_holes)?;
    let mounting = Mounting::new(&mirror, &camera, view.as_ref(), border.as_ref(), top_mm);
    let obstacles = obstacles::placed(profile, &camera, &mounting);
    let profile = Arc::new(profile.clone());
    Ok(Design {
        profile,
        mirror,
        view,
        camera,
        border,
        blind_holes,
        cavity,
        tool,
        mounting,
        obstacles,
        facts,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_without_a_number_are_told_in_words() {
        let fit = SolveError::NotConverged { steps: 25, last_step_mm: f64::NAN };
        let law = LeastCurlError::NotConverged { steps: 9, last_step: f64::INFINITY };
        let place = FailureCause::NotSelfConsistent { rounds: 3, last_step_mm: f64::NAN };
        for text in [fit.to_string(), law.to_string(), place.to_string()] {
            assert!(text.contains("by more than numbers can say)"), "{text}");
        }
        let fit = SolveError::NotConverged { steps: 25, last_step_mm: 2.5e-3 };
        assert!(fit.to_string().ends_with("changed the mirror by 2.5e-3 mm)"), "{fit}");
    }
}
