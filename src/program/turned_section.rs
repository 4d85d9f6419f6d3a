//! What a nose leaves along one azimuth.
//!
//! Lower sides of two circles of one radius cross once: that of the centre farther out is the lower one outwards. So the section at
//! an azimuth follows from the circles in the order of their centres, each of which is the lowest between two crossings or nowhere.
//! Without cusps it is the line of the places at which the circles touch what they all follow: a radius from each centre, square
//! to the way from the centre before it to the one after it.

use crate::geom::DVec2;

/// A circle of a nose as an azimuth passes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NoseCircle {
    /// Its centre: distance from the axis, negative beyond it, and Z, mm.
    pub centre: DVec2,
    /// Number of the move.
    pub step: usize,
    /// Turns that the spindle has made.
    pub turn: f64,
    /// Whether the azimuth is on the other side of the axis, as half a turn later.
    pub is_beyond: bool,
}

/// What is left at one azimuth.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnedSection {
    nose_mm: f64,
    /// In the order of their centres from the axis.
    arcs: Vec<SectionArc>,
}

/// A circle that is the lowest from a distance of the axis up to the next one's.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SectionArc {
    from_mm: f64,
    circle: NoseCircle,
}

/// The lowest place of all circles at a distance from the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionPlace {
    /// Its Z, mm.
    pub z_mm: f64,
    /// Number of the move whose circle it is.
    pub step: usize,
}

impl TurnedSection {
    pub(super) fn new(mut circles: Vec<NoseCircle>, nose_mm: f64) -> Self {
        circles.sort_by(|a, b| {
            let [x, y] = [[a.centre.x, b.centre.x], [a.centre.y, b.centre.y]];
            x[0].total_cmp(&x[1]).then(y[0].total_cmp(&y[1])).then(a.step.cmp(&b.step))
        });
        // Of the same distance from the axis the lowest alone matters.
        circles.dedup_by(|later, before| later.centre.x == before.centre.x);
        let mut arcs: Vec<SectionArc> = Vec::new();
        for circle in circles {
            let mut from_mm = f64::NEG_INFINITY;
            while let Some(last) = arcs.last() {
                from_mm = crossing(last.circle.centre, circle.centre, nose_mm);
                if from_mm > last.from_mm {
                    break;
                }
                arcs.pop();
                from_mm = f64::NEG_INFINITY;
            }
            arcs.push(SectionArc { from_mm, circle });
        }
        Self { nose_mm, arcs }
    }

    /// The lowest place at a distance from the axis; none where no circle comes.
    #[must_use]
    pub fn lowest(&self, radius_mm: f64) -> Option<SectionPlace> {
        self.on_arc(self.arc_over(radius_mm)?, radius_mm)
    }

    /// Number of the arc over a distance from the axis.
    fn arc_over(&self, radius_mm: f64) -> Option<usize> {
        self.arcs.partition_point(|arc| arc.from_mm <= radius_mm).checked_sub(1)
    }

    /// The circle that is the lowest at a distance from the axis.
    pub(super) fn circle_over(&self, radius_mm: f64) -> Option<&NoseCircle> {
        Some(&self.arcs[self.arc_over(radius_mm)?].circle)
    }

    /// The place of an arc at a distance from the axis.
    fn on_arc(&self, arc: usize, radius_mm: f64) -> Option<SectionPlace> {
        let NoseCircle { centre, step, .. } = self.arcs[arc].circle;
        let off = radius_mm - centre.x;
        let depth = self.nose_mm * self.nose_mm - off * off;
        (depth >= 0.0).then(|| SectionPlace { z_mm: centre.y - depth.sqrt(), step })
    }

    /// The place at a distance from the axis of the line that all circles touch; none where no circle comes.
    #[must_use]
    pub fn without_cusps(&self, radius_mm: f64) -> Option<SectionPlace> {
        let arc = self.arc_over(radius_mm)?;
        let low = self.on_arc(arc, radius_mm)?;
        let touched = self.touched(arc);
        let is_inside = radius_mm < touched.x;
        let beside = if is_inside { arc.checked_sub(1) } else { Some(arc + 1) };
        let beside = beside.filter(|&k| k < self.arcs.len()).map(|k| self.touched(k));
        let Some(beside) = beside.filter(|beside| (beside.x < touched.x) == is_inside) else {
            return Some(low);
        };
        let share = (radius_mm - touched.x) / (beside.x - touched.x);
        let z_mm = (touched.y + share * (beside.y - touched.y)).min(low.z_mm);
        Some(SectionPlace { z_mm, ..low })
    }

    /// The place at which the circle of an arc touches what they all follow, within the arc.
    fn touched(&self, arc: usize) -> DVec2 {
        let centre = |k: usize| self.arcs[k].circle.centre;
        let (last, at) = (self.arcs.len() - 1, centre(arc));
        let way = centre((arc + 1).min(last)) - centre(arc.saturating_sub(1));
        let off = if way.x > 0.0 { way.y / way.length() * self.nose_mm } else { 0.0 };
        let end = self.arcs.get(arc + 1).map_or(f64::INFINITY, |next| next.from_mm);
        let x = (at.x + off).max(self.arcs[arc].from_mm).min(end);
        let depth = self.nose_mm * self.nose_mm - (x - at.x) * (x - at.x);
        DVec2::new(x, at.y - depth.max(0.0).sqrt())
    }

