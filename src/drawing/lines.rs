//! Segments of a view made into lines.

use crate::geom::DVec2;
use std::collections::BTreeMap;

/// A straight piece of a view.
pub(super) type Segment = [DVec2; 2];

/// Joins segments with common ends, to within `grain`, to lines as long as no third one branches off, and leaves out places that
/// lie within `grain` of the rest. Segments that lie on each other count once.
pub(super) fn joined(segments: &[Segment], grain: f64) -> Vec<Vec<DVec2>> {
    let mut network = Network::new(segments, grain);
    let all = 0..network.segments.len();
    // From ends and branches first; what is left are closed lines.
    let mut lines = Vec::new();
    for wanted_open in [true, false] {
        for k in all.clone() {
            for from in network.segments[k] {
                let is_open = network.at[&network.key(from)].len() != 2;
                if !network.taken[k] && (is_open || !wanted_open) {
                    lines.push(simplified(&network.follow(from, k), grain));
                }
            }
        }
    }
    lines
}

/// Segments by their ends.
struct Network {
    grain: f64,
    segments: Vec<Segment>,
    at: BTreeMap<[i64; 2], Vec<usize>>,
    taken: Vec<bool>,
}

impl Network {
    fn new(segments: &[Segment], grain: f64) -> Self {
        let key = |p: DVec2| (p / grain).round().to_array().map(|x| x as i64);
        let mut known = BTreeMap::new();
        for &[a, b] in segments {
            let (from, to) = (key(a), key(b));
            if from != to {
                known.entry((from.min(to), from.max(to))).or_insert([a, b]);
            }
        }
        let segments: Vec<Segment> = known.into_values().collect();
        let mut at: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
        for (k, segment) in segments.iter().enumerate() {
            segment.iter().for_each(|end| at.entry(key(*end)).or_default().push(k));
        }
        let taken = vec![false; segments.len()];
        Self { grain, segments, at, taken }
    }

    fn key(&self, p: DVec2) -> [i64; 2] {
        (p / self.grain).round().to_array().map(|x| x as i64)
    }

    /// The line from an end of a segment as far as it goes without a branch.
    fn follow(&mut self, from: DVec2, first: usize) -> Vec<DVec2> {
        let (mut line, mut next) = (vec![from], Some(first));
        while let Some(k) = next {
            self.taken[k] = true;
            let [a, b] = self.segments[k];
            let end = if self.key(a) == self.key(line[line.len() - 1]) { b } else { a };
            line.push(end);
            let there = &self.at[&self.key(end)];
            let other = there.iter().copied().find(|other| !self.taken[*other]);
            next = other.filter(|_| there.len() == 2);
        }
        line
    }
}

/// A line without the places that lie within `grain` of the straight way between those that it keeps.
fn simplified(line: &[DVec2], grain: f64) -> Vec<DVec2> {
    let (mut kept, mut from) = (vec![line[0]], 0);
    while from + 1 < line.len() {
        let is_straight = |to: usize| {
            let (start, way) = (line[from], line[to] - line[from]);
            let off = |p: &DVec2| way.perp_dot(*p - start).abs() <= grain * way.length();
            let ahead = |p: &DVec2| way.dot(*p - start) >= 0.0;
            line[from + 1..to].iter().all(|p| off(p) && ahead(p))
        };
        let mut to = from + 1;
        while to + 1 < line.len() && is_straight(to + 1) {
            to += 1;
        }
        kept.push(line[to]);
        from = to;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(a: [f64; 2], b: [f64; 2]) -> Segment {
        [DVec2::from_array(a), DVec2::from_array(b)]
    }

    #[test]
    fn a_square_in_pieces_is_one_closed_line_with_its_corners() {
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let mut pieces = Vec::new();
        for k in 0..4 {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            // One is there twice, in the other direction.
            pieces.extend([segment(a, middle), segment(b, middle), segment(middle, b)]);
        }
        let lines = joined(&pieces, 1e-6);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        assert!((5..=6).contains(&lines[0].len()), "{lines:?}");
        let length: f64 = lines[0].windows(2).map(|w| w[0].distance(w[1])).sum();
        assert_eq!(length, 16.0);
    }

    #[test]
    fn lines_end_where_a_third_one_branches_off() {
        let pieces = [
            segment([0.0, 0.0], [1.0, 0.0]),
            segment([1.0, 0.0], [2.0, 0.0]),
            segment([2.0, 0.0], [3.0, 0.0]),
            segment([2.0, 0.0], [2.0, 5.0]),
        ];
        let mut lengths: Vec<f64> = joined(&pieces, 1e-6)
            .iter()
            .map(|line| line.windows(2).map(|w| w[0].distance(w[1])).sum())
            .collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(lengths, [1.0, 2.0, 5.0]);
    }
}
