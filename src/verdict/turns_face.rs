//! The face that a ball leaves which goes around the axis of a round mirror, as in a spiral: circles and azimuths whose places follow
//! the cusps.

use super::cusp_search::CuspSearch;
use super::polar_face::{PolarFace, PolarLimits, UncutPlace, azimuths, facet_estimate, whole};
use super::polar_section::PolarSection;
use crate::geom::{DVec2, TriMesh};
use crate::machining::{ROWS, rim_distances};
use crate::mirror::{Mirror, SurfaceSamples};
use crate::num::{cos, sin};
use crate::program::{SweptCutter, TurnCoverage};
use crate::results::CuttingFault;
use std::f64::consts::TAU;

/// Moves that go around so much are turns.
const AROUND: f64 = 0.98;
/// What a rim may be out of round, as a share of its radius, for circles of facets to end in it.
const ROUND: f64 = 1e-6;
/// Halvings by which the narrowest turns are found, to far less than four digits.
const HALVINGS: usize = 40;

/// A round mirror, cut by turns about its axis.
pub(super) struct RoundFace {
    /// Radii of its rims in the plan, the inner one 0 of a disc, mm.
    radii_mm: [f64; 2],
    /// Its largest slope.
    steepest: f64,
}

impl RoundFace {
    /// The face of `mirror`; none of one whose rims are no circles in the plan.
    pub(super) fn new(mirror: &Mirror) -> Option<Self> {
        let rims = rim_distances(mirror)?;
        let is_round = rims.iter().all(|[least, most]| most - least <= ROUND * most);
        let steepest = || SurfaceSamples::new(mirror).largest(|place| place.slope.length()).0;
        let radii_mm = rims.map(|[least, most]| 0.5 * (least + most));
        is_round.then(|| Self { radii_mm, steepest: steepest() })
    }

    /// Radii of its rims, mm.
    pub(super) fn radii_mm(&self) -> [f64; 2] {
        self.radii_mm
    }

    /// Azimuths for turns of a ball so far apart, and about how many facets that makes.
    fn size(&self, ball_mm: f64, apart_mm: f64) -> [f64; 2] {
        let [inner, outer] = self.radii_mm;
        // No farther from each other than the turns are, for a mirror that is not the same all around.
        let by_turns = whole(TAU * outer / apart_mm);
        let azimuths = azimuths(self.steepest, 0.5 * apart_mm / ball_mm).max(by_turns);
        [azimuths, facet_estimate((outer - inner) / apart_mm, azimuths)]
    }

    /// The least distance of turns, mm, whose cut by a ball takes no more than `most` facets.
    pub(super) fn narrowest_mm(&self, ball_mm: f64, most: f64) -> f64 {
        let [mut low, mut high] = [0.0, ball_mm];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let [_, facets] = self.size(ball_mm, middle);
            if facets <= most { high = middle } else { low = middle }
        }
        high
    }

    /// What `swept` leaves, if its moves are turns, and whether facets, no more than `most` then, follow its cusps.
    ///
    /// # Errors
    /// [`CuttingFault`] where no move comes over a place of the mirror.
    pub(super) fn cut(
        &self,
        swept: &SweptCutter,
        turns: &TurnCoverage,
        most: f64,
    ) -> Option<Result<(TriMesh, bool), CuttingFault>> {
        if turns.around < AROUND {
            return None;
        }
        let (radii_mm, apart_mm) = (self.radii_mm, turns.apart_mm);
        let [azimuths, _] = self.size(swept.cutter().radius_mm, apart_mm);
        let section = |share: f64| SweptSection::new(swept, share, (radii_mm, apart_mm));
        let limits = PolarLimits { radii_mm, rim: &|_| None, corners: &[], azimuths, most };
        let face = PolarFace::of_sections(&section, limits)
            .map_err(|UncutPlace(at_mm)| CuttingFault::Uncut { at_mm });
        Some(face.map(|face| (face.mesh, face.follows_cusps)))
    }
}

/// What a cutter leaves along one radius.
struct SweptSection<'a> {
    swept: &'a SweptCutter,
    /// Direction of the radius.
    out: DVec2,
    /// Ends of the radius, mm.
    radii_mm: [f64; 2],
    /// Distance of the turns, mm.
    apart_mm: f64,
}

impl<'a> SweptSection<'a> {
    /// At an azimuth that is a share of a turn, between two radii, of turns so far apart, mm.
    fn new(swept: &'a SweptCutter, share: f64, (radii_mm, apart_mm): ([f64; 2], f64)) -> Self {
        let angle = TAU * share;
        Self { swept, out: DVec2::new(cos(angle), sin(angle)), radii_mm, apart_mm }
    }
}

