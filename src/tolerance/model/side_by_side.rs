//! Several made systems traced side by side: one pixel's rays through all of them at once.

use super::super::local_polynomial::values;
use super::super::work_counts::{WorkCounts, WorkKind};
use super::content::{LAST_STEP, MOST_STEPS, meet_tangent, reflected};
use super::made_forms::{MadeForms, WaveExpansion};
use super::sample::PixelSample;
use super::state::{PartPose, PerturbedState};
use super::system::OpticalSystem;
use crate::num::{Arithmetic, Lanes};
use crate::tolerance_terms::Misalignment;
use std::array::from_fn;

/// `L` made systems.
#[derive(Debug, Clone)]
pub(crate) struct SideBySide<'a, const L: usize> {
    states: [&'a PerturbedState<f64>; L],
    misalignment: Misalignment<Lanes<L>>,
    pose: PartPose<Lanes<L>>,
    forms: MadeForms<L>,
    /// Share of the slope that terraces leave.
    inclined: Lanes<L>,
    /// Systems whose light goes on to where the slope sends it.
    pictured: [bool; L],
    /// Form errors at a ray of each, and those that do nothing.
    counts: [[usize; 2]; L],
}

/// Where lines meet the made mirrors.
struct Meeting<const L: usize> {
    /// Their directions.
    along: [Lanes<L>; 3],
    at: [Lanes<L>; 3],
    slope: [Lanes<L>; 2],
    /// Those that have met.
    met: [bool; L],
    /// Evaluations of the designed surface for each, and of polynomials that are it.
    evaluated: [[usize; 2]; L],
}

impl<'a, const L: usize> SideBySide<'a, L> {
    /// The systems of these errors and poses.
    pub(crate) fn new(
        system: &OpticalSystem,
        states: [&'a PerturbedState<f64>; L],
        poses: [&PartPose<f64>; L],
    ) -> Self {
        let values = states.map(|state| state.misalignment.values());
        let counts = states.map(|state| {
            let zeros = state.form.iter().filter(|a| **a == 0.0).count();
            [state.form.len() - zeros, zeros]
        });
        Self {
            states,
            misalignment: Misalignment::from_fn(|field| {
                Lanes(values.map(|values| values[field as usize]))
            }),
            pose: PartPose::side_by_side(poses),
            forms: MadeForms::new(&system.basis, states),
            inclined: Lanes(states.map(|state| 1.0 - state.terraced)),
            pictured: states.map(|state| state.terraced <= 0.5),
            counts,
        }
    }
}

impl OpticalSystem {
    /// [`OpticalSystem::content`] of several systems: for each what it would be alone. None where it takes
    /// what is rare, such as a first step that is the last one too.
    pub(crate) fn contents<const L: usize>(
        &self,
        sample: &PixelSample,
        made: &SideBySide<L>,
        work: &mut WorkCounts,
    ) -> [Option<[f64; 2]>; L] {
        let found = self.meetings(sample, made);
        let slope = found.slope.map(|p| p * made.inclined);
        let (at, leaving) = reflected(&made.pose, found.at, found.along, slope);
        from_fn(|k| {
            found.met[k].then(|| {
                work.count(WorkKind::Rays, [1, 0]);
                work.count(WorkKind::Forms, made.counts[k]);
                work.count(WorkKind::Surface, found.evaluated[k]);
                let alone = |of: [Lanes<L>; 3]| of.map(|x| x.0[k]);
                self.image_of_reflected(sample.point, alone(at), alone(leaving))
            })
        })
    }

