//! Solids of revolution, and the intersection of a ray with them.

use glam::DMat3;

use crate::geom::{DVec2, DVec3, Ray};

/// Segments of the smooth curve between two of a run's points.
const SEGMENTS: usize = 4;
/// Share of a band's height by which bands overlap, lest rays slip between two of them.
const OVERLAP: f64 = 1e-9;
/// Share of its terms by which a discriminant may be negative.
const GRAZE: f64 = 1e-14;

/// The generatrix of a solid of revolution, from its foot to its top: runs of points (radius, height). A run is
/// a smooth curve through its points; between runs there are edges.
pub(super) type Generatrix = Vec<Vec<[f64; 2]>>;

/// The side of a solid of revolution between two heights: a cone, a cylinder or a flat ring.
#[derive(Debug, Clone, Copy)]
struct Frustum {
    /// Radius and height at the lower end.
    from: DVec2,
    /// At the upper end.
    to: DVec2,
    /// Outward normals (radial, axial) at both ends.
    normals: [DVec2; 2],
}

/// A solid of revolution about any axis.
#[derive(Debug, Clone)]
pub(super) struct SolidOfRevolution {
    foot: DVec3,
    /// Two vectors across the axis, and the axis.
    frame: DMat3,
    bands: Vec<Frustum>,
    /// Largest radius.
    radius: f64,
}

/// Intersection of a ray with a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SurfaceHit {
    /// Distance along the ray.
    pub t: f64,
    /// The surface's outward unit normal.
    pub normal: DVec3,
}

impl SolidOfRevolution {
    /// Turns `outline` about the line from `foot` along the unit vector `axis`.
    #[must_use]
    pub(super) fn new(foot: DVec3, axis: DVec3, outline: &Generatrix) -> Self {
        let across = axis.any_orthonormal_vector();
        let frame = DMat3::from_cols(across, axis.cross(across), axis);
        let bands: Vec<Frustum> = outline.iter().flat_map(|run| bands(run)).collect();
        let radius = bands.iter().map(|band| band.from.x.max(band.to.x)).fold(0.0, f64::max);
        Self { foot, frame, bands, radius }
    }

    /// A sphere around it: centre and radius.
    #[must_use]
    pub(super) fn bounding_sphere(&self) -> (DVec3, f64) {
        let heights = self.bands.iter().flat_map(|band| [band.from.y, band.to.y]);
        let [lo, hi] =
            heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], h| [lo.min(h), hi.max(h)]);
        let centre = self.foot + self.frame.z_axis * (0.5 * (lo + hi));
        (centre, DVec2::new(self.radius, 0.5 * (hi - lo)).length())
    }

    /// The first place ahead of the ray's origin, nearer than `within`, where it meets the surface.
    #[must_use]
    pub(super) fn intersect(&self, ray: &Ray, within: f64) -> Option<SurfaceHit> {
        let turn = self.frame.transpose();
        let (o, d) = (turn * (ray.origin - self.foot), turn * ray.direction);
        let across = d.truncate().length_squared();
        let along = o.truncate().dot(d.truncate());
        let away = o.truncate().length_squared();
        let beyond = away - self.radius * self.radius;
        if along * along < across * beyond || (across == 0.0 && beyond > 0.0) {
            return None;
        }
        let mut nearest: Option<(f64, DVec2)> = None;
        for band in &self.bands {
            let end = nearest.map_or(within, |(t, _)| t);
            let found = band.intersect(o.z, d.z, [across, along, away], end);
            nearest = found.or(nearest);
        }
        let (t, normal) = nearest?;
        let place = (o + d * t).truncate().normalize_or(DVec2::X);
        let normal = self.frame * (place * normal.x).extend(normal.y);
        Some(SurfaceHit { t, normal: normal.normalize() })
    }
}

