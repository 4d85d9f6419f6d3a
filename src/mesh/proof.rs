//! Proof of a facet: upper bounds of its errors over its whole area.
//!
//! *Chord.* With d_ij the facet's edges and H the Hessian, the interpolation error of a quadratic
//! sag is -1/2 sum over i < j of l_i l_j d_ij' H d_ij at barycentric coordinates l; its largest
//! value is known in closed form. Slope differences along the edges give d_ij' H d_ij for a mean
//! Hessian; the third derivative M over a facet of diameter D bounds what that leaves out by
//! M D^3 / 3.
//!
//! *Facet error.* Let c(q) be the image point whose wanted direction the mirror shows at q, and
//! c_T the one that the flat facet shows. Linear interpolation of c over the facet is off by at
//! most K D^2 / 6, K bounding its second derivative (Jung: the facet fits a circle of radius
//! D / sqrt 3), so |c_T - c| <= max over corners |c_T - c_i| + K D^2 / 6.
//!
//! *Rounding.* X and Y are single-precision numbers already. Both the facet through the exact sags
//! and the one through their single-precision roundings are bounded.

use crate::geom::{DVec2, DVec3, turn};
use crate::mirror::{CellBounds, Cells, Mirror, Point, Sheet, Union};
use crate::num::log;
use crate::optics::{Strip, reflect_vertical};

/// A corner of a facet with what the mirror does there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Position, mm.
    pub at: DVec3,
    /// The mirror's slope (Z_X, Z_Y).
    pub slope: DVec2,
    /// The image point (mm) whose wanted direction the mirror shows here.
    pub content: DVec2,
}

/// Upper bounds of the errors of one facet, or of all.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bound {
    /// Height between facet and mirror, mm.
    pub chord_mm: f64,
    /// Displacement of the image against the smooth mirror, mm on the mirror.
    pub facet_mm: f64,
    /// How far rounding the sags to single precision moves the image, mm on the mirror.
    pub rounding_mm: f64,
}

impl Bound {
    /// What holds for both.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            chord_mm: larger(self.chord_mm, other.chord_mm),
            facet_mm: larger(self.facet_mm, other.facet_mm),
            rounding_mm: larger(self.rounding_mm, other.rounding_mm),
        }
    }
}

/// What the proof needs to know of a cell of the panel.
#[derive(Debug, Clone, Copy)]
struct Cell {
    /// Bound of the sag's third derivative, 1/mm^2.
    third: f64,
    /// Bound of the second derivative of c, 1/mm.
    content: f64,
}

impl Union for Cell {
    fn union(self, other: Self) -> Self {
        Self { third: self.third.max(other.third), content: self.content.max(other.content) }
    }
}

/// Bounds the errors of facets of one panel.
#[derive(Debug, Clone)]
pub struct Prover<'a> {
    /// The panel's surface.
    pub sheet: &'a Sheet,
    /// The panel's image.
    pub strip: Strip,
    cells: Cells<Cell>,
}

impl<'a> Prover<'a> {
    /// A prover for the designed panel of `mirror` with image `strip`.
    #[must_use]
    pub fn new(mirror: &'a Mirror, strip: Strip) -> Self {
        let bounds = Cells::new(&mirror.sheet, mirror.panel);
        Self { sheet: &mirror.sheet, strip, cells: bounds.map(|cell| content_bounds(&strip, cell)) }
    }

    /// The corner at (X, Y) of the mirror point `point`.
    #[inline]
    #[must_use]
    pub fn vertex(&self, q: DVec2, point: Point) -> Vertex {
        let content = self.strip.locate(reflect_vertical(point.slope), q);
        Vertex { at: q.extend(point.sag), slope: point.slope, content }
    }

