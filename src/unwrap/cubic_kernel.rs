//! Cubic interpolation of code values in whole numbers, as OpenCV's `remap` with `INTER_CUBIC`: places in 32nds of a pixel, the cubic of
//! R. G. Keys (1981) with a = -3/4.

use std::ops::Range;
use std::sync::LazyLock;
use wide::{i16x8, u8x16};

/// Places between two samples that are told apart.
pub(super) const STEPS: i64 = 32;
/// Parameter of the cubic: slope of the kernel at 1.
const A: f64 = -0.75;
/// Bits of a weight after the point.
const BITS: u32 = 14;
/// Farthest that taps move to stay within their range: their first one lies up to two before it, their last one up to two behind.
const MOST_SHIFT: i64 = 2;
const SHIFTS: usize = 5;
/// Kernels of one shift.
const BLOCK: usize = (STEPS * STEPS) as usize;

/// Weights of 4 x 4 samples, row by row.
type Weights = [i16x8; 2];

/// The kernels by their numbers: blocks of a pair of shifts, first the one without any; in each the step down times 32 and the step across.
static KERNELS: LazyLock<Vec<Weights>> = LazyLock::new(|| {
    let kernel = |k: usize| {
        let (shifts, step) = ((k / BLOCK) as i64, (k % BLOCK) as i64);
        let shift = |number: i64| number - if number > MOST_SHIFT { SHIFTS as i64 } else { 0 };
        let [x, y] = [shifts % SHIFTS as i64, shifts / SHIFTS as i64].map(shift);
        whole(weights(step % STEPS, x), weights(step / STEPS, y))
    };
    (0..SHIFTS * SHIFTS * BLOCK).map(kernel).collect()
});

/// The kernels, for [`sampled`].
pub(super) fn kernels() -> &'static [Weights] {
    &KERNELS
}

/// The first of four samples of an axis that are used at a place, and which kernel is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Taps {
    /// Number of the sample.
    pub first: usize,
    /// Step between two samples.
    step: usize,
    /// By how much the samples moved to stay within their range, as a number from 0.
    shift: usize,
}

impl Taps {
    /// Those at a place, in samples from the first one's centre, of `range`: beyond it the sample at its edge repeats.
    ///
    /// # Panics
    /// When there are less than four samples.
    pub(super) fn at(place: f64, range: &Range<usize>) -> Self {
        assert!(range.len() >= 4, "as many samples as the kernel has");
        let [from, to] = [range.start, range.end].map(|edge| STEPS * edge as i64 - STEPS / 2);
        // (The cast saturates.)
        let place = ((place * STEPS as f64).round_ties_even() as i64).clamp(from, to);
        let (wanted, step) = (place.div_euclid(STEPS) - 1, place.rem_euclid(STEPS));
        let first = wanted.clamp(range.start as i64, range.end as i64 - 4);
        let shift = (wanted - first).rem_euclid(SHIFTS as i64);
        Self { first: first as usize, step: step as usize, shift: shift as usize }
    }

    /// Number of the kernel across and down.
    pub(super) fn kernel(across: Self, down: Self) -> u16 {
        let block = down.shift * SHIFTS + across.shift;
        (block * BLOCK + down.step * STEPS as usize + across.step) as u16
    }
}

/// Weights of four samples at a step, where the taps of the cubic lie `shift` samples farther than the four: taps beyond them are those at
/// the edge.
fn weights(step: i64, shift: i64) -> [f64; 4] {
    let t = step as f64 / STEPS as f64;
    let taps = [
        A * ((t - 2.0) * t + 1.0) * t,
        ((A + 2.0) * t - (A + 3.0)) * t * t + 1.0,
        ((-(A + 2.0) * t + 2.0 * A + 3.0) * t - A) * t,
        A * (1.0 - t) * t * t,
    ];
    let mut weights = [0.0; 4];
    for (k, tap) in taps.into_iter().enumerate() {
        weights[(k as i64 + shift).clamp(0, 3) as usize] += tap;
    }
    weights
}

