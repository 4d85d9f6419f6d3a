//! The finest mesh of a given number of triangles.
//!
//! The number falls as the limit is loosened, nearly as a power of it. Forecasts aim; meshes
//! tell by how much the forecasts are off, and the next aim allows for that.

use super::{Face, Forecast, Limits, MeshError, Mesher, Optimum};
use crate::geom::{Chart, Precision};
use crate::mirror::Mirror;
use crate::optics::View;

/// Share of the budget that is aimed at, and that must be used to be content.
const AIM: f64 = 0.985;
const ENOUGH: f64 = 0.97;
/// Most forecasts for an aim, and how near the last is to come for a small and for a large budget.
const FORECASTS: usize = 80;
const NEAR: [f64; 2] = [0.03, 0.004];
/// Most meshes made to use a budget well, for budgets below so many triangles, and for larger ones: the
/// numbers of rows and columns of small meshes go in steps, and large ones take seconds.
const MESHES: [(usize, usize); 2] = [(20_000, 20), (200_000, 8)];
const LARGE_MESHES: usize = 5;
/// The most by which a limit changes from mesh to mesh.
const LONGEST: f64 = 4.0;
/// By how much the limit grows, ever faster, when that many did not keep the budget.
const GROWTH: f64 = 1.5;
/// Meshes that rounding refuses, after which finer ones are not tried.
const REFUSALS: usize = 2;
/// The loosest and the strictest limit that are tried, over the mirror's size: pictures of near targets
/// may be off by more than their width, and numbers of single precision are 6e-8 apart.
const LOOSEST: f64 = 10.0;
const STRICTEST: f64 = 1e-10;
const STRICTEST_SINGLE: f64 = 1e-8;
/// From one loose limit to the next where the fewest triangles are looked for.
const LOOSE_STEP: f64 = 10.0;
/// Forecasts on one side of the aim, after which steps grow.
const PATIENCE: u32 = 3;
/// Limits nearer to each other than this are not told apart, by meshes and by forecasts.
const APART: f64 = 1.0 + 1e-4;
const APART_BY_FORECASTS: f64 = 1.01;

/// How many triangles closing a face adds, which is not for the mesh to know.
pub trait Closing {
    /// To a face that is foreseen.
    fn foreseen(&self, forecast: &Forecast) -> f64;
    /// To a face that is made.
    fn counted(&self, face: &Face) -> usize;
}

/// A number of triangles, and what they are for.
pub struct Budget<'a> {
    /// The mirror.
    pub mirror: &'a Mirror,
    /// The camera's chart.
    pub camera: &'a Chart,
    /// What its image must show: with a view the budget is spent on the facet error, else on the
    /// chord error.
    pub view: Option<&'a View>,
    /// Digits of the file.
    pub precision: Precision,
    /// Most triangles of the closed part.
    pub triangles: usize,
    /// What closing adds.
    pub closing: &'a dyn Closing,
}

/// Limits that suit a budget, and the mesh that they let foresee.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// The one limit.
    pub limits: Limits,
    /// What a mesh within it will be.
    pub forecast: Forecast,
}

