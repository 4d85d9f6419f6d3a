//! What the tests of designs share: profiles in a few words, and optics written anew from the
//! literature (docs/theory.md, T5 and T17 to T20) on plain vectors and angles.

use super::{builds::parsed, panel, shipped};
use morion::internals::design::{Design, DesignError, design};
use morion::internals::geom::{DVec2, DVec3, Rect};
use morion::internals::num::quadrature::gauss_legendre;
use morion::internals::num::{asinh, atan, atan2, cos, exp, log, sin, sinh, tan};
use std::f64::consts::PI;

pub const ORTHOGRAPHIC: &str = "[camera.orthographic]\npixels = [640, 480]";

/// A pinhole so far from the mirror.
pub fn pinhole(distance_mm: f64) -> String {
    format!("[camera.pinhole]\npixels = [640, 480]\nfocal_px = 800\ndistance_mm = {distance_mm:?}")
}

/// A profile in a few words.
#[derive(Debug, Clone)]
pub struct Wish {
    pub camera: String,
    pub projection: String,
    pub layout: String,
    pub method: &'static str,
    pub degree: usize,
    pub width_mm: f64,
}

impl Wish {
    /// A strip of `law` (with the horizon in the middle of nothing in particular), orthographic.
    pub fn strip(law: &str, azimuth_deg: [f64; 2], elevation_deg: [f64; 2], degree: usize) -> Self {
        Self {
            camera: ORTHOGRAPHIC.into(),
            projection: format!(
                "[projection.{law}]\nazimuth_deg = {azimuth_deg:?}\nelevation_deg = \
                 {elevation_deg:?}"
            ),
            layout: "[layout.strip]".into(),
            method: "vector-field",
            degree,
            width_mm: 60.0,
        }
    }

    /// The full turn from -30 to 30 degrees.
    pub fn panoramic(law: &str, degree: usize) -> Self {
        Self::strip(law, [-180.0, 180.0], [-30.0, 30.0], degree)
    }

    /// The conquistador that fills its frame.
    pub fn conquistador(law: &str, degree: usize) -> Self {
        let layout =
            "[layout.conquistador]\npanel = \"refit\"\nridge = \"crest\"\nfill_frame = true";
        Self { layout: layout.into(), ..Self::panoramic(law, degree) }
    }

    /// A round mirror; with an inner rim if it has a width.
    pub fn round(camera: &str, projection: &str, inner_mm: f64, degree: usize) -> Self {
        let layout = if inner_mm > 0.0 {
            format!("[layout.annulus]\ninner_width_mm = {inner_mm:?}")
        } else {
            "[layout.disc]".into()
        };
        Self {
            camera: camera.into(),
            projection: projection.into(),
            layout,
            method: "vector-field",
            degree,
            width_mm: 60.0,
        }
    }

    /// The same before a target.
    pub fn before(mut self, target: &str) -> Self {
        self.projection = format!("{}\n{target}", self.projection);
        self
    }

    pub fn text(&self) -> String {
        let Self { camera, projection, layout, method, degree, width_mm } = self;
        format!(
            "{camera}\n{projection}\n{layout}\n[method.{method}]\ndegree = {degree}\n[part]\n\
             width_mm = {width_mm:?}\nbase_mm = {:?}\n[mesh]\nfacet_px = 1\n[export]\nformats = \
             [\"stl\"]\n",
            0.0625 * width_mm.max(0.02)
        )
    }

    pub fn design(&self) -> Result<Design, DesignError> {
        design(&parsed(&self.text()))
    }

    pub fn made(&self) -> Design {
        self.design().unwrap_or_else(|error| panic!("{error}\n{}", self.text()))
    }
}

/// The shipped round mirrors.
pub fn round() -> impl Iterator<Item = &'static str> {
    let names = morion::internals::profile::shipped().iter().map(|profile| profile.name);
    names.filter(|name| {
        matches!(
            shipped(name).projection,
            Some(morion::internals::profile::ProjectionSpec::Radial(_))
        )
    })
}

/// Points of a rectangle with the weights of a Gauss rule, sum 1.
pub fn gauss_grid(Rect { min, max }: Rect, n: usize) -> Vec<(DVec2, f64)> {
    let (nodes, weights) = gauss_legendre(n);
    let (mid, half) = (0.5 * (min + max), 0.5 * (max - min));
    let mut grid = Vec::with_capacity(n * n);
    for (v, b) in nodes.iter().zip(&weights) {
        for (u, a) in nodes.iter().zip(&weights) {
            grid.push((mid + half * DVec2::new(*u, *v), 0.25 * a * b));
        }
    }
    grid
}

