//! The functions that a mirror is a sum of, at the places where its residual is looked at.
//!
//! Every basis is a product of tables along two directions; a radial one has a single place in
//! its second direction. Whoever fits with it need not know which it is.

use crate::geom::{DVec2, Rect};
use crate::num::legendre::{derivatives, values};
use crate::num::quadrature::gauss_legendre;
use crate::num::{Dual, cos};
use crate::optics::ImagingTask;
use crate::parallel;
use std::f64::consts::PI;

mod splines;

/// Places at which a basis is tabulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NodeSet {
    /// Gauss nodes with their weights, for integrals over the domain.
    Quadrature,
    /// More of them, which resolve the field of a wide pinhole to rounding, for figures.
    Fine,
    /// Chebyshev's extrema, rim included, for the worst place of the domain; the weights are one.
    Extrema,
}

/// Weight of a place beyond the picture. The RMS error of wide views grows by 0.05 % at most where the mirror is twice as
/// wide as the frame, and steep rims, which a lower weight leaves, take up to a third fewer facets.
const BEYOND_PICTURE: f64 = 1e-3;

/// Places fewer than which the threads cost more than they bring.
const WORTH_THREADS: usize = 64;

/// Basis functions B_j with their derivatives at chosen places.
#[derive(Debug, Clone)]
pub(super) struct Basis {
    along: AxisTable,
    across: AxisTable,
    terms: Vec<(usize, usize)>,
    /// Constant that is subtracted from each unknown's function.
    levels: Vec<f64>,
    size_mm: f64,
    /// Whether the places are the pairs of equal number of both tables, not all pairs.
    is_scattered: bool,
}

/// F with its slopes dF/dx and dF/dy.
pub(super) type LocalValues = [f64; 3];

/// Functions of one coordinate at its places.
#[derive(Debug, Clone)]
struct AxisTable {
    places: Vec<AxisNode>,
}

#[derive(Debug, Clone)]
struct AxisNode {
    /// mm.
    at: f64,
    weight: f64,
    /// Whether a first look takes this place.
    coarse: bool,
    p: Vec<f64>,
    /// 1/mm.
    d: Vec<f64>,
}

/// Places on [-1, 1], ascending: (place, weight, coarse).
type AxisNodes = Vec<(f64, f64, bool)>;

fn gauss(count: usize) -> AxisNodes {
    let (nodes, weights) = gauss_legendre(count);
    nodes.into_iter().zip(weights).map(|(x, w)| (x, w, true)).collect()
}

/// Extrema five times as dense as the degree. Between them the worst error of a best fit exceeds that at them by
/// 1 % at most (measured on the panoramic). A quarter of them are the coarse ones: 1.25 places for each unknown
/// of a direction, both ends among them; a search that begins with twice as many takes as many steps of
/// thrice the work.
fn extrema(degree: usize) -> AxisNodes {
    let steps = 2 * (2 * ((5 * degree).div_ceil(4)) + 8);
    (0..=steps).map(|k| (-cos(PI * k as f64 / steps as f64), 1.0, k % 4 == 0)).collect()
}

/// The means of the Legendre polynomials up to `degree` over part of [-1, 1], by
/// (2 k + 1) P_k = (P_{k+1} - P_{k-1})'.
fn means(degree: usize, ends: [f64; 2]) -> Vec<f64> {
    let [lo, hi] = ends.map(|t| values(degree + 1, t));
    let mean = |k: usize| {
        let whole =
            |p: &[f64]| (p[k + 1] - if k == 0 { -1.0 } else { p[k - 1] }) / (2 * k + 1) as f64;
        (whole(&hi) - whole(&lo)) / (ends[1] - ends[0])
    };
    (0..=degree).map(mean).collect()
}

