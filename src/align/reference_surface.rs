//! The designed mirror as reference surface: the projection of any point on it, its size and area.

use crate::geom::{DVec2, DVec3, Outline};
use crate::mirror::{HeightAndSlope, Mirror};
use crate::num::{exp, sort_by_number};

/// Projection of a point on the mirror along the camera's ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProjectedPoint {
    /// Position on the mirror, mm.
    pub at: DVec3,
    /// The mirror's unit normal there, towards the camera.
    pub normal: DVec3,
    /// Towards the camera along its ray, with a Z of 1.
    pub up: DVec3,
}

impl ProjectedPoint {
    fn new(mirror: &Mirror, q: DVec2, point: &HeightAndSlope) -> Self {
        let at = mirror.position(q, point);
        let view = DVec2::from_array(mirror.chart.view(at.to_array()));
        Self { at, normal: mirror.normal(q, point).normalize(), up: (-view).extend(1.0) }
    }

    /// Signed distance of `p` above the tangent plane, mm.
    #[inline]
    #[must_use]
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p - self.at)
    }
}

/// Nodes of the table along each side.
const NODES: usize = 96;
/// Steps of the quadrature along each side.
const STEPS: usize = 48;

/// A mirror with its size, and a table of it for searches where speed matters more than digits.
#[derive(Debug, Clone)]
pub(super) struct ReferenceSurface<'a> {
    mirror: &'a Mirror,
    outline: Outline,
    table: Vec<ProjectedPoint>,
    /// Area of the surface, mm^2.
    pub area: f64,
    /// Centre of that area, mm.
    pub centre: DVec3,
    /// RMS distance of the surface from its centre, mm.
    pub gyration: f64,
    /// The distance from its centre that 95 % of the surface keep, mm.
    pub radius: f64,
    /// The larger side of its outline, mm.
    pub width: f64,
    /// Radius of the ball whose centres are measured, mm; 0 where points lie on the part.
    ball_mm: f64,
}

/// Steps towards the place that a ball touches: each leaves a share of the ball's radius over that of the curvature.
const CONTACT_STEPS: usize = 40;
/// Distance within which the place is found, mm.
const CONTACT_MM: f64 = 1e-9;

impl<'a> ReferenceSurface<'a> {
    /// Measures `mirror` and tabulates it.
    #[must_use]
    pub(super) fn new(mirror: &'a Mirror) -> Self {
        let outline = mirror.full_outline();
        let k = mirror.chart.vergence;
        // An area dq of the reference plane is seen on exp(-2 k f) dq of the plane through the
        // mirror's point, and that on 1 / (n . up) as much of the mirror.
        let mut pieces: Vec<(DVec3, f64)> = Vec::new();
        for line in outline.samples(STEPS) {
            let places: Vec<DVec2> = line.iter().map(|s| s.0).collect();
            for (point, (q, weight)) in mirror.eval_many(&places).iter().zip(line) {
                let foot = ProjectedPoint::new(mirror, q, point);
                let area = weight * exp(-2.0 * k * point.f) / foot.normal.dot(foot.up);
                pieces.push((foot.at, area));
            }
        }
        let area: f64 = pieces.iter().map(|p| p.1).sum();
        let centre = pieces.iter().map(|p| p.0 * p.1).sum::<DVec3>() / area;
        let square = |p: &(DVec3, f64)| p.1 * (p.0 - centre).length_squared();
        let gyration = (pieces.iter().map(square).sum::<f64>() / area).sqrt();
        let radius =
            percentile_95(pieces.into_iter().map(|(at, w)| ((at - centre).length(), w)).collect());
        let width = outline.bounds().size().max_element();
        let table = table(mirror, outline);
        Self { mirror, outline, table, area, centre, gyration, radius, width, ball_mm: 0.0 }
    }

    /// The surface that centres of a ball of this radius, mm, lie on when it touches the mirror.
    #[must_use]
    pub(super) fn touched_by(self, ball_mm: f64) -> Self {
        Self { ball_mm, ..self }
    }

