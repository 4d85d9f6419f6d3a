//! Surfaces over a rectangle: a tensor Legendre series in the coordinates of a chart.

use super::bounds::{BoundCells, OFF};
use super::height_field::{HeightAndSlope, HeightField, HeightRow, Hessian};
use crate::geom::{DVec2, DerivativeBounds};
use crate::num::legendre::{Jet, Row, Series};
use crate::num::{Interval, bernstein};
use crate::parallel;

/// The surface f = s F(u, v), where (u, v) runs over [-1, 1]^2 as q runs over a rectangle, F is the
/// paper's f in the paper's units and s the scale in mm per unit.
#[derive(Debug, Clone)]
pub struct TensorLegendre {
    /// F.
    pub series: Series,
    /// Where (u, v) = (0, 0), mm.
    pub centre: DVec2,
    /// mm per unit of u and of v.
    pub half: DVec2,
    /// s, mm per unit of F.
    pub scale_mm: f64,
}

impl HeightField for TensorLegendre {
    type Row<'a> = TensorLegendreRow;

    fn row(&self, y: f64) -> TensorLegendreRow {
        TensorLegendreRow {
            row: self.series.row((y - self.centre.y) / self.half.y),
            centre: self.centre.x,
            per_mm: 1.0 / self.half.x,
            scale: self.scale_mm,
            slope: self.scale_mm / self.half,
        }
    }

    /// Without the memory that a row takes.
    fn at(&self, q: DVec2) -> HeightAndSlope {
        let [u, v] = self.unit(q);
        self.point(&self.series.gradient(u, v))
    }

    #[inline]
    fn at_each<const N: usize>(&self, places: [DVec2; N]) -> [HeightAndSlope; N] {
        let units = places.map(|q| self.unit(q));
        let jets = self.series.gradients(units.map(|[u, _]| u), units.map(|[_, v]| v));
        jets.map(|jet| self.point(&jet))
    }

    fn height(&self, q: DVec2) -> f64 {
        let [u, v] = self.unit(q);
        self.scale_mm * self.series.value(u, v)
    }

    fn hessian(&self, q: DVec2) -> Hessian {
        self.hessian_on(&self.row(q.y), q.x)
    }

    fn at_with_hessian(&self, q: DVec2) -> (HeightAndSlope, Hessian) {
        let [u, v] = self.unit(q);
        let jet = self.series.jet(u, v);
        (self.point(&jet), self.second(&jet))
    }

    /// Terms of odd degree change their sign.
    fn reflected(&self, axis: usize) -> Self {
        let (rows, columns) = self.series.shape();
        let series = Series::from_fn(rows, columns, |i, j| {
            let c = self.series.coefficient(i, j);
            if [i, j][axis] % 2 == 1 { -c } else { c }
        });
        let mut centre = self.centre;
        centre[axis] = -centre[axis];
        Self { series, centre, ..self.clone() }
    }

    /// Third derivatives, which are polynomials, by their Bernstein coefficients; the others by Taylor's theorem about
    /// the middle of each cell.
    fn cell_bounds(&self, cells: &BoundCells) -> Vec<DerivativeBounds> {
        let (lo, step) = ((cells.rect.min - self.centre) / self.half, cells.size / self.half);
        let count = cells.count;
        let edges = |lo: f64, step: f64| -> Vec<f64> {
            (0..=count).map(|k| lo + step * k as f64).collect()
        };
        let (u, v) = (edges(lo.x, step.x), edges(lo.y, step.y));
        // The middles of a row of cells lie on one line of constant v.
        let middles = |j: usize| -> Vec<[f64; 6]> {
            let middle = |k: usize| {
                let [lo, hi] = cells.corners(k);
                0.5 * (lo + hi)
            };
            let row = self.row(middle(j * count).y);
            let about = |i: usize| {
                let q = middle(j * count + i);
                let (point, c) = (row.at(q.x), self.hessian_on(&row, q.x));
                [point.f, point.slope.x, point.slope.y, c.xx, c.xy, c.yy]
            };
            (0..count).map(about).collect()
        };
        let (third, middles): (_, Vec<Vec<[f64; 6]>>) =
            parallel::join(|| self.third_derivatives(&u, &v), || parallel::map(count, 1, middles));
        let middles = middles.concat();
        let off: [f64; 6] =
            std::array::from_fn(|i| OFF * middles.iter().map(|m| m[i].abs()).fold(0.0, f64::max));
        let half = 0.5 * cells.size;
        let [x, y] = [half.x, half.y].map(|half| Interval::around(0.0, half));
        let bounds = |(k, middle): (usize, &[f64; 6])| {
            let third = third.each_ref().map(|range| range[k]);
            let [xxx, xxy, xyy, yyy] = third;
            let about = |i: usize, by_x: Interval, by_y: Interval| {
                Interval::around(middle[i], off[i]) + by_x * x + by_y * y
            };
            let hessian @ [xx, xy, yy] =
                [about(3, xxx, xxy), about(4, xxy, xyy), about(5, xyy, yyy)];
            let slope @ [by_x, by_y] = [about(1, xx, xy), about(2, xy, yy)];
            DerivativeBounds { f: about(0, by_x, by_y), slope, hessian, third }
        };
        middles.iter().enumerate().map(bounds).collect()
    }
}