impl PolarSection for SweptSection<'_> {
    fn cusps_mm(&self) -> Vec<f64> {
        let &Self { swept, out, radii_mm: [inner, outer], apart_mm } = self;
        let rows = ((outer - inner) * ROWS as f64 / apart_mm).ceil().max(1.0);
        let pitch_mm = (outer - inner) / rows;
        let search = CuspSearch { swept, ways: [out.perp(), out], apart_mm, pitch_mm };
        let middle = |k: usize| inner + (k as f64 + 0.5) * pitch_mm;
        (0..rows as usize).filter_map(|k| search.near(0.0, middle(k))).collect()
    }

    fn cut(&self, radius_mm: f64) -> Option<(f64, usize)> {
        let place = self.swept.lowest(self.out * radius_mm)?;
        Some((place.z_mm, place.step))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Cutter, DVec3};
    use crate::mirror::{Hessian, LocalSurface};
    use crate::program::ToolMove;

    /// A surface of revolution: height, slope and second derivative along the radius.
    type Shape = fn(f64) -> [f64; 3];

    fn plane(_: f64) -> [f64; 3] {
        [5.0, 0.0, 0.0]
    }

    fn cone(r: f64) -> [f64; 3] {
        [9.0 - 0.5 * r, -0.5, 0.0]
    }

    /// A dome of 25 mm radius.
    fn sphere(r: f64) -> [f64; 3] {
        let z = f64::sqrt(625.0 - r * r);
        [z, -r / z, -625.0 / (z * z * z)]
    }

    const BALL_MM: f64 = 2.0;

    /// Moves of the tip along a spiral, and of its places of contact, short enough for their slopes to add nothing.
    fn spiral(shape: Shape, apart_mm: f64) -> [Vec<ToolMove>; 2] {
        let contact = |k: usize| {
            let turns = k as f64 / 800.0;
            let r = (10.0 + apart_mm * (1.5 - turns)).max(0.0);
            let out = DVec2::new(cos(TAU * turns), -sin(TAU * turns));
            let [z, slope, _] = shape(r);
            ((r * out).extend(z), (-slope * out).extend(1.0).normalize())
        };
        let tip = |k: usize| {
            let (at, normal) = contact(k);
            at + BALL_MM * (normal - DVec3::Z)
        };
        let count = (800.0 * (10.0 / apart_mm + 1.5)).ceil() as usize;
        let moved = |from: DVec3, to: DVec3| ToolMove { from, to, feed: Some(1.0), line: 1 };
        [
            (0..count).map(|k| moved(tip(k), tip(k + 1))).collect(),
            (0..count).map(|k| moved(contact(k).0, contact(k + 1).0)).collect(),
        ]
    }

    fn face(shape: Shape, apart_mm: f64, inner: f64) -> TriMesh {
        let [moves, contacts] = spiral(shape, apart_mm);
        let corners = [DVec2::splat(-10.0), DVec2::splat(10.0)];
        let swept = SweptCutter::new(&moves, Cutter::ball(BALL_MM), corners);
        let turns = TurnCoverage::new(&contacts, 1, [inner, 10.0]).unwrap();
        assert!((turns.apart_mm / apart_mm - 1.0).abs() < 0.01, "{turns:?}");
        let steepest = shape(10.0)[1].abs();
        let round = RoundFace { radii_mm: [inner, 10.0], steepest };
        round.cut(&swept, &turns, 6e6).unwrap().unwrap_or_else(|fault| panic!("{fault}")).0
    }

    /// Error of the slope, RMS over the plan, of facets and of the closed form T77 with the curvatures across and along a circle; and the
    /// height of the highest cusp over that of T76. Over a plane: w / (2 R sqrt 3) and w^2 / 8 R.
    fn told(shape: Shape, mesh: &TriMesh, apart_mm: f64, inner: f64) -> [f64; 2] {
        let local = |r: f64| {
            let [z, slope, bend] = shape(r);
            let at = DVec3::new(r, 0.0, z);
            let hessian = Hessian { xx: bend, xy: 0.0, yy: slope / r };
            LocalSurface { at, slope: DVec2::new(slope, 0.0), hessian }
        };
        let scallop = |r: f64| {
            let scallop = crate::machining::Scallop::new(&local(r), BALL_MM, DVec2::Y);
            scallop.unwrap_or_else(|| panic!("{r}"))
        };
        let (mut area, mut square, mut exact) = (0.0, 0.0, 0.0);
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
            let normal = (b - a).cross(c - a);
            let middle = ((a + b + c) / 3.0).truncate();
            let r = middle.length();
            // In the middle turns are as narrow as their distance, which T77 does not know.
            if r < inner.max(2.0) {
                continue;
            }
            let off = -normal.truncate() / normal.z - shape(r)[1] * middle / r;
            area += 0.5 * normal.z;
            square += 0.5 * normal.z * off.length_squared();
            let most = scallop(r).slope(apart_mm);
            exact += 0.5 * normal.z * most * most / 3.0;
        }
        assert!(area > 0.9 * std::f64::consts::PI * (100.0 - inner.max(2.0) * inner.max(2.0)));
        let high = mesh.vertices.iter().filter(|v| v.truncate().length() > inner.max(2.0));
        let high = high.map(|v| {
            let r = v.truncate().length();
            let [z, slope, _] = shape(r);
            let height = (v.z - z) / f64::sqrt(1.0 + slope * slope);
            height / scallop(r).height_mm(apart_mm).unwrap()
        });
        [(square / exact).sqrt(), high.fold(0.0, f64::max)]
    }

    #[test]
    fn facets_follow_the_cusps_of_a_spiral() {
        let shapes: [(Shape, f64, f64); 4] =
            [(plane, 0.5, 0.0), (cone, 0.5, 0.0), (sphere, 0.5, 0.0), (cone, 0.4, 5.0)];
        for (shape, apart_mm, inner) in shapes {
            let mesh = face(shape, apart_mm, inner);
            let [rms, high] = told(shape, &mesh, apart_mm, inner);
            assert!((rms - 1.0).abs() < 0.02, "{apart_mm} {inner}: slopes {rms}");
            assert!((high - 1.0).abs() < 0.05, "{apart_mm} {inner}: cusps {high}");
        }
    }

    #[test]
    fn the_narrowest_turns_have_the_most_facets() {
        let round = RoundFace { radii_mm: [3.0, 40.0], steepest: 0.8 };
        for most in [1e5, 1e6] {
            let narrowest = round.narrowest_mm(3.0, most);
            let [_, facets] = round.size(3.0, narrowest);
            assert!(facets <= most && facets > 0.95 * most, "{facets} of {most}");
        }
    }
}