    /// Bounds over the facet `t`, counter-clockwise seen from above; infinite for a facet that is
    /// not.
    #[must_use]
    pub fn bound(&self, t: [&Vertex; 3]) -> Bound {
        let [a, b, c] = t.map(|v| v.at.truncate());
        let double_area = turn(a, b, c);
        if !(double_area > 0.0) {
            let never = f64::INFINITY;
            return Bound { chord_mm: never, facet_mm: never, rounding_mm: never };
        }
        let cell = self.cells.over(a.min(b).min(c), a.max(b).max(c));
        let [ab, bc, ca] = [b - a, c - b, a - c];
        let lengths = [ab.length(), bc.length(), ca.length()];
        let diameter = lengths[0].max(lengths[1]).max(lengths[2]);

        let curve = |i: usize, j: usize, edge: DVec2| (t[j].slope - t[i].slope).dot(edge);
        let quadratic = largest_deviation(curve(0, 1, ab), curve(1, 2, bc), curve(2, 0, ca));
        let cubic = cell.third * diameter * diameter * diameter / 3.0;

        let exact = t.map(|v| v.at);
        let single = exact.map(|p| p.truncate().extend(f64::from(p.z as f32)));
        let shown = [exact, single].map(|corners| self.shown_by_facet(corners));
        let off =
            |content: DVec2| t.iter().map(|v| (content - v.content).length()).fold(0.0, larger);
        let between = cell.content * diameter * diameter / 6.0;
        let moved = exact.iter().zip(single).map(|(e, s)| (e.z - s.z).abs()).fold(0.0, larger);
        Bound {
            chord_mm: quadratic + cubic + moved,
            facet_mm: off(shown[0]).max(off(shown[1])) + between,
            rounding_mm: (shown[1] - shown[0]).length(),
        }
    }

    /// Whether the facet lies in a cell of the panel where the slope may vanish, so that nothing
    /// can be said about its image however small it is.
    #[must_use]
    pub fn sees_the_pole(&self, t: &[Vertex; 3]) -> bool {
        let [a, b, c] = t.map(|v| v.at.truncate());
        self.cells.over(a.min(b).min(c), a.max(b).max(c)).content.is_infinite()
    }

    /// The image point whose wanted direction a flat facet shows.
    fn shown_by_facet(&self, corners: [DVec3; 3]) -> DVec2 {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let slope = -normal.truncate() / normal.z;
        self.strip.locate(reflect_vertical(slope), corners[0].truncate())
    }
}

/// The larger of two errors; one that is no number is larger than all.
fn larger(a: f64, b: f64) -> f64 {
    if b <= a { a } else { b }
}

/// Largest |1/2 (l0 l1 h01 + l1 l2 h12 + l2 l0 h20)| over the triangle, exactly.
pub(super) fn largest_deviation(h01: f64, h12: f64, h20: f64) -> f64 {
    let edges = h01.abs().max(h12.abs()).max(h20.abs()) / 8.0;
    // The stationary point inside the triangle, if there is one.
    let weights = [h12 * (h01 + h20 - h12), h20 * (h01 + h12 - h20), h01 * (h12 + h20 - h01)];
    let sum = weights[0] + weights[1] + weights[2];
    if weights.iter().all(|w| w * sum > 0.0) {
        edges.max((0.5 * h01 * h12 * h20 / sum).abs())
    } else {
        edges
    }
}

/// Bounds of c over a cell. With w the slope as a complex number, c / s is (arg w, z(m)) at
/// m = -log |w|: |D log w| <= H / |w| and |D^2 log w| <= (H / |w|)^2 + M / |w|.
fn content_bounds(strip: &Strip, cell: &CellBounds) -> Cell {
    if cell.slope_min <= 0.0 {
        let never = f64::INFINITY;
        return Cell { third: cell.third, content: never };
    }
    let turn = cell.curvature / cell.slope_min;
    let [stretch, bend] = strip.law.stretch(-log(cell.slope_max), -log(cell.slope_min));
    let stretch = stretch.max(1.0);
    let second = stretch * (turn * turn + cell.third / cell.slope_min) + bend * turn * turn;
    Cell { third: cell.third, content: strip.scale_mm * second }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn largest_deviation_is_the_largest_of_many_samples() {
        let shapes = [
            [1.0, 1.0, 1.0],
            [2.0, -1.0, 0.3],
            [-0.2, -1.0, -1.1],
            [4.0, 1.0, 1.0],
            [0.0, 1.0, 1.0],
            [1.0, 0.6, 0.9],
        ];
        for [h01, h12, h20] in shapes {
            let mut sampled: f64 = 0.0;
            for i in 0..=400 {
                for j in 0..=400 - i {
                    let (l0, l1) = (f64::from(i) / 400.0, f64::from(j) / 400.0);
                    let l2 = 1.0 - l0 - l1;
                    sampled =
                        sampled.max((0.5 * (l0 * l1 * h01 + l1 * l2 * h12 + l2 * l0 * h20)).abs());
                }
            }
            let found = largest_deviation(h01, h12, h20);
            assert!(found >= sampled - 1e-15 && found <= sampled * 1.001, "{h01} {h12} {h20}");
        }
    }
}
