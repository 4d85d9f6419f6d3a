//! What the tolerances ask for at every place of a panel: the mirror's quadratic model there, what
//! its image does with slopes, and the limits that rounding leaves. Facets are shaped by these;
//! whether they hold is for the proof to say.

use crate::geom::{Chart, DVec2, Outline, Precision, Rect};
use crate::mesh::bound::deviation::{Triangle, largest_deviation};
use crate::mesh::bound::error_bounder::{SurfaceVertex, gradient_of};
use crate::mesh::bound::region::ImagingProblem;
use crate::mesh::bound::vertex_snapping::{LEAST_LEFT, rounding_left};
use crate::mesh::{Limits, MeshError};
use crate::mirror::{Hessian, Mirror};
use crate::num::{Dual, exp, max_or_nan};
use crate::parallel;
use glam::DMat2;
use std::sync::Arc;

/// Cells per side of the table.
const CELLS: usize = 48;
/// Share of the error that rounding can cause at worst which mostly comes about in some facet.
const LIKELY: f64 = 0.7;

/// Longest cells, in widths; nearly developable mirrors would do with longer ones, in which
/// neighbouring rows of facets no longer fit each other.
pub const SLENDER: f64 = 4.0;
/// The least curvature in any direction, as a share of the largest, for such cells.
const FLAT: f64 = 1.0 / (SLENDER * SLENDER);

/// What of the model's excess counts beside what is known of the mirror at a facet's corners: between
/// these, long facets do not keep what their corners say.
const FORESEEN: f64 = 0.1;

/// Cells that are looked at closely where the mirror is flattest, and places to the side of each.
const FLATTEST: usize = 64;
const CLOSE: usize = 8;
/// Places that are looked at along each side.
const SIDE: usize = 512;

/// The model at one place.
#[derive(Debug, Clone, Copy)]
pub struct LocalModel {
    /// Second derivatives of h, 1/mm.
    pub curvature: Hessian,
    /// Image displacement (mm) per change of h's gradient.
    pub per_slope: DMat2,
    /// mm along the ray per mm of h.
    stretch: f64,
    /// How far single precision moves a vertex at worst, mm.
    rounding: f64,
}

impl LocalModel {
    const ZERO: Self = Self {
        curvature: Hessian { xx: 0.0, xy: 0.0, yy: 0.0 },
        per_slope: DMat2::ZERO,
        stretch: 0.0,
        rounding: 0.0,
    };

    fn add(&mut self, other: &Self, weight: f64) {
        self.curvature.xx += weight * other.curvature.xx;
        self.curvature.xy += weight * other.curvature.xy;
        self.curvature.yy += weight * other.curvature.yy;
        self.per_slope += other.per_slope * weight;
        self.stretch += weight * other.stretch;
        self.rounding += weight * other.rounding;
    }

    /// Chord error (mm) of a facet with edges `a` and `b` from one corner.
    #[inline]
    fn chord(&self, a: DVec2, b: DVec2) -> f64 {
        let h = &self.curvature;
        let (ha, hb) = (h.times(a), h.times(b));
        let (aa, ab, bb) = (ha.dot(a), ha.dot(b), hb.dot(b));
        largest_deviation(aa, bb, aa + bb - 2.0 * ab) * self.stretch
    }

    /// The square of such a facet's error in the image, mm^2.
    #[inline]
    fn facet_squared(&self, a: DVec2, b: DVec2) -> f64 {
        let h = &self.curvature;
        let (ha, hb) = (h.times(a), h.times(b));
        let facet = (b.perp() * -ha.dot(a) + a.perp() * hb.dot(b)) * (0.5 / a.perp_dot(b));
        let shift = |gradient: DVec2| (self.per_slope * (facet - gradient)).length_squared();
        shift(DVec2::ZERO).max(shift(ha)).max(shift(hb))
    }

    /// What rounding at its worst adds to the facet error of such a facet by tilting it, mm.
    fn tilt(&self, a: DVec2, b: DVec2) -> f64 {
        let longest = a.length_squared().max(b.length_squared()).max((a - b).length_squared());
        let height = a.perp_dot(b).abs() / longest.sqrt();
        let [x, y] = [self.per_slope.x_axis, self.per_slope.y_axis];
        let norm = (x.length_squared() + y.length_squared()).sqrt();
        2.0 * self.rounding / self.stretch * norm / height
    }
}

/// The places of a panel and the limits there.
#[derive(Clone)]
pub struct SizingField {
    domain: Rect,
    table: Arc<Vec<LocalModel>>,
    limits: Limits,
}

