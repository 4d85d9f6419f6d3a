//! Point proposals: a triangular lattice in rows along X, stretched along each axis by a spacing
//! that follows the tolerances. Proposals need not be right, only near: the proof decides.

use super::deviation::largest_deviation;
use super::proof::Prover;
use super::rim::Arc;
use super::{Bound, Limits, MOST_FACETS, MeshError};
use crate::geom::{DVec2, Outline, Rect};
use crate::mirror::Curvature;
use crate::num::{Dual, cos, exp, sin};

/// Places per side where the tolerances are turned into spacings, and along a round rim.
const PLACES: usize = 32;
/// Share of a limit that the lattice aims at; the rest is for the proof's remainder terms.
const AIM: f64 = 0.985;
/// Row distance over column spacing of equilateral triangles.
const EQUILATERAL: f64 = 0.866_025_403_784_438_6;
/// Distance of the lattice from round rims, in spacings: near enough for facets within the
/// limits, and so far that neighbours on the rim are joined by an edge.
const CLEARANCE: f64 = 0.6;

/// Points to triangulate.
#[derive(Debug)]
pub struct Proposal {
    /// The points: the lattice in rows, then each rim's.
    pub points: Vec<DVec2>,
    /// Round rims and their numbers of points.
    pub rims: Vec<(Arc, usize)>,
}

/// The lattice's points, row by row, single-precision numbers; the first and last of a row and
/// the first and last row lie exactly on the rim of `domain`, of which the face holds `copies`. A
/// round outline has points on its rims instead.
pub fn propose(
    prover: &Prover,
    domain: Rect,
    copies: usize,
    limits: Limits,
) -> Result<Proposal, MeshError> {
    let needs = Needs::new(prover, domain, limits);
    if let Some(place) = needs.places.iter().find(|place| !needs.outlasts_rounding(place)) {
        let bound = Bound { chord_mm: place.rounding, ..Bound::default() };
        return Err(MeshError::Floor { at: place.at, size_mm: 0.0, bound });
    }
    let (columns, rows) = needs.spacings();
    let (across, along) = (count(&columns, domain.size().x), count(&rows, domain.size().y));
    let outline = &prover.mirror().outline;
    let share = outline.area() / outline.bounds().area();
    let facets = 2.0 * across * along * share;
    let all = facets * copies as f64;
    if !(all <= MOST_FACETS) {
        return Err(MeshError::TooMany { facets: all, most: MOST_FACETS });
    }
    let spacing = Spacing { domain, columns: &columns, rows: &rows };
    let even = steps(&columns, domain.min.x, domain.max.x, 0.0);
    let odd = steps(&columns, domain.min.x, domain.max.x, 0.5);
    let mut points = Vec::with_capacity((facets / 2.0) as usize + even.len());
    for (k, &y) in steps(&rows, domain.min.y, domain.max.y, 0.0).iter().enumerate() {
        let row = if k % 2 == 0 { &even } else { &odd };
        let row = row.iter().map(|&x| DVec2::new(x, y));
        points.extend(row.filter(|&q| spacing.is_clear(outline, q)));
    }
    let mut rims = Vec::new();
    for arc in Arc::all(prover.mirror()) {
        let before = points.len();
        points.extend(spacing.along(&arc));
        rims.push((arc, points.len() - before));
    }
    Ok(Proposal { points, rims })
}

/// The lattice's spacings at any place.
struct Spacing<'a> {
    domain: Rect,
    columns: &'a [f64],
    rows: &'a [f64],
}

