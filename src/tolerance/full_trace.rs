//! From perturbed systems to displacements of the picture, in full.

use super::engine::Engine;
use super::model::{OpticalSystem, PartPose, PixelSample, SideBySide};
use super::perturbed_system::PerturbedSystem;
use super::work_counts::{WorkCounts, WorkKind};

/// Systems that are traced side by side while there are as many: enough for the processor to have several
/// at hand while it waits for one. A group of two serves both signs of an error.
pub(super) const MOST: usize = 8;
const FEW: usize = 2;

/// Systems of a list, traced side by side.
struct Group<'a, const L: usize> {
    /// Their numbers in the list.
    numbers: [usize; L],
    together: SideBySide<'a, L>,
}

/// Made systems whose rays are not all as designed.
struct Traced<'a> {
    system: &'a OpticalSystem,
    made: &'a [PerturbedSystem],
    poses: Vec<PartPose<f64>>,
}

impl Engine {
    /// Displacements, px, x and y of each sample, of several made systems.
    #[must_use]
    pub fn displacements(&self, made: &[PerturbedSystem]) -> Vec<Vec<f64>> {
        let system = &self.system;
        let poses = made.iter().map(|m| PartPose::new(&m.state.misalignment)).collect();
        let traced = Traced { system, made, poses };
        let moving = (0..made.len()).filter(|&k| !made[k].state.is_perfect());
        let moving: Vec<usize> = moving.collect();
        let (many, rest) = moving.as_chunks::<MOST>();
        let (few, single) = rest.as_chunks::<FEW>();
        let (many, few) = (traced.groups(many), traced.groups(few));
        let single = traced.groups(single.as_chunks::<1>().0);
        let per = 1.0 / system.camera.pixel_mm;
        let mut all: Vec<Vec<f64>> = made.iter().map(|_| self.base.clone()).collect();
        let mut work = WorkCounts::default();
        let still = made.len() - moving.len();
        work.count(WorkKind::Rays, [0, still * system.samples.len()]);
        let mut moved = vec![[0.0; 2]; made.len()];
        // Sample by sample: what belongs to one stays in the cache.
        for (k, sample) in system.samples.iter().enumerate() {
            traced.moved(sample, &many, &mut moved, &mut work);
            traced.moved(sample, &few, &mut moved, &mut work);
            traced.moved(sample, &single, &mut moved, &mut work);
            for ((made, moved), out) in made.iter().zip(&moved).zip(&mut all) {
                let noise = made.noise(k);
                out[2 * k] += moved[0] * per + noise[0];
                out[2 * k + 1] += moved[1] * per + noise[1];
            }
        }
        system.counter.add(work);
        all
    }
}