impl SizingField {
    /// The needs of the part `domain` of a mirror.
    pub fn new(sight: &ImagingProblem, domain: Rect, limits: Limits) -> Self {
        let outline = &sight.mirror.outline;
        let nodes: Vec<DVec2> = domain.grid(CELLS, CELLS).map(|(q, _)| q).collect();
        let place = |&q: &DVec2| place(sight, into(outline, q), limits.precision);
        let table = Arc::new(parallel::map_slice(&nodes, 1, place));
        Self { domain, table, limits }
    }

    /// The same places under other limits, or none if these are for other digits.
    pub fn under(self, limits: Limits) -> Option<Self> {
        (self.limits.precision == limits.precision).then_some(Self { limits, ..self })
    }

    /// Whether the image limits anything.
    pub fn sees(&self) -> bool {
        self.limits.facet_mm.is_some()
    }

    /// The domain.
    pub fn domain(&self) -> Rect {
        self.domain
    }

    /// The centres of the table's cells.
    pub fn centres(&self) -> impl Iterator<Item = DVec2> {
        let (min, step) = (self.domain.min, self.domain.size() / CELLS as f64);
        (0..CELLS * CELLS).map(move |k| {
            min + step * DVec2::new((k % CELLS) as f64 + 0.5, (k / CELLS) as f64 + 0.5)
        })
    }

    /// The model at `q`.
    pub fn at(&self, q: DVec2) -> LocalModel {
        let last = CELLS as f64;
        let share = (q - self.domain.min) / self.domain.size() * last;
        let share = share.clamp(DVec2::ZERO, DVec2::splat(last));
        // Truncation is floor for what is not negative, and quicker.
        let [i, j] = share.to_array().map(|x| (x as usize).min(CELLS - 1));
        let f = share - DVec2::new(i as f64, j as f64);
        let k = j * (CELLS + 1) + i;
        let mut place = LocalModel::ZERO;
        place.add(&self.table[k], (1.0 - f.x) * (1.0 - f.y));
        place.add(&self.table[k + 1], f.x * (1.0 - f.y));
        place.add(&self.table[k + CELLS + 1], (1.0 - f.x) * f.y);
        place.add(&self.table[k + CELLS + 2], f.x * f.y);
        place
    }

    /// How many times as large as it may be the area of a facet with edges `a` and `b` is, when
    /// rounding is left out of it.
    pub fn excess(&self, place: &LocalModel, a: DVec2, b: DVec2) -> f64 {
        let Limits { chord_mm, facet_mm, .. } = self.limits;
        let by_chord = chord_mm.map_or(0.0, |limit| place.chord(a, b) / (limit - place.rounding));
        let by_facet = facet_mm.map_or(0.0, |limit| place.facet_squared(a, b) / (limit * limit));
        by_chord.max(by_facet)
    }

    /// The same of a facet of which is known what the mirror does at its corners.
    pub fn excess_of(&self, place: &LocalModel, t: [&SurfaceVertex; 3]) -> f64 {
        let Limits { chord_mm, facet_mm, precision } = self.limits;
        let q = t.map(|v| v.q);
        let by_chord = chord_mm.map_or(0.0, |limit| {
            let [ab, bc, ca] = Triangle::new(q).curves(t.map(|v| v.gradient));
            largest_deviation(ab, bc, ca) * place.stretch / (limit - place.rounding)
        });
        let by_facet = facet_mm.map_or(0.0, |limit| {
            let shift = |h: [f64; 3]| {
                let flat = gradient_of(q, h);
                let of =
                    |v: &SurfaceVertex| (place.per_slope * (flat - v.gradient)).length_squared();
                t.map(of).into_iter().fold(0.0, max_or_nan)
            };
            let exact = shift(t.map(|v| v.h));
            let largest = match precision {
                Precision::Single => max_or_nan(exact, shift(t.map(|v| v.h + v.rounding))),
                Precision::Double => exact,
            };
            largest / (limit * limit)
        });
        max_or_nan(
            max_or_nan(by_chord, by_facet),
            FORESEEN * self.excess(place, q[1] - q[0], q[2] - q[0]),
        )
    }

