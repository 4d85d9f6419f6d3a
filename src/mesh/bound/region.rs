//! What the proof knows of a region of the chart: bounds of derivatives, by intervals.
//!
//! The mirror's bounds over a box become jets over intervals in the variables (x, y); the very
//! formulas that the optics evaluate, run on those jets, give bounds of the content's first and
//! second derivatives. Intervals lose a factor of a few, but only in terms of second order.

use crate::geom::{Chart, DVec2, Outline};
use crate::mirror::{DerivativeBounds, Mirror, UnionBound};
use crate::num::{Interval, Jet2, Scalar, exp};
use crate::optics::{ImagingTask, Target};

type Jet = Jet2<Interval>;

/// Share of a range's width by which it is widened for the facets' gradients, which are means over
/// edges and may leave it by a little.
const MARGIN: f64 = 0.25;
/// Rounding to single precision moves nothing by so large a share of the mirror's size.
const ROUNDING: f64 = 1e-6;
/// Second derivatives, in units of one over the mirror's size, from which on a box is taken apart:
/// so much costs facets of a pixel in a thousand some per cent. (Once: what is still loose then is
/// looked at facet by facet.)
const LOOSE: f64 = 100.0;
/// How often it is, and into how many parts per side.
const LEVELS: usize = 1;
const PARTS: usize = 4;

/// Bounds that hold all over a region.
#[derive(Debug, Clone, Copy)]
pub struct RegionBounds {
    /// Third derivatives of h (xxx, xxy, xyy, yyy), 1/mm^2.
    pub third: [Interval; 4],
    /// mm along the camera's ray per mm of h.
    pub stretch: f64,
    /// |c''| + |c_T''| (xx, xy, yy), 1/mm.
    pub second: [f64; 3],
    /// |c''| alone.
    pub mirror: [f64; 3],
    /// |c'|.
    pub first: f64,
    /// How far apart in the chart the mirror and a facet are met by one ray of a camera that is
    /// not the chart's, per mm between them.
    pub drift: f64,
    /// Corners of the box of facet gradients for which `second` holds.
    pub gradient: [DVec2; 2],
    /// Whether the mirror may look at a place that the image does not have.
    pub pole: bool,
}

impl RegionBounds {
    /// Holds where there is no mirror.
    pub const NOTHING: Self = Self {
        third: [Interval { lo: f64::INFINITY, hi: f64::NEG_INFINITY }; 4],
        stretch: 0.0,
        second: [0.0; 3],
        mirror: [0.0; 3],
        first: 0.0,
        drift: 0.0,
        gradient: [DVec2::NEG_INFINITY, DVec2::INFINITY],
        pole: false,
    };
}

impl RegionBounds {
    /// What holds of a round mirror where this holds on the X axis, turned about by any angle with
    /// a cosine of at least `cos` and a sine of at most `sin` in size.
    #[must_use]
    pub fn turned(&self, [cos, sin]: [f64; 2]) -> Self {
        let (c, s) = (Interval::new(cos, 1.0), Interval::new(-sin, sin));
        let (cc, ss) = (c.square(), s.square());
        // On the axis the other two vanish, as h is even in y.
        let [a, _, b, _] = self.third;
        let rest = a - b * 2.0;
        let third = [
            c * (cc * a + ss * b * 3.0),
            s * (cc * rest + ss * b),
            c * (ss * rest + cc * b),
            s * (ss * a + cc * b * 3.0),
        ];
        let both = |[xx, xy, yy]: [f64; 3]| {
            [
                xx + sin * (2.0 * xy + sin * yy),
                xy + sin * (xx + yy),
                yy + sin * (2.0 * xy + sin * xx),
            ]
        };
        Self { third, second: both(self.second), mirror: both(self.mirror), ..*self }
    }
}

impl UnionBound for RegionBounds {
    fn union(self, other: Self) -> Self {
        let ([lo, hi], [other_lo, other_hi]) = (self.gradient, other.gradient);
        Self {
            third: std::array::from_fn(|k| self.third[k].hull(other.third[k])),
            stretch: self.stretch.max(other.stretch),
            second: std::array::from_fn(|k| self.second[k].max(other.second[k])),
            mirror: std::array::from_fn(|k| self.mirror[k].max(other.mirror[k])),
            first: self.first.max(other.first),
            drift: self.drift.max(other.drift),
            gradient: [lo.max(other_lo), hi.min(other_hi)],
            pole: self.pole || other.pole,
        }
    }
}

/// Bounds of the contents of a box: of the mirror's c, and of a facet's c_T.
#[derive(Debug, Clone, Copy)]
pub struct ContentBounds {
    mirror: [Jet; 2],
    facet: [Jet; 2],
}

