//! Form errors and waviness of several made systems, side by side.
//!
//! A system's polynomials are added up once; its waves are added up where a ray meets the mirror, in full, and
//! stand for themselves nearby by their slopes and second derivatives.

use super::super::form_field::FormField;
use super::super::local_polynomial::{start, terms, value};
use super::state::PerturbedState;
use crate::num::{Arithmetic, Lanes};
use std::array::from_fn;

/// Phase, rad, of the finest wave over which all are expanded to the second order about one place: their
/// slopes are then known to 4e-10 of themselves, and a telecentric camera's ray stays within it.
const EXPANDED_PHASE: f64 = 2e-5;

/// Form errors of one system by what they are made of: polynomials in common variables, and waves.
#[derive(Debug, Clone)]
pub(crate) struct FormBasis {
    /// Largest total degree of the polynomials.
    degree: usize,
    frames: Vec<PolynomialFrame>,
    waves: Vec<Wave>,
    /// Distance along X and along Y, mm, within which an expansion of the waves holds.
    reach_mm: f64,
}

/// Polynomials of (u, v) = ((x, y) - centre) / half.
#[derive(Debug, Clone)]
struct PolynomialFrame {
    centre: [f64; 2],
    half: [f64; 2],
    /// Number of each form error, and its coefficients in the order of [`value`].
    forms: Vec<(usize, Vec<f64>)>,
}

/// A wave of the form errors, or the waviness.
#[derive(Debug, Clone, Copy)]
struct Wave {
    /// Wave vector, 1/mm.
    vector: [f64; 2],
    /// Numbers of the form errors that are its cosine and its sine; none of the waviness.
    forms: Option<[usize; 2]>,
}

impl FormBasis {
    /// The basis of `fields`, in which each cosine is followed by its sine, and of a waviness of this wave
    /// vector.
    pub(crate) fn new(fields: &[FormField], waviness: [f64; 2]) -> Self {
        let degrees = fields.iter().flat_map(|field| match field {
            FormField::Polynomial { terms, .. } => terms.as_slice(),
            _ => &[],
        });
        let degree = degrees.map(|(i, j, _)| i + j).max().unwrap_or(0);
        let mut made =
            Self { degree, frames: Vec::new(), waves: Vec::new(), reach_mm: f64::INFINITY };
        for (k, field) in fields.iter().enumerate() {
            match field {
                FormField::Polynomial { centre, half, terms } => {
                    let form = (k, made.coefficients(terms));
                    made.frame(*centre, *half).forms.push(form);
                }
                FormField::Cosine(vector) => {
                    made.waves.push(Wave { vector: *vector, forms: Some([k, k + 1]) });
                }
                FormField::Sine(_) => {}
            }
        }
        made.waves.push(Wave { vector: waviness, forms: None });
        let components = made.waves.iter().flat_map(|wave| wave.vector);
        let finest = components.fold(0.0, |most: f64, k| most.max(k.abs()));
        made.reach_mm = EXPANDED_PHASE / finest;
        made
    }

    /// Coefficients in the order of [`value`] of a sum of c u^i v^j over (i, j, c).
    fn coefficients(&self, sum: &[(usize, usize, f64)]) -> Vec<f64> {
        let mut c = vec![0.0; terms(self.degree)];
        for &(i, j, size) in sum {
            c[start(self.degree, i) + j] += size;
        }
        c
    }

    fn frame(&mut self, centre: [f64; 2], half: [f64; 2]) -> &mut PolynomialFrame {
        let same = |frame: &PolynomialFrame| (frame.centre, frame.half) == (centre, half);
        let found = self.frames.iter().position(same).unwrap_or(self.frames.len());
        if found == self.frames.len() {
            self.frames.push(PolynomialFrame { centre, half, forms: Vec::new() });
        }
        &mut self.frames[found]
    }

    /// Wave vectors, 1/mm, of all waves, the waviness last.
    pub(crate) fn wave_vectors(&self) -> impl Iterator<Item = [f64; 2]> {
        self.waves.iter().map(|wave| wave.vector)
    }
}

/// Form errors and waviness of `L` systems.
#[derive(Debug, Clone)]
pub(super) struct MadeForms<const L: usize> {
    degree: usize,
    polynomials: Vec<MadePolynomial<L>>,
    waves: Vec<MadeWave<L>>,
    reach_mm: f64,
}

#[derive(Debug, Clone)]
struct MadePolynomial<const L: usize> {
    centre: [f64; 2],
    half: [f64; 2],
    c: Vec<Lanes<L>>,
}

#[derive(Debug, Clone, Copy)]
struct MadeWave<const L: usize> {
    /// Its number.
    number: usize,
    vector: [f64; 2],
    /// Amplitudes of cosine and sine, mm.
    amplitudes: [Lanes<L>; 2],
}

/// The sum of waves about one place.
#[derive(Debug, Clone, Copy)]
pub(super) struct WaveExpansion<const L: usize> {
    at: [Lanes<L>; 2],
    /// Height, slopes along X and Y, and second derivatives by XX, XY and YY there.
    sums: [Lanes<L>; 6],
}