impl Spacing<'_> {
    /// Distance of neighbours at `q` in the direction `way`.
    fn at(&self, q: DVec2, way: DVec2) -> f64 {
        let share = ((q - self.domain.min) / self.domain.size()).clamp(DVec2::ZERO, DVec2::ONE);
        let interpolate = |spacing: &[f64], share: f64| {
            let place = share * (spacing.len() - 1) as f64;
            let k = (place as usize).min(spacing.len() - 2);
            spacing[k] + (spacing[k + 1] - spacing[k]) * (place - k as f64)
        };
        let column = interpolate(self.columns, share.x);
        let row = interpolate(self.rows, share.y) / EQUILATERAL;
        1.0 / (way / DVec2::new(column, row)).length()
    }

    /// Whether the lattice point `q` is inside the outline and not too near a round rim.
    fn is_clear(&self, outline: &Outline, q: DVec2) -> bool {
        let Outline::Ring { inner, outer } = *outline else { return true };
        let r = q.length();
        if inner == 0.0 && r < 0.5 * outer {
            return true;
        }
        if r < inner || r > outer {
            return false;
        }
        let clear = CLEARANCE * self.at(q, q / r);
        r <= outer - clear && (inner == 0.0 || r >= inner + clear)
    }

    /// Points on a rim.
    fn along(&self, arc: &Arc) -> Vec<DVec2> {
        let [from, to] = arc.ends;
        let spacing = |k: usize| {
            let angle = from + (to - from) * k as f64 / (4 * PLACES) as f64;
            let (s, c) = (sin(angle), cos(angle));
            let here = self.at(DVec2::new(c, s) * arc.radius, DVec2::new(-s, c));
            (here / arc.radius).min(Arc::widest())
        };
        let spacings: Vec<f64> = (0..=4 * PLACES).map(spacing).collect();
        let mut angles = steps(&spacings, from, to, 0.0);
        if arc.closed {
            angles.pop();
        }
        angles.into_iter().map(|angle| arc.at(angle)).collect()
    }
}

/// Number of steps over `length` at the given spacings.
fn count(spacing: &[f64], length: f64) -> f64 {
    let cell = length / (spacing.len() - 1) as f64;
    spacing.windows(2).map(|s| 0.5 * cell * (1.0 / s[0] + 1.0 / s[1])).sum()
}

/// Places from `lo` to `hi`, both included, a whole number of local spacings apart; with a `phase`
/// the inner ones are moved by that share of a step.
fn steps(spacing: &[f64], lo: f64, hi: f64, phase: f64) -> Vec<f64> {
    let total = count(spacing, hi - lo);
    let whole = total.ceil().max(1.0);
    let cell = (hi - lo) / (spacing.len() - 1) as f64;
    let mut places = vec![lo];
    let mut next = if phase > 0.0 { phase } else { 1.0 };
    let mut reached = 0.0;
    for (k, s) in spacing.windows(2).enumerate() {
        let here = 0.5 * cell * (1.0 / s[0] + 1.0 / s[1]) * whole / total;
        while next < reached + here && next < whole - 0.25 {
            let x = lo + cell * (k as f64 + (next - reached) / here);
            let x = f64::from(x as f32);
            if places.last().is_some_and(|&last| x > last) && x < hi {
                places.push(x);
            }
            next += 1.0;
        }
        reached += here;
    }
    places.push(hi);
    places
}

/// Half the distance between the single-precision numbers around `x`.
fn half_step(x: f64) -> f64 {
    let single = x.abs() as f32;
    0.5 * (f64::from(single.next_up()) - f64::from(single))
}

/// What the tolerances ask for at one place of the panel.
#[derive(Debug, Clone, Copy)]
struct Place {
    at: DVec2,
    /// Second derivatives of h, 1/mm.
    curvature: Curvature,
    /// mm along the ray per mm of h.
    stretch: f64,
    /// How far single precision moves a vertex at worst, mm.
    rounding: f64,
    /// Image displacement (mm) per change of h's gradient along x and y.
    per_slope: [DVec2; 2],
}