impl Frustum {
    /// Distance and normal (radial, axial) of the first contact ahead and before `end` of a ray of axial
    /// place `z` and direction `dz`; `[a, b, c]`: its square distance from the axis is
    /// a t^2 + 2 b t + c.
    #[inline]
    fn intersect(&self, z: f64, dz: f64, [a, b, c]: [f64; 3], end: f64) -> Option<(f64, DVec2)> {
        let way = self.to - self.from;
        if way.y == 0.0 {
            let t = (self.from.y - z) / dz;
            let radius = (a * t * t + 2.0 * b * t + c).max(0.0).sqrt();
            let share = (radius - self.from.x) / way.x;
            let inside = t > 0.0 && t < end && (-OVERLAP..=1.0 + OVERLAP).contains(&share);
            return inside.then(|| (t, self.normals[0].lerp(self.normals[1], share)));
        }
        // Where the square distance from the axis is that of the cone's side.
        let slope = way.x / way.y;
        let (m, n) = (self.from.x + slope * (z - self.from.y), slope * dz);
        let (a, b, c) = (a - n * n, b - m * n, c - m * m);
        let root = b * b - a * c;
        // A ray along the axis grazes every cone's tip; rounding must not let it through.
        if root < -GRAZE * b * b {
            return None;
        }
        let q = -b - root.max(0.0).sqrt().copysign(b);
        let (first, second) = (q / a, c / q);
        let share = |t: f64| (z + dz * t - self.from.y) / way.y;
        let inside =
            |t: &f64| *t > 0.0 && *t < end && (-OVERLAP..=1.0 + OVERLAP).contains(&share(*t));
        let t = [first, second].into_iter().filter(inside).min_by(f64::total_cmp)?;
        Some((t, self.normals[0].lerp(self.normals[1], share(t))))
    }
}

/// The bands of one run, with one normal at each point between two of them.
fn bands(run: &[[f64; 2]]) -> Vec<Frustum> {
    let points: Vec<DVec2> = run.iter().copied().map(DVec2::from_array).collect();
    let points = if points.len() > 2 { curve(&points) } else { points };
    // The outside is on the right hand of who climbs.
    let normal = |from: DVec2, to: DVec2| -(to - from).normalize().perp();
    let sides: Vec<DVec2> = points.windows(2).map(|p| normal(p[0], p[1])).collect();
    let at = |k: usize| match k {
        0 => sides[0],
        _ if k == sides.len() => sides[k - 1],
        _ => (sides[k - 1] + sides[k]).normalize(),
    };
    let band =
        |(k, p): (usize, &[DVec2])| Frustum { from: p[0], to: p[1], normals: [at(k), at(k + 1)] };
    points.windows(2).enumerate().map(band).collect()
}

