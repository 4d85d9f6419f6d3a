//! Tight bounds: a facet taken apart, for the proof alone, until what is proven of its parts is
//! near what they are seen to do.
//!
//! The errors are known at the corners of a part, and what its interior may add shrinks by 8
//! (chord) or 4 (facet error) with each halving of its edges. The part that may be worst is halved
//! first.

use super::bound_table::FacetFrame;
use super::deviation::{Triangle, largest_quadratic};
use super::error_bounder::{
    ErrorBound, ErrorBounder, FacetPair, SurfaceVertex, gradient_of, size_of,
};
use super::region::ImagingProblem;
use crate::geom::{DVec2, DVec3};
use crate::mesh::Limits;
use crate::num::{exp, max_or_nan};
use crate::optics::ImagingTask;

/// Largest share by which a bound should be over an error that is reached.
pub(crate) const LOOSE: f64 = 0.04;
/// Most times that a part of one facet is taken apart.
const MOST_SPLITS: usize = 400;
/// The same when only the limits are asked about, and where formulas over intervals, which take
/// long, are all that tells something of a part.
const MOST_TO_SETTLE: usize = 64;
const MOST_SLOW: usize = 12;
/// How many times a limit a quick bound may be for its facet to be taken apart.
const HOPEFUL: f64 = 4.0;
/// The same while there is no bound at all.
const MOST_UNBOUND: usize = 40;
/// Errors that are nothing, as a share of the mirror's size.
pub(crate) const NOTHING: f64 = 1e-12;
/// What of a facet's error its parts may add before their second derivatives are looked at closely.
const SMALL: f64 = 0.01;
const SMALL_IF_FINE: f64 = 1.0;

/// Which error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ErrorKind {
    Chord,
    Facet,
}

impl ErrorKind {
    pub fn of(self, bound: &ErrorBound) -> f64 {
        match self {
            Self::Chord => bound.chord_mm,
            Self::Facet => bound.facet_mm,
        }
    }

    pub fn set(self, bound: &mut ErrorBound, to: f64) {
        match self {
            Self::Chord => bound.chord_mm = to,
            Self::Facet => bound.facet_mm = to,
        }
    }

    pub fn limit(self, limits: &Limits) -> Option<f64> {
        match self {
            Self::Chord => limits.chord_mm,
            Self::Facet => limits.facet_mm,
        }
    }

    pub fn of_both(self, both: [f64; 2]) -> f64 {
        both[self as usize]
    }
}

/// A place on a facet.
#[derive(Debug, Clone, Copy)]
struct FacetPoint {
    /// Barycentric coordinates.
    weights: [f64; 3],
    /// In the chart, mm.
    q: DVec2,
    /// The mirror's h, mm, and its gradient.
    h: f64,
    gradient: DVec2,
    /// How far the mirror's h is over that of the exact facet and of the rounded one, mm.
    over: [f64; 2],
    /// The facet error there, mm; a camera that is not the chart's sees the mirror aside.
    seen: f64,
    /// The same for the mirror at the very place.
    shown: f64,
}

#[derive(Debug, Clone, Copy)]
struct SubTriangle {
    corners: [FacetPoint; 3],
    /// Its error is not larger.
    bound: f64,
}

/// One error of a facet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Enclosure {
    /// It is nowhere larger,
    pub bound: f64,
    /// and somewhere at least so large.
    pub reached: f64,
}

