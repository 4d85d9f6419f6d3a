//! One smooth sheet: a tensor Legendre series placed in the part frame.

use crate::geom::DVec2;
use crate::num::legendre::{Row, Series};

/// Height (mm) and slope of a surface at a point of its chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightAndSlope {
    /// f, mm.
    pub f: f64,
    /// (f_x, f_y), dimensionless.
    pub slope: DVec2,
}

impl HeightAndSlope {
    /// That of the sum of two surfaces.
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self { f: self.f + other.f, slope: self.slope + other.slope }
    }
}

/// Second derivatives of the height, 1/mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hessian {
    /// f_xx.
    pub xx: f64,
    /// f_xy.
    pub xy: f64,
    /// f_yy.
    pub yy: f64,
}

impl Hessian {
    /// Determinant of the Hessian: negative on saddles.
    #[must_use]
    pub fn det(&self) -> f64 {
        self.xx * self.yy - self.xy * self.xy
    }

    /// The Hessian times a vector.
    #[inline]
    #[must_use]
    pub fn times(&self, d: DVec2) -> DVec2 {
        DVec2::new(self.xx * d.x + self.xy * d.y, self.xy * d.x + self.yy * d.y)
    }

    /// Largest absolute eigenvalue.
    #[must_use]
    pub fn norm(&self) -> f64 {
        let mean = 0.5 * (self.xx + self.yy);
        let half = 0.5 * (self.xx - self.yy);
        mean.abs() + (half * half + self.xy * self.xy).sqrt()
    }
}

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

impl TensorLegendre {
    /// Its reflection across the line where coordinate `axis` (0 = x, 1 = y) vanishes: terms of odd
    /// degree in it change their sign.
    #[must_use]
    pub fn reflected(&self, axis: usize) -> Self {
        let (rows, columns) = self.series.shape();
        let series = Series::from_fn(rows, columns, |i, j| {
            let c = self.series.coefficient(i, j);
            if [i, j][axis] % 2 == 1 { -c } else { c }
        });
        let mut centre = self.centre;
        centre[axis] = -centre[axis];
        Self { series, centre, ..self.clone() }
    }

    /// The sheet on the line of constant `y`.
    #[must_use]
    pub fn row(&self, y: f64) -> TensorLegendreRow {
        TensorLegendreRow {
            row: self.series.row((y - self.centre.y) / self.half.y),
            centre: self.centre.x,
            per_mm: 1.0 / self.half.x,
            scale: self.scale_mm,
            slope: self.scale_mm / self.half,
        }
    }

    /// Height and slope at one point.
    #[must_use]
    pub fn at(&self, q: DVec2) -> HeightAndSlope {
        // As `SheetRow::at` has it.
        let (u, v) =
            ((q.x - self.centre.x) * (1.0 / self.half.x), (q.y - self.centre.y) / self.half.y);
        let jet = self.series.gradient(u, v);
        let slope = DVec2::from_array(jet.gradient) * (self.scale_mm / self.half);
        HeightAndSlope { f: self.scale_mm * jet.f, slope }
    }

    /// Second derivatives at one point, 1/mm.
    #[must_use]
    pub fn hessian(&self, q: DVec2) -> Hessian {
        let u = (q - self.centre) / self.half;
        let [xx, xy, yy] = self.series.row(u.y).jet(u.x).hessian.map(|h| h * self.scale_mm);
        let (a, b) = (self.half.x, self.half.y);
        Hessian { xx: xx / (a * a), xy: xy / (a * b), yy: yy / (b * b) }
    }
}

/// A sheet on one line of constant Y.
#[derive(Debug, Clone)]
pub struct TensorLegendreRow {
    row: Row,
    centre: f64,
    per_mm: f64,
    scale: f64,
    slope: DVec2,
}

impl TensorLegendreRow {
    /// Height and slope at `x`.
    #[inline]
    #[must_use]
    pub fn at(&self, x: f64) -> HeightAndSlope {
        let jet = self.row.gradient((x - self.centre) * self.per_mm);
        HeightAndSlope {
            f: self.scale * jet.f,
            slope: DVec2::from_array(jet.gradient) * self.slope,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