impl<const L: usize> MadeForms<L> {
    /// Those of the systems with these errors. Waves that none of them has are left out.
    pub(super) fn new(basis: &FormBasis, states: [&PerturbedState<f64>; L]) -> Self {
        let form = |k: usize| Lanes(states.map(|state| state.form[k]));
        let polynomial = |frame: &PolynomialFrame| {
            let mut c = vec![Lanes::constant(0.0); terms(basis.degree)];
            for (k, terms) in &frame.forms {
                let amplitude = form(*k);
                c.iter_mut().zip(terms).for_each(|(sum, c)| *sum = *sum + amplitude * *c);
            }
            let &PolynomialFrame { centre, half, .. } = frame;
            let acts = c.iter().any(|c| *c != Lanes::constant(0.0));
            acts.then_some(MadePolynomial { centre, half, c })
        };
        let wave = |(number, &Wave { vector, forms }): (usize, &Wave)| {
            let amplitudes = match forms {
                Some(forms) => forms.map(form),
                None => [0, 1].map(|k| Lanes(states.map(|s| s.wave.unwrap_or_default()[k]))),
            };
            let acts = amplitudes != [Lanes::constant(0.0); 2];
            acts.then_some(MadeWave { number, vector, amplitudes })
        };
        Self {
            degree: basis.degree,
            polynomials: basis.frames.iter().filter_map(polynomial).collect(),
            waves: basis.waves.iter().enumerate().filter_map(wave).collect(),
            reach_mm: basis.reach_mm,
        }
    }

    /// Height and slopes of the polynomials.
    #[inline]
    pub(super) fn polynomials(&self, at: [Lanes<L>; 2]) -> [Lanes<L>; 3] {
        let mut sum = [Lanes::constant(0.0); 3];
        for MadePolynomial { centre, half, c } in &self.polynomials {
            let unit = [0, 1].map(|k| (at[k] - centre[k]) / half[k]);
            let [f, f_u, f_v] = value(self.degree, c, unit);
            sum = [sum[0] + f, sum[1] + f_u / half[0], sum[2] + f_v / half[1]];
        }
        sum
    }

    /// Height and slopes of the waves as a pixel sees them that sees these shares of each: by the expansion
    /// `about` of an earlier place where it holds, and for the systems where it does not by one that takes its
    /// place. Systems that are not `open` are not asked about.
    #[inline]
    pub(super) fn waves(
        &self,
        about: &mut Option<WaveExpansion<L>>,
        seen: &[f64],
        at: [Lanes<L>; 2],
        open: &[bool; L],
    ) -> [Lanes<L>; 3] {
        if self.waves.is_empty() {
            return [Lanes::constant(0.0); 3];
        }
        let held = about.map(|about| {
            let near = |k: usize, i: usize| (at[i].0[k] - about.at[i].0[k]).abs() <= self.reach_mm;
            (about, from_fn::<bool, L, _>(|k| !open[k] || near(k, 0) && near(k, 1)))
        });
        let made = match held {
            Some((about, held)) if !held.contains(&false) => about,
            Some((about, held)) => self.expanded(seen, at).keeping(about, held),
            None => self.expanded(seen, at),
        };
        *about = Some(made);
        made.at(at)
    }

    fn expanded(&self, seen: &[f64], at: [Lanes<L>; 2]) -> WaveExpansion<L> {
        let mut sums = [Lanes::constant(0.0); 6];
        for &MadeWave { number, vector: [k, l], amplitudes: [a, b] } in &self.waves {
            let [sine, cosine] = (at[0] * k + at[1] * l).sin_cos();
            let height = (a * cosine + b * sine) * seen[number];
            let rise = (b * cosine - a * sine) * seen[number];
            sums[0] = sums[0] + height;
            sums[1] = sums[1] + rise * k;
            sums[2] = sums[2] + rise * l;
            sums[3] = sums[3] - height * (k * k);
            sums[4] = sums[4] - height * (k * l);
            sums[5] = sums[5] - height * (l * l);
        }
        WaveExpansion { at, sums }
    }
}

impl<const L: usize> WaveExpansion<L> {
    /// `other` for the systems that are to keep it, this for the rest.
    fn keeping(mut self, other: Self, kept: [bool; L]) -> Self {
        let pairs = self.at.iter_mut().zip(&other.at).chain(self.sums.iter_mut().zip(&other.sums));
        for (mine, other) in pairs {
            for (k, _) in kept.iter().enumerate().filter(|(_, kept)| **kept) {
                mine.0[k] = other.0[k];
            }
        }
        self
    }