impl Place {
    /// Facet error (mm) and chord error (mm) of the lattice triangle with base `a` along X and
    /// height `b` along Y, on the quadratic surface through this place.
    fn errors(&self, a: f64, b: f64) -> (f64, f64) {
        let corners = [DVec2::ZERO, DVec2::new(a, 0.0), DVec2::new(0.5 * a, b)];
        let Curvature { xx, xy, yy } = self.curvature;
        let facet = DVec2::new(0.5 * xx * a, 0.5 * (xy * a + yy * b) - xx * a * a / (8.0 * b));
        let shift = |corner: &DVec2| {
            let slope = facet - self.curvature.times(*corner);
            (self.per_slope[0] * slope.x + self.per_slope[1] * slope.y).length()
        };
        let along = |i: usize, j: usize| {
            let edge = corners[j] - corners[i];
            self.curvature.times(edge).dot(edge)
        };
        let worst = corners.iter().map(shift).fold(0.0, f64::max);
        let deviation = largest_deviation(along(0, 1), along(1, 2), along(2, 0));
        (worst, deviation * self.stretch)
    }
}

/// The point of the outline that is nearest to `q`; not the very centre of a disc, where laws may
/// have no derivative.
fn into(outline: &Outline, q: DVec2) -> DVec2 {
    let Outline::Ring { inner, outer } = *outline else { return q };
    let r = q.length();
    let clamped = r.clamp(inner.max(1e-3 * outer), outer);
    if r > 0.0 { q * (clamped / r) } else { DVec2::X * clamped }
}

/// What the tolerances depend on at `q`.
fn place(prover: &Prover, q: DVec2) -> Place {
    let mirror = prover.mirror();
    let chart = &mirror.chart;
    let k = chart.vergence;
    let point = mirror.surface.at(q);
    let at = mirror.place(q, &point);
    let grow = exp(k * point.f);
    let gradient = point.slope * grow;
    let Curvature { xx, xy, yy } = mirror.surface.curvature(q);
    let s = point.slope;
    let curvature = Curvature {
        xx: grow * (xx + k * s.x * s.x),
        xy: grow * (xy + k * s.x * s.y),
        yy: grow * (yy + k * s.y * s.y),
    };
    let per_slope = prover.view().map_or([DVec2::ZERO; 2], |view| {
        let fixed = |x: f64| Dual::<2> { value: x, slope: [0.0; 2] };
        let slope = [Dual::variable(gradient.x, 0), Dual::variable(gradient.y, 1)];
        let slope = chart.slope(q.to_array().map(fixed), slope.map(|s| s / grow));
        let image = prover.camera().coordinates(at).0;
        let [x, y] = view.content(prover.camera(), at.to_array().map(fixed), slope, image);
        [0, 1].map(|k| DVec2::new(x.slope[k], y.slope[k]))
    });
    let p = mirror.slope(q, &point);
    let half = at.to_array().map(half_step);
    let across = if k == 0.0 { 0.0 } else { p.abs().dot(DVec2::new(half[0], half[1])) };
    let ray = (1.0 + k * k * q.length_squared()).sqrt();
    Place {
        at: q,
        curvature,
        stretch: ray / (grow * grow),
        rounding: (half[2] + across) * ray / (1.0 + k * q.dot(p)),
        per_slope,
    }
}

/// The places of a panel and the limits there.
struct Needs {
    places: Vec<Place>,
    limits: Limits,
    size: DVec2,
}

impl Needs {
    fn new(prover: &Prover, domain: Rect, limits: Limits) -> Self {
        let place = |q: DVec2| place(prover, into(&prover.mirror().outline, q));
        let places = domain.grid(PLACES, PLACES).map(|(q, _)| place(q)).collect();
        Self { places, limits, size: domain.size() }
    }

    /// Whether rounding leaves anything of the chord limit.
    fn outlasts_rounding(&self, place: &Place) -> bool {
        self.limits.chord_mm.is_none_or(|limit| place.rounding < AIM * limit)
    }

    fn keeps(&self, place: &Place, a: f64, b: f64) -> bool {
        let (facet, chord) = place.errors(a, b);
        self.limits.facet_mm.is_none_or(|limit| facet <= AIM * limit)
            && self.limits.chord_mm.is_none_or(|limit| chord <= AIM * limit - place.rounding)
    }