impl ContentBounds {
    /// |c''| + |c_T''| (xx, xy, yy).
    pub fn second(&self) -> [f64; 3] {
        let (mirror, facet) = (second(&self.mirror), second(&self.facet));
        std::array::from_fn(|k| mirror[k] + facet[k])
    }

    /// |c'|.
    pub fn first(&self) -> f64 {
        size(self.mirror.iter().flat_map(|jet| jet.gradient).map(Interval::magnitude))
    }

    /// |c_T - c|, from the ranges of both.
    pub fn apart(&self) -> f64 {
        size((0..2).map(|k| (self.facet[k].value - self.mirror[k].value).magnitude()))
    }

    fn is_bounded(&self) -> bool {
        self.mirror.iter().all(|jet| jet.value.is_finite())
    }
}

/// The sizes of second derivatives (xx, xy, yy).
pub fn second(jets: &[Jet; 2]) -> [f64; 3] {
    std::array::from_fn(|k| size(jets.iter().map(|jet| jet.hessian[k].magnitude())))
}

fn size(parts: impl Iterator<Item = f64>) -> f64 {
    parts.map(|x| x * x).sum::<f64>().sqrt()
}

/// Ranges for facets in a box of the chart: up = a + p . (X, Y) with up = Z - plane.
#[derive(Debug, Clone, Copy)]
pub struct FacetPlanes {
    h: Interval,
    /// The gradient of h, which is linear in q.
    gradient: [Interval; 2],
    /// p, the same everywhere on a facet.
    slope: [Interval; 2],
}

impl FacetPlanes {
    /// Facets with h's gradient in `gradient`.
    fn of_gradient(k: f64, q: [Interval; 2], h: Interval, gradient: [Interval; 2]) -> Self {
        let base = h - (q[0] * gradient[0] + q[1] * gradient[1]);
        Self { h, gradient, slope: gradient.map(|g| g / (base * k + 1.0)) }
    }

    /// Facets with p in `slope`.
    pub fn of_slope(k: f64, q: [Interval; 2], h: Interval, slope: [Interval; 2]) -> Self {
        let lean = (q[0] * slope[0] + q[1] * slope[1]) * k + 1.0;
        Self { h, gradient: slope.map(|p| p * (h * k + 1.0) / lean), slope }
    }
}

/// The ranges of x and of y in a box.
pub fn sides([lo, hi]: [DVec2; 2]) -> [Interval; 2] {
    [Interval::new(lo.x, hi.x), Interval::new(lo.y, hi.y)]
}

/// Who looks at a mirror, and what it must see.
#[derive(Debug, Clone, Copy)]
pub struct ImagingProblem<'a> {
    /// The mirror.
    pub mirror: &'a Mirror,
    /// The camera's chart.
    pub camera: Chart,
    /// What its image must show.
    pub view: Option<&'a ImagingTask>,
}

