//! The as-cut surface: at each place the lowest ball of all those that pass over it.
//!
//! A pass is a curve of ball centres, the mirror's places along one line of the plan plus the ball's
//! radius along the normal, known by its points and derivatives and between them by cubics. The height of
//! the cut under one pass is the least of C_z(t) - sqrt(R^2 - |(X, Y) - C_xy(t)|^2), found by Newton's method.

mod ball_path;
mod pass;
mod path;

pub use ball_path::{BallPath, BallPaths};

use super::{BallRaster, MachiningError};
use crate::geom::DVec2;
use crate::mirror::Mirror;
use crate::parallel;
use pass::Pass;
use path::{Line, passes_along_ridge};

/// Longest step along a pass, as a share of the face's size; otherwise a stepover.
const LONGEST: f64 = 1.0 / 200.0;
/// Most points of all passes.
pub const MOST_POINTS: f64 = 2e7;

/// All passes of a raster, and those that follow the ridge of a folded mirror.
#[derive(Debug, Clone)]
pub struct Passes {
    raster: BallRaster,
    across: DVec2,
    /// Number of the first line; line k runs at (k + 1/2) stepovers from the axis.
    first: i64,
    lines: Vec<Vec<Pass>>,
    ridge: Vec<Pass>,
}

impl Passes {
    /// The passes of `raster` over the face that lies between the corners `lo` and `hi` of X and Y, and
    /// one beyond its rims. Lines lie evenly on both sides of the axis, none through it. A ridge has passes of
    /// its own: one along the bottom of a valley, where lines have a gap, and one on either side of a crest.
    ///
    /// # Errors
    /// [`MachiningError::TooFine`] when there are too many, [`MachiningError::Lost`] when a line leaves the
    /// mirror.
    pub fn new(
        mirror: &Mirror,
        [lo, hi]: [DVec2; 2],
        raster: BallRaster,
    ) -> Result<Self, MachiningError> {
        let w = raster.stepover_mm;
        let (along, across) = (raster.along(), raster.along().perp());
        let [[t_lo, t_hi], [u_lo, u_hi]] = [along, across].map(|way| range([lo, hi], way));
        let step = step([lo, hi], &raster);
        let count = Self::points([lo, hi], &raster);
        if !(count <= MOST_POINTS) {
            let (stepover_mm, what, least_mm) = (w, "points of passes", None);
            return Err(MachiningError::TooFine { stepover_mm, count, what, least_mm });
        }
        let first = (u_lo / w - 0.5).floor() as i64 - 1;
        let last = (u_hi / w - 0.5).ceil() as i64 + 1;
        let line = |k: i64| -> Result<Vec<Pass>, MachiningError> {
            let foot = across * ((k as f64 + 0.5) * w);
            let ends = [t_lo - 2.0 * w, t_hi + 2.0 * w];
            Line { mirror, raster, foot, along, ends }.passes(step)
        };
        // Gathered before the first error is looked for, which is the same on any number of threads.
        let count = (last - first + 1).max(0) as usize;
        let lines = parallel::map(count, 1, |k| line(first + k as i64));
        let lines = lines.into_iter().collect::<Result<_, _>>()?;
        Ok(Self {
            raster,
            across,
            first,
            lines,
            ridge: passes_along_ridge(mirror, raster.ball_mm, step),
        })
    }

    /// How many points the passes of `raster` would have, about; no more than [`MOST_POINTS`] are made.
    #[must_use]
    pub fn points(corners: [DVec2; 2], raster: &BallRaster) -> f64 {
        let w = raster.stepover_mm;
        let wide = |way: DVec2| {
            let [lo, hi] = range(corners, way);
            hi - lo + 4.0 * w
        };
        let along = raster.along();
        wide(along.perp()) / w * (wide(along) / step(corners, raster))
    }

    /// The raster.
    #[must_use]
    pub fn raster(&self) -> BallRaster {
        self.raster
    }

    /// How far from half way between lines `k` - 1 and `k`, that is from `k` stepovers, the cut of one meets
    /// that of the other at `x` along them, mm; none where it does not near there.
    #[must_use]
    pub fn cusp(&self, x: f64, k: i64) -> Option<f64> {
        let BallRaster { ball_mm, stepover_mm, .. } = self.raster;
        let line = |k: i64| self.lines.get(usize::try_from(k - self.first).ok()?);
        let (before, after) = (line(k - 1)?, line(k)?);
        let height = |line: &[Pass], xy: DVec2| {
            line.iter().filter_map(|pass| pass.height(xy, ball_mm)).reduce(f64::min)
        };
        let higher = |off: f64| {
            let xy = self.raster.along() * x + self.across * (k as f64 * stepover_mm + off);
            Some(height(before, xy)? - height(after, xy)?)
        };
        let [from, to] = [-0.4 * stepover_mm, 0.4 * stepover_mm];
        let [low, high] = [higher(from)?, higher(to)?];
        if !(low < 0.0 && high > 0.0) {
            return None;
        }
        // The difference is almost straight: false position, a step of Newton's method with the slope of the
        // parabola through the three places, and one of the secant through the last two.
        let off = from + (to - from) * low / (low - high);
        let value = higher(off)?;
        let slope =
            (value - low) / (off - from) + (high - value) / (to - off) - (high - low) / (to - from);
        if !(slope > 0.0) {
            return None;
        }
        let next = (off - value / slope).clamp(from, to);
        let left = higher(next)?;
        let last = next - left * (next - off) / (left - value);
        Some(if last.is_finite() { last.clamp(from, to) } else { next })
    }

