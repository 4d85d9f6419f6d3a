//! Where given pixels look in a made system, and how far parts differ in that.

use super::engine::{Engine, adjustments};
use super::error_source::ErrorSource;
use super::linear_model::LinearModel;
use super::linear_prediction::moved_by_tracks;
use super::model::{OpticalSystem, PartPose, PixelSample};
use super::perturbed_system::PerturbedSystem;
use super::texture::facets_displace;
use super::work_counts::WorkCounts;
use crate::geom::{DVec2, DVec3, Ray};
use crate::parallel;
use crate::tolerance_terms::{ActsOn, Texture};

/// Lines of sight of given image points, also beyond the mirror's rim, where its surface goes on.
#[derive(Debug)]
pub struct SightLines<'a> {
    engine: &'a Engine,
    /// With a sample for each image point that has one.
    system: OpticalSystem,
    /// Number of the sample of each image point.
    numbers: Vec<Option<usize>>,
    /// Whether each image point shows the mirror itself.
    pub on_mirror: Vec<bool>,
}

/// Covariance of a displacement of the picture, px^2: along x, along both, along y.
pub type CovariancePx = [f64; 3];

impl Engine {
    /// Lines of sight of image points, mm.
    #[must_use]
    pub fn sight_lines(&self, points: &[DVec2]) -> SightLines<'_> {
        self.lines(points, false)
    }

    /// The same for [`SightLines::rays`] alone, of systems whose errors are those of mounting, camera and size.
    #[must_use]
    pub fn mounted_sight_lines(&self, points: &[DVec2]) -> SightLines<'_> {
        self.lines(points, true)
    }

    /// Whether image points show the mirror as designed.
    #[must_use]
    pub fn shows_mirror(&self, points: &[DVec2]) -> Vec<bool> {
        parallel::map_slice(points, 64, |&point| self.system.sees(point).is_some())
    }

    fn lines(&self, points: &[DVec2], is_bare: bool) -> SightLines<'_> {
        let found: Vec<Option<(PixelSample, bool)>> =
            parallel::map_slice(points, 16, |&point| self.system.sample_at(point, is_bare));
        let on_mirror = found.iter().map(|found| found.as_ref().is_some_and(|f| f.1)).collect();
        let (mut samples, mut numbers) = (Vec::new(), Vec::with_capacity(points.len()));
        for found in found {
            numbers.push(found.is_some().then_some(samples.len()));
            samples.extend(found.map(|found| found.0));
        }
        SightLines { engine: self, system: self.system.with(samples), numbers, on_mirror }
    }
}

impl SightLines<'_> {
    /// The ray that leaves the mirror towards what each image point shows in a made system, in the world; none where none does.
    #[must_use]
    pub fn rays(&self, made: &PerturbedSystem) -> Vec<Option<Ray>> {
        let pose = PartPose::new(&made.state.misalignment);
        let rays = parallel::map_slice(&self.system.samples, 16, |sample| {
            let mut work = WorkCounts::default();
            let found = self.system.leaving_ray(sample, &pose, &made.state, &mut work);
            self.system.counter.add(work);
            let (origin, direction) = found?;
            let direction = DVec3::from_array(direction).normalize();
            direction.is_finite().then(|| Ray { origin: origin.into(), direction })
        });
        self.numbers.iter().map(|k| k.and_then(|k| rays[k])).collect()
    }

    /// Covariance, px^2, of where in the picture that belongs which each image point shows, among parts that are adjusted as the study
    /// asks, by first derivatives; none where nothing is shown. Systematic errors are in all parts, and add nothing; nor do those of
    /// mounting, camera and size where they are known.
    #[must_use]
    pub fn covariances(&self, is_mounted: bool) -> Vec<Option<CovariancePx>> {
        let Self { engine, system, .. } = self;
        let columns = engine.forms.len() + engine.modes.len();
        let linear = LinearModel::new(system, &engine.spec, columns);
        let adjusted = adjustments(system, &linear, &engine.spec.compensators);
        let mut all = vec![[0.0; 3]; system.samples.len()];
        let is_known = |acts_on: ActsOn| {
            is_mounted && (acts_on.is_mounting() || acts_on.is_camera() || acts_on.is_size())
        };
        let random = engine
            .spec
            .sources
            .iter()
            .filter(|source| !source.is_systematic() && !is_known(source.kind.row().acts_on));
        for source in random {
            let scale = match source.kind.row().acts_on {
                ActsOn::Layers => 1.0,
                _ => source.mean_square(),
            };
            let own = engine.common_columns(&engine.linear, source);
            let here = engine.common_columns(&linear, source);
            for (([a, b], own), (_, here)) in own.into_iter().zip(here) {
                let steps = engine.compensation.apply(&mut own.to_vec());
                let mut moved = here.to_vec();
                for (step, done) in steps.iter().zip(engine.compensation.adjustments()) {
                    let Some(here) = adjusted.iter().find(|here| here.name == done.name) else {
                        continue;
                    };
                    let share = step / done.per_step;
                    moved.iter_mut().zip(&here.column).for_each(|(x, by)| *x += share * by);
                }
                all.iter_mut().zip(moved.as_chunks().0).for_each(|(sum, moved)| {
                    add(sum, scale * a * b, *moved);
                });
            }
            self.add_independent(&linear, source, &mut all);
        }
        let of = |k: usize| Some(all[k]).filter(|[xx, _, yy]| (xx + yy).is_finite());
        self.numbers.iter().map(|k| k.and_then(of)).collect()
    }

    /// What tracks and facets add, by which each pixel moves on its own.
    fn add_independent(
        &self,
        linear: &LinearModel,
        source: &ErrorSource,
        all: &mut [CovariancePx],
    ) {
        let square = source.mean_square();
        let share = self.engine.unadjusted_share();
        match source.kind.row().acts_on {
            ActsOn::Texture(Texture::Stepover) => {
                for (k, sum) in all.iter_mut().enumerate() {
                    let (seen, moved) = moved_by_tracks(&self.system, linear, k, square.sqrt());
                    add(sum, share * square * seen / 12.0, moved);
                }
            }
            ActsOn::Facets => {
                let moved = facets_displace(square.sqrt());
                let half = 0.5 * share * moved * moved;
                all.iter_mut().for_each(|[xx, _, yy]| {
                    *xx += half;
                    *yy += half;
                });
            }
            _ => {}
        }
    }
}

fn add([xx, xy, yy]: &mut CovariancePx, weight: f64, [x, y]: [f64; 2]) {
    *xx += weight * x * x;
    *xy += weight * x * y;
    *yy += weight * y * y;
}