impl ImagingProblem<'_> {
    /// Whether all places of a facet show the same: parallel rays in, and only directions count.
    pub fn is_plain(&self) -> bool {
        let parallel = self.camera.vergence == 0.0 && self.mirror.chart.vergence == 0.0;
        parallel && self.view.is_none_or(|view| view.target == Target::Infinity)
    }

    /// Into how many parts per side the cells of the mirror's bounds should be taken: only under
    /// parallel rays and with targets at infinity are the formulas so short that intervals lose
    /// little over whole cells.
    pub fn parts(&self) -> usize {
        if self.is_plain() { 1 } else { 4 }
    }

    /// Everything about the box `lo`..`hi`, over which `bounds` hold, and about facets that touch
    /// it and lie where `around` holds, or inside the box without that.
    pub fn region(
        &self,
        [lo, hi]: [DVec2; 2],
        bounds: &DerivativeBounds,
        around: Option<&DerivativeBounds>,
    ) -> RegionBounds {
        let chart = &self.mirror.chart;
        let k = chart.vergence;
        let reach = lo.abs().max(hi.abs()).length();
        let low = exp(k * bounds.f.lo);
        let mut region = RegionBounds {
            third: third(bounds, k),
            stretch: (1.0 + k * k * reach * reach).sqrt() / (low * low),
            ..RegionBounds::NOTHING
        };
        if let Some(view) = self.view {
            region.drift = self.drift([lo, hi], bounds);
            // A box beside which facets reach cannot be taken apart without them.
            let levels = if around.is_some() { 0 } else { LEVELS };
            let around = around.unwrap_or(bounds);
            self.see(view, [lo, hi], [bounds, around], levels, &mut region);
        }
        region
    }

    /// Fills in what has to do with the image; where bounds are loose or none, from parts of the
    /// box.
    fn see(
        &self,
        view: &ImagingTask,
        [lo, hi]: [DVec2; 2],
        [bounds, around]: [&DerivativeBounds; 2],
        levels: usize,
        region: &mut RegionBounds,
    ) {
        let (plane, gradient) = self.planes([lo, hi], around);
        let contents = self.contents(view, [lo, hi], bounds, plane);
        let (second, mirror) = (contents.second(), second(&contents.mirror));
        let [xx, xy, yy] = second;
        let steepest = size([xx, xy, xy, yy].into_iter());
        let across = self.mirror.outline.bounds().size().max_element();
        // Elsewhere boxes are many, and facets in loose ones are looked at one by one.
        let is_loose = !contents.is_bounded() || (plane.is_none() && !(steepest * across < LOOSE));
        if levels > 0 && is_loose {
            let step = (hi - lo) / PARTS as f64;
            for k in 0..PARTS * PARTS {
                let lo = lo + step * DVec2::new((k % PARTS) as f64, (k / PARTS) as f64);
                let part = [lo, lo + step];
                if !beyond(&self.mirror.outline, part) {
                    let bounds = self.narrow(bounds, part);
                    self.see(view, part, [&bounds, &bounds], levels - 1, region);
                }
            }
        } else {
            let pole = !contents.is_bounded();
            let first = contents.first();
            let found =
                RegionBounds { second, mirror, first, gradient, pole, ..RegionBounds::NOTHING };
            *region = region.union(found);
        }
    }

    /// The facets that may touch a box: with gradients of h in the box returned.
    fn planes(
        &self,
        part: [DVec2; 2],
        bounds: &DerivativeBounds,
    ) -> (Option<FacetPlanes>, [DVec2; 2]) {
        if self.is_plain() {
            return (None, RegionBounds::NOTHING.gradient);
        }
        let chart = &self.mirror.chart;
        let k = chart.vergence;
        let grow = Interval::new(exp(k * bounds.f.lo), exp(k * bounds.f.hi));
        let wide = bounds.slope.map(|s| {
            let range = s * grow;
            Interval::around(range.mid(), (0.5 + MARGIN) * range.width())
        });
        // Rounded facets leave the mirror's heights by less than this.
        let slack = ROUNDING * self.mirror.outline.bounds().size().max_element();
        let h = Interval::new(
            chart.projective_height(bounds.f.lo) - slack,
            chart.projective_height(bounds.f.hi) + slack,
        );
        let gradient = [DVec2::new(wide[0].lo, wide[1].lo), DVec2::new(wide[0].hi, wide[1].hi)];
        (Some(FacetPlanes::of_gradient(k, sides(part), h, wide)), gradient)
    }

    /// Bounds over a part of a region where `bounds` hold: by Taylor's theorem about its middle.
    pub fn narrow(&self, bounds: &DerivativeBounds, [lo, hi]: [DVec2; 2]) -> DerivativeBounds {
        let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        if !self.is_sound([lo, hi]) {
            return self.mirror.surface.box_bounds(lo, hi).unwrap_or(*bounds);
        }
        let point = self.mirror.surface.at(middle);
        let c = self.mirror.surface.hessian(middle);
        let [x, y] = [half.x, half.y].map(|half| Interval::around(0.0, half));
        let near = |at: f64, x_rate: Interval, y_rate: Interval, known: Interval| {
            // Evaluation is good to far better than this.
            let slack = 1e-11 * (known.magnitude() + known.width());
            let here = Interval::around(at, slack) + x_rate * x + y_rate * y;
            let (lo, hi) = (here.lo.max(known.lo), here.hi.min(known.hi));
            if lo <= hi { Interval::new(lo, hi) } else { known }
        };
        let [xxx, xxy, xyy, yyy] = bounds.third;
        let [known_xx, known_xy, known_yy] = bounds.hessian;
        let xx = near(c.xx, xxx, xxy, known_xx);
        let xy = near(c.xy, xxy, xyy, known_xy);
        let yy = near(c.yy, xyy, yyy, known_yy);
        let [known_x, known_y] = bounds.slope;
        let slope = [near(point.slope.x, xx, xy, known_x), near(point.slope.y, xy, yy, known_y)];
        let f = near(point.f, slope[0], slope[1], bounds.f);
        DerivativeBounds { f, slope, hessian: [xx, xy, yy], third: bounds.third }
    }

    /// Whether the ways from a box's middle to its points on the mirror stay where a round surface's
    /// bounds hold: between its radii.
    fn is_sound(&self, [lo, hi]: [DVec2; 2]) -> bool {
        let Some([inner, outer]) = self.mirror.surface.radii() else { return true };
        let nearest = DVec2::ZERO.clamp(lo, hi).length();
        let middle = (0.5 * (lo + hi)).length();
        middle <= outer && nearest >= inner * (1.0 - Outline::EDGE)
    }

    /// The contents over a box where `bounds` hold; without a plane those of a facet do not vary.
    pub fn contents(
        &self,
        view: &ImagingTask,
        [lo, hi]: [DVec2; 2],
        bounds: &DerivativeBounds,
        plane: Option<FacetPlanes>,
    ) -> ContentBounds {
        let chart = &self.mirror.chart;
        let middle = chart.point(0.5 * (lo + hi), bounds.f.mid());
        let near = self.camera.coordinates(middle).0;
        let [x, y] = sides([lo, hi]);
        let q = [Jet::variable_x(x), Jet::variable_y(y)];
        let f = Jet::from_parts(bounds.f, bounds.slope, bounds.hessian);
        let ([xx, xy, yy], [xxx, xxy, xyy, yyy]) = (bounds.hessian, bounds.third);
        let slope = [
            Jet::from_parts(bounds.slope[0], [xx, xy], [xxx, xxy, xyy]),
            Jet::from_parts(bounds.slope[1], [xy, yy], [xxy, xyy, yyy]),
        ];
        let (at, p) = (|| chart.position(q, f), chart.slope(q, slope));
        let mirror = view.image_of_seen_along(self.tangent(q, at), at, p, near);
        let facet = plane.map_or([Jet::constant(0.0); 2], |plane| {
            self.facet_contents(view, [lo, hi], plane, near)
        });
        ContentBounds { mirror, facet }
    }

    /// The contents of facets over a box.
    pub fn facet_contents(
        &self,
        view: &ImagingTask,
        part: [DVec2; 2],
        plane: FacetPlanes,
        near: DVec2,
    ) -> [Jet; 2] {
        let chart = &self.mirror.chart;
        let [x, y] = sides(part);
        let q = [Jet::variable_x(x), Jet::variable_y(y)];
        let h = Jet::from_parts(plane.h, plane.gradient, [Interval::point(0.0); 3]);
        let at = || {
            let grow = h * chart.vergence + 1.0;
            [q[0] / grow, q[1] / grow, h / grow + chart.plane_mm]
        };
        view.image_of_seen_along(self.tangent(q, at), at, plane.slope.map(Jet::flat), near)
    }

    /// The tangent of the camera's ray to the point `at` over `q`. In its own chart it follows from q
    /// alone, in closer bounds than by the point.
    fn tangent(&self, q: [Jet; 2], at: impl FnOnce() -> [Jet; 3]) -> [Jet; 2] {
        if self.camera == self.mirror.chart {
            q.map(|q| q * self.camera.vergence)
        } else {
            self.camera.view(at())
        }
    }

    /// [`RegionBounds::drift`]: |v| / (1 + p . v), with v the tangent of the ray's angle to the axis and
    /// p the mirror's slope. (The chart is then that of parallel rays.)
    fn drift(&self, part: [DVec2; 2], bounds: &DerivativeBounds) -> f64 {
        if self.camera == self.mirror.chart {
            return 0.0;
        }
        let view = self.camera.view(self.mirror.chart.position(sides(part), bounds.f));
        let lean = view[0] * bounds.slope[0] + view[1] * bounds.slope[1] + 1.0;
        let tangent = size(view.into_iter().map(Interval::magnitude));
        if lean.lo > 0.0 { tangent / lean.lo } else { f64::INFINITY }
    }
}

