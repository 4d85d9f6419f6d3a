//! The finest mesh of a given number of triangles.
//!
//! The number falls as the limit is loosened, nearly as a power of it. Forecasts aim; meshes
//! tell by how much the forecasts are off, and the next aim allows for that.

use super::{Face, Limits, MeshError, MeshForecast, Mesher, Optimum};
use crate::geom::{Chart, Precision};
use crate::mirror::Mirror;
use crate::num::{exp, log};
use crate::optics::ImagingTask;

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
/// The least share of theory's power of the limit that the number of triangles is taken to follow.
const FLATTEST: f64 = 0.125;
/// Share of the budget above which the fewest triangles are made before anything is aimed at: often they
/// cannot be, or are too many.
const CLOSE: f64 = 0.5;
/// From one limit that is tried to the next one that may be, whatever the budget: what a budget can choose
/// from, a larger one can.
const APART: f64 = 1.01;
/// What rounding may do to such a limit, as a share of it.
const HAIR: f64 = 1e-6;
/// How many finer limits are tried after the search, for budgets below so many triangles: numbers rise and
/// fall by some in a hundred from limit to limit, the less, the larger they are.
const FINER: [(usize, usize); 2] = [(20_000, 8), (200_000, 3)];

/// How many triangles closing a face adds, which is not for the mesh to know.
pub trait ClosureCount {
    /// To a face that is foreseen.
    fn foreseen(&self, forecast: &MeshForecast) -> f64;
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
    pub view: Option<&'a ImagingTask>,
    /// Digits of the file.
    pub precision: Precision,
    /// Most triangles of the closed part.
    pub triangles: usize,
    /// What closing adds.
    pub closing: &'a dyn ClosureCount,
}

/// Limits that suit a budget, and the mesh that they let foresee.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshPlan {
    /// The one limit.
    pub limits: Limits,
    /// What a mesh within it will be.
    pub forecast: MeshForecast,
}

/// The loose limit of the fewest triangles, and how many these are.
type FewestTriangles = Result<(MeshPlan, f64), MeshError>;

/// What meshes that were made tell.
struct BudgetSearch {
    bracket: Bracket,
    /// The one of the least error that fitted.
    best: Option<Face>,
    /// How many were refused.
    refusals: usize,
    /// The fewest triangles of any.
    least: usize,
}

impl BudgetSearch {
    /// The number of triangles of the mesh within `limit`; infinite where it is refused and a looser
    /// limit may help.
    fn make(&mut self, budget: &Budget, mesher: &mut Mesher, limit: f64) -> Result<f64, MeshError> {
        let most = budget.triangles;
        let count = match mesher.mesh(budget.limits(limit)) {
            Ok(face) => {
                let count = face.mesh.triangles.len() + budget.closing.counted(&face);
                self.least = self.least.min(count);
                if count <= most {
                    let finest = self
                        .best
                        .as_ref()
                        .is_none_or(|best| budget.error(&face) < budget.error(best));
                    if finest {
                        self.best = Some(face);
                    }
                } else if limit >= self.bracket.loosest {
                    return Err(MeshError::BudgetTooSmall { most, least: self.least });
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
}

impl Budget<'_> {
    /// The finest mesh that, closed, has no more triangles than the budget.
    ///
    /// # Errors
    /// [`MeshError::BudgetTooSmall`] when there is none, and what no looser limit helps against.
    pub fn mesh(&self) -> Result<Face, MeshError> {
        let most = self.triangles as f64;
        let small = MESHES.into_iter().find(|(below, _)| self.triangles < *below);
        let usual = small.map_or(LARGE_MESHES, |(_, meshes)| meshes);
        let mut mesher = self.mesher();
        let mut tried =
            BudgetSearch { bracket: self.bracket(), best: None, refusals: 0, least: usize::MAX };
        let fewest = self.loosest(&mut mesher);
        if fewest.as_ref().is_ok_and(|(_, count)| *count > CLOSE * most) {
            tried.make(self, &mut mesher, tried.bracket.loosest)?;
        } else if self.is_small() && tried.make(self, &mut mesher, tried.bracket.loosest).is_err() {
            // It may be the finest of all, on a cone; it need not be there.
            tried.refusals = 0;
        }
        let aim = self.limit_of(&self.aim(&mut mesher, fewest)?);
        let mut limit = tried.bracket.next(aim, aim);
        let mut power = self.power();
        for made in 1.. {
            let count = tried.make(self, &mut mesher, limit)?;
            let content = count <= most && count >= ENOUGH * most;
            let enough = made >= usual || tried.refusals >= REFUSALS;
            if content || tried.bracket.is_closed() || (enough && tried.best.is_some()) {
                break;
            }
            limit = if made < usual {
                let step = power.step(limit, count, AIM * most);
                tried.bracket.next(limit, limit * step.clamp(1.0 / LONGEST, LONGEST))
            } else {
                tried.bracket.clamp((0..=made - usual).fold(limit, |limit, _| limit * GROWTH))
            };
        }
        self.finer(&mut mesher, &mut tried);
        Ok(tried.best.expect("a bracket closes on a limit that fitted"))
    }

    /// Tries some limits below those that fitted: numbers of triangles do not rise with every one.
    fn finer(&self, mesher: &mut Mesher, tried: &mut BudgetSearch) {
        let steps = FINER.into_iter().find(|(below, _)| self.triangles < *below);
        let mut limit = tried.bracket.fits;
        for _ in 0..steps.map_or(0, |(_, steps)| steps) {
            limit = tried.bracket.on_grid(limit / APART);
            if tried.refusals >= REFUSALS || tried.make(self, mesher, limit).is_err() {
                break;
            }
        }
    }

    /// What the budget is spent on, mm.
    fn error(&self, face: &Face) -> f64 {
        if self.view.is_some() { face.bound.facet_mm } else { face.bound.chord_mm }
    }

    fn is_small(&self) -> bool {
        self.triangles < MESHES[0].0
    }

    /// What a mesh within the budget will be.
    ///
    /// # Errors
    /// [`MeshError`] as far as it can be foreseen.
    pub fn foresee(&self) -> Result<MeshPlan, MeshError> {
        let mut mesher = self.mesher();
        let fewest = self.loosest(&mut mesher);
        let plan = self.aim(&mut mesher, fewest)?;
        // A forecast may be off by some.
        if self.foreseen(&plan.forecast) <= 1.1 * self.triangles as f64 {
            return Ok(plan);
        }
        let least = self.foreseen(&mesher.forecast(plan.limits)?) as usize;
        Err(MeshError::BudgetTooSmall { most: self.triangles, least })
    }

    /// The loose limit of the fewest triangles, and how many these are: hardly any mesh has fewer.
    fn loosest(&self, mesher: &mut Mesher) -> FewestTriangles {
        let mut fewest: Option<(MeshPlan, f64)> = None;
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
                _ => fewest = Some((MeshPlan { limits, forecast }, count)),
            }
            limit /= LOOSE_STEP;
        }
    }

    /// The limit at which a forecast comes nearest to the budget, or that of the `fewest`.
    fn aim(&self, mesher: &mut Mesher, fewest: FewestTriangles) -> Result<MeshPlan, MeshError> {
        let target = AIM * self.triangles as f64;
        let near = NEAR[usize::from(!self.is_small())];
        let fitting = target * (1.0 + near);
        if let Ok((plan, count)) = fewest
            && count > fitting
        {
            return Ok(plan);
        }
        let mut bracket = self.bracket();
        let mut limit = bracket.clamp(self.guess());
        let mut plan = fewest.clone().ok();
        if let Some((plan, count)) = &plan {
            bracket.note(self.limit_of(plan), *count, target);
        }
        let mut power = self.power();
        for _ in 0..FORECASTS {
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
            if is_near || bracket.is_closed() || (count > target && limit >= bracket.loosest) {
                break;
            }
            limit = bracket.next(limit, limit * power.step(limit, count, target));
        }
        plan.map_or_else(|| fewest.map(|(plan, _)| plan), |(plan, _)| Ok(plan))
    }

    fn mesher(&self) -> Mesher<'_> {
        Mesher::new(self.mirror, self.camera, self.view)
    }