impl<'a> Traced<'a> {
    fn groups<const L: usize>(&self, numbers: &[[usize; L]]) -> Vec<Group<'a, L>> {
        let group = |&numbers: &[usize; L]| {
            let states = numbers.map(|k| &self.made[k].state);
            let poses = numbers.map(|k| &self.poses[k]);
            Group { numbers, together: SideBySide::new(self.system, states, poses) }
        };
        numbers.iter().map(group).collect()
    }

    /// Puts displacements of the content that `sample` sees, mm, into `moved`.
    fn moved<const L: usize>(
        &self,
        sample: &PixelSample,
        groups: &[Group<L>],
        moved: &mut [[f64; 2]],
        work: &mut WorkCounts,
    ) {
        for Group { numbers, together } in groups {
            let contents = self.system.contents(sample, together, work);
            for (&number, content) in numbers.iter().zip(contents) {
                let (pose, state) = (&self.poses[number], &self.made[number].state);
                let content =
                    content.unwrap_or_else(|| self.system.content(sample, pose, state, work));
                moved[number] = [content[0] - sample.content.x, content[1] - sample.content.y];
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::design::design;
    use crate::num::random::RandomStream;
    use crate::pipeline::load;
    use crate::tolerance::{
        Criterion, ErrorSource, FormMeasure, Perturbation, Process, ProcessPreset, Reference,
        ToleranceSpec,
    };

    const STREAM: RandomStream = RandomStream { seed: 2, trial: 5 };

    /// An engine of all error sources but a measured one, for a shipped profile.
    pub(in crate::tolerance) fn engine(name: &str) -> Engine {
        let design = design(&load(name).unwrap()).unwrap();
        let process = Process::of(ProcessPreset::PrecisionCnc);
        let source = |kind: Perturbation| {
            let (limit, distribution) = process.usual(kind);
            ErrorSource { kind, limit, distribution, weight: 1.0 }
        };
        let kinds = Perturbation::all().filter(|kind| *kind != Perturbation::Map);
        let spec = ToleranceSpec {
            sources: kinds.map(source).filter(|source| source.limit != 0.0).collect(),
            form: FormMeasure::Pv,
            texture: process.texture,
            map: None,
            compensators: Vec::new(),
            criterion: Criterion::Rms,
            reference: Reference::Design,
            budget_px: 1.0,
            budget_blur_px: 1.0,
            target_yield: 0.9,
            samples: 60,
        };
        let view = design.view.as_ref().unwrap();
        Engine::new(&design.mirror, &design.camera, view, spec).unwrap()
    }

    /// Trials, and systems whose rays end at the first step, leave their polynomials' squares, do not meet
    /// the mirror, or are as designed.
    fn systems(engine: &Engine) -> Vec<PerturbedSystem> {
        let mut all: Vec<PerturbedSystem> =
            (0..13).map(|k| engine.trial(&engine.spec.sources, 1, k)).collect();
        let single = [
            (Perturbation::DecentreX, 1e-300),
            (Perturbation::DecentreX, 2e3),
            (Perturbation::TiltY, -60.0),
            (Perturbation::TiltX, 1500.0),
            (Perturbation::Facets, 0.5),
            (Perturbation::Layers, 0.05),
            (Perturbation::Layers, 30.0),
            (Perturbation::Slope, 0.5),
            (Perturbation::Stepover, 0.1),
        ];
        all.extend(single.map(|error| engine.make(&[error], STREAM)));
        all
    }

    fn bits(field: &[f64]) -> Vec<u64> {
        field.iter().map(|x| x.to_bits()).collect()
    }

    #[test]
    fn systems_side_by_side_have_the_bits_that_they_have_alone() {
        for name in ["conquistador", "hyperbolic"] {
            let engine = engine(name);
            let made = systems(&engine);
            let alone: Vec<Vec<f64>> = made
                .iter()
                .map(|made| engine.displacements(std::slice::from_ref(made)).remove(0))
                .collect();
            let lost = alone.iter().filter(|field| field.iter().any(|x| x.is_nan())).count();
            assert!((1..6).contains(&lost), "{name}: {lost}");
            for count in [2, 3, 8, 11, made.len()] {
                for (systems, alone) in made.chunks(count).zip(alone.chunks(count)) {
                    for (together, alone) in engine.displacements(systems).iter().zip(alone) {
                        assert_eq!(bits(together), bits(alone), "{name}: {count}");
                    }
                }
            }
        }
    }

    /// The same rays by the trace that numbers with derivatives take: form errors by `libm` at each step.
    #[test]
    fn systems_side_by_side_show_what_single_rays_do() {
        for name in ["conquistador", "hyperbolic"] {
            let engine = engine(name);
            let (system, made) = (&engine.system, systems(&engine));
            for (made, found) in made.iter().zip(engine.displacements(&made)) {
                let pose = PartPose::new(&made.state.misalignment);
                for (k, sample) in system.samples.iter().enumerate() {
                    let work = &mut WorkCounts::default();
                    let content = system.content(sample, &pose, &made.state, work);
                    let designed = sample.content.to_array();
                    for i in 0..2 {
                        let moved = (content[i] - designed[i]) / system.camera.pixel_mm;
                        let off = found[2 * k + i] - moved - made.noise(k)[i];
                        let same = off.abs() <= 1e-9 || off.is_nan() && moved.is_nan();
                        assert!(same, "{name}: {:?} {k} {off:e}", made.state);
                    }
                }
            }
        }
    }

    /// Where errors move hits out of the squares that polynomials are made for, wider ones need not ask the
    /// mirror itself, and show the same.
    #[test]
    fn wider_polynomials_show_what_the_mirror_does_where_hits_go_far() {
        let engine = engine("conquistador");
        let wider = |source: &ErrorSource| ErrorSource { limit: 4.0 * source.limit, ..*source };
        let sources: Vec<ErrorSource> = engine.spec.sources.iter().map(wider).collect();
        let made: Vec<PerturbedSystem> = (0..9).map(|k| engine.trial(&sources, 1, k)).collect();
        let evaluated = |engine: &Engine| {
            let _ = engine.worked();
            let found = engine.displacements(&made).concat();
            let surface = engine.worked().kinds().find(|(kind, _)| *kind == WorkKind::Surface);
            (found, surface.map_or(0, |(_, [evaluated, _])| evaluated))
        };
        let (found, many) = evaluated(&engine);
        let (wide, few) = evaluated(&engine.widened(&sources).unwrap());
        assert!(10 * few < many, "{few} {many}");
        for (a, b) in found.iter().zip(&wide) {
            assert!((a - b).abs() < 1e-8, "{a} {b}");
        }
    }
}
