//! Cusps: the lines in which the cuts of neighbouring passes meet, and rows of a lattice that follow them.
//!
//! Half way between two lines is the cusp on a plane alone: elsewhere it is off by a share of the
//! stepover that grows with it. A facet across a cusp would take both slopes for their mean.

use super::Passes;
use crate::geom::{DVec2, turn};
use crate::parallel;

/// How far the cusps are from half way between their lines, at places along these.
pub(super) struct Cusps {
    stepover_mm: f64,
    along_mm: f64,
    /// Numbers of the first cusp, `first.y` stepovers from the axis, and of the first place, `first.x`
    /// times `along_mm` along the lines.
    first: [i64; 2],
    places: usize,
    /// Cusp by cusp, mm.
    off: Vec<f64>,
}

impl Cusps {
    /// Of `passes` over the face between the corners `lo` and `hi` (x along the lines, y across them), at
    /// multiples of `along_mm`.
    pub(super) fn new(passes: &Passes, [lo, hi]: [DVec2; 2], along_mm: f64) -> Self {
        let stepover_mm = passes.raster().stepover_mm;
        let pitch = DVec2::new(along_mm, stepover_mm);
        let [from, to] = [(lo / pitch).floor(), (hi / pitch).ceil()];
        let first = [from.x as i64, from.y as i64];
        let [places, cusps] = [to.x - from.x, to.y - from.y].map(|count| count as usize + 1);
        let off = |n: usize| {
            let x = (first[0] + (n % places) as i64) as f64 * along_mm;
            passes.cusp(x, first[1] + (n / places) as i64).unwrap_or(0.0)
        };
        let off = parallel::map(places * cusps, 1, off);
        Self { stepover_mm, along_mm, first, places, off }
    }

    /// Where the place (`x`, `y`) of the lattice goes across the lines: on the cusp if it is half way between
    /// two lines, on its line if it is on one, and evenly in between.
    pub(super) fn snap(&self, x: f64, y: f64) -> f64 {
        let at = y / self.stepover_mm;
        let share = 1.0 - 2.0 * (at - at.round()).abs();
        let column = (x / self.along_mm).round() as i64 - self.first[0];
        let cusp = at.round() as i64 - self.first[1];
        y + share * self.off[cusp as usize * self.places + column as usize]
    }
}

/// The least that snapping may leave of a facet's area.
const LEFT: f64 = 0.2;

/// Puts the corners of facets back on their rows, `straight` across the lines, where the snapped corners leave
/// next to nothing of the facet or turn it over.
pub(super) fn straighten(x: &[f64], straight: &[f64], snapped: &mut [f64], triangles: &[[u32; 3]]) {
    let area = |t: &[u32; 3], y: &[f64]| {
        let [a, b, c] = t.map(|v| DVec2::new(x[v as usize], y[v as usize]));
        turn(a, b, c)
    };
    let mut any = true;
    while any {
        any = false;
        for t in triangles {
            let moved = t.iter().any(|&v| snapped[v as usize] != straight[v as usize]);
            if moved && !(area(t, snapped) >= LEFT * area(t, straight)) {
                any = true;
                for &v in t {
                    snapped[v as usize] = straight[v as usize];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machining::BallRaster;
    use crate::mirror::fixtures::quadric;
    use crate::num::radians;

    const CORNERS: [DVec2; 2] = [DVec2::splat(-4.0), DVec2::splat(4.0)];

    /// Over a slope of tan t across the lines both balls keep their distance, so the cut is a row of
    /// circles turned by t: its cusps are on the chord's bisector, R - sqrt(R^2 - W^2/4) up the normal.
    #[test]
    fn on_a_slope_cusps_stand_up_the_normal() {
        use crate::num::{atan, sin};
        let (ball, w, steep) = (2.0, 0.4, 0.75);
        let mut mirror = quadric([0.0; 3], 0.0);
        let crate::mirror::Surface::Tensor(sheet) = &mut mirror.surface else { unreachable!() };
        // f = steep y.
        sheet.series =
            crate::num::legendre::Series::from_fn(
                1,
                2,
                |_, j| {
                    if j == 1 { 4.0 * steep } else { 0.0 }
                },
            );
        let raster = BallRaster { ball_mm: ball, stepover_mm: w, angle: 0.0 };
        let passes = Passes::new(&mirror, CORNERS, raster).unwrap();
        let apart = w * f64::sqrt(1.0 + steep * steep);
        let height = ball - f64::sqrt(ball * ball - 0.25 * apart * apart);
        let exact = -height * sin(atan(steep));
        let cusps = Cusps::new(&passes, CORNERS, 0.5);
        for (x, y) in [(0.0, 0.0), (3.5, -2.0), (-4.0, 3.6)] {
            assert!(
                (cusps.snap(x, y) - y - exact).abs() < 1e-5,
                "{} {exact}",
                cusps.snap(x, y) - y
            );
            assert!((cusps.snap(x, y + 0.2) - y - 0.2).abs() < 1e-14);
            assert!((cusps.snap(x, y + 0.1) - y - 0.1 - 0.5 * exact).abs() < 1e-5);
        }
    }

    #[test]
    fn at_a_cusp_both_lines_cut_alike() {
        for degrees in [0.0, 37.0] {
            let raster = BallRaster { ball_mm: 2.0, stepover_mm: 0.3, angle: radians(degrees) };
            let mirror = quadric([-0.05, 0.04, 0.07], 0.0);
            let passes = Passes::new(&mirror, CORNERS, raster).unwrap();
            let mut farthest = 0.0f64;
            for (k, x) in [(-7, 1.1), (0, -2.0), (5, 0.3), (9, -1.7)] {
                let off = passes.cusp(x, k).unwrap();
                let height = |more: f64| {
                    let y = f64::from(k as i32) * 0.3 + off + more;
                    passes.height(raster.along() * x + raster.along().perp() * y).unwrap()
                };
                // The slope falls by s w, some 0.3 / 2, from one side to the other.
                let e = 1e-4;
                let [left, right] = [-e, e].map(|more| height(more) - height(0.0));
                assert!(left + right < -0.08 * e, "{left} {right}");
                farthest = farthest.max(off.abs());
            }
            assert!(farthest > 1e-4, "{farthest}");
        }
    }

    #[test]
    fn facets_that_snapping_turns_over_are_put_back() {
        let (x, straight) = ([0.0, 1.0, 0.5, 0.5], [0.0, 0.0, 0.1, -1.0]);
        let triangles = [[0, 1, 2], [0, 3, 1]];
        let mut snapped = [0.0, 0.0, -0.1, -1.2];
        straighten(&x, &straight, &mut snapped, &triangles);
        assert_eq!(snapped, [0.0, 0.0, 0.1, -1.2]);
    }
}