impl Budget<'_> {
    /// The finest mesh that, closed, has no more triangles than the budget.
    ///
    /// # Errors
    /// [`MeshError::Few`] when there is none, and what no looser limit helps against.
    pub fn mesh(&self) -> Result<Face, MeshError> {
        let most = self.triangles as f64;
        let small = MESHES.into_iter().find(|(below, _)| self.triangles < *below);
        let usual = small.map_or(LARGE_MESHES, |(_, meshes)| meshes);
        let mut bracket = self.bracket(APART);
        let mut mesher = self.mesher();
        let mut limit = bracket.clamp(self.limit_of(&self.aim(&mut mesher)?));
        let mut best: Option<Face> = None;
        let (mut steps, mut refusals, mut least) = (Steps::default(), 0, usize::MAX);
        for made in 1.. {
            let count = match mesher.mesh(self.limits(limit)) {
                Ok(face) => {
                    let count = face.mesh.triangles.len() + self.closing.counted(&face);
                    least = least.min(count);
                    if count <= self.triangles {
                        // Every limit that is tried is stricter than those that fitted.
                        best = Some(face);
                    } else if limit >= bracket.loosest {
                        return Err(MeshError::Few { most: self.triangles, least });
                    }
                    count as f64
                }
                Err(error) => {
                    refusals += 1;
                    bracket.too_strict(limit, error)?
                }
            };
            let content = count <= most && count >= ENOUGH * most;
            bracket.note(limit, count, most);
            let enough = made >= usual || refusals >= REFUSALS;
            if content || bracket.is_closed() || (enough && best.is_some()) {
                break;
            }
            limit = if made < usual {
                let step = steps.next(count > most, self.scaled(1.0, count, AIM * most));
                bracket.next(limit, limit * step.clamp(1.0 / LONGEST, LONGEST))
            } else {
                bracket.clamp((0..=made - usual).fold(limit, |limit, _| limit * GROWTH))
            };
        }
        Ok(best.expect("a bracket closes on a limit that fitted"))
    }

    fn is_small(&self) -> bool {
        self.triangles < MESHES[0].0
    }

    /// What a mesh within the budget will be.
    ///
    /// # Errors
    /// [`MeshError`] as far as it can be foreseen.
    pub fn foresee(&self) -> Result<Plan, MeshError> {
        let mut mesher = self.mesher();
        let plan = self.aim(&mut mesher)?;
        // A forecast may be off by some.
        if self.foreseen(&plan.forecast) <= 1.1 * self.triangles as f64 {
            return Ok(plan);
        }
        let least = self.foreseen(&mesher.forecast(plan.limits)?) as usize;
        Err(MeshError::Few { most: self.triangles, least })
    }

    /// The loose limit of the fewest triangles, and how many these are: hardly any mesh has fewer.
    fn loosest(&self, mesher: &mut Mesher) -> Result<(Plan, f64), MeshError> {
        let mut fewest: Option<(Plan, f64)> = None;
        let mut limit = LOOSEST * self.size();
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
                _ => fewest = Some((Plan { limits, forecast }, count)),
            }
            limit /= LOOSE_STEP;
        }
    }

    /// The limit at which a forecast comes nearest to the budget, or the loosest.
    fn aim(&self, mesher: &mut Mesher) -> Result<Plan, MeshError> {
        let target = AIM * self.triangles as f64;
        let near = NEAR[usize::from(!self.is_small())];
        let fitting = target * (1.0 + near);
        let fewest = self.loosest(mesher);
        if let Ok((plan, count)) = fewest
            && count > fitting
        {
            return Ok(plan);
        }
        let mut bracket = self.bracket(APART_BY_FORECASTS);
        let mut limit = bracket.clamp(self.guess());
        let mut plan = fewest.clone().ok();
        if let Some((plan, count)) = &plan {
            bracket.note(self.limit_of(plan), *count, target);
        }
        let mut steps = Steps { patience: PATIENCE, ..Steps::default() };
        for _ in 0..FORECASTS {
            let limits = self.limits(limit);
            let count = match mesher.estimate(limits) {
                Ok(forecast) => {
                    let count = self.foreseen(&forecast);
                    // Until one fits, the one that is nearest to it.
                    let is_less = |(_, kept): &(Plan, f64)| *kept > fitting && count < *kept;
                    if count <= fitting || plan.as_ref().is_none_or(is_less) {
                        plan = Some((Plan { limits, forecast }, count));
                    }
                    count
                }
                Err(error) => bracket.too_strict(limit, error)?,
            };
            bracket.note(limit, count, target);
            let is_near = (count / target - 1.0).abs() < near;
            if is_near || bracket.is_closed() || (count > target && limit >= bracket.loosest) {
                break;
            }
            let step = steps.next(count > target, self.scaled(1.0, count, target));
            limit = bracket.next(limit, limit * step);
        }
        plan.map_or_else(|| fewest.map(|(plan, _)| plan), |(plan, _)| Ok(plan))
    }

    fn mesher(&self) -> Mesher<'_> {
        Mesher::new(self.mirror, self.camera, self.view)
    }

    fn foreseen(&self, forecast: &Forecast) -> f64 {
        forecast.facets + self.closing.foreseen(forecast)
    }

    fn limits(&self, limit: f64) -> Limits {
        let [chord_mm, facet_mm] =
            if self.view.is_some() { [None, Some(limit)] } else { [Some(limit), None] };
        Limits { chord_mm, facet_mm, precision: self.precision }
    }

    fn limit_of(&self, plan: &Plan) -> f64 {
        plan.limits.facet_mm.or(plan.limits.chord_mm).expect("one limit is set")
    }

    fn size(&self) -> f64 {
        self.mirror.whole().bounds().size().max_element()
    }

    /// A bracket of limits that are told apart when they are `apart`.
    fn bracket(&self, apart: f64) -> Bracket {
        let size = self.size();
        let strictest = match self.precision {
            Precision::Single => STRICTEST_SINGLE,
            Precision::Double => STRICTEST,
        };
        Bracket {
            strictest: strictest * size,
            loosest: LOOSEST * size,
            apart,
            fails: 0.0,
            fits: f64::INFINITY,
        }
    }

    /// A limit to begin with: half again the triangles that theory needs at least.
    fn guess(&self) -> f64 {
        let optimum = Optimum::new(self.mirror, self.camera, self.view);
        let (least, usual) = match self.view {
            Some(_) => (optimum.facet(1.0), 0.1 * self.size() * self.size()),
            None => (optimum.chord(1.0), 0.1 * self.size()),
        };
        self.scaled(1.0, 1.5 * least.unwrap_or(usual), self.triangles as f64)
    }

    /// Where `target` triangles are expected when there are `count` at `limit`: one triangle a
    /// pixel of facet error, one a square millimetre and micrometre of chord error.
    fn scaled(&self, limit: f64, count: f64, target: f64) -> f64 {
        let ratio = count / target;
        limit * if self.view.is_some() { ratio.sqrt() } else { ratio }
    }
}

