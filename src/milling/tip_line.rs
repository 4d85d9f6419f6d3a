//! A line that a tip follows over the mirror.

use crate::geom::{DVec2, DVec3};

/// Places of a cutter's tip along one line of a raster, from beyond one side of the mirror to beyond the other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TipLine {
    /// The places, mm: two at least.
    pub places: Vec<DVec3>,
    /// Directions of the line, of unit length, at its first and its last place.
    pub directions: [DVec3; 2],
}

impl TipLine {
    /// The line the other way.
    pub(super) fn reversed(&self) -> Self {
        let [first, last] = self.directions;
        let places = self.places.iter().rev().copied().collect();
        Self { places, directions: [-last, -first] }
    }

    /// The line farther across by `by`.
    pub(super) fn shifted(&self, by: DVec2) -> Self {
        let by = by.extend(0.0);
        let places = self.places.iter().map(|&at| at + by).collect();
        Self { places, directions: self.directions }
    }

    /// Raises places that are lower than `floor_mm` to it.
    pub(super) fn raise(&mut self, floor_mm: f64) {
        for at in &mut self.places {
            at.z = at.z.max(floor_mm);
        }
    }

    /// Its first and its last place.
    pub(super) fn ends(&self) -> [DVec3; 2] {
        [self.places[0], self.places[self.places.len() - 1]]
    }
}

/// The places of a path of straight moves that are needed for it to stay within `chord_mm` (Douglas and Peucker's method).
#[must_use]
pub fn thinned(places: &[DVec3], chord_mm: f64) -> Vec<DVec3> {
    let Some(last) = places.len().checked_sub(1) else { return Vec::new() };
    let mut kept = vec![false; places.len()];
    kept[0] = true;
    kept[last] = true;
    let mut parts = vec![[0, last]];
    while let Some([from, to]) = parts.pop() {
        let off = |k: usize| distance_from_move(places[k], [places[from], places[to]]);
        let farthest = (from + 1..to).map(|k| (off(k), k)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, k)) = farthest.filter(|(off, _)| *off > chord_mm) {
            kept[k] = true;
            parts.extend([[from, k], [k, to]]);
        }
    }
    places.iter().zip(kept).filter(|(_, kept)| *kept).map(|(at, _)| *at).collect()
}

/// Distance of a place from a straight move.
#[must_use]
pub fn distance_from_move(at: DVec3, [from, to]: [DVec3; 2]) -> f64 {
    let way = to - from;
    let length = way.length_squared();
    let share = if length > 0.0 { ((at - from).dot(way) / length).clamp(0.0, 1.0) } else { 0.0 };
    at.distance(from + share * way)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_path_keeps_its_ends_and_its_distance() {
        let arc: Vec<DVec3> = (0..=1000)
            .map(|k| DVec3::new(0.01 * f64::from(k), 0.0, 0.001 * f64::from(k * k) * 0.01))
            .collect();
        let few = thinned(&arc, 1e-2);
        assert!(few.len() > 5 && few.len() < 60, "{}", few.len());
        assert_eq!((few[0], few[few.len() - 1]), (arc[0], arc[1000]));
        for at in &arc {
            let off = few.windows(2).map(|pair| distance_from_move(*at, [pair[0], pair[1]]));
            assert!(off.fold(f64::INFINITY, f64::min) <= 1e-2);
        }
        assert_eq!(thinned(&arc[..1], 1.0), arc[..1]);
    }
}