/// The integral of `f` from `lo` to `hi`, by 8 panels of 24 Gauss nodes.
pub fn integral(lo: f64, hi: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (nodes, weights) = gauss_legendre(24);
    let half = (hi - lo) / 16.0;
    let mut sum = 0.0;
    for k in 0..8 {
        let mid = lo + half * f64::from(2 * k + 1);
        for (x, w) in nodes.iter().zip(&weights) {
            sum += w * half * f(mid + half * x);
        }
    }
    sum
}

/// What one camera ray meets and sees.
#[derive(Debug, Clone, Copy)]
pub struct Trace {
    pub at: DVec3,
    pub normal: DVec3,
    pub seen: DVec3,
}

/// The pinhole of a camera `distance_mm` from the reference plane; none for parallel rays.
pub fn eye(design: &Design, distance_mm: f64) -> Option<DVec3> {
    (distance_mm.is_finite()).then(|| DVec3::Z * (design.mirror.chart.plane_mm + distance_mm))
}

/// The camera's ray through image point `q`, reflected by the vector law at the mirror's normal.
pub fn trace(design: &Design, eye: Option<DVec3>, q: DVec2) -> Trace {
    let point = design.mirror.row(q.y).at(q.x);
    let at = design.mirror.position(q, &point);
    let normal = design.mirror.normal(q, &point).normalize();
    let ray = match eye {
        None => DVec3::NEG_Z,
        Some(eye) => (at - eye).normalize(),
    };
    Trace { at, normal, seen: ray - 2.0 * ray.dot(normal) * normal }
}

/// The direction at azimuth `a` and elevation `e` (radians): the part's X, Y, Z are the paper's
/// y, z, x.
pub fn direction(a: f64, e: f64) -> DVec3 {
    DVec3::new(cos(e) * sin(a), cos(e) * cos(a), sin(e))
}

pub fn rad(degrees: f64) -> f64 {
    degrees * (PI / 180.0)
}

/// Elevation of row z of a strip's law, and back (docs/theory.md, T17).
pub fn elevation(law: &str, z: f64) -> f64 {
    match law {
        "cylindrical" => atan(z),
        "mercator" => atan(sinh(z)),
        "equirectangular" => z,
        "equal-area" => morion::internals::num::asin(z),
        _ => panic!("{law}"),
    }
}

pub fn row_of(law: &str, elevation: f64) -> f64 {
    match law {
        "cylindrical" => tan(elevation),
        "mercator" => asinh(tan(elevation)),
        "equirectangular" => elevation,
        "equal-area" => sin(elevation),
        _ => panic!("{law}"),
    }
}

/// The (azimuth, z) of a strip's image point, radians and the paper's units.
pub struct Paper {
    pub scale_mm: f64,
    middle: DVec2,
    at_middle: DVec2,
}

impl Paper {
    /// Of the strip `width_mm` wide over the given angles.
    pub fn new(design: &Design, law: &str, azimuth_deg: [f64; 2], elevation_deg: [f64; 2]) -> Self {
        let Rect { min, max } = panel(design);
        let z = elevation_deg.map(|e| row_of(law, rad(e)));
        let span = rad(azimuth_deg[1] - azimuth_deg[0]);
        Self {
            scale_mm: (max.x - min.x) / span,
            middle: 0.5 * (min + max),
            at_middle: DVec2::new(
                rad(0.5 * (azimuth_deg[0] + azimuth_deg[1])),
                0.5 * (z[0] + z[1]),
            ),
        }
    }

    pub fn of(&self, q: DVec2) -> DVec2 {
        self.at_middle + (q - self.middle) / self.scale_mm
    }

    /// The direction that `q` must see.
    pub fn wanted(&self, law: &str, q: DVec2) -> DVec3 {
        let p = self.of(q);
        direction(p.x, elevation(law, p.y))
    }
}

/// The angle whose cosine is `x`.
pub fn acos(x: f64) -> f64 {
    atan2(((1.0 - x) * (1.0 + x)).max(0.0).sqrt(), x)
}

/// The angle between a direction and the axis towards the camera.
pub fn polar(d: DVec3) -> f64 {
    atan2(d.truncate().length(), d.z)
}

/// The angle between two unit vectors.
pub fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * morion::internals::num::asin((0.5 * (a - b).length()).min(1.0))
}

/// The slope of log y against log x by least squares.
pub fn order(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (log(*x), log(*y))).collect();
    let mean = logs.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let sum = |f: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>();
    sum(&|p| (p.0 - mean.0) * (p.1 - mean.1)) / sum(&|p| (p.0 - mean.0) * (p.0 - mean.0))
}

/// E = exp(-asinh z) of the paper's law.
pub fn shrink(z: f64) -> f64 {
    exp(-asinh(z))
}