impl Basis {
    /// Products P_i P_j of Legendre polynomials up to `degree` in each direction over `area`
    /// (mm), but for the constant: the mean over the area is zero. Along a direction that is `even` only
    /// those even about its middle, looked at in the upper half alone.
    #[must_use]
    pub(super) fn rectangle(area: Rect, even: [bool; 2], degree: usize, places: NodeSet) -> Self {
        let line = match places {
            // Degree + 1 nodes are exact for the polynomials; the rest resolve the field.
            NodeSet::Quadrature => gauss(degree + 16 + degree % 2),
            NodeSet::Fine => gauss(degree + 48 + degree % 2),
            NodeSet::Extrema => extrema(degree),
        };
        let (half, centre) = (0.5 * area.size(), area.centre());
        let table = |axis: usize| {
            let (half, centre) = (half[axis], centre[axis]);
            // The middle place, where there is one, is k = len / 2.
            let (skip, times) = if even[axis] { (line.len() / 2, 2.0) } else { (0, 1.0) };
            let place = |&(t, w, coarse): &(f64, f64, bool)| {
                let p = values(degree, t);
                let d = derivatives(&p).iter().map(|d| d / half).collect();
                let weight = match places {
                    NodeSet::Quadrature | NodeSet::Fine => times * half * w,
                    NodeSet::Extrema => w,
                };
                AxisNode { at: centre + half * t, weight, coarse, p, d }
            };
            AxisTable { places: line[skip..].iter().map(place).collect() }
        };
        let degrees = |axis: usize| (0..=degree).step_by(if even[axis] { 2 } else { 1 });
        let terms: Vec<(usize, usize)> = degrees(0)
            .flat_map(|i| degrees(1).map(move |j| (i, j)))
            .filter(|&term| term != (0, 0))
            .collect();
        Self {
            along: table(0),
            across: table(1),
            levels: vec![0.0; terms.len()],
            terms,
            size_mm: area.size().max_element(),
            is_scattered: false,
        }
    }

    /// The same functions over the same `area` (mm) but for constants: the mean over `part` of it is zero.
    #[must_use]
    pub(super) fn with_mean_zero_over(mut self, part: Rect, area: Rect) -> Self {
        let degree = self.along.places[0].p.len() - 1;
        let (half, centre) = (0.5 * area.size(), area.centre());
        let [lo, hi] = [part.min, part.max].map(|corner| (corner - centre) / half);
        let (x, y) = (means(degree, [lo.x, hi.x]), means(degree, [lo.y, hi.y]));
        self.levels = self.terms.iter().map(|&(i, j)| x[i] * y[j]).collect();
        self
    }

    /// The functions of [`Basis::rectangle`], looked at where the camera of `view` sees them in a part of its
    /// `picture`: at places spread over that as those are over the rectangle, weighted by their areas in the picture.
    /// What lies beyond it counts only so far as to determine the mirror there, and so does what is not wanted of it.
    #[must_use]
    pub(super) fn over_picture(
        (area, picture): (Rect, Rect),
        even: [bool; 2],
        degree: usize,
        places: NodeSet,
        view: &ImagingTask,
    ) -> Self {
        let whole = Self::rectangle(area, even, degree, places);
        let in_picture = Self::rectangle(picture, even, degree, places);
        let is_wanted = |image: DVec2| view.projection.wants(image);
        let share = |image: DVec2| match picture.contains(image) && is_wanted(image) {
            true => 1.0,
            false => BEYOND_PICTURE,
        };
        // A largest error is that of what is wanted.
        let counts = |image: DVec2| places != NodeSet::Extrema || is_wanted(image);
        // (A lens is inverted at each of them.)
        let seen = parallel::map(in_picture.len(), WORTH_THREADS, |k| {
            let image = in_picture.at(k);
            let weight = share(image) * in_picture.weight(k);
            counts(image).then(|| (view.picture.chart_point(image), weight, in_picture.coarse(k)))
        });
        let seen: Vec<_> = seen.into_iter().flatten().collect();
        let all = (0..whole.len()).map(|k| {
            let q = whole.at(k);
            let (image, density) = (view.picture.image_point(q), view.picture.density(q));
            (q, share(image) * density * whole.weight(k), whole.coarse(k))
        });
        let shows = |q: DVec2| picture.contains(view.picture.image_point(q));
        let beyond = all.clone().filter(|(q, ..)| places != NodeSet::Extrema && !shows(*q));
        let places: Vec<_> = match seen.iter().all(|(q, ..)| area.contains(*q)) {
            true => seen.into_iter().chain(beyond).collect(),
            // A mirror smaller than the picture ends before it.
            false => all.filter(|(q, ..)| counts(view.picture.image_point(*q))).collect(),
        };
        let (half, centre) = (0.5 * area.size(), area.centre());
        let table = |axis: usize| {
            let place = |&(q, weight, coarse): &(DVec2, f64, bool)| {
                let p = values(degree, (q[axis] - centre[axis]) / half[axis]);
                let d = derivatives(&p).iter().map(|d| d / half[axis]).collect();
                AxisNode { at: q[axis], weight: if axis == 0 { weight } else { 1.0 }, coarse, p, d }
            };
            AxisTable { places: parallel::map_slice(&places, WORTH_THREADS, place) }
        };
        Self { along: table(0), across: table(1), is_scattered: true, ..whole }
    }

