//! A face as a lathe or the turns of a mill leave it, on a lattice of circles and azimuths whose places follow the cusps.
//!
//! Between two cusps of one azimuth there are [`ROWS`] rows. A turn farther the cusps have moved from row to row by a whole feed: at
//! each azimuth the nearest row is moved onto each cusp, and where a cusp goes over to the next row, the facets' diagonal follows it.
//! Towards the axis azimuths become fewer by halves, as the circles do. Beyond the largest circle that a rim leaves whole, facets follow the cusps
//! of each azimuth up to it.
//!
//! Where that takes too many facets rows are even, and the face is without its cusps: their slopes are then the path's to tell.

use super::polar_rim::{self, RimPlace};
use super::polar_section::PolarSection;
use crate::geom::{DVec3, TriMesh};
use crate::num::{cos, sin};
use crate::parallel;
use crate::program::TurnedSurface;
use std::f64::consts::TAU;

/// Rows from cusp to cusp.
pub(super) const ROWS: usize = 8;
/// Azimuths of a circle come in multiples of this, so that they can be halved four times.
const MULTIPLE: usize = 16;
/// Distance of two cusps over the mean one from which on both have rows.
const CLOSE: f64 = 0.1;
/// What a row keeps of its distance from the next one, at least, when it is moved.
const KEPT: f64 = 0.2;
/// Least distance of an uneven rim from the circle within it over that of the turns.
const HALF: f64 = 0.5;
/// Share of its radius from which on a rim is no circle.
const EVEN: f64 = 1e-7;
/// Halvings of the azimuths towards the axis, at most.
const MOST_HALVINGS: usize = 4;
/// Azimuths of a rim, at least: its polygon is then 0.004 % of its radius inside it.
const LEAST_AZIMUTHS: f64 = 360.0;
/// Tilts of facets about the axis over those of the cusps: independent of them, they add 1 % to the root mean square.
const TILT_SHARE: f64 = 0.14;
/// Facets of a face without cusps, about, and its azimuths at the most: chords are then less than a micrometre off any mirror that is
/// turned, and what they are off in slope is the path's to tell.
const EVEN_FACETS: f64 = 1.5e6;
const EVEN_AZIMUTHS: f64 = 1440.0;
/// One azimuth of so many has its cusps among the highest places.
const PEAKS: usize = 4;
/// Facets for each row and azimuth of the rim, as azimuths become fewer towards the axis: twice the mean of 1, 1/2, 1/4... over halves,
/// quarters... of the radius.
const FACETS: f64 = 4.0 / 3.0;

/// A face of a lathe between two radii.
pub(super) struct PolarFace {
    /// The facets, counter-clockwise from above.
    pub mesh: TriMesh,
    /// The move that cuts each vertex.
    pub steps: Vec<usize>,
    /// Mean distance of the cusps along the radius, mm.
    pub apart_mm: f64,
    /// Whether facets follow the cusps; else the face is without them.
    pub follows_cusps: bool,
    /// Cusps that the face is without, with the moves that leave them: some of all.
    pub peaks: Vec<(DVec3, usize)>,
}

/// X and Y of a place that no move comes over, mm.
pub(super) struct UncutPlace(pub [f64; 2]);

/// What a face is to be.
pub(super) struct PolarLimits<'a> {
    /// Inner radius, 0 of a disc, and the outer one, mm.
    pub radii_mm: [f64; 2],
    /// Distance of the outer rim from the axis at an azimuth, radians, mm; none of one that is round.
    pub rim: &'a (dyn Fn(f64) -> Option<f64> + Sync),
    /// Azimuths of the rim's corners, radians, 0 to a turn.
    pub corners: &'a [f64],
    /// Azimuths of a circle: as [`whole`] has them.
    pub azimuths: f64,
    /// Most facets that follow cusps; with 0 none do.
    pub most: f64,
}

/// Azimuths of the rim that a mirror takes with this largest slope, or bend around the axis, and cusps with this largest tilt, f / (2 r).
pub(super) fn azimuths(bend: f64, tilt: f64) -> f64 {
    // A facet between two azimuths is tilted by up to its slope times half the angle between them.
    whole(0.5 * TAU * bend / (TILT_SHARE * tilt))
}

