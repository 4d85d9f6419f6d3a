//! The finest mesh of a given number of triangles.
//!
//! The number falls as the limit is loosened, nearly as a power of it. Forecasts aim; meshes tell by how much the
//! forecasts are off, and the next aim allows for that.

mod bracket;
mod tuning;

use super::bound::error_bound::Limits;
use super::error::MeshError;
use super::face::{Face, FaceForecast};
use super::mesher::{Mesher, SmoothPanels};
use super::sizing::optimum::Optimum;
use crate::geom::{Chart, Precision};
use crate::mirror::Mirror;
use crate::optics::ImagingTask;
use bracket::{Bracket, PowerLaw};
use tuning::TUNING;

pub use tuning::LEAST_USED;

/// The number of triangles that closing a face adds, which is not for the mesh to know.
pub trait ClosureCount {
    /// The number for a face that is foreseen.
    fn foreseen(&self, forecast: &FaceForecast) -> f64;
    /// The number for a face that is made.
    fn counted(&self, face: &Face) -> usize;
}

/// A triangle budget, and the imaging problem that it is for.
pub struct Budget<'a> {
    /// The mirror.
    pub mirror: &'a Mirror,
    /// The camera's chart.
    pub camera: &'a Chart,
    /// The imaging task: with a view the budget is spent on the facet error, else on the chord error.
    pub view: Option<&'a ImagingTask>,
    /// Precision of the file.
    pub precision: Precision,
    /// Most triangles of the closed part.
    pub triangles: usize,
    /// The number of triangles that closing adds.
    pub closing: &'a dyn ClosureCount,
}

/// Limits of a mesh, and its forecast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshPlan {
    /// The limits; of a budget, one.
    pub limits: Limits,
    /// The forecast of a mesh within them.
    pub forecast: FaceForecast,
}

/// The loose limit of the fewest triangles, and how many these are.
type FewestTriangles = Result<(MeshPlan, f64), MeshError>;

/// The meshes that were made for a budget.
struct BudgetSearch<'a> {
    budget: &'a Budget<'a>,
    mesher: Mesher<'a>,
    bracket: Bracket,
    /// The mesh of the least error among those that fit.
    best: Option<Face>,
    /// Number of limits that were refused.
    refusals: usize,
    /// The fewest triangles of any mesh.
    least: usize,
    /// Limits whose meshes did not fit, mm, and the numbers of their triangles.
    too_fine: Vec<(f64, usize)>,
}

impl<'a> BudgetSearch<'a> {
    fn new(budget: &'a Budget<'a>, panels: &'a SmoothPanels) -> Self {
        Self {
            budget,
            mesher: budget.mesher(panels),
            bracket: budget.bracket(),
            best: None,
            refusals: 0,
            least: usize::MAX,
            too_fine: Vec::new(),
        }
    }

    /// The number of triangles of the mesh within `limit`; infinite where it is refused and a looser limit may help.
    fn make(&mut self, limit: f64) -> Result<f64, MeshError> {
        let (budget, most) = (self.budget, self.budget.triangles);
        let count = match self.mesher.mesh(budget.limits(limit)) {
            Ok(face) => {
                let count = face.mesh.triangles.len() + budget.closing.counted(&face);
                self.least = self.least.min(count);
                if count <= most {
                    self.keep_if_best(face);
                } else if limit >= self.bracket.loosest() {
                    return Err(MeshError::BudgetTooSmall { most, least: self.least });
                } else {
                    self.too_fine.push((limit, count));
                }
                count as f64
            }
            Err(error) => {
                self.refusals += 1;
                self.bracket.too_strict(limit, error)?
            }
        };
        self.bracket.note(limit, count, most as f64);
        Ok(count)
    }

    fn keep_if_best(&mut self, face: Face) {
        let error = |face: &Face| self.budget.error(face);
        if self.best.as_ref().is_none_or(|best| error(&face) < error(best)) {
            self.best = Some(face);
        }
    }

    /// Makes the mesh of the loosest limit first, where it may be too large, or the finest of all.
    fn try_loosest(&mut self, fewest: &FewestTriangles) -> Result<(), MeshError> {
        let most = self.budget.triangles as f64;
        let loosest = self.bracket.loosest();
        if fewest.as_ref().is_ok_and(|(_, count)| *count > TUNING.close_to_fewest * most) {
            self.make(loosest)?;
        } else if self.budget.is_small() && self.make(loosest).is_err() {
            // On a cone this mesh may be the finest of all; its refusal does not count.
            self.refusals = 0;
        }
        Ok(())
    }