impl ErrorBounder<'_> {
    /// Bounds over a facet whose quick ones, `bound`, are over `limits`, for which it is taken apart
    /// until they are proven to hold or seen to be broken.
    #[must_use]
    pub fn settle(
        &self,
        t: [&SurfaceVertex; 3],
        mut bound: ErrorBound,
        limits: &Limits,
    ) -> ErrorBound {
        if bound == ErrorBound::NEVER {
            return bound;
        }
        for kind in [ErrorKind::Chord, ErrorKind::Facet] {
            let Some(limit) = kind.limit(limits) else { continue };
            let quick = kind.of(&bound);
            let hopeful = if self.ground.is_fine() { f64::INFINITY } else { HOPEFUL * limit };
            if quick > limit && quick <= hopeful {
                let slow = kind == ErrorKind::Facet && !self.plain;
                let mut left = if slow { MOST_SLOW } else { MOST_TO_SETTLE };
                let found = self.search(t, kind, quick, |found| {
                    left -= 1;
                    left == 0 || found.bound <= limit || found.reached > limit
                });
                kind.set(&mut bound, found.bound);
            }
        }
        bound
    }

    /// Bounds that are near errors which the facet has, as far as it can be taken apart for that.
    #[must_use]
    pub fn bound_tightly(&self, t: [&SurfaceVertex; 3]) -> ErrorBound {
        let mut bound = self.bound(t);
        if bound == ErrorBound::NEVER {
            return bound;
        }
        for kind in [ErrorKind::Chord, ErrorKind::Facet] {
            let found = self.search(t, kind, kind.of(&bound), |found| self.is_near(found));
            kind.set(&mut bound, found.bound);
        }
        bound
    }

    /// Bounds that a few splits bring near those errors which have `limits`, or well below these.
    pub(crate) fn bound_roughly(&self, t: [&SurfaceVertex; 3], limits: &Limits) -> ErrorBound {
        const SPLITS: usize = 12;
        const WELL_BELOW: f64 = 0.7;
        let (mut bound, reached) = self.estimate(t);
        if bound == ErrorBound::NEVER {
            return bound;
        }
        for kind in [ErrorKind::Chord, ErrorKind::Facet] {
            let Some(limit) = kind.limit(limits) else { continue };
            let quick = Enclosure { bound: kind.of(&bound), reached: kind.of_both(reached) };
            if !(quick.bound <= WELL_BELOW * limit || self.is_near(&quick)) {
                let mut left = SPLITS;
                let found = self.search(t, kind, quick.bound, |found| {
                    left -= 1;
                    left == 0 || found.bound <= WELL_BELOW * limit || self.is_near(found)
                });
                kind.set(&mut bound, found.bound);
            }
        }
        bound
    }

    /// Whether a bound is as near as it need be.
    pub(crate) fn is_near(&self, found: &Enclosure) -> bool {
        let least = NOTHING * self.mirror().outline.bounds().size().max_element();
        found.bound <= ((1.0 + LOOSE) * found.reached).max(least)
    }

    /// Whether anything can be said of the image in a facet.
    pub(crate) fn is_bounded(&self, t: [&SurfaceVertex; 3]) -> bool {
        let quick = self.bound(t);
        quick != ErrorBound::NEVER
            && self.search(t, ErrorKind::Facet, quick.facet_mm, |f| f.bound < f64::INFINITY).bound
                < f64::INFINITY
    }

    /// One error of the facet `t`, of which `quick` is a bound, looked at until `enough` is known.
    pub(crate) fn search(
        &self,
        t: [&SurfaceVertex; 3],
        kind: ErrorKind,
        quick: f64,
        mut enough: impl FnMut(&Enclosure) -> bool,
    ) -> Enclosure {
        let work = FacetSearch::new(self, t, kind);
        let quick = if quick.is_nan() { f64::INFINITY } else { quick };
        let mut reached = 0.0f64;
        let mut parts: Vec<SubTriangle> = Vec::new();
        let weights = |i: usize| std::array::from_fn(|k| if k == i { 1.0 } else { 0.0 });
        let corners = [0, 1, 2].map(|i| work.corner(weights(i), t[i]));
        parts.push(work.part(corners, quick, &mut reached));
        for split in 0..MOST_SPLITS {
            // Parts that cannot be worse than what is reached are not kept.
            let worst =
                (0..parts.len()).reduce(|a, b| if parts[b].bound > parts[a].bound { b } else { a });
            let Some(k) = worst else { break };
            let SubTriangle { corners: [a, b, c], bound } = parts[k];
            let found = Enclosure { bound: max_or_nan(bound, reached), reached };
            if enough(&found) || (split >= MOST_UNBOUND && !(bound < f64::INFINITY)) {
                return found;
            }
            parts.swap_remove(k);
            let [ab, bc, ca] = [work.between(&a, &b), work.between(&b, &c), work.between(&c, &a)];
            for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                let part = work.part(corners, bound, &mut reached);
                if !(part.bound <= reached) {
                    parts.push(part);
                }
            }
        }
        let bound = parts.iter().map(|part| part.bound).fold(reached, max_or_nan);
        Enclosure { bound, reached }
    }
}

/// All that stays the same while one facet is looked at.
struct FacetSearch<'a> {
    prover: &'a ErrorBounder<'a>,
    kind: ErrorKind,
    view: Option<&'a ImagingTask>,
    corners: [DVec2; 3],
    diameter: f64,
    facets: FacetPair,
    /// h of the facets' planes on the rays of the exact corners, mm.
    h: [[f64; 3]; 2],
    /// The gradients of these.
    gradients: [DVec2; 2],
    /// How far rounding moves the corners in the chart, mm.
    shift: f64,
}

