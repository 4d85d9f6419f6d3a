//! The kinds of lattices, and the cell that suits a place for each.
//!
//! With vertices on the mirror the fewest facets are (docs/theory.md, T42 to T44): on bowls equilateral triangles in
//! the metric of the curvature; on saddles, for the chord error, squares in that metric, turned from the principal
//! directions by half of atan(1/2), for then all four edges of a square and both of its diagonals reach the tolerance
//! at once; on saddles, for the facet error, right triangles with legs along the directions that are conjugate in the
//! curvature and perpendicular in the image, for then a facet shows what the mirror shows in the middle of its longest
//! edge.

use super::field::SizingField;
use super::local_model::LocalModel;
use super::tuning::TUNING;
use crate::geom::DVec2;
use glam::DMat2;

/// Half of atan(1/2): its cosine and sine.
const SADDLE_TURN: DVec2 = DVec2::new(0.973_248_989_474_818_7, 0.229_752_920_547_268_07);
const SIN_60: f64 = 0.866_025_403_784_438_6;
const SQUARE: [DVec2; 4] = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
const HEXAGON: [DVec2; 6] = [
    DVec2::X,
    DVec2::new(0.5, SIN_60),
    DVec2::new(-0.5, SIN_60),
    DVec2::NEG_X,
    DVec2::new(-0.5, -SIN_60),
    DVec2::new(0.5, -SIN_60),
];

/// Kind of the lattice that a mesh is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LatticeKind {
    /// Equilateral triangles in the metric of the curvature.
    Triangles,
    /// Equilateral triangles in the metric of the image.
    ImageTriangles,
    /// Squares in the metric of the curvature, turned from the principal directions.
    Squares,
    /// Squares in the metric of the image along conjugate directions.
    ImageSquares,
}

impl LatticeKind {
    /// All kinds.
    pub(crate) const ALL: [Self; 4] =
        [Self::Triangles, Self::Squares, Self::ImageTriangles, Self::ImageSquares];
    /// The kinds for a mirror without a limit of the facet error.
    pub(crate) const BY_CURVATURE: [Self; 2] = [Self::Triangles, Self::Squares];

    /// The steps to the neighbours of a point, in cells.
    pub(crate) fn steps(self) -> &'static [DVec2] {
        match self {
            Self::Triangles | Self::ImageTriangles => &HEXAGON,
            Self::Squares | Self::ImageSquares => &SQUARE,
        }
    }

    /// Whether its directions turn so much from place to place that a step has to follow them.
    pub(crate) fn turns(self) -> bool {
        self == Self::ImageSquares
    }

    /// Area of two facets, in cells.
    pub(crate) fn area(self) -> f64 {
        if self.steps().len() == 6 { SIN_60 } else { 1.0 }
    }

    /// Factor by which a cell may be enlarged at a place.
    pub(crate) fn enlargement(self, sizing: &SizingField, model: &LocalModel, cell: &DMat2) -> f64 {
        let steps = self.steps();
        let [a, b] = [*cell * steps[0], *cell * steps[1]];
        let first = sizing.enlargement(model, a, b);
        if steps.len() == 6 { first } else { first.max(sizing.enlargement(model, a, a + b)) }
    }

    /// The cell, of any size, that suits a place: the map from unit steps to steps of the lattice.
    pub(crate) fn cell(self, model: &LocalModel) -> DMat2 {
        let h = &model.hessian;
        let curvature = SymmetricMatrix { xx: h.xx, xy: h.xy, yy: h.yy };
        match self {
            Self::Triangles => curvature.inverse_root().1,
            Self::ImageTriangles => {
                let k = model.image_per_gradient * curvature.matrix();
                SymmetricMatrix::of(k.transpose() * k).inverse_root().1
            }
            Self::Squares => {
                let (lengths, _) = curvature.inverse_root();
                let turn = DMat2::from_cols(SADDLE_TURN, SADDLE_TURN.perp());
                curvature.axes() * DMat2::from_diagonal(lengths) * turn
            }
            Self::ImageSquares => {
                // K = A H has K e_k of unit length for e_k = A' y_k / s_k, with A H A' y = s y.
                let a = model.image_per_gradient;
                let both = SymmetricMatrix::of(a * curvature.matrix() * a.transpose());
                let sides = a.transpose() * both.axes();
                let s = both.values().abs();
                let [x, y] = [sides.x_axis / s.x, sides.y_axis / s.y];
                let longest = TUNING.longest_cell * x.length().min(y.length());
                let cell =
                    DMat2::from_cols(x.clamp_length_max(longest), y.clamp_length_max(longest));
                // Not mirrored.
                let side = if cell.determinant() < 0.0 { -1.0 } else { 1.0 };
                DMat2::from_cols(cell.x_axis, cell.y_axis * side)
            }
        }
    }
}

/// A symmetric 2 x 2 matrix.
#[derive(Debug, Clone, Copy)]
struct SymmetricMatrix {
    xx: f64,
    xy: f64,
    yy: f64,
}

impl SymmetricMatrix {
    /// The symmetric part of `m`.
    fn of(m: DMat2) -> Self {
        Self { xx: m.x_axis.x, xy: 0.5 * (m.x_axis.y + m.y_axis.x), yy: m.y_axis.y }
    }

    fn matrix(&self) -> DMat2 {
        DMat2::from_cols(DVec2::new(self.xx, self.xy), DVec2::new(self.xy, self.yy))
    }

    /// Eigenvalues, the larger first.
    fn values(&self) -> DVec2 {
        let mean = 0.5 * (self.xx + self.yy);
        let half = DVec2::new(0.5 * (self.xx - self.yy), self.xy).length();
        DVec2::new(mean + half, mean - half)
    }

    /// Unit eigenvectors, as columns in the order of the values.
    fn axes(&self) -> DMat2 {
        let half = 0.5 * (self.xx - self.yy);
        let radius = DVec2::new(half, self.xy).length();
        let first = if half >= 0.0 {
            DVec2::new(radius + half, self.xy)
        } else {
            DVec2::new(self.xy, radius - half)
        };
        let first = first.normalize_or(DVec2::X);
        DMat2::from_cols(first, first.perp())
    }

    /// |M|^-1/2 with the ratio of its eigenvalues limited to that of the longest cell: its eigenvalues, and itself.
    fn inverse_root(&self) -> (DVec2, DMat2) {
        let sizes = self.values().abs();
        let least = sizes.max_element() / (TUNING.longest_cell * TUNING.longest_cell);
        let lengths = sizes.max(DVec2::splat(least)).map(|s| 1.0 / s.sqrt());
        let axes = self.axes();
        (lengths, axes * DMat2::from_diagonal(lengths) * axes.transpose())
    }
}