    /// P_k(t) - 1 for k = 1 ..= `degree`, functions of the distance r from the axis alone, looked
    /// at along q = (r, 0) for r between the `radii` (mm): zero at the outer rim. On a disc
    /// (inner radius zero) t = 2 (r / rim)^2 - 1, which is smooth on the axis; on an annulus t is
    /// linear in r. The weights are those of the area.
    #[must_use]
    pub(super) fn radial(radii: [f64; 2], degree: usize, places: NodeSet) -> Self {
        let [inner, rim] = radii;
        let disc = inner == 0.0;
        let mut line = match places {
            NodeSet::Quadrature | NodeSet::Fine => gauss(2 * degree + 24),
            // One direction can afford more.
            NodeSet::Extrema => extrema(4 * degree),
        };
        if disc && places == NodeSet::Extrema {
            // On the axis every such mirror looks back at the camera.
            line.remove(0);
        }
        let place = |(t, w, coarse): (f64, f64, bool)| {
            // r, dt/dr and dr/dt.
            let (at, rate, inverse) = if disc {
                let at = rim * f64::sqrt(0.5 * (1.0 + t));
                (at, 4.0 * at / (rim * rim), 0.25 * rim * rim / at)
            } else {
                let half = 0.5 * (rim - inner);
                (0.5 * (rim + inner) + half * t, 1.0 / half, half)
            };
            let p = values(degree, t);
            let d = derivatives(&p).iter().map(|d| d * rate).collect();
            let weight = match places {
                NodeSet::Quadrature | NodeSet::Fine => 2.0 * PI * at * inverse * w,
                NodeSet::Extrema => w,
            };
            AxisNode { at, weight, coarse, p: p.iter().map(|p| p - 1.0).collect(), d }
        };
        let fixed = AxisNode { at: 0.0, weight: 1.0, coarse: true, p: vec![1.0], d: vec![0.0] };
        Self {
            along: AxisTable { places: line.into_iter().map(place).collect() },
            across: AxisTable { places: vec![fixed] },
            terms: (1..=degree).map(|k| (k, 0)).collect(),
            levels: vec![0.0; degree],
            size_mm: rim,
            is_scattered: false,
        }
    }

    /// The degrees (i, j) of each unknown's function, in the order of the coefficients.
    #[must_use]
    pub(super) fn terms(&self) -> &[(usize, usize)] {
        &self.terms
    }

    /// Constant that is subtracted from each unknown's function, in the order of the coefficients.
    #[must_use]
    pub(super) fn levels(&self) -> &[f64] {
        &self.levels
    }

    /// Number of unknowns.
    #[must_use]
    pub(super) fn unknowns(&self) -> usize {
        self.terms.len()
    }

    /// Number of places.
    #[must_use]
    pub(super) fn len(&self) -> usize {
        let across = if self.is_scattered { 1 } else { self.across.places.len() };
        self.along.places.len() * across
    }

    /// The longest side of the domain, or the radius of its rim, mm.
    #[must_use]
    pub(super) fn size_mm(&self) -> f64 {
        self.size_mm
    }

    /// Image point of place `k`, mm.
    #[must_use]
    pub(super) fn at(&self, k: usize) -> DVec2 {
        let (a, b) = self.pair(k);
        DVec2::new(a.at, b.at)
    }