impl<'a> FacetSearch<'a> {
    fn new(prover: &'a ErrorBounder<'a>, t: [&SurfaceVertex; 3], kind: ErrorKind) -> Self {
        let facets = FacetPair::new(t, prover.precision);
        let exact = t.map(|v| v.h);
        let rounded = facets
            .single
            .as_ref()
            .map_or(exact, |facet| std::array::from_fn(|i| prover.height(facet, i, t[i].q)));
        Self {
            prover,
            kind,
            view: prover.sight.view.filter(|_| kind == ErrorKind::Facet),
            corners: t.map(|v| v.q),
            diameter: Triangle::new(t.map(|v| v.q)).diameter,
            h: [exact, rounded],
            gradients: [exact, rounded].map(|h| gradient_of(t.map(|v| v.q), h)),
            shift: prover.shift(t, &facets),
            facets,
        }
    }

    fn vergence(&self) -> f64 {
        self.prover.sight.mirror.chart.vergence
    }

    /// A corner of the facet.
    fn corner(&self, weights: [f64; 3], v: &SurfaceVertex) -> FacetPoint {
        self.place(weights, v.q, [v.h, v.gradient.x, v.gradient.y], v.content)
    }

    /// Half-way between two places.
    fn between(&self, a: &FacetPoint, b: &FacetPoint) -> FacetPoint {
        let weights = std::array::from_fn(|i| 0.5 * (a.weights[i] + b.weights[i]));
        self.at(weights)
    }

    fn at(&self, weights: [f64; 3]) -> FacetPoint {
        let [a, b, c] = self.corners;
        let q = a * weights[0] + b * weights[1] + c * weights[2];
        let mirror = self.prover.sight.mirror;
        let point = mirror.surface.at(q);
        if self.view.is_some() {
            let v = self.prover.vertex(q, point);
            return self.place(weights, q, [v.h, v.gradient.x, v.gradient.y], v.content);
        }
        let (chart, k) = (&mirror.chart, self.vergence());
        let slope = if k == 0.0 { point.slope } else { point.slope * exp(k * point.f) };
        self.place(weights, q, [chart.projective_height(point.f), slope.x, slope.y], DVec2::ZERO)
    }