    /// The cusp that is the nearest to a distance from the axis: its own, and its place; none of a single circle.
    #[must_use]
    pub fn cusp_beside(&self, radius_mm: f64) -> Option<(f64, SectionPlace)> {
        let arc = self.arc_over(radius_mm)?;
        let ends = [arc, arc + 1].into_iter().filter(|&k| k > 0 && k < self.arcs.len());
        let off = |k: &usize| (self.arcs[*k].from_mm - radius_mm).abs();
        let at = self.arcs[ends.min_by(|a, b| off(a).total_cmp(&off(b)))?].from_mm;
        Some((at, self.lowest(at)?))
    }

    /// Distances from the axis of the cusps between circles, rising.
    pub fn cusps(&self) -> impl DoubleEndedIterator<Item = f64> + '_ {
        self.arcs.iter().skip(1).map(|arc| arc.from_mm)
    }
}

/// Distance from the axis from which on the lower side of the circle about `b` is the lower one, whose centre is farther out than `a`.
fn crossing(a: DVec2, b: DVec2, radius: f64) -> f64 {
    let (middle, way) = (0.5 * (a + b), b - a);
    let length = way.length();
    let half = 0.5 * length;
    let rise = f64::sqrt((radius * radius - half * half).max(0.0)) / length;
    let cross = middle + rise * DVec2::new(way.y, -way.x);
    // Where the circles cross on the upper side of one, the other's lower side ends above it or does not meet it.
    if half >= radius || cross.y > a.y.min(b.y) {
        return if a.y < b.y { a.x + radius } else { b.x - radius };
    }
    cross.x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;

    fn circles(centres: &[DVec2]) -> Vec<NoseCircle> {
        let circle = |(step, &centre)| NoseCircle { centre, step, turn: 0.0, is_beyond: false };
        centres.iter().enumerate().map(circle).collect()
    }

    /// The lowest of circles by trying all of them.
    fn tried(centres: &[DVec2], radius: f64, at: f64) -> Option<f64> {
        let depth = |c: &DVec2| radius * radius - (at - c.x) * (at - c.x);
        let all = centres.iter().filter(|c| depth(c) >= 0.0).map(|c| c.y - depth(c).sqrt());
        all.reduce(f64::min)
    }

    /// Of circles anywhere, some far apart, some hidden by others.
    #[test]
    fn a_section_is_the_lowest_of_all_circles() {
        let mut random = Draws::new(7);
        for spread in [0.1, 1.0, 10.0] {
            let centres: Vec<DVec2> =
                (0..60).map(|_| DVec2::new(20.0 * random.unit(), spread * random.unit())).collect();
            let section = TurnedSection::new(circles(&centres), 0.7);
            for k in 0..4000 {
                let at = -1.0 + 22.0 * f64::from(k) / 4000.0;
                let found = section.lowest(at).map(|place| place.z_mm);
                match (found, tried(&centres, 0.7, at)) {
                    (Some(a), Some(b)) => assert!((a - b).abs() < 1e-9, "{spread} {at}: {a} {b}"),
                    (a, b) => assert_eq!(a.is_some(), b.is_some(), "{spread} {at}"),
                }
            }
        }
    }

    /// Circles that follow a sphere a radius away from it touch it: without cusps the section is the sphere but for its chords from
    /// place to place, and its cusps are f^2 / (8 r (1 + r k)) higher.
    #[test]
    fn without_cusps_a_section_is_what_its_circles_follow() {
        for (nose_mm, feed_mm) in [(0.4, 0.02), (1.0, 0.006), (2.0, 0.1)] {
            let sphere_mm = 30.0;
            let centre = |k: i32| {
                let angle = f64::from(k) * feed_mm / (sphere_mm + nose_mm);
                (sphere_mm + nose_mm) * DVec2::new(crate::num::sin(angle), crate::num::cos(angle))
            };
            let turns = (20.0 / feed_mm) as i32;
            let centres: Vec<DVec2> = (0..=turns).map(centre).collect();
            let section = TurnedSection::new(circles(&centres), nose_mm);
            let touched_mm = feed_mm * sphere_mm / (sphere_mm + nose_mm);
            let chord = touched_mm * touched_mm / (8.0 * sphere_mm);
            let cusp = feed_mm * feed_mm / (8.0 * nose_mm * (1.0 + nose_mm / sphere_mm));
            let (mut deepest, mut highest) = (0.0_f64, 0.0_f64);
            for k in 0..4000 {
                let at = 0.5 + 17.0 * f64::from(k) / 4000.0;
                let z = section.without_cusps(at).unwrap().z_mm;
                let off = f64::sqrt(at * at + z * z) - sphere_mm;
                deepest = deepest.min(off);
                assert!(off < 1e-12 && off > -1.01 * chord - 1e-12, "{feed_mm} {at}: {off}");
                let (beside, low) = section.cusp_beside(at).unwrap();
                assert!((beside - at).abs() < 0.6 * feed_mm);
                highest = highest.max(f64::sqrt(beside * beside + low.z_mm * low.z_mm) - sphere_mm);
            }
            assert!((deepest / chord + 1.0).abs() < 0.1, "{deepest} {chord}");
            // (The next order is that of the feed over the nose, squared.)
            assert!((highest / cusp - 1.0).abs() < 0.01, "{highest} {cusp}");
        }
    }
}