    /// Weight of place `k`, mm^2 for quadrature.
    #[must_use]
    pub(super) fn weight(&self, k: usize) -> f64 {
        let (a, b) = self.pair(k);
        a.weight * b.weight
    }

    /// Whether place `k` belongs to the coarse ones: enough to determine the unknowns.
    #[must_use]
    pub(super) fn coarse(&self, k: usize) -> bool {
        let (a, b) = self.pair(k);
        a.coarse && b.coarse
    }

    /// Value and derivatives of every unknown's function at place `k`.
    pub(super) fn row(&self, k: usize) -> impl Iterator<Item = LocalValues> {
        let (a, b) = self.pair(k);
        let terms = self.terms.iter().zip(&self.levels);
        terms.map(|(&(i, j), l)| [a.p[i] * b.p[j] - l, a.d[i] * b.p[j], a.p[i] * b.d[j]])
    }

    /// F and its slopes at every place, from the coefficients.
    #[must_use]
    pub(super) fn locals(&self, coefficients: &[f64]) -> Vec<LocalValues> {
        let level: f64 = self.levels.iter().zip(coefficients).map(|(l, c)| l * c).sum();
        if self.is_scattered {
            let local = |k: usize| {
                let sum = |[f, x, y]: LocalValues, ([b, b_x, b_y], c): (LocalValues, &f64)| {
                    [f + c * b, x + c * b_x, y + c * b_y]
                };
                self.row(k).zip(coefficients).fold([0.0; 3], sum)
            };
            return parallel::map(self.len(), WORTH_THREADS, local);
        }
        let mut locals = vec![[0.0; 3]; self.len()];
        let count = self.across.places.len();
        let rows = self.along.places[0].p.len();
        for (k, b) in self.across.places.iter().enumerate() {
            // The sum over j once for each place across.
            let mut folded = vec![[0.0; 2]; rows];
            for (&(i, j), c) in self.terms.iter().zip(coefficients) {
                folded[i][0] += c * b.p[j];
                folded[i][1] += c * b.d[j];
            }
            for (h, a) in self.along.places.iter().enumerate() {
                let local = &mut locals[h * count + k];
                for ([f, f_y], (p, d)) in folded.iter().zip(a.p.iter().zip(&a.d)) {
                    local[0] += f * p;
                    local[1] += f * d;
                    local[2] += f_y * p;
                }
                local[0] -= level;
            }
        }
        locals
    }

    fn pair(&self, k: usize) -> (&AxisNode, &AxisNode) {
        if self.is_scattered {
            return (&self.along.places[k], &self.across.places[k]);
        }
        let count = self.across.places.len();
        (&self.along.places[k / count], &self.across.places[k % count])
    }
}