/// Azimuths of the rim, no fewer than are needed.
pub(super) fn whole(needed: f64) -> f64 {
    let multiple = MULTIPLE as f64;
    (needed.max(LEAST_AZIMUTHS) / multiple).ceil() * multiple
}

/// About how many facets a face has of a meridian so many feeds long.
pub(super) fn facet_estimate(turns: f64, azimuths: f64) -> f64 {
    FACETS * turns * ROWS as f64 * azimuths
}

impl PolarFace {
    /// What `surface` leaves.
    pub(super) fn new(surface: &TurnedSurface, limits: PolarLimits) -> Result<Self, UncutPlace> {
        Self::of_sections(&|share| surface.section(share), limits)
    }

    /// What is left along the azimuths, each a share of a turn.
    pub(super) fn of_sections<S: PolarSection>(
        section: &(impl Fn(f64) -> S + Sync),
        limits: PolarLimits,
    ) -> Result<Self, UncutPlace> {
        let [inner, outer] = limits.radii_mm;
        let cusps = section(0.0).cusps_mm().into_iter().rev();
        let cusps: Vec<f64> = cusps.filter(|at| (inner..outer).contains(at)).collect();
        let apart_mm = (outer - inner) / cusps.len().max(1) as f64;
        let facets = facet_estimate(cusps.len() as f64, limits.azimuths);
        if limits.most > 0.0 && facets <= limits.most {
            let rows = |outer: f64| {
                let cusps: Vec<f64> = cusps.iter().copied().filter(|cusp| *cusp < outer).collect();
                rows(&cusps, [inner, outer])
            };
            let pitch_mm = apart_mm / ROWS as f64;
            let count = limits.azimuths as usize;
            let face = Self::on_rows(section, &limits, (&rows, pitch_mm, count))?;
            return Ok(Self { apart_mm, ..face });
        }
        let azimuths = limits.azimuths.min(EVEN_AZIMUTHS);
        let count = (EVEN_FACETS / (FACETS * azimuths)).ceil();
        let rows = |outer: f64| {
            let row = |k: usize| outer + (inner - outer) * (k as f64 / count);
            (0..=count as usize).map(row).collect()
        };
        let without = |share: f64| WithoutCusps(section(share));
        let pitch_mm = (outer - inner) / count;
        let face = Self::on_rows(&without, &limits, (&rows, pitch_mm, azimuths as usize))?;
        Ok(Self { apart_mm, follows_cusps: false, ..face })
    }

    /// The face on rows up to a radius, which are about so far apart, mm, with so many azimuths.
    fn on_rows<S: PolarSection>(
        section: &(impl Fn(f64) -> S + Sync),
        limits: &PolarLimits,
        (rows, pitch_mm, count): (&dyn Fn(f64) -> Vec<f64>, f64, usize),
    ) -> Result<Self, UncutPlace> {
        let mut outer = limits.radii_mm[1];
        let rims = uneven_rim(limits, count);
        if let Some(rims) = &rims {
            // The largest circle that the rim leaves room beside.
            let room_mm = HALF * ROWS as f64 * pitch_mm;
            outer = rims.iter().map(|rim| rim.radius_mm).fold(outer, f64::min) - room_mm;
        }
        let lattice = PolarLattice::new(rows(outer), count);
        let spokes = parallel::map(count, 1, |k| {
            let own = section(k as f64 / count as f64);
            let beyond = rims.as_ref().map(|rims| {
                let rim = &rims[k];
                let corner = rim.is_corner.then(|| section(rim.azimuth / TAU));
                let section = corner.as_ref().unwrap_or(&own);
                polar_rim::beyond(section, outer, rim, pitch_mm)
            });
            let has_peaks = k.is_multiple_of(PEAKS);
            let peaks = if has_peaks { lattice.peaks(&own, k) } else { Vec::new() };
            (lattice.spoke(&own, k), (beyond, peaks))
        });
        let (spokes, beyond): (Vec<_>, Vec<_>) = spokes.into_iter().unzip();
        let (beyond, peaks): (Vec<_>, Vec<_>) = beyond.into_iter().unzip();
        let mut face = lattice.joined(&spokes)?;
        face.peaks = peaks.concat();
        if let Some(beyond) = beyond.into_iter().collect::<Option<Vec<_>>>() {
            polar_rim::add(&mut face.mesh, &mut face.steps, &beyond).map_err(UncutPlace)?;
        }
        Ok(face)
    }
}