    /// What a ball with its centre at `p` touches, by `project` of points on the mirror and so many steps at most: the place
    /// of its centre above it.
    fn touched(
        &self,
        p: DVec3,
        steps: usize,
        project: impl Fn(DVec3) -> Option<ProjectedPoint>,
    ) -> Option<ProjectedPoint> {
        let mut foot = project(p)?;
        if self.ball_mm == 0.0 {
            return Some(foot);
        }
        for _ in 0..steps {
            let before = foot.normal;
            foot = project(p - self.ball_mm * foot.normal)?;
            if self.ball_mm * (foot.normal - before).length() < CONTACT_MM {
                break;
            }
        }
        Some(ProjectedPoint { at: foot.at + self.ball_mm * foot.normal, ..foot })
    }

    /// Projection of `p`, to all digits; `None` outside the outline or closer than `margin` mm to its
    /// rim or to a fold.
    #[must_use]
    pub(super) fn project(&self, p: DVec3, margin: f64) -> Option<ProjectedPoint> {
        self.touched(p, CONTACT_STEPS, |p| {
            let q = self.inside(p, margin)?;
            Some(ProjectedPoint::new(self.mirror, q, &self.mirror.row(q.y).at(q.x)))
        })
    }

    /// [`ReferenceSurface::project`] by the table, to some thousandth of the width.
    #[must_use]
    pub(super) fn project_approximately(&self, p: DVec3) -> Option<ProjectedPoint> {
        self.touched(p, 1, |p| self.tabulated(p))
    }

    /// The place on the camera's ray of `p`, by the table.
    fn tabulated(&self, p: DVec3) -> Option<ProjectedPoint> {
        let q = self.inside(p, 0.0)?;
        let bounds = self.outline.bounds();
        let u = (q - bounds.min) / bounds.size() * (NODES - 1) as f64;
        let last = (NODES - 2) as f64;
        let cell = u.floor().clamp(DVec2::ZERO, DVec2::splat(last));
        let t = u - cell;
        let first = cell.y as usize * NODES + cell.x as usize;
        let mix = |pick: fn(&ProjectedPoint) -> DVec3| {
            let at = |k: usize| pick(&self.table[first + k]);
            at(0).lerp(at(1), t.x).lerp(at(NODES).lerp(at(NODES + 1), t.x), t.y)
        };
        let normal = mix(|foot| foot.normal).normalize();
        Some(ProjectedPoint { at: mix(|foot| foot.at), normal, up: mix(|foot| foot.up) })
    }

    fn inside(&self, p: DVec3, margin: f64) -> Option<DVec2> {
        let chart = &self.mirror.chart;
        // Points beside or behind a pinhole are on no ray.
        if !(chart.view_scale(p.z) > 0.05) {
            return None;
        }
        let q = chart.coordinates(p).0;
        let depth = match self.outline {
            Outline::Rect(rect) => (q - rect.min).min(rect.max - q).min_element(),
            Outline::Ring { inner: 0.0, outer } => outer - q.length(),
            Outline::Ring { inner, outer } => (outer - q.length()).min(q.length() - inner),
        };
        let fold = if self.mirror.folded { q.y.abs() } else { f64::INFINITY };
        (depth.min(fold) >= margin).then_some(q)
    }
}

/// The distance that 95 % of the weight do not exceed.
pub(super) fn percentile_95(mut distances: Vec<(f64, f64)>) -> f64 {
    sort_by_number(&mut distances, |d| d.0);
    let total: f64 = distances.iter().map(|d| d.1).sum();
    let mut sum = 0.0;
    let within = |(_, weight): &&(f64, f64)| {
        sum += weight;
        sum >= 0.95 * total
    };
    distances.iter().find(within).map_or(0.0, |d| d.0)
}

/// The mirror over an even grid around its outline; beyond the rim it goes on straight, so that
/// what is mixed near the rim is sound.
fn table(mirror: &Mirror, outline: Outline) -> Vec<ProjectedPoint> {
    let bounds = outline.bounds();
    let step = bounds.size() / (NODES - 1) as f64;
    let node = |k: usize| {
        let q = bounds.min + step * DVec2::new((k % NODES) as f64, (k / NODES) as f64);
        let rim = match outline {
            Outline::Rect(rect) => q.clamp(rect.min, rect.max),
            Outline::Ring { inner, outer } => {
                let way = if q == DVec2::ZERO { DVec2::X } else { q.normalize() };
                way * q.length().clamp(inner, outer)
            }
        };
        let mut point = mirror.row(rim.y).at(rim.x);
        point.f += point.slope.dot(q - rim);
        ProjectedPoint::new(mirror, q, &point)
    };
    (0..NODES * NODES).map(node).collect()
}
