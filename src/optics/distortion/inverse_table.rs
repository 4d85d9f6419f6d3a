//! Table of the inverse of a lens's distortion over a rectangle, from which Newton's method needs a step or two.

use super::lift::{Lift, MOST_CHANGE};
use super::radial_map::{RadialMap, relative_change, solved};
use super::{Distortion, DistortionFault};

/// Nodes along each side of the square from which a cell's points are interpolated, by cubic polynomials.
const STENCIL: usize = 4;
/// Most steps of Newton's method: with cells of a hundredth of the picture the first or the second is the last.
const MOST_STEPS: usize = 4;

/// Inverse of a distortion at the nodes of a grid, in cells between which it is interpolated and refined.
///
/// The nodes are those of the branch of the centre. In a cell whose nodes, and those around it, have Jacobians that
/// are near each other the map is one to one, and Newton's method finds the point on that branch; in others, and
/// beyond the rectangle, the inverse is followed from the centre. A point's inverse depends on the point alone.
#[derive(Debug, Clone)]
pub(crate) struct InverseTable {
    distortion: Distortion,
    map: RadialMap,
    /// The distorted point of the first node.
    corner: [f64; 2],
    /// Cells to a unit of the distorted point; negative where it falls from node to node.
    per_unit: [f64; 2],
    cells: [usize; 2],
    /// Points of the model's own plane, row by row: not finite where there is none.
    nodes: Vec<[f64; 2]>,
    /// Largest last step of Newton's method in each cell, as [`Self::last_steps()`] finds it.
    last_steps: Vec<Option<f64>>,
    /// Largest step: of the shorter side of a cell, a quarter.
    longest: f64,
}

impl InverseTable {
    /// The table over the rectangle of distorted points between two corners, in so many cells or the least number
    /// that can be interpolated in.
    #[must_use]
    pub(crate) fn new(
        distortion: &Distortion,
        [from, to]: [[f64; 2]; 2],
        cells: [usize; 2],
    ) -> Self {
        let cells = cells.map(|n| n.max(STENCIL - 1));
        let map = distortion.map();
        let side = [0, 1].map(|k| (to[k] - from[k]) / cells[k] as f64);
        let node = |k: usize| {
            let place = [k % (cells[0] + 1), k / (cells[0] + 1)];
            let mut lift = Lift::new(&map, [0, 1].map(|k| from[k] + side[k] * place[k] as f64));
            if lift.advance(1.0) { lift.at } else { [f64::NAN; 2] }
        };
        let nodes: Vec<[f64; 2]> = (0..(cells[0] + 1) * (cells[1] + 1)).map(node).collect();
        let per_unit = side.map(|side| 1.0 / side);
        let longest = 0.25 * side[0].abs().min(side[1].abs());
        let last_steps = Vec::new();
        let mut table = Self {
            distortion: *distortion,
            map,
            corner: from,
            per_unit,
            cells,
            nodes,
            last_steps,
            longest,
        };
        table.last_steps = table.last_steps();
        table
    }

    /// The undistorted point of a distorted one: [`Distortion::undistorted`], to rounding.
    ///
    /// # Errors
    /// As of that.
    #[inline]
    pub(crate) fn undistorted(&self, p: [f64; 2]) -> Result<[f64; 2], DistortionFault> {
        match self.refined(p) {
            Some(at) => self.distortion.ray(at),
            None => self.distortion.undistorted(p),
        }
    }

    /// The point of the model's own plane, by Newton's method from the interpolated one, in a cell where that is
    /// known to be right.
    #[inline]
    pub(super) fn refined(&self, p: [f64; 2]) -> Option<[f64; 2]> {
        let place = [0, 1].map(|k| (p[k] - self.corner[k]) * self.per_unit[k]);
        let [columns, rows] = self.cells;
        if !(0.0 <= place[0].min(place[1]) && place[0] <= columns as f64 && place[1] <= rows as f64)
        {
            return None;
        }
        let cell = [0, 1].map(|k| (place[k] as usize).min(self.cells[k] - 1));
        let last_step = self.last_steps[cell[1] * columns + cell[0]]?;
        let mut at = self.interpolated(place, self.stencil(cell));
        for _ in 0..MOST_STEPS {
            let image = self.map.image(at);
            let by = solved(self.map.jacobian(at), [p[0] - image[0], p[1] - image[1]]);
            at = [at[0] + by[0], at[1] + by[1]];
            let size = by[0].abs().max(by[1].abs());
            if size <= last_step {
                return Some(at);
            }
            if !(size <= self.longest) {
                return None;
            }
        }
        None
    }

    /// First column and row of the nodes from which a cell is interpolated: one before its own, except at a side.
    #[inline]
    fn stencil(&self, cell: [usize; 2]) -> [usize; 2] {
        [0, 1].map(|k| cell[k].saturating_sub(1).min(self.cells[k] + 1 - STENCIL))
    }

    /// The interpolated point at `place`, counted in cells.
    #[inline]
    fn interpolated(&self, place: [f64; 2], first: [usize; 2]) -> [f64; 2] {
        let [across, down] = [0, 1].map(|k| lagrange_weights(place[k] - first[k] as f64));
        let mut sum = [0.0; 2];
        for (row, weight) in (first[1]..).zip(down) {
            let start = row * (self.cells[0] + 1) + first[0];
            let mut of_row = [0.0; 2];
            for (node, weight) in self.nodes[start..start + STENCIL].iter().zip(across) {
                of_row = [of_row[0] + weight * node[0], of_row[1] + weight * node[1]];
            }
            sum = [sum[0] + weight * of_row[0], sum[1] + weight * of_row[1]];
        }
        sum
    }

    /// Of each cell, the step of Newton's method after which the error is below rounding; none where the Jacobian
    /// changes too much for it among the nodes of the stencil.
    fn last_steps(&self) -> Vec<Option<f64>> {
        let [columns, rows] = self.cells;
        let jacobians: Vec<_> = self.nodes.iter().map(|w| self.map.jacobian(*w)).collect();
        let cell = |k: usize| {
            let cell = [k % columns, k / columns];
            let own = cell[1] * (columns + 1) + cell[0];
            let first = self.stencil(cell);
            let around = (0..STENCIL * STENCIL)
                .map(|k| (first[1] + k / STENCIL) * (columns + 1) + first[0] + k % STENCIL);
            // (NaN fails.)
            let mut change = 0.0;
            for node in around {
                let of_node = relative_change(jacobians[own], jacobians[node]);
                if !(of_node <= MOST_CHANGE) {
                    return None;
                }
                change = f64::max(change, of_node);
            }
            let [[x, y], [next_x, next_y]] = [self.nodes[own], self.nodes[own + columns + 2]];
            let side = (next_x - x).abs().min((next_y - y).abs());
            // Half the change over the step times the step is left, and may be an eighth of the last digit.
            let size = x.abs().max(y.abs()).max(side);
            Some(f64::sqrt(0.25 * f64::EPSILON * size * side / change).min(self.longest))
        };
        (0..columns * rows).map(cell).collect()
    }
}

/// Weights of the values at 0, 1, 2 and 3 in that at `t` of the cubic polynomial through them.
#[inline]
fn lagrange_weights(t: f64) -> [f64; STENCIL] {
    let [a, b, c, d] = [t, t - 1.0, t - 2.0, t - 3.0];
    [b * c * d * (-1.0 / 6.0), a * c * d * 0.5, a * b * d * -0.5, a * b * c * (1.0 / 6.0)]
}