/// Points on Catmull and Rom's curve through `points`; radii below 0 are 0. It crosses the axis
/// level, and ends as a parabola elsewhere.
fn curve(points: &[DVec2]) -> Vec<DVec2> {
    let last = points.len() - 1;
    let beyond = |end: DVec2, next: DVec2, third: DVec2| match end.x {
        0.0 => DVec2::new(-next.x, next.y),
        _ => 3.0 * (end - next) + third,
    };
    let mut out = vec![points[0]];
    for k in 0..last {
        let (p1, p2) = (points[k], points[k + 1]);
        let p0 = if k > 0 { points[k - 1] } else { beyond(p1, p2, points[2]) };
        let p3 = if k + 1 < last { points[k + 2] } else { beyond(p2, p1, points[k - 1]) };
        for step in 1..=SEGMENTS {
            let t = step as f64 / SEGMENTS as f64;
            let bend =
                (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t + (3.0 * (p1 - p2) + p3 - p0) * (t * t);
            let point = p1 + 0.5 * t * ((p2 - p0) + bend);
            out.push(if step == SEGMENTS { p2 } else { point.max(DVec2::new(0.0, f64::MIN)) });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;

    fn ray(from: DVec3, to: DVec3) -> Ray {
        Ray { origin: from, direction: (to - from).normalize() }
    }

    fn draw(draws: &mut Draws) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| draws.inside([-1.0, 1.0])))
    }

    #[test]
    fn a_cone_is_met_where_its_equation_says() {
        let axis = DVec3::new(0.48, -0.6, 0.64);
        let foot = DVec3::new(3.0, 1.0, -2.0);
        let cone = SolidOfRevolution::new(foot, axis, &vec![vec![[2.0, 0.0], [0.5, 3.0]]]);
        let mut draws = Draws::new(1);
        let mut hits = 0;
        for _ in 0..4000 {
            let ray = ray(foot + 9.0 * draw(&mut draws), foot + axis + 3.0 * draw(&mut draws));
            let off = |t: f64| {
                let p = ray.at(t) - foot;
                let h = p.dot(axis);
                ((p - axis * h).length() - (2.0 - 0.5 * h), h)
            };
            let found = cone.intersect(&ray, f64::INFINITY);
            // By small steps.
            let change = |k: &i32| {
                let [(a, h), (b, g)] = [*k, *k + 1].map(|k| off(f64::from(k) * 0.01));
                a * b < 0.0 && [h, g].iter().all(|h| (0.0..=3.0).contains(h))
            };
            let stepped = (0..3000).find(change);
            if let (Some(k), None) = (stepped, &found) {
                panic!("{ray:?} is met at {k}");
            }
            let Some(SurfaceHit { t, normal }) = found else { continue };
            hits += 1;
            let (off, height) = off(t);
            assert!(off.abs() < 1e-12 && (-1e-8..3.0 + 1e-8).contains(&height), "{off} {height}");
            assert!((normal.dot(axis) - 0.5 / 1.25_f64.sqrt()).abs() < 1e-12);
            if let Some(k) = stepped {
                assert!(t <= f64::from(k + 1) * 0.01 + 1e-9, "{t} {k}");
            }
        }
        assert!(hits > 1000, "{hits}");
    }

    #[test]
    fn a_closed_outline_lets_no_ray_through() {
        let egg = vec![
            vec![[0.0, 0.0], [1.0, 0.0]],
            vec![[1.0, 0.0], [1.3, 0.8], [0.7, 1.6], [0.9, 2.2]],
            vec![[0.9, 2.2], [0.4, 2.2]],
            vec![[0.4, 2.2], [0.3, 2.5], [0.0, 2.6]],
        ];
        let solid = SolidOfRevolution::new(DVec3::ZERO, DVec3::Z, &egg);
        let (centre, radius) = solid.bounding_sphere();
        let mut draws = Draws::new(2);
        for _ in 0..20_000 {
            let way = draw(&mut draws).normalize();
            // Through a point inside: in at the front, out at the back.
            let inside = DVec3::new(0.0, 0.0, draws.inside([0.1, 2.4]));
            let from = inside - 20.0 * way;
            let entry = solid.intersect(&ray(from, inside), f64::INFINITY).expect("a hole");
            let exit = solid.intersect(&ray(inside, inside + way), f64::INFINITY).expect("a hole");
            assert!(entry.t < 20.0 && entry.normal.length() - 1.0 < 1e-12);
            for p in [from + way * entry.t, inside + way * exit.t] {
                assert!((p - centre).length() <= radius * (1.0 + 1e-12), "{p}");
            }
        }
    }

    #[test]
    fn a_smooth_run_has_a_spheres_normals() {
        let arc = |k: i32| {
            let a = crate::num::radians(f64::from(k) * 15.0 - 90.0);
            [2.0 * crate::num::cos(a).max(0.0), 5.0 + 2.0 * crate::num::sin(a)]
        };
        let ball =
            SolidOfRevolution::new(DVec3::ZERO, DVec3::Z, &vec![(0..=12).map(arc).collect()]);
        let centre = DVec3::new(0.0, 0.0, 5.0);
        let mut draws = Draws::new(3);
        for _ in 0..2000 {
            let ray = ray(20.0 * draw(&mut draws).normalize(), centre + draw(&mut draws));
            let SurfaceHit { t, normal } = ball.intersect(&ray, f64::INFINITY).unwrap();
            let exact = ray.at(t) - centre;
            assert!((exact.length() - 2.0).abs() < 0.004, "{}", exact.length());
            assert!(normal.angle_between(exact) < 0.05, "{}", normal.angle_between(exact));
        }
    }

    #[test]
    fn nothing_beyond_the_end_or_behind_the_origin_is_met() {
        let rod =
            SolidOfRevolution::new(DVec3::ZERO, DVec3::Z, &vec![vec![[1.0, 0.0], [1.0, 4.0]]]);
        let from = DVec3::new(5.0, 0.0, 2.0);
        assert_eq!(
            rod.intersect(&ray(from, DVec3::new(0.0, 0.0, 2.0)), 9.0).map(|c| c.t),
            Some(4.0)
        );
        assert_eq!(rod.intersect(&ray(from, DVec3::new(0.0, 0.0, 2.0)), 3.9), None);
        assert_eq!(rod.intersect(&ray(from, DVec3::new(9.0, 0.0, 2.0)), 9.0), None);
    }
}