    /// The largest spacing of equilateral triangles at a place, at most the domain's size.
    fn equilateral(&self, place: &Place) -> f64 {
        let (facet, chord) = place.errors(1.0, EQUILATERAL);
        let largest = self.size.max_element();
        let by_facet = self.limits.facet_mm.map_or(largest, |limit| AIM * limit / facet);
        let by_chord = self
            .limits
            .chord_mm
            .map_or(largest, |limit| ((AIM * limit - place.rounding) / chord).sqrt());
        by_facet.min(by_chord).min(largest)
    }

    /// Column spacing against X and row spacing against Y, at the grid's places: of a few trial
    /// widenings of the columns, the one that needs the fewest points.
    fn spacings(&self) -> (Vec<f64>, Vec<f64>) {
        let width = PLACES + 1;
        let equilateral: Vec<f64> = self.places.iter().map(|p| self.equilateral(p)).collect();
        let narrowest =
            |i: usize| (0..width).map(|j| equilateral[j * width + i]).fold(f64::INFINITY, f64::min);
        let base: Vec<f64> = (0..width).map(narrowest).collect();
        let trial = |widening: f64| {
            let columns: Vec<f64> = base.iter().map(|a| a * widening).collect();
            let rows: Vec<f64> = (0..width).map(|j| self.row_spacing(j, &columns)).collect();
            (columns, rows)
        };
        let points = |(columns, rows): &(Vec<f64>, Vec<f64>)| {
            count(columns, self.size.x) * count(rows, self.size.y)
        };
        [0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3]
            .map(trial)
            .into_iter()
            .min_by(|a, b| points(a).total_cmp(&points(b)))
            .expect("there are trials")
    }

    /// The widest row distance at row `j` that suits every place of the row.
    fn row_spacing(&self, j: usize, columns: &[f64]) -> f64 {
        let row = &self.places[j * columns.len()..(j + 1) * columns.len()];
        let keeps = |b: f64| row.iter().zip(columns).all(|(place, &a)| self.keeps(place, a, b));
        let narrowest = columns.iter().copied().fold(f64::INFINITY, f64::min);
        let (mut low, mut high) = (0.3 * narrowest, 8.0 * narrowest);
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            if keeps(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_reach_both_ends_exactly_and_alternate() {
        let spacing = [0.1, 0.2, 0.3];
        let even = steps(&spacing, -1.0, 2.0, 0.0);
        let odd = steps(&spacing, -1.0, 2.0, 0.5);
        assert_eq!((even[0], *even.last().unwrap()), (-1.0, 2.0));
        assert_eq!((odd[0], *odd.last().unwrap()), (-1.0, 2.0));
        assert_eq!(odd.len(), even.len() + 1);
        assert!(even.windows(2).all(|w| w[1] > w[0]) && odd.windows(2).all(|w| w[1] > w[0]));
        for k in 1..odd.len() - 1 {
            assert!(even[k - 1] < odd[k] && odd[k] < even[k]);
        }
    }

    #[test]
    fn errors_of_a_bowl_and_a_saddle_are_the_closed_forms() {
        let place = |curvature: Curvature| {
            let per_slope = [DVec2::X, DVec2::Y];
            Place { at: DVec2::ZERO, curvature, stretch: 1.0, rounding: 0.0, per_slope }
        };
        let h = 0.1;
        // Equilateral triangle on z = k r^2 / 2: circumradius h/sqrt 3, chord k R^2 / 2.
        let bowl = Curvature { xx: 2.0, xy: 0.0, yy: 2.0 };
        let (facet, chord) = place(bowl).errors(h, EQUILATERAL * h);
        assert!((facet - 2.0 * h / 3.0f64.sqrt()).abs() < 1e-15);
        assert!((chord - h * h / 3.0).abs() < 1e-15);
        // On the saddle the facet's own point is half a circumradius from the centre towards the
        // apex, farthest from the corners of the base.
        let saddle = Curvature { xx: 2.0, xy: 0.0, yy: -2.0 };
        let (facet, _) = place(saddle).errors(h, EQUILATERAL * h);
        let radius = h / 3.0f64.sqrt();
        assert!((facet / (2.0 * radius) - 1.75f64.sqrt()).abs() < 1e-12);
    }
}