impl TensorLegendre {
    /// (u, v) of a place, as the row has them.
    #[inline]
    fn unit(&self, q: DVec2) -> [f64; 2] {
        [(q.x - self.centre.x) * (1.0 / self.half.x), (q.y - self.centre.y) / self.half.y]
    }

    #[inline]
    fn point(&self, jet: &Jet) -> HeightAndSlope {
        let slope = DVec2::from_array(jet.gradient) * (self.scale_mm / self.half);
        HeightAndSlope { f: self.scale_mm * jet.f, slope }
    }

    /// The Hessian at `x` of the line of `row`.
    fn hessian_on(&self, row: &TensorLegendreRow, x: f64) -> Hessian {
        self.second(&row.row.jet((x - self.centre.x) / self.half.x))
    }

    fn second(&self, jet: &Jet) -> Hessian {
        let [xx, xy, yy] = jet.hessian.map(|h| h * self.scale_mm);
        let (a, b) = (self.half.x, self.half.y);
        Hessian { xx: xx / (a * a), xy: xy / (a * b), yy: yy / (b * b) }
    }

    /// Ranges over every cell of the third derivatives of the height, x-most first.
    fn third_derivatives(&self, u: &[f64], v: &[f64]) -> [Vec<Interval>; 4] {
        let ranges = |by_y: usize| {
            let mut series = self.series.clone();
            let mut unit = self.scale_mm;
            for step in 0..3 {
                if step < by_y {
                    series = series.derivative_v();
                    unit /= self.half.y;
                } else {
                    series = series.derivative_u();
                    unit /= self.half.x;
                }
            }
            let ranges = bernstein::ranges(&series, u, v);
            ranges.into_iter().map(|[lo, hi]| Interval::new(lo, hi) * unit).collect()
        };
        let ((a, b), (c, d)) = parallel::join(
            || parallel::join(|| ranges(0), || ranges(1)),
            || parallel::join(|| ranges(2), || ranges(3)),
        );
        [a, b, c, d]
    }
}

/// A tensor series on one line of constant y.
#[derive(Debug, Clone)]
pub struct TensorLegendreRow {
    row: Row,
    centre: f64,
    per_mm: f64,
    scale: f64,
    slope: DVec2,
}

impl HeightRow for TensorLegendreRow {
    #[inline]
    fn at(&self, x: f64) -> HeightAndSlope {
        self.point(&self.row.gradient(self.argument(x)))
    }

    #[inline]
    fn at_each<const N: usize>(&self, xs: [f64; N]) -> [HeightAndSlope; N] {
        self.row.gradients(xs.map(|x| self.argument(x))).map(|jet| self.point(&jet))
    }
}

impl TensorLegendreRow {
    #[inline]
    fn argument(&self, x: f64) -> f64 {
        (x - self.centre) * self.per_mm
    }