/// Factors on the limit, which grow while it stays on one side: where rims need most of the triangles, or
/// a mirror is flat, the number hardly follows the limit.
#[derive(Debug, Default)]
struct Steps {
    /// Steps to one side that are taken as they come.
    patience: u32,
    /// Steps to the side of the last one, and which.
    streak: u32,
    too_many: Option<bool>,
}

impl Steps {
    fn next(&mut self, too_many: bool, step: f64) -> f64 {
        self.streak = if self.too_many == Some(too_many) { self.streak + 1 } else { 0 };
        self.too_many = Some(too_many);
        (self.patience..self.streak).fold(step, |step, _| step * step)
    }
}

/// What is known about limits.
#[derive(Debug)]
struct Bracket {
    strictest: f64,
    loosest: f64,
    /// Limits nearer to each other than this are not told apart.
    apart: f64,
    /// The loosest limit known to be too strict.
    fails: f64,
    /// The strictest limit known to fit.
    fits: f64,
}

impl Bracket {
    /// An error that a looser limit may not meet counts as too many triangles.
    fn too_strict(&self, limit: f64, error: MeshError) -> Result<f64, MeshError> {
        match error {
            MeshError::TooMany { .. } | MeshError::Floor { .. } | MeshError::Single { .. }
                if limit < self.loosest =>
            {
                Ok(f64::INFINITY)
            }
            error => Err(error),
        }
    }

    fn note(&mut self, limit: f64, count: f64, target: f64) {
        if count > target {
            self.fails = self.fails.max(limit);
        } else {
            self.fits = self.fits.min(limit);
        }
    }

    /// Whether there is nothing left to try.
    fn is_closed(&self) -> bool {
        self.fits <= self.strictest || self.fits <= self.fails * self.apart
    }

    /// The limit after `limit`: `wanted`, where that can be.
    fn next(&self, limit: f64, wanted: f64) -> f64 {
        let next = if wanted > self.fails && wanted < self.fits {
            wanted
        } else if self.fits == f64::INFINITY {
            2.0 * limit
        } else if self.fails == 0.0 {
            0.5 * limit
        } else {
            (self.fails * self.fits).sqrt()
        };
        self.clamp(next)
    }

    fn clamp(&self, limit: f64) -> f64 {
        limit.clamp(self.strictest, self.loosest)
    }
}
