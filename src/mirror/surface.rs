//! The surfaces of the program, and the one place that tells them apart.

use super::bicubic_spline::BicubicSpline;
use super::bounds::{BoundGrid, DerivativeBounds};
use super::height_field::{HeightAndSlope, HeightField, HeightRow, Hessian, bound_grid};
use super::radial_legendre::RadialLegendre;
use super::radial_tensor_sum::RadialTensorSum;
use super::tensor_legendre::TensorLegendre;
use crate::geom::{DVec2, Rect};

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

            /// As [`HeightField::hessian`].
            #[must_use]
            pub fn hessian(&self, q: DVec2) -> Hessian {
                match self {
                    $(Self::$kind(field) => field.hessian(q),)+
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
}
