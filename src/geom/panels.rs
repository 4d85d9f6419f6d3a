//! Rectangles that tile a rectangle.

use super::{DVec2, Outline, Rect};
use crate::num::sort_by_number;

/// Rectangles side by side that tile a rectangle, mm: places on a common side belong to the one that comes first,
/// places outside to the nearest.
#[derive(Debug, Clone, PartialEq)]
pub struct Panels(pub Vec<Rect>);

/// A straight line between panels, as long as possible: no panel reaches over it.
#[derive(Debug, Clone, PartialEq)]
pub struct DividingLine {
    /// The coordinate that is constant on the line: 0 = x, 1 = y.
    pub axis: usize,
    /// Its value, mm.
    pub at: f64,
    /// Where the line begins and ends along the other coordinate, mm.
    pub ends: [f64; 2],
    /// The panels below and above that value, each in their order along the line.
    pub sides: [Vec<usize>; 2],
}

/// What a panel below a dividing line and one above it have of the line in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommonStretch {
    /// The panel below and the one above.
    pub pair: [usize; 2],
    /// Its ends along the line, mm: the same where the panels touch at a corner alone.
    pub ends: [f64; 2],
}

impl DividingLine {
    /// The place on the line whose other coordinate is `along`, mm.
    #[must_use]
    pub fn place(&self, along: f64) -> DVec2 {
        if self.axis == 0 { DVec2::new(self.at, along) } else { DVec2::new(along, self.at) }
    }

    /// Every stretch that a panel on one side has in common with one on the other.
    #[must_use]
    pub fn stretches(&self, parts: &Panels) -> Vec<CommonStretch> {
        let along = 1 - self.axis;
        let pairs = self.sides[0].iter().flat_map(|&a| self.sides[1].iter().map(move |&b| [a, b]));
        let stretch = |pair: [usize; 2]| {
            let [a, b] = pair.map(|k| parts.0[k]);
            let ends = [a.min[along].max(b.min[along]), a.max[along].min(b.max[along])];
            (ends[0] <= ends[1]).then_some(CommonStretch { pair, ends })
        };
        pairs.filter_map(stretch).collect()
    }
}

impl Panels {
    /// The panel that `q` belongs to.
    #[inline]
    #[must_use]
    pub fn index_of(&self, q: DVec2) -> usize {
        self.0.iter().position(|rect| rect.contains(q)).unwrap_or_else(|| self.nearest(q))
    }

    /// The rectangle that they tile.
    #[must_use]
    pub fn bounds(&self) -> Rect {
        let none = Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
        self.0
            .iter()
            .fold(none, |all, rect| Rect { min: all.min.min(rect.min), max: all.max.max(rect.max) })
    }

    fn nearest(&self, q: DVec2) -> usize {
        let outside = |k: usize| Outline::Rect(self.0[k]).distance_outside(q);
        (1..self.0.len()).fold(0, |least, k| if outside(k) < outside(least) { k } else { least })
    }

    /// `lo`, the sides of panels between along `axis`, rising, and `hi`.
    #[must_use]
    pub fn breaks(&self, axis: usize, lo: f64, hi: f64) -> Vec<f64> {
        let sides = self.0.iter().flat_map(|rect| [rect.min[axis], rect.max[axis]]);
        let mut breaks: Vec<f64> = sides.filter(|side| lo < *side && *side < hi).collect();
        breaks.extend([lo, hi]);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        breaks
    }

    /// Every line between panels; where four meet, the line of constant x goes through.
    #[must_use]
    pub fn dividing_lines(&self) -> Vec<DividingLine> {
        let mut lines = Vec::new();
        for axis in [0, 1] {
            let mut places: Vec<f64> = self.0.iter().map(|rect| rect.max[axis]).collect();
            places.sort_by(f64::total_cmp);
            places.dedup();
            for at in places {
                lines.extend(self.lines_at(axis, at));
            }
        }
        lines
    }