/// Whether a box has nothing of the outline (nor of what a rim's chords cut off).
pub fn beyond(outline: &Outline, [lo, hi]: [DVec2; 2]) -> bool {
    let Outline::Ring { inner, outer } = *outline else { return false };
    let nearest = DVec2::ZERO.clamp(lo, hi).length();
    let farthest = lo.abs().max(hi.abs()).length();
    nearest > outer * (1.0 + 1e-6) || farthest < inner * (1.0 - 2.0 * Outline::EDGE)
}

/// The third derivatives of h = (exp(k f) - 1) / k:
/// exp(k f) (f_ijk + k (f_ij f_k + f_ik f_j + f_jk f_i) + k^2 f_i f_j f_k).
fn third(bounds: &DerivativeBounds, k: f64) -> [Interval; 4] {
    if k == 0.0 {
        return bounds.third;
    }
    let ([x, y], [xx, xy, yy], [xxx, xxy, xyy, yyy]) = (bounds.slope, bounds.hessian, bounds.third);
    let grow = Interval::new(exp(k * bounds.f.lo), exp(k * bounds.f.hi));
    let part = |of: Interval, pairs: [(Interval, Interval); 3], cube: Interval| {
        let sum = pairs[0].0 * pairs[0].1 + pairs[1].0 * pairs[1].1 + pairs[2].0 * pairs[2].1;
        (of + sum * k + cube * (k * k)) * grow
    };
    [
        part(xxx, [(xx, x); 3], x.square() * x),
        part(xxy, [(xx, y), (xy, x), (xy, x)], x.square() * y),
        part(xyy, [(yy, x), (xy, y), (xy, y)], y.square() * x),
        part(yyy, [(yy, y); 3], y.square() * y),
    ]
}