/// A strip as its profile says, by definitions alone.
#[derive(Debug, Clone, Copy)]
pub struct Strip<'a> {
    pub law: &'a str,
    pub azimuth_deg: [f64; 2],
    pub elevation_deg: [f64; 2],
    /// Infinite for parallel rays.
    pub distance: f64,
    pub target: World,
}

/// Where the world is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum World {
    Far,
    Cylinder(f64),
    Plane(f64),
}

impl World {
    /// The key of a profile.
    pub fn key(self) -> String {
        match self {
            Self::Far => String::new(),
            Self::Cylinder(radius) => format!("target_radius_mm = {radius:?}"),
            Self::Plane(height) => format!("target_plane_mm = {height:?}"),
        }
    }

    /// The world's point in direction `d` from the origin.
    pub fn point(self, d: DVec3) -> DVec3 {
        match self {
            Self::Far => d * 1e300,
            Self::Cylinder(radius) => d * (radius / d.truncate().length()),
            Self::Plane(height) => d * (height / d.z),
        }
    }

    /// Where the ray from `at` along `d` meets the world, both from the origin.
    pub fn hit(self, at: DVec3, d: DVec3) -> DVec3 {
        match self {
            Self::Far => d,
            Self::Cylinder(radius) => {
                let (p, u) = (at.truncate(), d.truncate());
                let (a, b, c) = (u.dot(u), p.dot(u), p.dot(p) - radius * radius);
                at + d * ((-b + (b * b - a * c).sqrt()) / a)
            }
            Self::Plane(height) => at + d * ((height - at.z) / d.z),
        }
    }
}

/// Errors of a strip: root mean square by a Gauss rule, largest over a grid with the rim.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    pub ray_mrad: [f64; 2],
    pub pixel_px: [f64; 2],
}

impl Strip<'_> {
    pub fn wish(&self, degree: usize) -> Wish {
        let camera = match self.distance.is_finite() {
            true => pinhole(self.distance),
            false => ORTHOGRAPHIC.into(),
        };
        let wish = Wish::strip(self.law, self.azimuth_deg, self.elevation_deg, degree);
        Wish { camera, ..wish }.before(&self.target.key())
    }

    /// The direction that image point `q` must see from the mirror's point `at`.
    pub fn wanted(&self, design: &Design, paper: &Paper, q: DVec2, at: DVec3) -> DVec3 {
        let origin = DVec3::Z * design.view.as_ref().unwrap().origin_mm;
        match self.target {
            World::Far => paper.wanted(self.law, q),
            world => (world.point(paper.wanted(self.law, q)) - (at - origin)).normalize(),
        }
    }

    /// Ray error (rad) and image displacement (mm) at image point `q`.
    pub fn error(&self, design: &Design, paper: &Paper, q: DVec2) -> [f64; 2] {
        let Trace { at, seen, .. } = trace(design, eye(design, self.distance), q);
        let origin = DVec3::Z * design.view.as_ref().unwrap().origin_mm;
        let wanted = self.wanted(design, paper, q, at);
        let shown = self.target.hit(at - origin, seen);
        let place = DVec2::new(
            atan2(shown.x, shown.y),
            row_of(self.law, atan2(shown.z, shown.truncate().length())),
        );
        let mut off = place - paper.of(q);
        off.x -= 2.0 * PI * (off.x / (2.0 * PI)).round();
        [angle(seen, wanted), off.length() * paper.scale_mm]
    }

    pub fn paper(&self, design: &Design) -> Paper {
        Paper::new(design, self.law, self.azimuth_deg, self.elevation_deg)
    }

    pub fn errors(&self, design: &Design, n: usize) -> Errors {
        let (paper, area) = (self.paper(design), panel(design));
        let (mut square, mut max) = ([0.0; 2], [0.0f64; 2]);
        for (q, weight) in gauss_grid(area, n) {
            let error = self.error(design, &paper, q);
            (0..2).for_each(|k| square[k] += weight * error[k] * error[k]);
        }
        // Even steps in the middle, finer ones towards the rim.
        for k in 0..(n + 1) * (n + 1) {
            let even = DVec2::new((k % (n + 1)) as f64, (k / (n + 1)) as f64) / n as f64;
            for part in [even, DVec2::from_array(even.to_array().map(|t| 0.5 - 0.5 * cos(PI * t)))]
            {
                let error = self.error(design, &paper, area.min + area.size() * part);
                (0..2).for_each(|k| max[k] = max[k].max(error[k]));
            }
        }
        let px = 1.0 / design.camera.pixel_mm;
        let both = |k: usize, unit: f64| [square[k].sqrt() * unit, max[k] * unit];
        Errors { ray_mrad: both(0, 1e3), pixel_px: both(1, px) }
    }
}
