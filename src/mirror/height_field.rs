//! The contract of a surface: a height over the coordinates of a chart, with its derivatives and bounds of them.

use super::bounds::{BoundCells, BoundGrid};
use crate::geom::{DVec2, DerivativeBounds, Rect};

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
    #[inline]
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self { f: self.f + other.f, slope: self.slope + other.slope }
    }
}

/// Second derivatives of a height, 1/mm: a symmetric matrix.
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
    /// The determinant: negative on saddles.
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

    /// The vector that the Hessian times it gives `right`; not finite where the determinant is 0.
    #[must_use]
    pub fn solve(&self, right: DVec2) -> DVec2 {
        let Self { xx, xy, yy } = *self;
        DVec2::new(yy * right.x - xy * right.y, xx * right.y - xy * right.x) / self.det()
    }

    /// That of the sum of two surfaces.
    #[inline]
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self { xx: self.xx + other.xx, xy: self.xy + other.xy, yy: self.yy + other.yy }
    }

    /// Whether the matrix is positive definite: the surface is hollow in every direction.
    #[must_use]
    pub fn is_positive_definite(&self) -> bool {
        self.xx > 0.0 && self.det() > 0.0
    }

    /// Largest absolute eigenvalue.
    #[must_use]
    pub fn norm(&self) -> f64 {
        let mean = 0.5 * (self.xx + self.yy);
        let half = 0.5 * (self.xx - self.yy);
        mean.abs() + (half * half + self.xy * self.xy).sqrt()
    }
}

/// A surface as a height f (mm) over a chart's coordinates q = (x, y) in mm.
///
/// [`super::Surface`] lists the surfaces of the program. Evaluation is good to far better than 1e-11 of the largest
/// value, on which the bounds rely.
pub trait HeightField: Sized {
    /// The surface on one line of constant y.
    type Row<'a>: HeightRow
    where
        Self: 'a;

    /// The line of constant `y`, ready for many values of x.
    fn row(&self, y: f64) -> Self::Row<'_>;

    /// Height and slope at one point, with the bits of [`HeightRow::at`].
    fn at(&self, q: DVec2) -> HeightAndSlope {
        self.row(q.y).at(q.x)
    }

    /// Height and slope at each of a few points, with the bits of [`HeightRow::at`].
    #[inline]
    fn at_each<const N: usize>(&self, places: [DVec2; N]) -> [HeightAndSlope; N] {
        places.map(|q| self.at(q))
    }

    /// Height at one point, mm, with the bits of [`HeightRow::at`].
    fn height(&self, q: DVec2) -> f64 {
        self.at(q).f
    }

    /// Second derivatives at one point, 1/mm.
    fn hessian(&self, q: DVec2) -> Hessian;

    /// Height and slope at one point with the bits of [`HeightField::at`], and second derivatives, which may round otherwise
    /// than [`HeightField::hessian`].
    fn at_with_hessian(&self, q: DVec2) -> (HeightAndSlope, Hessian) {
        (self.at(q), self.hessian(q))
    }

    /// The surface reflected across the line where coordinate `axis` (0 = x, 1 = y) vanishes.
    #[must_use]
    fn reflected(&self, axis: usize) -> Self;

    /// Bounds over each of many cells.
    fn cell_bounds(&self, cells: &BoundCells) -> Vec<DerivativeBounds>;

    /// Bounds over one box, where that takes no more than the bounds of a cell.
    fn box_bounds(&self, _lo: DVec2, _hi: DVec2) -> Option<DerivativeBounds> {
        None
    }

    /// Inner and outer radius between which alone bounds hold; none where they hold everywhere.
    fn radii(&self) -> Option<[f64; 2]> {
        None
    }

    /// Whether f is a function of the distance from the axis alone.
    fn is_axisymmetric(&self) -> bool {
        false
    }

    /// Whether f is a bicubic polynomial between [`HeightField::breaks`].
    fn is_bicubic(&self) -> bool {
        false
    }

    /// `lo`, the places between where the surface is less than smooth along `axis`, and `hi`.
    fn breaks(&self, _axis: usize, lo: f64, hi: f64) -> Vec<f64> {
        vec![lo, hi]
    }
}

/// Places that are evaluated at once: enough to hide how long each operation takes, and few enough for the
/// registers of a processor with vectors of two numbers.
const LANES: usize = 8;

/// A surface on one line of constant y.
pub trait HeightRow {
    /// Height and slope at `x`.
    fn at(&self, x: f64) -> HeightAndSlope;

    /// Height and slope at each of a few places, with the bits of [`HeightRow::at`].
    #[inline]
    fn at_each<const N: usize>(&self, xs: [f64; N]) -> [HeightAndSlope; N] {
        xs.map(|x| self.at(x))
    }

    /// Adds height and slope at each of `xs`, with the bits of [`HeightRow::at`].
    fn extend_at(&self, xs: &[f64], points: &mut Vec<HeightAndSlope>) {
        let (several, rest) = xs.as_chunks::<LANES>();
        for xs in several {
            points.extend(self.at_each(*xs));
        }
        points.extend(rest.iter().map(|x| self.at(*x)));
    }
}

/// Bounds of `surface` over `rect`, as far as the surface reaches.
pub(super) fn bound_grid(surface: &impl HeightField, rect: Rect) -> BoundGrid<DerivativeBounds> {
    BoundGrid::new(rect, |cells| surface.cell_bounds(cells))
}