    #[inline]
    fn point(&self, jet: &Jet) -> HeightAndSlope {
        let slope = DVec2::from_array(jet.gradient) * self.slope;
        HeightAndSlope { f: self.scale * jet.f, slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Rect;
    use crate::mirror::Surface;

    #[test]
    fn a_reflection_is_the_sheet_at_reflected_places() {
        let series = Series::from_fn(5, 4, |i, j| f64::from(1 + (7 * i + 3 * j) as u32 % 5));
        let (centre, half) = (DVec2::new(2.0, -3.0), DVec2::new(10.0, 7.0));
        let sheet = TensorLegendre { series, centre, half, scale_mm: 0.3 };
        for (axis, sign) in [DVec2::new(-1.0, 1.0), DVec2::new(1.0, -1.0)].into_iter().enumerate() {
            let reflected = sheet.reflected(axis);
            for q in [DVec2::new(0.5, 0.25), DVec2::new(-6.0, 2.0), DVec2::new(7.5, -8.0)] {
                let (there, here) = (reflected.at(sign * q), sheet.at(q));
                assert!((there.f - here.f).abs() < 1e-13, "{axis} {q}");
                assert!((there.slope - sign * here.slope).length() < 1e-13, "{axis} {q}");
                // It is no even one.
                assert!((reflected.at(q).f - here.f).abs() > 1e-3, "{axis} {q}");
            }
        }
    }

    /// f = 0.02 x^2 y on a rectangle off the origin, as a Legendre series.
    fn sheet() -> TensorLegendre {
        let (centre, half) = (DVec2::new(3.0, -2.0), DVec2::new(4.0, 5.0));
        // X = 3 + 4u, Y = -2 + 5v; u^2 = (2 P2 + 1)/3.
        let x2 = [9.0 + 16.0 / 3.0, 24.0, 32.0 / 3.0];
        let y = [-2.0, 5.0];
        let series = Series::from_fn(3, 2, |i, j| 0.01 * x2[i] * y[j]);
        TensorLegendre { series, centre, half, scale_mm: 2.0 }
    }

    #[test]
    fn derivatives_are_per_millimetre() {
        let q = DVec2::new(1.5, -4.0);
        let point = sheet().at(q);
        assert!((point.f - 0.02 * 2.25 * -4.0).abs() < 1e-13);
        assert!((point.slope - DVec2::new(0.04 * 1.5 * -4.0, 0.02 * 2.25)).length() < 1e-14);
        let c = sheet().hessian(q);
        assert!((c.xx + 0.16).abs() < 1e-14 && (c.xy - 0.06).abs() < 1e-14 && c.yy.abs() < 1e-14);
        assert!((c.det() + 0.0036).abs() < 1e-14);
        assert!((c.norm() - 0.18).abs() < 1e-13);
    }

    const PANEL: Rect = Rect { min: DVec2::new(-20.0, -14.0), max: DVec2::new(31.0, 9.0) };

    /// A wavy surface of mixed degrees.
    fn wavy() -> TensorLegendre {
        let series = Series::from_fn(7, 6, |i, j| {
            (1.0 + ((3 * i + 5 * j) % 7) as f64 - 3.0) / (1 + i * i + j * j) as f64
        });
        let (centre, half) = (DVec2::new(1.0, -2.0), DVec2::new(30.0, 12.0));
        TensorLegendre { series, centre, half, scale_mm: 4.0 }
    }

    #[test]
    fn bounds_hold_at_every_sample_and_are_not_idle() {
        let bounds = Surface::Tensor(wavy()).bound_grid(PANEL);
        let step = 1e-3;
        let (mut found, mut allowed) = (0.0f64, 0.0f64);
        for (q, _) in PANEL.grid(37, 29) {
            let held = bounds.over(q, q);
            let (point, c) = (wavy().at(q), wavy().hessian(q));
            assert!(held.f.contains(point.f));
            assert!(held.slope[0].contains(point.slope.x) && held.slope[1].contains(point.slope.y));
            for (range, x) in held.hessian.iter().zip([c.xx, c.xy, c.yy]) {
                assert!(range.contains(x));
            }
            let d = |e: DVec2| {
                let (a, b) = (wavy().hessian(q + e * step), wavy().hessian(q - e * step));
                [a.xx - b.xx, a.xy - b.xy, a.yy - b.yy].map(|x| x / (2.0 * step))
            };
            let (dx, dy) = (d(DVec2::X), d(DVec2::Y));
            for (range, x) in held.third.iter().zip([dx[0], dx[1], dx[2], dy[2]]) {
                let slack = 1e-6 * (1.0 + x.abs());
                assert!(range.lo - slack <= x && x <= range.hi + slack, "{range:?} {x}");
                found = found.max(x.abs());
                allowed = allowed.max(range.magnitude());
            }
        }
        assert!(found > 0.8 * allowed, "{found} of {allowed}");
    }

    #[test]
    fn a_box_over_many_cells_takes_the_worst_of_them() {
        let bounds = Surface::Tensor(wavy()).bound_grid(PANEL);
        let whole = bounds.over(PANEL.min, PANEL.max);
        for (q, _) in PANEL.grid(9, 9) {
            let here = bounds.over(q, q);
            assert_eq!(whole.union(here), whole);
        }
    }
}