/// A section without its cusps.
struct WithoutCusps<S>(S);

impl<S: PolarSection> PolarSection for WithoutCusps<S> {
    fn cusps_mm(&self) -> Vec<f64> {
        Vec::new()
    }

    fn cut(&self, radius_mm: f64) -> Option<(f64, usize)> {
        self.0.without_cusps(radius_mm)
    }

    fn left_out(&self, radius_mm: f64) -> Option<(f64, f64, usize)> {
        self.0.cusp_beside(radius_mm)
    }
}

/// The rim's places at each azimuth, where it is not round. Those nearest to corners are in the corners.
fn uneven_rim(limits: &PolarLimits, count: usize) -> Option<Vec<RimPlace>> {
    let outer = limits.radii_mm[1];
    let even = |k: usize| TAU * k as f64 / count as f64;
    let mut azimuths: Vec<(f64, bool)> = (0..count).map(|k| (even(k), false)).collect();
    for &corner in limits.corners {
        azimuths[(corner / TAU * count as f64).round() as usize % count] = (corner, true);
    }
    let rim = |k: usize| {
        let (azimuth, is_corner) = azimuths[k];
        Some(RimPlace { azimuth, is_corner, radius_mm: (limits.rim)(azimuth)? })
    };
    let rims = parallel::map(count, 1, rim).into_iter().collect::<Option<Vec<_>>>()?;
    rims.iter().any(|rim| (rim.radius_mm - outer).abs() > EVEN * outer).then_some(rims)
}

/// Distances of the rows from the axis, falling, of cusps that fall; none of cusps that are nearer than [`CLOSE`] to each other or to a
/// rim.
fn rows(cusps: &[f64], [inner, outer]: [f64; 2]) -> Vec<f64> {
    let least = CLOSE * (outer - inner) / cusps.len().max(1) as f64;
    let mut ends = vec![outer];
    for &cusp in cusps {
        if ends[ends.len() - 1] - cusp > least && cusp - inner > least {
            ends.push(cusp);
        }
    }
    ends.push(inner);
    let mut rows = vec![outer];
    for pair in ends.windows(2) {
        let part = |k: usize| pair[0] + (pair[1] - pair[0]) * (k as f64 / ROWS as f64);
        rows.extend((1..ROWS).map(part));
        rows.push(pair[1]);
    }
    rows
}

/// Circles, and the azimuths of each.
struct PolarLattice {
    rows: Vec<f64>,
    azimuths: usize,
    /// Of each row one azimuth of so many has a vertex.
    strides: Vec<usize>,
    /// Number of the first vertex of each row.
    first: Vec<u32>,
}

/// A vertex of a spoke.
#[derive(Debug, Clone, Copy)]
struct SpokePlace {
    radius_mm: f64,
    cut: Option<(f64, usize)>,
    /// Whether it is on a cusp.
    on_cusp: bool,
}

impl PolarLattice {
    fn new(rows: Vec<f64>, azimuths: usize) -> Self {
        let outer = rows[0];
        let stride = |radius: f64| {
            let halvings = (1..=MOST_HALVINGS).filter(|&k| radius < outer / (1 << k) as f64);
            1 << halvings.count()
        };
        let mut strides: Vec<usize> = rows.iter().map(|&radius| stride(radius)).collect();
        // From row to row azimuths become fewer by one half at the most.
        for k in 1..strides.len() {
            strides[k] = strides[k].min(2 * strides[k - 1]);
        }
        let mut first = vec![0];
        for (radius, stride) in rows.iter().zip(&strides) {
            let count = if *radius == 0.0 { 1 } else { azimuths / stride };
            first.push(first[first.len() - 1] + count as u32);
        }
        Self { rows, azimuths, strides, first }
    }

