//! The surfaces of the program, and the one place that tells them apart.

use super::bounds::BoundGrid;
use super::height_field::{HeightAndSlope, HeightField, HeightRow, Hessian, bound_grid};
use super::panelled::PanelledSurface;
use super::radial_legendre::RadialLegendre;
use super::radial_tensor_sum::RadialTensorSum;
use super::tensor_legendre::TensorLegendre;
use crate::geom::{BicubicSpline, DVec2, DerivativeBounds, Rect};

/// Defines [`Surface`] and hands its services on to the height fields that are listed. (Rows are evaluated some
/// hundred million times in a build, which an enumeration serves faster than a table of functions.)
macro_rules! surfaces {
    ($($(#[$doc:meta])+ $kind:ident($field:ty),)+) => {
        /// The height f over a chart's image coordinates: one of the height fields.
        #[derive(Debug, Clone)]
        pub enum Surface {
            $($(#[$doc])+ $kind($field),)+
        }

        /// A [`Surface`] on one line of constant y.
        #[derive(Debug, Clone)]
        pub enum SurfaceRow<'a> {
            $($(#[$doc])+ $kind(<$field as HeightField>::Row<'a>),)+
        }

        impl Surface {
            /// As [`HeightField::row`].
            #[must_use]
            pub fn row(&self, y: f64) -> SurfaceRow<'_> {
                match self {
                    $(Self::$kind(field) => SurfaceRow::$kind(field.row(y)),)+
                }
            }

            /// As [`HeightField::at`].
            #[must_use]
            pub fn at(&self, q: DVec2) -> HeightAndSlope {
                match self {
                    $(Self::$kind(field) => field.at(q),)+
                }
            }

            /// As [`HeightField::at_each`].
            #[must_use]
            pub fn at_each<const N: usize>(&self, places: [DVec2; N]) -> [HeightAndSlope; N] {
                match self {
                    $(Self::$kind(field) => field.at_each(places),)+
                }
            }

            /// As [`HeightField::height`].
            #[must_use]
            pub fn height(&self, q: DVec2) -> f64 {
                match self {
                    $(Self::$kind(field) => field.height(q),)+
                }
            }

            /// As [`HeightField::hessian`].
            #[must_use]
            pub fn hessian(&self, q: DVec2) -> Hessian {
                match self {
                    $(Self::$kind(field) => field.hessian(q),)+
                }
            }

            /// As [`HeightField::at_with_hessian`].
            #[must_use]
            pub fn at_with_hessian(&self, q: DVec2) -> (HeightAndSlope, Hessian) {
                match self {
                    $(Self::$kind(field) => field.at_with_hessian(q),)+
                }
            }

            /// As [`HeightField::reflected`].
            #[must_use]
            pub fn reflected(&self, axis: usize) -> Self {
                match self {
                    $(Self::$kind(field) => Self::$kind(field.reflected(axis)),)+
                }
            }

            /// Bounds over `rect`, as far as the surface reaches.
            #[must_use]
            pub fn bound_grid(&self, rect: Rect) -> BoundGrid<DerivativeBounds> {
                match self {
                    $(Self::$kind(field) => bound_grid(field, rect),)+
                }
            }

            /// As [`HeightField::box_bounds`].
            #[must_use]
            pub fn box_bounds(&self, lo: DVec2, hi: DVec2) -> Option<DerivativeBounds> {
                match self {
                    $(Self::$kind(field) => field.box_bounds(lo, hi),)+
                }
            }

            /// As [`HeightField::radii`].
            #[must_use]
            pub fn radii(&self) -> Option<[f64; 2]> {
                match self {
                    $(Self::$kind(field) => field.radii(),)+
                }
            }

            /// As [`HeightField::is_axisymmetric`].
            #[must_use]
            pub fn is_axisymmetric(&self) -> bool {
                match self {
                    $(Self::$kind(field) => field.is_axisymmetric(),)+
                }
            }

            /// As [`HeightField::is_bicubic`].
            #[must_use]
            pub fn is_bicubic(&self) -> bool {
                match self {
                    $(Self::$kind(field) => field.is_bicubic(),)+
                }
            }

            /// As [`HeightField::breaks`].
            #[must_use]
            pub fn breaks(&self, axis: usize, lo: f64, hi: f64) -> Vec<f64> {
                match self {
                    $(Self::$kind(field) => field.breaks(axis, lo, hi),)+
                }
            }
        }

        impl SurfaceRow<'_> {
            /// Height and slope at `x`.
            #[inline]
            #[must_use]
            pub fn at(&self, x: f64) -> HeightAndSlope {
                match self {
                    $(Self::$kind(row) => row.at(x),)+
                }
            }

            /// As [`HeightRow::extend_at`].
            pub fn extend_at(&self, xs: &[f64], points: &mut Vec<HeightAndSlope>) {
                match self {
                    $(Self::$kind(row) => row.extend_at(xs, points),)+
                }
            }
        }
    };
}

surfaces! {
    /// A tensor series over a rectangle.
    Tensor(TensorLegendre),
    /// A series along the radius.
    Radial(RadialLegendre),
    /// The sum of both.
    Sum(RadialTensorSum),
    /// A spline through sag on a grid.
    Spline(BicubicSpline),
    /// Tensor series side by side.
    Panels(PanelledSurface),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::GridAxis;
    use crate::num::legendre::Series;
    use crate::num::sample::Draws;

    const HALF: f64 = 6.0;

    /// One of each kind, over a square or a disc about the axis.
    fn surfaces() -> Vec<Surface> {
        let mut r = Draws::new(11);
        let series =
            Series::from_fn(5, 4, |i, j| r.inside([-1.0, 1.0]) / (1 + i * i + j * j) as f64);
        let (centre, half) = (DVec2::ZERO, DVec2::splat(HALF));
        let tensor = TensorLegendre { series, centre, half, scale_mm: 1.5 };
        let series = Series::from_fn(4, 1, |i, _| [1.0, -2.0, 0.4, 0.1][i]);
        let radial = RadialLegendre::new(series, [0.0, 1.5 * HALF], 0.7);
        let knots = GridAxis { first_mm: -HALF, step_mm: 2.0 * HALF / 8.0, count: 9 };
        let values: Vec<f64> = (0..81).map(|_| r.inside([-1.0, 1.0])).collect();
        let spline = BicubicSpline::new(knots, knots, &values).expect("a grid");
        vec![
            Surface::Tensor(tensor.clone()),
            Surface::Radial(radial.clone()),
            Surface::Sum(RadialTensorSum { radial, tensor }),
            Surface::Spline(spline),
        ]
    }

    #[test]
    fn heights_of_both_panels_are_those_of_rows() {
        let roof = crate::mirror::fixtures::roof(30.0);
        for q in [DVec2::new(0.3, 1.7), DVec2::new(0.3, -1.7), DVec2::new(-4.0, 0.0)] {
            assert_eq!(roof.height(q).to_bits(), roof.row(q.y).at(q.x).f.to_bits(), "{q}");
        }
        assert!(roof.height(DVec2::new(0.0, -2.0)) > 1.0);
    }

    #[test]
    fn every_surface_keeps_the_contract() {
        let rect = Rect { min: DVec2::splat(-HALF), max: DVec2::splat(HALF) };
        let size = |surface: &Surface| surface.hessian(DVec2::ONE).norm() + 1.0;
        for surface in surfaces() {
            let (bounds, mirrored) = (surface.bound_grid(rect), surface.reflected(1));
            let mut r = Draws::new(3);
            for _ in 0..200 {
                let q = DVec2::new(r.inside([-HALF, HALF]), r.inside([-HALF, HALF]));
                let (point, hessian) = (surface.at(q), surface.hessian(q));
                // A row has the same bits, and the height alone.
                let on_row = surface.row(q.y).at(q.x);
                assert_eq!(on_row, point, "{q}");
                let xs: Vec<f64> = (0..11).map(|k| q.x - 0.1 * f64::from(k)).collect();
                let mut many = Vec::new();
                surface.row(q.y).extend_at(&xs, &mut many);
                assert!(xs.iter().map(|x| surface.row(q.y).at(*x)).eq(many), "{q}");
                let places = [0.0, 0.1, -0.2].map(|off| q + DVec2::new(off, -2.0 * off));
                assert_eq!(surface.at_each(places), places.map(|q| surface.at(q)), "{q}");
                assert_eq!(surface.height(q).to_bits(), point.f.to_bits(), "{q}");
                let (again, found) = surface.at_with_hessian(q);
                let off = [found.xx - hessian.xx, found.xy - hessian.xy, found.yy - hessian.yy];
                let off = off.iter().fold(0.0f64, |most, off| most.max(off.abs()));
                assert!(again == point && off < 1e-12 * size(&surface), "{q}: {off}");
                // The Hessian is the derivative of the slope; differences are good to their step, where a
                // knot is between.
                let e = 1e-5;
                for (way, second) in
                    [(DVec2::X, [hessian.xx, hessian.xy]), (DVec2::Y, [hessian.xy, hessian.yy])]
                {
                    let change = surface.at(q + way * e).slope - surface.at(q - way * e).slope;
                    let off = change / (2.0 * e) - DVec2::from_array(second);
                    assert!(off.length() < 1e-3 * size(&surface), "{q}: {off}");
                }
                let there = mirrored.at(q * DVec2::new(1.0, -1.0));
                assert!((there.f - point.f).abs() < 1e-12 * size(&surface), "{q}");
                let held = bounds.over(q, q);
                assert!(held.f.contains(point.f) && held.slope[0].contains(point.slope.x), "{q}");
                assert!(
                    held.slope[1].contains(point.slope.y) && held.hessian[0].contains(hessian.xx)
                );
                assert!(
                    held.hessian[1].contains(hessian.xy) && held.hessian[2].contains(hessian.yy)
                );
            }
            let breaks = surface.breaks(0, -HALF, HALF);
            assert_eq!((breaks[0], breaks[breaks.len() - 1]), (-HALF, HALF));
            assert_eq!(breaks.len() > 2, surface.is_bicubic());
        }
    }
}