    /// Where the rays meet the made mirrors, by Newton's method as for a single one.
    fn meetings<const L: usize>(&self, sample: &PixelSample, made: &SideBySide<L>) -> Meeting<L> {
        let (from, along) = self.ray_in_part(sample, &made.misalignment, &made.pose);
        let mut found = Meeting::new(along);
        let mut t = meet_tangent(sample, (from, along));
        let point = |t: Lanes<L>| [0, 1, 2].map(|k| from[k] + along[k] * t);
        let mut open = made.pictured;
        let (mut about, mut last) = (None, None);
        for _ in 0..MOST_STEPS {
            let [x, y, z] = point(t);
            let near = |x: f64, hit: f64| (x - hit).abs() <= self.farthest;
            let follows = |k: usize| near(x.0[k], sample.hit.x) && near(y.0[k], sample.hit.y);
            open = from_fn(|k| open[k] && follows(k));
            if !open.contains(&true) {
                break;
            }
            let surface = self.made_surfaces(
                sample,
                made,
                &mut about,
                [x, y, z],
                &open,
                &mut found.evaluated,
            );
            let step =
                (z - surface[0]) / (along[2] - along[0] * surface[1] - along[1] * surface[2]);
            t = t - step;
            let ended: [bool; L] = from_fn(|k| open[k] && step.0[k].abs() < LAST_STEP);
            let slope = [surface[1], surface[2]];
            if let (true, Some((before, slope_before))) = (ended.contains(&true), last) {
                found.end(&ended, point(t), [slope, slope_before], step / before);
            }
            open = from_fn(|k| open[k] && !ended[k]);
            last = Some((step, slope));
        }
        found
    }

    /// Height and slopes of the made surfaces at places of the rays; anything of those that are not `open`.
    #[inline]
    fn made_surfaces<const L: usize>(
        &self,
        sample: &PixelSample,
        made: &SideBySide<L>,
        about: &mut Option<WaveExpansion<L>>,
        [x, y, z]: [Lanes<L>; 3],
        open: &[bool; L],
        evaluated: &mut [[usize; 2]; L],
    ) -> [Lanes<L>; 3] {
        let at = [x, y];
        let alone = |k: usize| at.map(|x| x.0[k]);
        let mut sum = match &sample.base {
            Some((degree, c)) => values(*degree, c, &sample.square, at),
            None => [Lanes::constant(0.0); 3],
        };
        for k in (0..L).filter(|&k| open[k]) {
            let expanded = sample.base.is_some() && sample.square.holds(alone(k));
            evaluated[k][usize::from(expanded)] += 1;
            if !expanded {
                let designed = self.designed(&self.panels[sample.panel], alone(k), z.0[k]);
                sum.iter_mut().zip(designed).for_each(|(sum, x)| sum.0[k] = x);
            }
        }
        let polynomials = made.forms.polynomials(at);
        let waves = made.forms.waves(about, &sample.seen, at, open);
        sum = [0, 1, 2].map(|i| sum[i] + (polynomials[i] + waves[i]));
        for (k, state) in made.states.iter().enumerate() {
            if open[k] && (state.map.is_some() || state.tracks.is_some()) {
                let (smooth, site) = (sum.map(|x| x.0[k]), &sample.site);
                let textured = self.add_map_and_tracks(smooth, state, alone(k), site);
                sum.iter_mut().zip(textured).for_each(|(sum, x)| sum.0[k] = x);
            }
        }
        sum
    }
}

impl<const L: usize> Meeting<L> {
    /// No meeting yet of lines in this direction.
    fn new(along: [Lanes<L>; 3]) -> Self {
        let none = Lanes::constant(f64::NAN);
        let (met, evaluated) = ([false; L], [[0; 2]; L]);
        Self { along, at: [none; 3], slope: [none; 2], met, evaluated }
    }

    /// Takes down the places of those that `ended`, after a last step that is `more` times the one before.
    /// So short a step changes the slope as the one before did.
    #[inline]
    fn end(
        &mut self,
        ended: &[bool; L],
        at: [Lanes<L>; 3],
        [slope, before]: [[Lanes<L>; 2]; 2],
        more: Lanes<L>,
    ) {
        let slope = [0, 1].map(|i| slope[i] + (slope[i] - before[i]) * more);
        for k in (0..L).filter(|&k| ended[k]) {
            self.at.iter_mut().zip(at).for_each(|(found, at)| found.0[k] = at.0[k]);
            self.slope.iter_mut().zip(slope).for_each(|(found, p)| found.0[k] = p.0[k]);
            self.met[k] = true;
        }
    }
}