    /// Height of the cut surface over (X, Y), mm; none where no pass comes.
    #[must_use]
    pub fn height(&self, xy: DVec2) -> Option<f64> {
        let at = xy.dot(self.across) / self.raster.stepover_mm - 0.5;
        // The two lines beside it and, as they may be curved or broken, the next two.
        let near = (at.floor() as i64 - 1)..=(at.floor() as i64 + 2);
        let lines = near.filter_map(|k| self.lines.get(usize::try_from(k - self.first).ok()?));
        let all = lines.flatten().chain(&self.ridge);
        let heights = all.filter_map(|pass| pass.height(xy, self.raster.ball_mm));
        heights.reduce(f64::min)
    }
}

/// The step along passes, mm.
fn step([lo, hi]: [DVec2; 2], raster: &BallRaster) -> f64 {
    raster.stepover_mm.min(LONGEST * (hi - lo).max_element())
}

/// The least and the largest part along `way` of the rectangle between two corners.
fn range([lo, hi]: [DVec2; 2], way: DVec2) -> [f64; 2] {
    let all = [lo, hi, DVec2::new(lo.x, hi.y), DVec2::new(hi.x, lo.y)].map(|p| p.dot(way));
    [all.into_iter().fold(f64::MAX, f64::min), all.into_iter().fold(f64::MIN, f64::max)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machining::Scallop;
    use crate::mirror::fixtures::{quadric, roof};
    use crate::num::{radians, tan};

    const CORNERS: [DVec2; 2] = [DVec2::splat(-4.0), DVec2::splat(4.0)];

    fn passes(terms: [f64; 3], raster: BallRaster) -> (Mirror, Passes) {
        let mirror = quadric(terms, 0.0);
        let passes = Passes::new(&mirror, CORNERS, raster).unwrap();
        (mirror, passes)
    }

    #[test]
    fn over_a_plane_the_cut_is_a_row_of_circles() {
        for degrees in [0.0, 90.0, 33.0] {
            let raster = BallRaster { ball_mm: 3.0, stepover_mm: 0.5, angle: radians(degrees) };
            let (_, passes) = passes([0.0; 3], raster);
            for k in 0..200 {
                let xy = DVec2::new(f64::from(k % 20) * 0.4 - 3.9, f64::from(k / 20) * 0.81 - 3.9);
                let u = xy.dot(raster.along().perp()) / 0.5;
                let off = 0.5 * (u.ceil() - 0.5 - u);
                let exact = 7.0 + 3.0 - (9.0 - off * off).sqrt();
                assert!((passes.height(xy).unwrap() - exact).abs() < 1e-13, "{degrees} {xy}");
            }
        }
    }

    /// On a curved mirror the cut differs from the formula of [`Scallop`] by what is smaller by a power of
    /// the stepover: its slope, of first order, by the second order at most.
    #[test]
    fn scallops_converge_to_the_formula_on_twisted_ground() {
        for (terms, degrees) in
            [([-0.04, 0.0, -0.02], 0.0), ([0.05, 0.03, -0.06], 20.0), ([0.02, -0.07, 0.03], 110.0)]
        {
            let off = |w: f64| {
                let raster = BallRaster { ball_mm: 2.0, stepover_mm: w, angle: radians(degrees) };
                let (mirror, passes) = passes(terms, raster);
                let across = raster.along().perp();
                let mut worst = 0.0f64;
                for k in 0..40 {
                    let near = DVec2::new(f64::from(k % 8) - 3.5, f64::from(k / 8) * 1.4 - 2.8);
                    // The nearest cusp, half way between two lines.
                    let cusp =
                        near + across * (w * (near.dot(across) / w).round() - near.dot(across));
                    let place = mirror.extended_surface(cusp);
                    let left = (passes.height(cusp).unwrap() - place.at.z) / place.stretch();
                    let scallop = Scallop::new(&place, 2.0, raster.along()).unwrap();
                    worst = worst.max((left / scallop.height_mm(w).unwrap() - 1.0).abs());
                }
                worst
            };
            let found = [0.2, 0.1, 0.05].map(off);
            assert!(found[2] < 0.01 && found[1] < 0.6 * found[0], "{terms:?}: {found:?}");
            assert!(found[2] < 0.6 * found[1], "{terms:?}: {found:?}");
        }
    }

    #[test]
    fn a_roof_upside_down_is_cut_to_a_fillet_of_the_balls_radius() {
        // Z = 7 + |Y| tan(30 deg): the ball touches at |Y| = R sin 30.
        let steep = tan(radians(30.0));
        let mirror = roof(30.0);
        for degrees in [0.0, 90.0, 40.0] {
            let raster = BallRaster { ball_mm: 2.0, stepover_mm: 0.1, angle: radians(degrees) };
            let passes = Passes::new(&mirror, CORNERS, raster).unwrap();
            let top = 7.0 + 2.0 / crate::num::cos(radians(30.0));
            for k in 0..50 {
                let xy = DVec2::new(3.9 - 0.15 * f64::from(k), 0.06 * f64::from(k) - 1.5);
                let height = passes.height(xy).unwrap();
                let exact = if xy.y.abs() < 1.0 {
                    top - (4.0 - xy.y * xy.y).sqrt()
                } else {
                    7.0 + steep * xy.y.abs()
                };
                // Scallops of w^2 / 8 R on a slope of 30 degrees.
                let above = height - exact;
                assert!(above > -1e-12 && above < 1.4e-3, "{degrees} {xy}: {above}");
            }
        }
    }
}
