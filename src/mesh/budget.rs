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
/// Most forecasts for an aim, and how near the last is to come.
const FORECASTS: usize = 80;
const NEAR: f64 = 0.004;
/// Most meshes made to use the budget well: of large ones; and of small ones, whose numbers of
/// rows and columns go in steps.
const MESHES: usize = 5;
const SMALL_MESHES: usize = 20;
const SMALL: usize = 20_000;
/// The most by which a limit changes from mesh to mesh.
const LONGEST: f64 = 4.0;
/// By how much the limit grows from mesh to mesh when that many did not keep the budget.
const GROWTH: f64 = 1.5;
/// The loosest and the strictest limit that are tried, over the mirror's size.
const LOOSEST: f64 = 10.0;
const STRICTEST: f64 = 1e-10;
/// Limits nearer to each other than this are not told apart.
const APART: f64 = 1.0 + 1e-4;

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
        let usual = if self.triangles < SMALL { SMALL_MESHES } else { MESHES };
        let mut bracket = self.bracket();
        let mut mesher = self.mesher();
        let mut limit = self.limit_of(&self.aim(&mut mesher)?);
        let mut best: Option<Face> = None;
        // How often in a row there were too many triangles, or too few.
        let (mut streak, mut before) = (0, None);
        for made in 1.. {
            let count = match mesher.mesh(self.limits(limit)) {
                Ok(face) => {
                    let count = face.mesh.triangles.len() + self.closing.counted(&face);
                    if count <= self.triangles {
                        // Every limit that is tried is stricter than those that fitted.
                        best = Some(face);
                    } else if limit >= bracket.loosest {
                        return Err(MeshError::Few { most: self.triangles, least: count });
                    }
                    count as f64
                }
                Err(error) => bracket.too_strict(limit, error)?,
            };
            let content = count <= most && count >= ENOUGH * most;
            bracket.note(limit, count, most);
            if content || bracket.is_closed() || (made >= usual && best.is_some()) {
                break;
            }
            let side = Some(count > most);
            streak = if side == before { streak + 1 } else { 0 };
            before = side;
            limit = if made < usual {
                // Where rims need most of the triangles, the number hardly follows the limit.
                let step = self.scaled(1.0, count, AIM * most);
                let step = (0..streak).fold(step, |step, _| step * step);
                bracket.next(limit, limit * step.clamp(1.0 / LONGEST, LONGEST))
            } else {
                (limit * GROWTH).min(bracket.loosest)
            };
        }
        Ok(best.expect("a bracket closes on a limit that fitted"))
    }

    /// What a mesh within the budget will be.
    ///
    /// # Errors
    /// [`MeshError`] as far as it can be foreseen.
    pub fn foresee(&self) -> Result<Plan, MeshError> {
        let plan = self.aim(&mut self.mesher())?;
        let least = self.foreseen(&plan.forecast);
        // A forecast may be off by some.
        if least > 1.1 * self.triangles as f64 {
            return Err(MeshError::Few { most: self.triangles, least: least as usize });
        }
        Ok(plan)
    }

    /// The limit at which a forecast comes nearest to the budget, or the loosest.
    fn aim(&self, mesher: &mut Mesher) -> Result<Plan, MeshError> {
        let target = AIM * self.triangles as f64;
        let mut bracket = self.bracket();
        let mut limit = bracket.clamp(self.guess());
        let fitting = target * (1.0 + NEAR);
        let mut plan: Option<(Plan, f64)> = None;
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
            let near = (count / target - 1.0).abs() < NEAR;
            if near || bracket.is_closed() || (count > target && limit >= bracket.loosest) {
                break;
            }
            limit = bracket.next(limit, self.scaled(limit, count, target));
        }
        let plan = plan.map(|(plan, _)| plan);
        plan.ok_or(MeshError::Few { most: self.triangles, least: usize::MAX })
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

    fn bracket(&self) -> Bracket {
        let size = self.size();
        Bracket {
            strictest: STRICTEST * size,
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
        self.scaled(1.0, 1.5 * least.unwrap_or(usual), self.triangles as f64)
    }

    /// Where `target` triangles are expected when there are `count` at `limit`: one triangle a
    /// pixel of facet error, one a square millimetre and micrometre of chord error.
    fn scaled(&self, limit: f64, count: f64, target: f64) -> f64 {
        let ratio = count / target;
        limit * if self.view.is_some() { ratio.sqrt() } else { ratio }
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
        self.fits <= self.strictest || self.fits <= self.fails * APART
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