    /// The factor by which a facet with edges `a` and `b` may be enlarged; rounding included.
    pub fn room(&self, place: &LocalModel, a: DVec2, b: DVec2) -> f64 {
        let by_chord = self
            .limits
            .chord_mm
            .map_or(f64::INFINITY, |limit| ((limit - place.rounding) / place.chord(a, b)).sqrt());
        // facet t + tilt / t <= limit
        let by_facet = self.limits.facet_mm.map_or(f64::INFINITY, |limit| {
            let facet = place.facet_squared(a, b).sqrt();
            let tilt = LIKELY * place.tilt(a, b);
            let root = (limit * limit - 4.0 * facet * tilt).max(0.0).sqrt();
            (limit + root) / (2.0 * facet)
        });
        by_chord.min(by_facet)
    }

    /// The factor by which an edge may be enlarged.
    pub fn edge_room(&self, place: &LocalModel, d: DVec2) -> f64 {
        let chord = place.curvature.times(d).dot(d).abs() / 8.0 * place.stretch;
        let by_chord = self
            .limits
            .chord_mm
            .map_or(f64::INFINITY, |limit| ((limit - place.rounding) / chord).sqrt());
        let image = (place.per_slope * place.curvature.times(d)).length() / 2.0;
        by_chord.min(self.limits.facet_mm.map_or(f64::INFINITY, |limit| limit / image))
    }

    /// Fails where single precision alone exceeds the chord limit.
    pub fn outlast_rounding(&self, mirror: &Mirror) -> Result<(), MeshError> {
        let Some(limit) = self.limits.chord_mm else { return Ok(()) };
        let worse = |a: (f64, DVec2), b: (f64, DVec2)| if b.0 > a.0 { b } else { a };
        let inside = self.centres().filter(|&q| mirror.outline.contains(q));
        let roughly = inside.map(|q| (self.at(q).rounding, q)).reduce(worse);
        let Some((mut reached, mut at)) = roughly else { return Ok(()) };
        if reached < limit && limit * LEAST_LEFT < reached {
            let rounding = |(q, way)| (rounding(mirror, q, way, self.limits.precision), q);
            let places = self.flattest(mirror).map(|q| (q, None)).chain(self.sides(mirror));
            (reached, at) = places.map(rounding).fold((reached, at), worse);
        }
        if reached < limit {
            return Ok(());
        }
        Err(MeshError::PrecisionLimit { at, chord_mm: Some(reached), facet_mm: None })
    }

    /// Places close to each other along the domain's sides, on which corners move along them alone, and
    /// that way: under parallel rays, where that changes no digit but Z's.
    fn sides(&self, mirror: &Mirror) -> impl Iterator<Item = (DVec2, Option<DVec2>)> {
        let Rect { min, max } = self.domain;
        let is_plain = mirror.chart.vergence == 0.0 && matches!(mirror.outline, Outline::Rect(_));
        let count = if is_plain { SIDE } else { 0 };
        (0..count).flat_map(move |k| {
            let at = min + (max - min) * (k as f64 / (SIDE - 1) as f64);
            let [along_x, along_y] = [DVec2::X, DVec2::Y].map(Some);
            [
                (DVec2::new(at.x, min.y), along_x),
                (DVec2::new(at.x, max.y), along_x),
                (DVec2::new(min.x, at.y), along_y),
                (DVec2::new(max.x, at.y), along_y),
            ]
        })
    }

    /// Places close to each other in those cells of the table where the mirror is flattest: there, in
    /// spots smaller than a cell, no corner rounds better than another.
    fn flattest(&self, mirror: &Mirror) -> impl Iterator<Item = DVec2> {
        let steep = |q: DVec2| mirror.slope(q, &mirror.surface.at(q)).length();
        let mut cells: Vec<(f64, DVec2)> = self.centres().map(|q| (steep(q), q)).collect();
        cells.sort_by(|a, b| a.0.total_cmp(&b.0));
        cells.truncate(FLATTEST);
        let half = 0.5 * self.domain.size() / CELLS as f64;
        let cell = move |(_, q): (f64, DVec2)| Rect { min: q - half, max: q + half };
        let outline = mirror.outline;
        cells
            .into_iter()
            .flat_map(move |found| {
                cell(found).grid(CLOSE, CLOSE).map(|(q, _)| q).collect::<Vec<_>>()
            })
            .filter(move |&q| outline.contains(q))
    }