/// The products in whole numbers, whose sum is 1.
fn whole(across: [f64; 4], down: [f64; 4]) -> Weights {
    let one = 1_i32 << BITS;
    let product =
        |k: usize| (across[k % 4] * down[k / 4] * f64::from(one)).round_ties_even() as i32;
    let mut all: [i32; 16] = std::array::from_fn(product);
    let largest = (0..16).fold(0, |best, k| if all[k] > all[best] { k } else { best });
    all[largest] += one - all.iter().sum::<i32>();
    let half = |first: usize| i16x8::new(std::array::from_fn(|k| all[first + k] as i16));
    [half(0), half(8)]
}

/// The value of a plane with rows of `width` samples at the kernel's place; `first`: index of the upper left of its samples.
#[inline]
pub(super) fn sampled(plane: &[u8], width: usize, first: u32, [upper, lower]: &Weights) -> u8 {
    // (One check of the bounds.)
    let span = &plane[first as usize..][..3 * width + 4];
    let mut samples = [0; 16];
    for (row, four) in samples.chunks_exact_mut(4).enumerate() {
        four.copy_from_slice(&span[row * width..row * width + 4]);
    }
    let samples = u8x16::new(samples);
    let sums =
        i16x8::from_u8x16_low(samples).dot(*upper) + i16x8::from_u8x16_high(samples).dot(*lower);
    let half = 1 << (BITS - 1);
    ((sums.reduce_add() + half) >> BITS).clamp(0, 255) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Value at a place of a plane of one row repeated.
    fn value(samples: &[u8], place: f64, range: Range<usize>) -> u8 {
        let plane = samples.repeat(4);
        let (across, down) = (Taps::at(place, &range), Taps::at(1.0, &(0..4)));
        sampled(
            &plane,
            samples.len(),
            across.first as u32,
            &kernels()[usize::from(Taps::kernel(across, down))],
        )
    }

    #[test]
    fn weights_sum_to_one_and_samples_are_kept() {
        for kernel in kernels() {
            let sum: i32 = kernel.iter().flat_map(|half| half.to_array()).map(i32::from).sum();
            assert_eq!(sum, 1 << BITS);
        }
        let samples = [0, 255, 7, 90, 255, 0, 3];
        for (k, sample) in samples.iter().enumerate() {
            assert_eq!(value(&samples, k as f64, 0..7), *sample, "{k}");
        }
    }

    #[test]
    fn between_samples_it_is_the_cubic_of_keys() {
        let samples = [10, 200, 30, 120, 250, 0, 90, 60];
        let cubic = |x: f64| match x.abs() {
            x if x <= 1.0 => (A + 2.0) * x * x * x - (A + 3.0) * x * x + 1.0,
            x if x < 2.0 => A * (x * x * x - 5.0 * x * x + 8.0 * x - 4.0),
            _ => 0.0,
        };
        // Each sample of a range, and those at its edges as often as they repeat.
        let range = 1..7;
        for k in 16..=7 * 32 - 16 {
            let place = f64::from(k) / 32.0;
            let edge = |i: i64| f64::from(samples[i.clamp(1, 6) as usize]);
            let wanted: f64 = (-4..12).map(|i: i64| edge(i) * cubic(place - i as f64)).sum();
            let found = f64::from(value(&samples, place, range.clone()));
            assert!((found - wanted.clamp(0.0, 255.0)).abs() < 0.51, "{place}: {found} {wanted}");
        }
        // Beyond the range its edge repeats.
        for (place, k) in [(-1e300, 1), (0.5, 1), (6.5, 6), (1e300, 6)] {
            let at_edge = value(&samples, if k == 1 { 0.5 } else { 6.5 }, range.clone());
            assert_eq!(value(&samples, place, range.clone()), at_edge, "{place}");
        }
    }

    #[test]
    fn a_ramp_is_what_the_cubic_makes_of_it_in_closed_form() {
        // With a = -3/4 the places of a ramp move by t/2 - 3/2 t^2 + t^3 between two samples, none at and half way between them.
        let samples: Vec<u8> = (0..16).map(|k| 16 * k).collect();
        for k in 32..12 * 32 {
            let place = f64::from(k) / 32.0;
            let t = place - place.floor();
            let wanted = 16.0 * (place + t * (0.5 + t * (t - 1.5)));
            let found = f64::from(value(&samples, place, 0..16));
            assert!((found - wanted).abs() < 0.51, "{place}: {found} {wanted}");
        }
    }
}