    /// The places of one azimuth, of the rows that have one there.
    fn spoke(&self, section: &impl PolarSection, azimuth: usize) -> Vec<Option<SpokePlace>> {
        let mut moved: Vec<(f64, bool)> = self.rows.iter().map(|&radius| (radius, false)).collect();
        let last = self.rows.len() - 1;
        for cusp in section.cusps_mm() {
            let below = self.rows.partition_point(|&row| row > cusp);
            let near = [below.saturating_sub(1), below.min(last)];
            let off = |k: usize| (self.rows[k] - cusp).abs();
            let row = if off(near[0]) <= off(near[1]) { near[0] } else { near[1] };
            // Rims stay where they are.
            if row == 0 || row >= last || moved[row].1 {
                continue;
            }
            let gaps = [row - 1, row].map(|k| KEPT * (self.rows[k] - self.rows[k + 1]));
            if moved[row - 1].0 - cusp >= gaps[0] && cusp - moved[row + 1].0 >= gaps[1] {
                moved[row] = (cusp, true);
            }
        }
        let place = |(row, &(radius_mm, on_cusp)): (usize, &(f64, bool))| {
            let has_one = azimuth.is_multiple_of(self.strides[row]);
            has_one.then(|| {
                let cut = section.cut(radius_mm);
                SpokePlace { radius_mm, cut, on_cusp }
            })
        };
        moved.iter().enumerate().map(place).collect()
    }

    /// The cusps of one azimuth beside its places that are left out of them.
    fn peaks(&self, section: &impl PolarSection, azimuth: usize) -> Vec<(DVec3, usize)> {
        let angle = TAU * azimuth as f64 / self.azimuths as f64;
        let [outer, inner] = [self.rows[0], self.rows[self.rows.len() - 1]];
        let beside = self.rows.iter().filter_map(|&row| section.left_out(row));
        beside
            .filter(|(radius, ..)| (inner..=outer).contains(radius))
            .map(|(radius, z, step)| {
                (DVec3::new(radius * cos(angle), radius * sin(angle), z), step)
            })
            .collect()
    }

    /// All spokes as a mesh. In the axis it is as low as the lowest of them.
    fn joined(&self, spokes: &[Vec<Option<SpokePlace>>]) -> Result<PolarFace, UncutPlace> {
        let (mut vertices, mut steps) = (Vec::new(), Vec::new());
        for (row, stride) in self.strides.iter().enumerate() {
            let places = spokes.iter().enumerate().step_by(*stride);
            let mut places: Vec<_> =
                places.filter_map(|(k, spoke)| Some((k, spoke[row]?))).collect();
            if self.rows[row] == 0.0 {
                let z = |place: &SpokePlace| place.cut.map_or(f64::INFINITY, |cut| cut.0);
                let lowest = places.into_iter().min_by(|a, b| z(&a.1).total_cmp(&z(&b.1)));
                places = lowest.into_iter().collect();
            }
            for (k, SpokePlace { radius_mm, cut, .. }) in places {
                let angle = TAU * k as f64 / self.azimuths as f64;
                let [x, y] = [radius_mm * cos(angle), radius_mm * sin(angle)];
                let Some((z, step)) = cut else { return Err(UncutPlace([x, y])) };
                vertices.push(DVec3::new(x, y, z));
                steps.push(step);
            }
        }
        let triangles = (1..self.rows.len()).flat_map(|row| self.ring(row, spokes)).collect();
        let mesh = TriMesh { vertices, triangles };
        Ok(PolarFace { mesh, steps, apart_mm: 0.0, follows_cusps: true, peaks: Vec::new() })
    }