    /// Fails where rounding tilts facets with two sides as `sides` says by more than the facet limit
    /// allows, over half of the mirror. (Some places may be saved by facets that round well.)
    pub fn outlast_tilting(
        &self,
        outline: &Outline,
        sides: impl Fn(&LocalModel) -> [DVec2; 2],
    ) -> Result<(), MeshError> {
        let Some(limit) = self.limits.facet_mm else { return Ok(()) };
        let least = |q: DVec2| {
            let place = self.at(q);
            let [a, b] = sides(&place);
            let error = place.facet_squared(a, b).sqrt();
            (2.0 * (error * LIKELY * place.tilt(a, b)).sqrt(), q)
        };
        let inside = self.centres().filter(|&q| outline.contains(q));
        let mut found: Vec<(f64, DVec2)> = inside.map(least).filter(|f| f.0.is_finite()).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        match found.get(found.len() / 2) {
            Some(&(reached, at)) if reached >= limit => {
                Err(MeshError::PrecisionLimit { at, chord_mm: None, facet_mm: Some(reached) })
            }
            _ => Ok(()),
        }
    }
}

/// The same with the lesser curvature raised to a share of the larger one. Where a mirror is nearly
/// developable, the quadratic model would have facets of any length, which cubic terms break.
fn all_round(Hessian { xx, xy, yy }: Hessian) -> Hessian {
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = DVec2::new(half, xy).length();
    let (larger, lesser) = (mean.abs() + radius, (mean.abs() - radius).abs());
    let missing = FLAT * larger - lesser;
    if !(missing > 0.0 && radius > 0.0) {
        return Hessian { xx, xy, yy };
    }
    // The lesser one's principal direction, and its sign.
    let up = if mean.abs() >= radius { mean.signum() } else { -mean.signum() };
    let share = 0.5 * up * missing;
    let turn = share * mean.signum() / radius;
    Hessian { xx: xx + share - turn * half, xy: xy - turn * xy, yy: yy + share + turn * half }
}

/// Half the distance between the single-precision numbers around `x`.
fn half_step(x: f64) -> f64 {
    let single = x.abs() as f32;
    0.5 * (f64::from(single.next_up()) - f64::from(single))
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
fn place(sight: &ImagingProblem, q: DVec2, precision: Precision) -> LocalModel {
    let mirror = sight.mirror;
    let chart = &mirror.chart;
    let k = chart.vergence;
    let point = mirror.surface.at(q);
    let at = mirror.position(q, &point);
    let grow = exp(k * point.f);
    let gradient = point.slope * grow;
    let Hessian { xx, xy, yy } = mirror.surface.hessian(q);
    let s = point.slope;
    let curvature = Hessian {
        xx: grow * (xx + k * s.x * s.x),
        xy: grow * (xy + k * s.x * s.y),
        yy: grow * (yy + k * s.y * s.y),
    };
    let per_slope = sight.view.map_or(DMat2::ZERO, |view| {
        let fixed = |x: f64| Dual::<2> { value: x, slope: [0.0; 2] };
        let slope = [Dual::variable(gradient.x, 0), Dual::variable(gradient.y, 1)];
        let slope = chart.slope(q.to_array().map(fixed), slope.map(|s| s / grow));
        let image = sight.camera.coordinates(at).0;
        let [x, y] = view.image_of_seen(&sight.camera, at.to_array().map(fixed), slope, image);
        DMat2::from_cols_array_2d(&[[x.slope[0], y.slope[0]], [x.slope[1], y.slope[1]]])
    });
    LocalModel {
        curvature: all_round(curvature),
        per_slope,
        stretch: length_of_ray(chart, q) / (grow * grow),
        rounding: rounding(mirror, q, None, precision),
    }
}

/// The length of the ray over `q` for a unit along the axis.
fn length_of_ray(chart: &Chart, q: DVec2) -> f64 {
    (1.0 + chart.vergence * chart.vergence * q.length_squared()).sqrt()
}

/// How far the file's digits move a vertex over `q`, which may be moved along `way` or anywhere, along
/// its ray at worst, mm.
fn rounding(mirror: &Mirror, q: DVec2, way: Option<DVec2>, precision: Precision) -> f64 {
    let half = |x: f64| match precision {
        Precision::Single => half_step(x),
        Precision::Double => 0.0,
    };
    let (chart, point) = (&mirror.chart, mirror.surface.at(q));
    let (k, p) = (chart.vergence, mirror.slope(q, &point));
    let [x, y, z] = mirror.position(q, &point).to_array().map(half);
    let across = if k == 0.0 { 0.0 } else { p.abs().dot(DVec2::new(x, y)) };
    let slope = way.map_or_else(|| p.length(), |way| p.dot(way).abs());
    let left = rounding_left(2.0 * z, slope, mirror.outline.bounds().size().max_element());
    left * (z + across) * length_of_ray(chart, q) / (1.0 + k * q.dot(p))
}
