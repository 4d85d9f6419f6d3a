//! First derivatives of the displacements by every error, exact.

use super::engine::{Engine, Made, Question};
use super::local::{DEGREE, Terms};
use super::model::{PLACED, Pose, Sample, State, System};
use super::source::{Kind, Source};
use crate::num::{Dual, Scalar};
use rayon::prelude::*;

type D = Dual<1>;

/// Columns of derivatives: x and y of each sample, px, for each internal unit of an error, in the
/// order placing numbers, form errors, waviness' cosine and sine, map.
#[derive(Debug, Clone)]
pub struct Linear {
    columns: Vec<Vec<f64>>,
    forms: usize,
    /// By the surface's slope along X and along Y at the hit: [x, y] of each sample.
    by_slope: [Vec<[f64; 2]>; 2],
}

/// Where the terms u and v are.
const ALONG_U: usize = DEGREE + 1;
const ALONG_V: usize = 1;

impl Linear {
    /// Of `system`, whose form errors are `forms` and after them so many `modes`; columns that no
    /// source and no compensator may need are there too but for the map's.
    pub(super) fn new(system: &System, question: &Question, forms: &[Kind], modes: usize) -> Self {
        let forms = forms.len() + modes;
        let has_map = question.map.is_some();
        let count = PLACED + forms + 2 + usize::from(has_map);
        let per = 1.0 / system.camera.pixel_mm;
        let of = |sample: &Sample| -> (Vec<[f64; 2]>, [[f64; 2]; 2]) {
            let columns = (0..count).map(|k| {
                let state = varied(system, k, forms);
                let seen = system.content(sample, &Pose::new(&state.placed), &state);
                seen.map(|x| x.slope[0] * per)
            });
            let state = system.perfect::<D>();
            let pose = Pose::new(&state.placed);
            let by = [ALONG_U, ALONG_V].map(|k| {
                let mut terms: Terms<D> = sample.polynomial().map(D::constant);
                // A slope of 1 is `half` for a unit of u.
                terms[k].slope[0] = sample.half();
                let seen = system.seen(&sample.by_polynomial(), &pose, &state, &terms);
                seen.map(|x| x.slope[0] * per)
            });
            (columns.collect(), by)
        };
        let all: Vec<_> = system.samples.par_iter().map(of).collect();
        let column = |k: usize| all.iter().flat_map(|(columns, _)| columns[k]).collect();
        Self {
            columns: (0..count).map(column).collect(),
            forms,
            by_slope: [0, 1].map(|k| all.iter().map(|(_, by)| by[k]).collect()),
        }
    }

    /// The column of a placing number.
    #[must_use]
    pub fn placed(&self, k: usize) -> &[f64] {
        &self.columns[k]
    }

    /// Amplitudes of the columns in a state.
    fn amplitudes(&self, state: &State<f64>) -> Vec<f64> {
        let placed = state.placed.iter().copied();
        let wave = state.wave.unwrap_or_default();
        let map = state.map.unwrap_or(0.0);
        placed.chain(state.form.iter().copied()).chain(wave).chain([map]).collect()
    }
}

/// The perfect state with unit derivative by column `k`.
fn varied(system: &System, k: usize, forms: usize) -> State<D> {
    let mut state = system.perfect::<D>();
    let (zero, one) = (D::constant(0.0), D::variable(0.0, 0));
    match k {
        k if k < PLACED => state.placed[k] = one,
        k if k < PLACED + forms => state.form[k - PLACED] = one,
        k if k == PLACED + forms => state.wave = Some([one, zero]),
        k if k == PLACED + forms + 1 => state.wave = Some([zero, one]),
        _ => state.map = Some(one),
    }
    state
}

impl Engine {
    /// Displacement of a made system by first derivatives alone.
    #[must_use]
    pub fn linear_displacement(&self, made: &Made) -> Vec<f64> {
        let mut sum = self.base.clone();
        let amplitudes = self.linear.amplitudes(&made.state);
        for (a, column) in amplitudes.iter().zip(&self.linear.columns) {
            if *a != 0.0 {
                sum.iter_mut().zip(column).for_each(|(sum, c)| *sum += a * c);
            }
        }
        for (k, out) in sum.chunks_exact_mut(2).enumerate() {
            let noise = made.noise(k);
            let mut by_tracks = [0.0; 2];
            if let Some(tracks) = made.state.tracks {
                let slope = self.system.track_slope(k, tracks);
                let [by_x, by_y] = [0, 1].map(|axis| self.linear.by_slope[axis][k]);
                by_tracks = [0, 1].map(|i| slope[0] * by_x[i] + slope[1] * by_y[i]);
            }
            out.iter_mut().zip(noise).zip(by_tracks).for_each(|((out, a), b)| *out += a + b);
        }
        sum
    }

    /// Mean square of the displacement, px^2, that a source causes after adjustment, by first
    /// derivatives and its distribution. Patterns finer than the distance of samples count as
    /// independent from sample to sample.
    #[must_use]
    pub fn variance(&self, source: &Source) -> f64 {
        let square = source.limit * source.limit * source.distribution.mean_square();
        let Self { linear, .. } = self;
        let count = self.samples() as f64;
        let of = |k: usize| {
            let mut column = linear.columns[k].clone();
            self.compensation.apply(&mut column);
            column.iter().map(|x| x * x).sum::<f64>() / count
        };
        let free = 1.0 - self.adjustments().len() as f64 / (2.0 * count);
        let pixel = self.system.camera.pixel_mm;
        let form = |k: usize| 1e-6 * of(PLACED + k);
        square
            * match source.kind {
                Kind::Slope => {
                    let first = self.forms.len();
                    let modes = self.modes.iter().enumerate();
                    modes.map(|(m, a)| a * a * form(first + m)).sum()
                }
                Kind::Waviness => 0.125 * (form(linear.forms) + form(linear.forms + 1)),
                Kind::ToolMarks => {
                    let way = self.system.track_way();
                    let ball = self.question.texture.ball_radius_mm;
                    let by = |k: usize| {
                        let [x, y] = [0, 1].map(|axis| linear.by_slope[axis][k]);
                        let moved = [0, 1].map(|i| way[0] * x[i] + way[1] * y[i]);
                        moved[0] * moved[0] + moved[1] * moved[1]
                    };
                    let mean = (0..self.samples()).map(by).sum::<f64>() / count;
                    free * mean / (12.0 * ball * ball)
                }
                Kind::Facets => 0.5 * free,
                Kind::Map if self.question.map.is_some() => of(PLACED + linear.forms + 2),
                Kind::Map => 0.0,
                Kind::Legendre(..) | Kind::Zernike(_) => {
                    self.forms.iter().position(|form| *form == source.kind).map_or(0.0, form)
                }
                kind => super::engine::placed_by(kind, pixel, &self.question.texture)
                    .map_or(0.0, |(k, unit)| unit * unit * of(k)),
            }
    }
}
