//! A conic or other axisymmetric surface plus a tensor series.

use super::bounds::BoundCells;
use super::height_field::{HeightAndSlope, HeightField, HeightRow, Hessian};
use super::radial_legendre::{RadialLegendre, RadialLegendreRow};
use super::tensor_legendre::{TensorLegendre, TensorLegendreRow};
use crate::geom::{DVec2, DerivativeBounds};

/// The sum of an axisymmetric surface and a tensor series. A conic over a disc, with its root at the rim, keeps the
/// few terms that it has along the radius.
#[derive(Debug, Clone)]
pub struct RadialTensorSum {
    /// The axisymmetric part.
    pub radial: RadialLegendre,
    /// The rest.
    pub tensor: TensorLegendre,
}

/// A sum on one line of constant y.
#[derive(Debug, Clone)]
pub struct RadialTensorSumRow<'a> {
    radial: RadialLegendreRow<'a>,
    tensor: TensorLegendreRow,
}

impl HeightField for RadialTensorSum {
    type Row<'a> = RadialTensorSumRow<'a>;

    fn row(&self, y: f64) -> RadialTensorSumRow<'_> {
        RadialTensorSumRow { radial: self.radial.row(y), tensor: self.tensor.row(y) }
    }

    fn at(&self, q: DVec2) -> HeightAndSlope {
        self.radial.at(q).plus(&self.tensor.at(q))
    }

    #[inline]
    fn at_each<const N: usize>(&self, places: [DVec2; N]) -> [HeightAndSlope; N] {
        let (radial, tensor) = (self.radial.at_each(places), self.tensor.at_each(places));
        std::array::from_fn(|k| radial[k].plus(&tensor[k]))
    }

    fn hessian(&self, q: DVec2) -> Hessian {
        self.radial.hessian(q).plus(&self.tensor.hessian(q))
    }

    fn at_with_hessian(&self, q: DVec2) -> (HeightAndSlope, Hessian) {
        let (point, hessian) = self.radial.at_with_hessian(q);
        let (by_tensor, more) = self.tensor.at_with_hessian(q);
        (point.plus(&by_tensor), hessian.plus(&more))
    }

    fn reflected(&self, axis: usize) -> Self {
        Self { radial: self.radial.reflected(axis), tensor: self.tensor.reflected(axis) }
    }

    fn cell_bounds(&self, cells: &BoundCells) -> Vec<DerivativeBounds> {
        let (radial, tensor) = (self.radial.cell_bounds(cells), self.tensor.cell_bounds(cells));
        radial.iter().zip(&tensor).map(|(a, b)| a.plus(b)).collect()
    }

    fn radii(&self) -> Option<[f64; 2]> {
        self.radial.radii()
    }
}

impl HeightRow for RadialTensorSumRow<'_> {
    #[inline]
    fn at(&self, x: f64) -> HeightAndSlope {
        self.radial.at(x).plus(&self.tensor.at(x))
    }

    #[inline]
    fn at_each<const N: usize>(&self, xs: [f64; N]) -> [HeightAndSlope; N] {
        let (radial, tensor) = (self.radial.at_each(xs), self.tensor.at_each(xs));
        std::array::from_fn(|k| radial[k].plus(&tensor[k]))
    }
}