    /// The lines on which the coordinate `axis` is `at`.
    fn lines_at(&self, axis: usize, at: f64) -> Vec<DividingLine> {
        let (along, rects) = (1 - axis, &self.0);
        let beside = |side: fn(&Rect) -> DVec2| {
            (0..rects.len()).filter(move |&k| side(&rects[k])[axis] == at)
        };
        // Where a panel below and a panel above have a part of the line in common.
        let mut common: Vec<([f64; 2], [usize; 2])> = Vec::new();
        for a in beside(|rect| rect.max) {
            for b in beside(|rect| rect.min) {
                let from = rects[a].min[along].max(rects[b].min[along]);
                let to = rects[a].max[along].min(rects[b].max[along]);
                if from < to {
                    common.push(([from, to], [a, b]));
                }
            }
        }
        sort_by_number(&mut common, |line| line.0[0]);
        let mut lines: Vec<DividingLine> = Vec::new();
        let mut last: Option<([f64; 2], [usize; 2])> = None;
        for ([from, to], pair) in common {
            // Four panels meet where both sides change.
            let goes_on = last.is_some_and(|([_, end], before)| {
                end == from && (axis == 0 || before[0] == pair[0] || before[1] == pair[1])
            });
            if !goes_on {
                lines.push(DividingLine {
                    axis,
                    at,
                    ends: [from, to],
                    sides: [Vec::new(), Vec::new()],
                });
            }
            if let Some(line) = lines.last_mut() {
                line.ends[1] = to;
                for (side, k) in line.sides.iter_mut().zip(pair) {
                    if side.last() != Some(&k) {
                        side.push(k);
                    }
                }
            }
            last = Some(([from, to], pair));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tiles(rects: &[[f64; 4]]) -> Panels {
        let rect = |&[a, b, c, d]: &[f64; 4]| Rect { min: DVec2::new(a, b), max: DVec2::new(c, d) };
        Panels(rects.iter().map(rect).collect())
    }

    #[test]
    fn where_four_meet_the_line_of_constant_x_goes_through() {
        let four = tiles(&[
            [0.0, 0.0, 1.0, 1.0],
            [1.0, 0.0, 3.0, 1.0],
            [0.0, 1.0, 1.0, 2.0],
            [1.0, 1.0, 3.0, 2.0],
        ]);
        let line = |axis, ends, a: &[usize], b: &[usize]| DividingLine {
            axis,
            at: 1.0,
            ends,
            sides: [a.to_vec(), b.to_vec()],
        };
        let wanted = [
            line(0, [0.0, 2.0], &[0, 2], &[1, 3]),
            line(1, [0.0, 1.0], &[0], &[2]),
            line(1, [1.0, 3.0], &[1], &[3]),
        ];
        assert_eq!(four.dividing_lines(), wanted);
    }

    #[test]
    fn a_line_that_ends_on_another_leaves_that_whole() {
        let three = tiles(&[[0.0, 0.0, 2.0, 1.0], [0.0, 1.0, 1.0, 2.0], [1.0, 1.0, 2.0, 2.0]]);
        let stem = DividingLine { axis: 0, at: 1.0, ends: [1.0, 2.0], sides: [vec![1], vec![2]] };
        let bar = DividingLine { axis: 1, at: 1.0, ends: [0.0, 2.0], sides: [vec![0], vec![1, 2]] };
        assert_eq!(three.dividing_lines(), [stem, bar]);
    }

    #[test]
    fn every_place_has_a_panel() {
        let two = tiles(&[[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 2.0, 1.0]]);
        let places = [(0.5, 0), (1.0, 0), (1.5, 1), (-3.0, 0), (9.0, 1)];
        assert!(places.iter().all(|&(x, k)| two.index_of(DVec2::new(x, 0.5)) == k));
        assert_eq!(two.breaks(0, -1.0, 1.5), [-1.0, 0.0, 1.0, 1.5]);
    }
}
