//! Rows across a face, and the strips between them.

use super::outlines::Polygon;
use crate::geom::{DVec2, turn};
use crate::num::sort_by_number;

/// How far the side of a strip may be from the outline, as a share of the face's size.
const STRAIGHT: f64 = 2e-5;

/// One side of a strip: where it meets the row below and the row above.
pub(super) type StripSide = [f64; 2];

/// Rows and the strips between them.
#[derive(Debug)]
pub(super) struct LatticeRows {
    /// y of each row.
    pub y: Vec<f64>,
    /// Whether the outline leaves the row free to follow a cusp.
    pub free: Vec<bool>,
    /// Strips over each row but the last: left and right side.
    pub strips: Vec<Vec<[StripSide; 2]>>,
}

impl LatticeRows {
    /// Where the rows of `panels` lie, `pitch` apart or closer, one of them at `row`, and the strips between them. Corners a
    /// hair off a row are put on it.
    pub(super) fn new(panels: &mut [Vec<Polygon>], pitch: f64, row: f64) -> Self {
        let hair = 0.02 * pitch;
        let points = || panels.iter().flatten().flatten();
        let [lo, hi] =
            points().fold([f64::MAX, f64::MIN], |[lo, hi], p| [lo.min(p.y), hi.max(p.y)]);
        let size = points().fold(0.0f64, |most, p| most.max(p.abs().max_element()));
        let mut y = needed_rows(panels, size, hair);
        let first = ((lo - row) / pitch).ceil() as i64;
        let last = ((hi - row) / pitch).floor() as i64;
        for corner in panels.iter_mut().flatten().flatten() {
            if let Some(row) = y.iter().find(|row| (*row - corner.y).abs() <= hair) {
                corner.y = *row;
            }
        }
        // Even rows give way to those that the outline needs.
        let fixed = y.clone();
        let clear = |at: &f64| fixed.iter().all(|row| (row - at).abs() > 0.05 * pitch);
        y.extend((first..=last).map(|k| row + k as f64 * pitch).filter(clear));
        y.sort_by(f64::total_cmp);
        let strips = y.windows(2).map(|pair| strips(panels, [pair[0], pair[1]])).collect();
        let free = y.iter().map(|at| !fixed.contains(at)).collect();
        Self { y, free, strips }
    }

    /// Where the sides of strips meet a row.
    pub(super) fn fixed(&self, k: usize) -> Vec<f64> {
        let above = self.strips.get(k).into_iter().flatten().flatten().map(|side| side[0]);
        let below = k.checked_sub(1).map(|k| &self.strips[k]);
        let below = below.into_iter().flatten().flatten().map(|side| side[1]);
        let mut fixed: Vec<f64> = above.chain(below).collect();
        fixed.sort_by(f64::total_cmp);
        fixed.dedup();
        fixed
    }

    /// The places of one row: where sides of strips meet it, and between them `along_mm` apart.
    pub(super) fn places(&self, k: usize, along_mm: f64) -> Vec<f64> {
        let fixed = self.fixed(k);
        let mut all = Vec::new();
        for pair in fixed.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            all.push(from);
            let covers =
                |[left, right]: &[StripSide; 2], end: usize| left[end] <= from && to <= right[end];
            let above =
                self.strips.get(k).is_some_and(|strips| strips.iter().any(|s| covers(s, 0)));
            let below = k > 0 && self.strips[k - 1].iter().any(|s| covers(s, 1));
            if above || below {
                let margin = 0.25 * along_mm;
                let (first, last) =
                    (((from + margin) / along_mm).ceil(), ((to - margin) / along_mm).floor());
                all.extend((first as i64..=last as i64).map(|n| n as f64 * along_mm));
            }
        }
        all.extend(fixed.last());
        all
    }
}