    fn foreseen(&self, forecast: &MeshForecast) -> f64 {
        forecast.facets + self.closing.foreseen(forecast)
    }

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

    /// A bracket that nothing is known of.
    fn bracket(&self) -> Bracket {
        let size = self.size();
        let strictest = match self.precision {
            Precision::Single => STRICTEST_SINGLE,
            Precision::Double => STRICTEST,
        };
        Bracket {
            strictest: strictest * size,
            loosest: LOOSEST * size,
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
        self.power().step(1.0, 1.5 * least.unwrap_or(usual), self.triangles as f64)
    }

    /// Theory's: the facet error falls with a facet's size, the chord error with its square.
    fn power(&self) -> PowerLaw {
        PowerLaw { theory: if self.view.is_some() { 2.0 } else { 1.0 }, last: None }
    }
}

/// The power of the limit that the number of triangles falls by, as the last two tries tell it: where rims
/// need most of the triangles, or a mirror is flat, the number hardly follows the limit.
#[derive(Debug)]
struct PowerLaw {
    /// Theory's power, and the largest.
    theory: f64,
    /// Logarithms of the last limit and its number.
    last: Option<[f64; 2]>,
}

impl PowerLaw {
    /// A factor on `limit`, which has `count` triangles, towards `target` triangles.
    fn step(&mut self, limit: f64, count: f64, target: f64) -> f64 {
        if count.is_infinite() {
            return f64::INFINITY;
        }
        let now = [log(limit), log(count)];
        let told = self.last.map(|last| (last[1] - now[1]) / (now[0] - last[0]));
        let power = told.filter(|told| told.is_finite()).unwrap_or(self.theory);
        self.last = Some(now);
        exp((now[1] - log(target)) / power.clamp(FLATTEST * self.theory, self.theory))
    }
}

/// What is known about limits.
#[derive(Debug)]
struct Bracket {
    strictest: f64,
    loosest: f64,
    /// The loosest limit known to be too strict.
    fails: f64,
    /// The strictest limit known to fit.
    fits: f64,
}

impl Bracket {
    /// An error that a looser limit may not meet counts as too many triangles.
    fn too_strict(&self, limit: f64, error: MeshError) -> Result<f64, MeshError> {
        match error {
            MeshError::TooMany { .. }
            | MeshError::NotRefinable { .. }
            | MeshError::PrecisionLimit { .. }
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
        self.fits <= self.strictest || self.fits <= self.fails * (APART + HAIR)
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
        let next = self.on_grid(next);
        if next <= self.fails * (1.0 + HAIR) {
            self.clamp(next * APART)
        } else if next >= self.fits * (1.0 - HAIR) {
            self.clamp(next / APART)
        } else {
            self.clamp(next)
        }
    }

    /// The nearest of the limits that may be tried: the loosest, divided by a power of [`APART`].
    fn on_grid(&self, limit: f64) -> f64 {
        let steps = (log(self.loosest / limit) / log(APART)).round();
        self.clamp(self.loosest * exp(-steps * log(APART)))
    }

    fn clamp(&self, limit: f64) -> f64 {
        limit.clamp(self.strictest, self.loosest)
    }
}