/// F and its slopes as variables of exact differentiation.
#[must_use]
pub(super) fn variables([f, x, y]: LocalValues) -> (Dual<3>, [Dual<3>; 2]) {
    (Dual::variable(f, 0), [Dual::variable(x, 1), Dual::variable(y, 2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip() -> Rect {
        Rect { min: DVec2::new(-3.0, 1.0), max: DVec2::new(5.0, 3.0) }
    }

    #[test]
    fn weights_sum_to_the_area() {
        let sum = |b: &Basis| (0..b.len()).map(|k| b.weight(k)).sum::<f64>();
        for even in [[false; 2], [true, false], [true; 2]] {
            let area = sum(&Basis::rectangle(strip(), even, 7, NodeSet::Quadrature));
            assert!((area - 16.0).abs() < 1e-12);
        }
        for radii in [[0.0, 2.0], [0.5, 2.0]] {
            let area = sum(&Basis::radial(radii, 7, NodeSet::Quadrature));
            let exact = PI * (radii[1] * radii[1] - radii[0] * radii[0]);
            assert!((area - exact).abs() < 1e-12, "{area} {exact}");
        }
    }

    #[test]
    fn the_mean_is_zero_over_the_part_that_is_asked_for() {
        let part = Rect { min: DVec2::new(-1.0, 1.5), max: DVec2::new(3.0, 3.0) };
        let whole = Basis::rectangle(strip(), [false; 2], 5, NodeSet::Quadrature);
        let c: Vec<f64> = (0..whole.unknowns()).map(|k| 1.0 / (k + 1) as f64).collect();
        let moved = whole.clone().with_mean_zero_over(part, strip());
        // The same function less a constant: its own mean over the part, by a quadrature there.
        let (before, after) = (whole.locals(&c), moved.locals(&c));
        let level = before[0][0] - after[0][0];
        for (a, b) in before.iter().zip(&after) {
            assert!((a[0] - b[0] - level).abs() < 1e-13 && a[1..] == b[1..]);
        }
        let (nodes, weights) = gauss_legendre(8);
        let mut mean = 0.0;
        for (u, w) in nodes.iter().zip(&weights) {
            for (v, x) in nodes.iter().zip(&weights) {
                let q = part.centre() + 0.5 * part.size() * DVec2::new(*u, *v);
                let t = (q - strip().centre()) / (0.5 * strip().size());
                let (p, r) = (values(5, t.x), values(5, t.y));
                let f: f64 = whole.terms().iter().zip(&c).map(|(&(i, j), c)| c * p[i] * r[j]).sum();
                mean += 0.25 * w * x * f;
            }
        }
        assert!((mean - level).abs() < 1e-13 && level.abs() > 1e-3, "{mean} {level}");
        // Over all of the area it is the basis as it was, to the last bit.
        let same = whole.clone().with_mean_zero_over(strip(), strip());
        assert_eq!(same.locals(&c), before);
    }

    #[test]
    fn slopes_are_those_of_the_function() {
        // x^2 y on the strip in Legendre form, with u = x - 1 over 4 and v = y - 2.
        let basis = Basis::rectangle(strip(), [false; 2], 2, NodeSet::Extrema);
        let u2 = [1.0 + 16.0 / 3.0, 8.0, 32.0 / 3.0];
        let c: Vec<f64> = basis.terms().iter().map(|&(i, j)| u2[i] * [2.0, 1.0, 0.0][j]).collect();
        for (k, [f, x, y]) in basis.locals(&c).into_iter().enumerate() {
            let q = basis.at(k);
            assert!((f + 2.0 * u2[0] - q.x * q.x * q.y).abs() < 1e-12);
            assert!((x - 2.0 * q.x * q.y).abs() < 1e-12 && (y - q.x * q.x).abs() < 1e-12);
            let row: Vec<LocalValues> = basis.row(k).collect();
            let by_row: f64 = row.iter().zip(&c).map(|(b, c)| b[1] * c).sum();
            assert!((by_row - x).abs() < 1e-12);
        }
    }

    #[test]
    fn radial_functions_are_zero_at_the_rim_and_flat_on_the_axis() {
        for radii in [[0.0, 2.0], [0.5, 2.0]] {
            let basis = Basis::radial(radii, 3, NodeSet::Extrema);
            let last = basis.len() - 1;
            assert!((basis.at(last).x - 2.0).abs() < 1e-15);
            assert!(basis.row(last).all(|[f, _, y]| f == 0.0 && y == 0.0));
            // P_1 - 1 is r^2 / 2 - 2 on the disc, (r - 2) / 0.75 on the annulus.
            for k in 0..basis.len() {
                let ([f, x, _], r) = (basis.row(k).next().unwrap(), basis.at(k).x);
                let exact = if radii[0] == 0.0 {
                    [0.5 * r * r - 2.0, r]
                } else {
                    [(r - 2.0) / 0.75, 1.0 / 0.75]
                };
                assert!((f - exact[0]).abs() < 1e-14 && (x - exact[1]).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn coarse_places_hold_the_corners() {
        for even in [[false; 2], [true, false], [true; 2]] {
            let basis = Basis::rectangle(strip(), even, 5, NodeSet::Extrema);
            let corner = |q: DVec2| {
                (0..basis.len()).any(|k| basis.coarse(k) && (basis.at(k) - q).length() < 1e-14)
            };
            assert!(corner(strip().max));
            assert_eq!(corner(DVec2::new(5.0, 1.0)), !even[1]);
            assert_eq!(corner(DVec2::new(-3.0, 3.0)), !even[0]);
        }
    }
}