    /// Height and slopes at a place nearby.
    #[inline]
    fn at(&self, at: [Lanes<L>; 2]) -> [Lanes<L>; 3] {
        let [x, y] = [0, 1].map(|k| at[k] - self.at[k]);
        let [f, f_x, f_y, f_xx, f_xy, f_yy] = self.sums;
        let (bent_x, bent_y) = (f_xx * x + f_xy * y, f_xy * x + f_yy * y);
        let height = f + x * (f_x + bent_x * 0.5) + y * (f_y + bent_y * 0.5);
        [height, f_x + bent_x, f_y + bent_y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{cos, sin};
    use crate::tolerance::form_field::{ripple, slope_modes};
    use crate::tolerance_terms::FormMeasure;

    /// Polynomials of two frames, the waves of a random slope, and a waviness.
    fn fields() -> Vec<FormField> {
        let rect = [(2, 0), (1, 2), (4, 0)]
            .map(|(i, j)| FormField::legendre(i, j, [1.0, -2.0], [30.0, 20.0], FormMeasure::Pv));
        let disc = [4, 11].map(|j| FormField::zernike(j, 25.0, FormMeasure::Rms));
        let waves = slope_modes(1.5, 60.0).into_iter().map(|(field, _)| field);
        rect.into_iter().chain(disc).chain(waves).collect()
    }

    fn state(k: usize, forms: usize) -> PerturbedState<f64> {
        let mut state = PerturbedState::perfect(forms);
        let size = |i: usize| 1e-3 * sin((3 * k * forms + i) as f64);
        state.form = (0..forms).map(size).collect();
        state.wave = Some([2e-4, -1e-4 * k as f64]);
        state
    }

    #[test]
    fn sums_are_those_of_all_form_errors() {
        const WAVE: [f64; 2] = [0.4, 2.5];
        let fields = fields();
        let basis = FormBasis::new(&fields, WAVE);
        let seen: Vec<f64> = (0..basis.wave_vectors().count()).map(|k| cos(k as f64)).collect();
        let states = [0, 1, 2].map(|k| state(k, fields.len()));
        let made = MadeForms::new(&basis, states.each_ref());
        let mut about = None;
        let (far, near) = (0.3, 0.9 * basis.reach_mm);
        for step in [[0.0, 0.0], [near, -near], [far, 0.0], [far, near], [far, far]] {
            let at = [Lanes([7.0, -4.5, 0.1]) + step[0], Lanes([-3.0, 11.0, 0.2]) + step[1]];
            let waves = made.waves(&mut about, &seen, at, &[true; 3]);
            let polynomials = made.polynomials(at);
            for (k, state) in states.iter().enumerate() {
                let alone = at.map(|x| x.0[k]);
                let mut exact = ripple(WAVE, state.wave.unwrap(), alone);
                exact = exact.map(|x| x * seen.last().unwrap());
                for (number, (a, field)) in state.form.iter().zip(&fields).enumerate() {
                    let wave = basis
                        .waves
                        .iter()
                        .position(|wave| wave.forms.is_some_and(|forms| forms.contains(&number)));
                    let share = wave.map_or(1.0, |wave| seen[wave]);
                    exact = [0, 1, 2].map(|i| exact[i] + a * share * field.at(alone)[i]);
                }
                for i in 0..3 {
                    let off = waves[i].0[k] + polynomials[i].0[k] - exact[i];
                    // About 7e-4 mm times the square of the phase to the place expanded about.
                    assert!(off.abs() < 2e-12, "{step:?} {k} {i}: {off:e}");
                }
            }
        }
    }

    #[test]
    fn expansions_are_kept_by_those_alone_that_stay_near() {
        let fields = fields();
        let basis = FormBasis::new(&fields, [0.4, 2.5]);
        let seen: Vec<f64> = basis.wave_vectors().map(|_| 1.0).collect();
        let states = [0, 1].map(|k| state(k, fields.len()));
        let both = MadeForms::new(&basis, states.each_ref());
        let single = [0, 1].map(|k| MadeForms::new(&basis, [&states[k]]));
        let (mut about, mut abouts) = (None, [None; 2]);
        let near = 0.5 * basis.reach_mm;
        for [a, b] in [[0.0, 0.0], [near, 1.0], [1.0, 1.0 + near], [1.0 + near, 1.0 + near]] {
            let at = [Lanes([3.0 + a, 5.0 + b]), Lanes([a, -b])];
            let found = both.waves(&mut about, &seen, at, &[true; 2]);
            for k in 0..2 {
                let at = at.map(|x| Lanes([x.0[k]]));
                let alone = single[k].waves(&mut abouts[k], &seen, at, &[true]);
                let same = (0..3).all(|i| found[i].0[k].to_bits() == alone[i].0[0].to_bits());
                assert!(same, "{a} {b}: {k}");
            }
        }
    }

    #[test]
    fn what_no_system_has_is_left_out() {
        let fields = fields();
        let basis = FormBasis::new(&fields, [0.4, 2.5]);
        let mut states = [0, 1].map(|_| PerturbedState::<f64>::perfect(fields.len()));
        let none = MadeForms::new(&basis, states.each_ref());
        assert!(none.waves.is_empty() && none.polynomials.is_empty());
        states[1].form[7] = 1e-3;
        let one = MadeForms::new(&basis, states.each_ref());
        assert!(one.waves.len() == 1 && one.polynomials.is_empty());
    }
}