    fn place(
        &self,
        weights: [f64; 3],
        q: DVec2,
        [h, x, y]: [f64; 3],
        content: DVec2,
    ) -> FacetPoint {
        let flat = self.h.map(|of| of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2]);
        let (mut shown, mut seen) = (0.0, 0.0f64);
        if let Some(view) = self.view {
            let camera = &self.prover.sight.camera;
            let is_same = *camera == self.prover.sight.mirror.chart;
            let facets = [Some(&self.facets.exact), self.facets.single.as_ref()];
            for (facet, h) in facets.into_iter().zip(flat) {
                let Some(facet) = facet else { continue };
                let at = self.lifted(q, h);
                let near = if is_same { q } else { camera.coordinates(at).0 };
                let found = self.prover.content(view, at, facet.slope, near);
                shown = max_or_nan(shown, view.projection.image_distance(found, content));
                if !is_same && let Some(aside) = self.aside(view, near) {
                    seen = seen.max(view.projection.image_distance(found, aside));
                }
            }
            if is_same {
                seen = shown;
            }
        }
        let over = flat.map(|flat| h - flat);
        FacetPoint { weights, q, h, gradient: DVec2::new(x, y), over, seen, shown }
    }

    /// What the mirror shows at the image point `near` of another camera than the chart's.
    fn aside(&self, view: &ImagingTask, near: DVec2) -> Option<DVec2> {
        let ImagingProblem { mirror, camera, .. } = &self.prover.sight;
        let q = mirror.intersect_camera_ray(camera, near)?;
        let point = mirror.surface.at(q);
        Some(self.prover.content(view, mirror.position(q, &point), mirror.slope(q, &point), near))
    }

    /// The point over `q` of height `h`.
    fn lifted(&self, q: DVec2, h: f64) -> DVec3 {
        let grow = 1.0 + self.vergence() * h;
        (q / grow).extend(h / grow + self.prover.sight.mirror.chart.plane_mm)
    }

    /// The part with the given corners, of which `known` is a bound; what it reaches goes to
    /// `reached`.
    fn part(&self, corners: [FacetPoint; 3], known: f64, reached: &mut f64) -> SubTriangle {
        let local = self.prover.ground.local(corners.map(|c| c.q));
        let found = match self.kind {
            ErrorKind::Chord => self.chord(&corners, &local, reached),
            ErrorKind::Facet => self.facet(&corners, &local, reached),
        };
        let bound = if found < known { found } else { known };
        SubTriangle { corners, bound }
    }

    /// Bound of the chord in h, and where it may be.
    fn rise(&self, corners: &[FacetPoint; 3], local: &FacetFrame, rest: f64) -> (f64, [f64; 3]) {
        let curves = local.triangle.curves(corners.map(|c| local.turn.rotate(c.gradient)));
        let [exact, rounded] =
            [0, 1].map(|k| largest_quadratic(corners.map(|c| c.over[k]), curves));
        let (found, at) = if rounded.0 > exact.0 { rounded } else { exact };
        (found + rest, at)
    }

    fn chord(&self, corners: &[FacetPoint; 3], local: &FacetFrame, reached: &mut f64) -> f64 {
        let k = self.vergence();
        let triangle = &local.triangle;
        let [lo, hi] = triangle.reach;
        let third = self.prover.ground.region(&self.prover.sight, local, self.diameter, 0.0).third;
        let (mut rise, at) = self.rise(corners, local, triangle.twist(third));
        if self.shift > 0.0 {
            // The rounded facet reaches a little beyond the exact one.
            let steep = corners
                .iter()
                .flat_map(|c| self.gradients.map(|gradient| (c.gradient - gradient).length()));
            let bend = size_of(third) * triangle.diameter * triangle.diameter / 6.0;
            rise += self.shift * (steep.fold(0.0, max_or_nan) + bend);
        }
        let mut consider = |place: &FacetPoint| {
            let farthest = place.over.map(f64::abs).into_iter().fold(0.0, f64::max);
            *reached = reached.max(farthest * self.stretch(place));
        };
        corners.iter().for_each(&mut consider);
        let inside = |k: usize| -> f64 { (0..3).map(|i| corners[i].weights[k] * at[i]).sum() };
        consider(&self.at([inside(0), inside(1), inside(2)]));
        if k == 0.0 {
            return rise;
        }
        let far = lo.abs().max(hi.abs()).length_squared();
        let lowest = |c: &FacetPoint| 1.0 + k * (c.h - c.over[0].max(c.over[1]));
        let low = corners.iter().map(lowest).fold(f64::INFINITY, f64::min);
        let lower = low - k * rise;
        let ray = (1.0 + k * k * far).sqrt();
        if lower > 0.0 { rise * ray / (low * lower) } else { f64::INFINITY }
    }

    /// mm along the ray per mm of h at a place, at least.
    fn stretch(&self, place: &FacetPoint) -> f64 {
        let k = self.vergence();
        if k == 0.0 {
            return 1.0;
        }
        let flat = place.h - place.over[0].min(place.over[1]);
        (1.0 + k * k * place.q.length_squared()).sqrt() / ((1.0 + k * flat) * (1.0 + k * place.h))
    }

    fn facet(&self, corners: &[FacetPoint; 3], local: &FacetFrame, reached: &mut f64) -> f64 {
        let triangle = &local.triangle;
        let region = self.prover.ground.region(&self.prover.sight, local, self.diameter, 0.0);
        let chord = if region.drift == 0.0 {
            0.0
        } else {
            self.rise(corners, local, triangle.twist(region.third)).0
        };
        let aside = self.prover.aside(&region, chord) + self.shift;
        let largest = corners.iter().map(|c| c.shown).fold(0.0, max_or_nan);
        *reached = corners.iter().map(|c| c.seen).fold(*reached, f64::max);
        let quick = triangle.bend(region.second);
        let known = self.gradients.iter().all(|&gradient| local.is_known(&region, gradient));
        let holds = known && aside <= self.prover.ground.margin();
        let beside = |first: f64| if aside == 0.0 { 0.0 } else { first * aside };
        let known = if holds { largest + quick + beside(region.first) } else { f64::INFINITY };
        let small = if self.prover.ground.is_fine() { SMALL_IF_FINE } else { SMALL };
        if quick <= small * largest && known < f64::INFINITY {
            return known;
        }
        let flat = corners.map(|c| c.h - c.over[0]);
        let at = corners.map(|c| c.q);
        if self.prover.ground.is_fine()
            && !self.prover.plain
            && aside <= self.prover.ground.margin()
        {
            let bend = self.prover.bend_closely(at, flat, &self.facets, (&region, aside));
            if bend < f64::INFINITY {
                return known.min(largest + bend + beside(region.first));
            }
        }
        let (contents, bend) = self.prover.closely(at, flat, &self.facets, aside);
        let close = largest + bend + beside(contents.first());
        let bound = if self.prover.plain { close } else { close.min(contents.apart()) };
        bound.min(known)
    }
}