    /// Makes meshes within limits from `limit` on until the budget is used well.
    fn run(&mut self, mut limit: f64, mut power: PowerLaw) -> Result<(), MeshError> {
        let most = self.budget.triangles as f64;
        let usual = self.budget.usual_meshes();
        let enough_used = TUNING.enough[usize::from(!self.budget.is_small())] * most;
        for made in 1.. {
            let count = self.make(limit)?;
            let content = count <= most && count >= enough_used;
            let enough = made >= usual || self.refusals >= TUNING.most_refusals;
            if content || self.bracket.is_closed() || (enough && self.best.is_some()) {
                break;
            }
            limit = if made < usual {
                let step = power.step(limit, count, TUNING.target * most);
                let longest = TUNING.longest_step;
                self.bracket.next(limit, limit * step.clamp(1.0 / longest, longest))
            } else {
                let grown = (0..=made - usual).fold(limit, |limit, _| limit * TUNING.growth);
                self.bracket.clamp(grown)
            };
        }
        Ok(())
    }

    /// Tries some limits below those that fitted: numbers of triangles do not rise with every one.
    fn try_finer(&mut self) {
        let triangles = self.budget.triangles;
        let steps = TUNING.finer_limits.into_iter().find(|(below, _)| triangles < *below);
        let mut limit = self.bracket.fits();
        for _ in 0..steps.map_or(0, |(_, steps)| steps) {
            limit = self.bracket.on_grid(limit / TUNING.grid);
            if self.refusals >= TUNING.most_refusals || self.make(limit).is_err() {
                break;
            }
        }
    }
}