/// y of the rows that the outline needs: through its corners and turns, and so near each other that its
/// sides are straight between them.
fn needed_rows(panels: &[Vec<Polygon>], size: f64, hair: f64) -> Vec<f64> {
    let mut y: Vec<f64> = Vec::new();
    let mut add = |at: f64| {
        if y.iter().all(|row| (row - at).abs() > hair) {
            y.push(at);
        }
    };
    for side in panels.iter().flatten() {
        let count = side.len();
        let corner = |k: usize| side[k % count];
        // Corners where the outline turns back in y, or turns sharply.
        let sharp = |k: usize| {
            let (into, out) = (corner(k) - corner(k + count - 1), corner(k + 1) - corner(k));
            into.y * out.y <= 0.0 || into.perp_dot(out).abs() > 0.1 * into.length() * out.length()
        };
        let turns: Vec<usize> = (0..count).filter(|&k| sharp(k)).collect();
        for (n, &from) in turns.iter().enumerate() {
            add(corner(from).y);
            let to = if n + 1 < turns.len() { turns[n + 1] } else { turns[0] + count };
            split(&corner, from, to, STRAIGHT * size, &mut add);
        }
    }
    y
}

/// Adds rows between two corners until the outline is nowhere farther than `off` from the chord.
fn split(
    corner: &impl Fn(usize) -> DVec2,
    from: usize,
    to: usize,
    off: f64,
    add: &mut impl FnMut(f64),
) {
    let (a, b) = (corner(from), corner(to));
    let away = |k: usize| turn(a, b, corner(k)).abs() / (b - a).length();
    let farthest = (from + 1..to).max_by(|&i, &j| away(i).total_cmp(&away(j)));
    if let Some(k) = farthest.filter(|&k| away(k) > off) {
        add(corner(k).y);
        split(corner, from, k, off, add);
        split(corner, k, to, off, add);
    }
}

/// The strips between two rows: pairs of sides of each panel, from left to right.
fn strips(panels: &[Vec<Polygon>], [low, high]: [f64; 2]) -> Vec<[StripSide; 2]> {
    let middle = 0.5 * (low + high);
    let mut all = Vec::new();
    for loops in panels {
        let mut sides: Vec<(f64, StripSide)> = Vec::new();
        for side in loops {
            let count = side.len();
            for k in 0..count {
                let (a, b) = (side[k], side[(k + 1) % count]);
                if (a.y > middle) == (b.y > middle) {
                    continue;
                }
                // Along the outline to where it meets the rows.
                let rising = b.y > a.y;
                let meet = |row: f64| {
                    let up = (row > middle) == rising;
                    let step = if up { 1 } else { count - 1 };
                    let edges = (0..count).map(|n| (k + n * step) % count);
                    let edges = edges.map(|k| {
                        if up {
                            (side[k], side[(k + 1) % count])
                        } else {
                            (side[(k + 1) % count], side[k])
                        }
                    });
                    let reached = |to: DVec2| if row > middle { to.y >= row } else { to.y <= row };
                    let edge = edges.into_iter().find(|&(_, to)| reached(to));
                    edge.map_or(f64::NAN, |(from, to)| at_row(from, to, row))
                };
                let side = [meet(low), meet(high)];
                sides.push((0.5 * (side[0] + side[1]), side));
            }
        }
        sort_by_number(&mut sides, |side| side.0);
        all.extend(sides.chunks_exact(2).map(|pair| [pair[0].1, pair[1].1]));
    }
    sort_by_number(&mut all, |piece| piece[0][0] + piece[0][1]);
    all
}

/// x of an edge on a row that it meets, the same bits whichever end comes first.
fn at_row(a: DVec2, b: DVec2, row: f64) -> f64 {
    let [lo, hi] = if a.y < b.y { [a, b] } else { [b, a] };
    if row <= lo.y {
        return lo.x;
    }
    if row >= hi.y {
        return hi.x;
    }
    lo.x + (hi.x - lo.x) * ((row - lo.y) / (hi.y - lo.y))
}