    /// The facets between a row and the one outside it.
    fn ring(&self, row: usize, spokes: &[Vec<Option<SpokePlace>>]) -> Vec<[u32; 3]> {
        let count = self.azimuths / self.strides[row - 1];
        let outside = |k: usize| self.first[row - 1] + (k % count) as u32;
        if self.rows[row] == 0.0 {
            let centre = self.first[row];
            return (0..count).map(|k| [outside(k), outside(k + 1), centre]).collect();
        }
        let fewer = self.azimuths / self.strides[row];
        let inside = |k: usize| self.first[row] + (k % fewer) as u32;
        if fewer < count {
            let split = |k: usize| {
                let [a, b, c] = [2 * k, 2 * k + 1, 2 * k + 2].map(outside);
                let [p, q] = [inside(k), inside(k + 1)];
                [[a, b, p], [b, c, q], [b, q, p]]
            };
            return (0..fewer).flat_map(split).collect();
        }
        let stride = self.strides[row];
        let on_cusp = |k: usize, row: usize| {
            spokes[k % count * stride][row].is_some_and(|place| place.on_cusp)
        };
        let halves = |k: usize| {
            let [a, b] = [outside(k), outside(k + 1)];
            let [p, q] = [inside(k), inside(k + 1)];
            // Inwards with the turns, unless a cusp goes outwards.
            let outwards = on_cusp(k, row) && on_cusp(k + 1, row - 1);
            let inwards = on_cusp(k, row - 1) && on_cusp(k + 1, row);
            match outwards && !inwards {
                false => [[a, b, q], [a, q, p]],
                true => [[a, b, p], [b, q, p]],
            }
        };
        (0..count).flat_map(halves).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::turn;
    use crate::program::{ToolMove, ToolPath, TurningPath};

    fn faced(feed_mm: f64, inner: f64) -> (PolarFace, f64) {
        let nose_mm = 0.8;
        let at = |x: f64| DVec3::new(x - nose_mm, 0.0, 5.0 - nose_mm);
        let (from, to) = (at(12.0), at(0.0));
        let moves = [(from, to, 12.0 / feed_mm), (to, to, 1.1)];
        let tool = ToolPath {
            moves: moves
                .map(|(from, to, _)| ToolMove { from, to, feed: Some(1.0), line: 1 })
                .into(),
            lines: 1,
        };
        let path = TurningPath {
            tool,
            turns: moves.map(|(.., turns)| turns).into(),
            ..TurningPath::default()
        };
        let limits = PolarLimits {
            radii_mm: [inner, 10.0],
            rim: &|_| None,
            corners: &[],
            azimuths: azimuths(0.3, 0.5 * feed_mm / nose_mm),
            most: 1e6,
        };
        let surface = TurnedSurface::new(&path, nose_mm);
        let face = PolarFace::new(&surface, limits).unwrap_or_else(|_| panic!("no face"));
        (face, nose_mm - f64::sqrt(nose_mm * nose_mm - 0.25 * feed_mm * feed_mm))
    }

    /// Over a plane the facets cover disc and ring once, reach from the lowest places up to the cusps and no higher, and their mean slope
    /// is that of the arcs, which is even up to f / (2 r): its root mean square is a sqrt(3) of that.
    #[test]
    fn facets_follow_the_cusps_of_a_plane() {
        for (feed_mm, inner) in [(0.2, 0.0), (0.1, 0.0), (0.2, 4.0)] {
            let (face, cusp) = faced(feed_mm, inner);
            let (mut area, mut square) = (0.0, 0.0);
            for t in &face.mesh.triangles {
                let [a, b, c] = t.map(|v| face.mesh.vertices[v as usize]);
                let double = turn(a.truncate(), b.truncate(), c.truncate());
                assert!(double > 0.0);
                let normal = (b - a).cross(c - a);
                let slope = normal.truncate().length() / normal.z;
                area += 0.5 * double;
                square += 0.5 * double * slope * slope;
            }
            let exact = std::f64::consts::PI * (100.0 - inner * inner);
            assert!((area / exact - 1.0).abs() < 1e-4, "{area} {exact}");
            let rms = (square / area).sqrt() / (0.5 * feed_mm / 0.8 / 3f64.sqrt());
            // Chords of eighths of an arc lose 1 / 64 of the mean square.
            assert!((rms - 1.0).abs() < 0.015, "{feed_mm} {inner}: {rms}");
            let high = face.mesh.vertices.iter().map(|v| v.z - 4.2).fold(0.0, f64::max);
            assert!((high / cusp - 1.0).abs() < 1e-6, "{high} {cusp}");
            assert!((face.apart_mm / feed_mm - 1.0).abs() < 0.03, "{}", face.apart_mm);
            let rim = crate::solid::rim(&face.mesh.into()).unwrap();
            assert_eq!((rim.edges, rim.hole_edges > 0), (368, inner > 0.0));
        }
    }
}