impl Budget<'_> {
    /// The finest mesh that, closed, has no more triangles than the budget.
    ///
    /// # Errors
    /// [`MeshError::BudgetTooSmall`] when there is none, and what no looser limit helps against.
    pub fn mesh(&self) -> Result<Face, MeshError> {
        let panels = SmoothPanels::new(self.mirror, self.view);
        let mut search = BudgetSearch::new(self, &panels);
        let fewest = self.loosest(&mut search.mesher);
        search.try_loosest(&fewest)?;
        let (plan, power) = self.aim(&mut search.mesher, fewest)?;
        let aim = self.limit_of(&plan);
        let limit = search.bracket.next(aim, aim);
        search.run(limit, power.for_others())?;
        search.try_finer();
        let best = search.best.expect("a bracket closes on a limit that fitted");
        let finer = search.too_fine.into_iter().filter(|(limit, _)| *limit < self.error(&best));
        let next_finer = finer.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, count)| count);
        Ok(Face { next_finer, ..best })
    }

    /// The error that the budget is spent on, mm.
    fn error(&self, face: &Face) -> f64 {
        if self.view.is_some() { face.bound.facet_mm } else { face.bound.chord_mm }
    }

    fn is_small(&self) -> bool {
        self.triangles < TUNING.most_meshes[0].0
    }

    /// Number of meshes after which the search ends, if one fits.
    fn usual_meshes(&self) -> usize {
        let small = TUNING.most_meshes.into_iter().find(|(below, _)| self.triangles < *below);
        small.map_or(TUNING.most_large_meshes, |(_, meshes)| meshes)
    }

    /// The plan of a mesh within the budget.
    ///
    /// # Errors
    /// [`MeshError`] as far as it can be foreseen.
    pub fn foresee(&self) -> Result<MeshPlan, MeshError> {
        let panels = SmoothPanels::new(self.mirror, self.view);
        let mut mesher = self.mesher(&panels);
        let fewest = self.loosest(&mut mesher);
        let (plan, _) = self.aim(&mut mesher, fewest)?;
        if self.foreseen(&plan.forecast) <= TUNING.forecast_error * self.triangles as f64 {
            return Ok(plan);
        }
        let least = self.foreseen(&mesher.forecast(plan.limits)?) as usize;
        Err(MeshError::BudgetTooSmall { most: self.triangles, least })
    }

    /// The loose limit of the fewest triangles, and how many these are: hardly any mesh has fewer.
    fn loosest(&self, mesher: &mut Mesher) -> FewestTriangles {
        let mut fewest: Option<(MeshPlan, f64)> = None;
        let mut limit = TUNING.loosest * self.size();
        loop {
            let limits = self.limits(limit);
            let forecast = match (mesher.estimate(limits), fewest) {
                (Ok(forecast), _) => forecast,
                (Err(_), Some(fewest)) => return Ok(fewest),
                (Err(error), None) => return Err(error),
            };
            let count = self.foreseen(&forecast);
            match fewest {
                Some(fewest) if count >= fewest.1 => return Ok(fewest),
                _ => fewest = Some((MeshPlan { limits, forecast }, count)),
            }
            limit /= TUNING.loose_step;
        }
    }

    /// The limit at which a forecast comes nearest to the budget, or that of the `fewest`; with the power law of forecasts.
    fn aim(
        &self,
        mesher: &mut Mesher,
        fewest: FewestTriangles,
    ) -> Result<(MeshPlan, PowerLaw), MeshError> {
        let mut power = self.power_law();
        let target = TUNING.target * self.triangles as f64;
        let near = TUNING.near_target[usize::from(!self.is_small())];
        let fitting = target * (1.0 + near);
        if let Ok((plan, count)) = fewest
            && count > fitting
        {
            return Ok((plan, power));
        }
        let mut bracket = self.bracket();
        let mut limit = bracket.clamp(self.guess());
        let mut plan = fewest.clone().ok();
        if let Some((plan, count)) = &plan {
            bracket.note(self.limit_of(plan), *count, target);
        }
        for _ in 0..TUNING.most_forecasts {
            let limits = self.limits(limit);
            let count = match mesher.estimate(limits) {
                Ok(forecast) => {
                    let count = self.foreseen(&forecast);
                    // Until one fits, the one that is nearest to it.
                    let is_less = |(_, kept): &(MeshPlan, f64)| *kept > fitting && count < *kept;
                    if count <= fitting || plan.as_ref().is_none_or(is_less) {
                        plan = Some((MeshPlan { limits, forecast }, count));
                    }
                    count
                }
                Err(error) => bracket.too_strict(limit, error)?,
            };
            bracket.note(limit, count, target);
            let is_near = (count / target - 1.0).abs() < near;
            if is_near || bracket.is_closed() || (count > target && limit >= bracket.loosest()) {
                break;
            }
            limit = bracket.next(limit, limit * power.step(limit, count, target));
        }
        let (plan, _) = plan.map_or(fewest, Ok)?;
        Ok((plan, power))
    }

    fn mesher<'m>(&'m self, panels: &'m SmoothPanels) -> Mesher<'m> {
        Mesher::new(panels, self.camera)
    }

    /// The number of triangles that a forecast comes to, closed.
    fn foreseen(&self, forecast: &FaceForecast) -> f64 {
        forecast.facets + self.closing.foreseen(forecast)
    }

    /// Limits with the one that the budget is spent on, mm.
    fn limits(&self, limit: f64) -> Limits {
        let [chord_mm, facet_mm] =
            if self.view.is_some() { [None, Some(limit)] } else { [Some(limit), None] };
        Limits { chord_mm, facet_mm, precision: self.precision }
    }

    fn limit_of(&self, plan: &MeshPlan) -> f64 {
        plan.limits.facet_mm.or(plan.limits.chord_mm).expect("one limit is set")
    }

    fn size(&self) -> f64 {
        self.mirror.full_outline().bounds().size().max_element()
    }

    /// A bracket of which only the ends are known.
    fn bracket(&self) -> Bracket {
        let size = self.size();
        let strictest = match self.precision {
            Precision::Single => TUNING.strictest_single,
            Precision::Double => TUNING.strictest,
        };
        Bracket::new(strictest * size, TUNING.loosest * size)
    }

    /// A limit to begin with, mm: half again the triangles that theory needs at least.
    fn guess(&self) -> f64 {
        let optimum = Optimum::new(self.mirror, self.camera, self.view);
        let (least, usual) = match self.view {
            Some(_) => (optimum.facet(1.0), 0.1 * self.size() * self.size()),
            None => (optimum.chord(1.0), 0.1 * self.size()),
        };
        self.power_law().step(1.0, TUNING.guess * least.unwrap_or(usual), self.triangles as f64)
    }

    /// Theory's law: the facet error falls with a facet's size, the chord error with its square.
    fn power_law(&self) -> PowerLaw {
        PowerLaw::new(if self.view.is_some() { 2.0 } else { 1.0 })
    }
}
