//! How far a mirror is from a sphere and from a plane: what a shop judges its making by.

use super::Mirror;
use crate::geom::{DVec2, DVec3, Outline, angle};
use crate::num::least_squares::solve;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// The sphere and the plane nearest to a mirror, and how far off they are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Form {
    /// The sphere.
    pub sphere: BestFitSphere,
    /// The plane.
    pub plane: BestFitPlane,
}

/// A sphere that fits best: the squared distances from it sum to the least.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BestFitSphere {
    /// Radius of curvature, mm, with the sign of a sag's formula, as of the profile's conics: positive
    /// where the centre lies on the camera's side (a hollow mirror), negative for a dome; none where
    /// the mirror is flat.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_of_curvature_mm: Option<f64>,
    /// The same with the other sign, mm: an older key, which readers of reports know.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Centre, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre_mm: Option<[f64; 3]>,
    /// How far off.
    #[serde(flatten)]
    pub departure: Departure,
}

/// A plane Z = a + b X + c Y that fits best: the squared distances along Z sum to the least.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BestFitPlane {
    /// Z on the axis, mm.
    pub height_mm: f64,
    /// Slopes dZ/dX and dZ/dY.
    pub slope: [f64; 2],
    /// How far off.
    #[serde(flatten)]
    pub departure: Departure,
}

/// How far a mirror is from a surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Departure {
    /// From the lowest to the highest place, along Z, mm; none where the mirror is wider than the
    /// sphere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sag_pv_mm: Option<f64>,
    /// The same square to the surface, mm.
    pub pv_mm: f64,
    /// Largest distance square to the surface, mm.
    pub largest_mm: f64,
    /// Largest angle between both normals, mrad.
    pub normal_max_mrad: f64,
}

/// A place of a mirror.
struct Sample {
    at: DVec3,
    normal: DVec3,
    weight: f64,
}

/// Samples along each axis of a rectangle's panel, and along the radii of a round one.
const STEPS: usize = 96;
const STEPS_ROUND: usize = 192;
/// Most steps of Newton's method.
const MOST_STEPS: usize = 60;
/// A radius of so many times the mirror's size is flat.
const FLAT: f64 = 1e9;

impl Form {
    /// The form of all panels of `mirror`, from samples weighted by the area of its image.
    #[must_use]
    pub fn of(mirror: &Mirror) -> Self {
        let samples = samples(mirror);
        let weight: f64 = samples.iter().map(|s| s.weight).sum();
        let middle = samples.iter().map(|s| s.at * s.weight).sum::<DVec3>() / weight;
        let plane = plane(&samples, middle);
        let size = mirror.full_outline().bounds().size().max_element();
        Self { sphere: sphere(&samples, middle, &plane, size), plane }
    }
}

fn samples(mirror: &Mirror) -> Vec<Sample> {
    let steps = match mirror.outline {
        Outline::Rect(_) => STEPS,
        Outline::Ring { .. } => STEPS_ROUND,
    };
    let line = |line: Vec<(DVec2, f64)>| {
        let places: Vec<DVec2> = line.iter().map(|(q, _)| *q).collect();
        let points = mirror.eval_many(&places);
        line.into_iter().zip(points).map(|((q, weight), point)| Sample {
            at: mirror.position(q, &point),
            normal: mirror.normal(q, &point).normalize(),
            weight,
        })
    };
    let flip = DVec3::new(1.0, -1.0, 1.0);
    let lines = mirror.outline.samples(steps).into_iter();
    let mut samples: Vec<Sample> =
        lines.flat_map(|samples| line(samples).collect::<Vec<_>>()).collect();
    if mirror.folded {
        let image =
            |s: &Sample| Sample { at: s.at * flip, normal: s.normal * flip, weight: s.weight };
        let images: Vec<Sample> = samples.iter().map(image).collect();
        samples.extend(images);
    }
    samples
}

fn plane(samples: &[Sample], middle: DVec3) -> BestFitPlane {
    let root = |k: usize| samples[k].weight.sqrt();
    let from = |k: usize| samples[k].at - middle;
    let a = DMatrix::from_fn(samples.len(), 3, |k, j| root(k) * [1.0, from(k).x, from(k).y][j]);
    let b = DVector::from_fn(samples.len(), |k, _| root(k) * from(k).z);
    // The samples span an area.
    let x = solve(a, b).map_or_else(|_| vec![0.0; 3], |solution| solution.x);
    let slope = [x[1], x[2]];
    let height_mm = middle.z + x[0] - x[1] * middle.x - x[2] * middle.y;
    let normal = DVec3::new(-x[1], -x[2], 1.0);
    let up = |p: DVec3| p.z - height_mm - slope[0] * p.x - slope[1] * p.y;
    let departure = departure(samples, |p| (Some(up(p)), up(p) / normal.length(), normal));
    BestFitPlane { height_mm, slope, departure }
}

/// Figures over all samples of `of`: height over the surface along Z, distance from it, and its
/// normal there.
fn departure(samples: &[Sample], of: impl Fn(DVec3) -> (Option<f64>, f64, DVec3)) -> Departure {
    let all: Vec<_> = samples.iter().map(|sample| (of(sample.at), sample.normal)).collect();
    let pv = |heights: &mut dyn Iterator<Item = f64>| {
        let [lo, hi] = heights.fold([f64::MAX, f64::MIN], |[lo, hi], up| [lo.min(up), hi.max(up)]);
        hi - lo
    };
    let along_z: Option<Vec<f64>> = all.iter().map(|((up, ..), _)| *up).collect();
    let distances = || all.iter().map(|((_, distance, _), _)| *distance);
    let turns = all.iter().map(|((.., normal), own)| angle(normal.normalize(), *own));
    Departure {
        sag_pv_mm: along_z.map(|heights| pv(&mut heights.into_iter())),
        pv_mm: pv(&mut distances()),
        largest_mm: distances().map(f64::abs).fold(0.0, f64::max),
        normal_max_mrad: 1e3 * turns.fold(0.0, f64::max),
    }
}

/// The sphere, or the plane if its curvature k is 0, where k |p|^2 / 2 + n . p + d = 0 and
/// |n|^2 - 2 k d = 1, with p from the middle of the mirror.
#[derive(Clone, Copy)]
struct Ball {
    k: f64,
    n: [f64; 2],
    d: f64,
}

impl Ball {
    /// n with its component along Z; none where there is no such surface.
    fn normal(&self) -> Option<DVec3> {
        let [x, y] = self.n;
        let square = 1.0 + 2.0 * self.k * self.d - x * x - y * y;
        (square > 0.0).then(|| DVec3::new(x, y, square.sqrt()))
    }

    /// Signed distance of `p`, with the gradient of the surface's equation there.
    fn distance(&self, n: DVec3, p: DVec3) -> (f64, DVec3) {
        let value = 0.5 * self.k * p.length_squared() + n.dot(p) + self.d;
        let gradient = p * self.k + n;
        (2.0 * value / (1.0 + gradient.length()), gradient)
    }

    fn off(&self, samples: &[Sample], middle: DVec3) -> Option<f64> {
        let n = self.normal()?;
        let square = |s: &Sample| {
            let (distance, _) = self.distance(n, s.at - middle);
            s.weight * distance * distance
        };
        Some(samples.iter().map(square).sum())
    }

    /// Gauss and Newton's step.
    fn step(&self, samples: &[Sample], middle: DVec3) -> Option<[f64; 4]> {
        let n = self.normal()?;
        let row = |s: &Sample| {
            let p = s.at - middle;
            let (distance, gradient) = self.distance(n, p);
            let length = gradient.length();
            let root = s.weight.sqrt();
            // |gradient|^2 = 1 + 2 k value, and distance = 2 value / (1 + |gradient|).
            let by_value = 1.0 / length;
            let by_k = -0.5 * distance * distance / length;
            let lean = p.z / n.z;
            [
                by_k + by_value * (0.5 * p.length_squared() + self.d * lean),
                by_value * (p.x - n.x * lean),
                by_value * (p.y - n.y * lean),
                by_value * (1.0 + self.k * lean),
                -distance,
            ]
            .map(|x| root * x)
        };
        let rows: Vec<[f64; 5]> = samples.iter().map(row).collect();
        let a = DMatrix::from_fn(rows.len(), 4, |k, j| rows[k][j]);
        let b = DVector::from_fn(rows.len(), |k, _| rows[k][4]);
        solve(a, b).ok().and_then(|solution| <[f64; 4]>::try_from(solution.x).ok())
    }

    fn moved(&self, [k, x, y, d]: [f64; 4], share: f64) -> Self {
        Self {
            k: self.k + share * k,
            n: [self.n[0] + share * x, self.n[1] + share * y],
            d: self.d + share * d,
        }
    }
}

fn sphere(samples: &[Sample], middle: DVec3, plane: &BestFitPlane, size: f64) -> BestFitSphere {
    let [b, c] = plane.slope;
    let normal = DVec3::new(-b, -c, 1.0).normalize();
    let offset = plane.height_mm + b * middle.x + c * middle.y - middle.z;
    let mut ball = Ball { k: 0.0, n: [normal.x, normal.y], d: -offset * normal.z };
    let mut off = ball.off(samples, middle).unwrap_or(f64::INFINITY);
    for _ in 0..MOST_STEPS {
        let Some(step) = ball.step(samples, middle) else { break };
        let shares = (0..30).map(|k| 1.0 / f64::from(1 << k));
        let mut tries = shares.filter_map(|share| {
            let moved = ball.moved(step, share);
            moved.off(samples, middle).filter(|&less| less < off).map(|less| (moved, less))
        });
        let Some((moved, less)) = tries.next() else { break };
        (ball, off) = (moved, less);
    }
    let n = ball.normal().unwrap_or(normal);
    let flat = ball.k.abs() * FLAT * size < 1.0;
    let (radius_mm, centre) =
        if flat { (None, None) } else { (Some(1.0 / ball.k), Some(middle - n / ball.k)) };
    let departure = departure(samples, |p| {
        let (distance, gradient) = ball.distance(n, p - middle);
        (ball.up(n, p - middle), distance, gradient)
    });
    BestFitSphere {
        radius_of_curvature_mm: radius_mm.map(|bulging| -bulging),
        radius_mm,
        centre_mm: centre.map(|centre| centre.to_array()),
        departure,
    }
}

impl Ball {
    /// Height of `p` over the surface along Z, where it has a place there: the root u of
    /// k u^2 / 2 - g u + value = 0, g the gradient's part along Z, that is nearest.
    fn up(&self, n: DVec3, p: DVec3) -> Option<f64> {
        let value = 0.5 * self.k * p.length_squared() + n.dot(p) + self.d;
        let along = self.k * p.z + n.z;
        let square = along * along - 2.0 * self.k * value;
        (square >= 0.0 && along > 0.0).then(|| 2.0 * value / (along + square.sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Chart, Rect};
    use crate::mirror::{RadialLegendre, Surface, TensorLegendre};
    use crate::num::legendre::Series;

    /// Z = 7 + sag(r^2) on a disc, by a series of so many terms.
    fn disc(terms: usize, radius: f64, sag: impl Fn(f64) -> f64) -> Mirror {
        let (nodes, weights) = crate::num::quadrature::gauss_legendre(64);
        let square = |u: f64| 0.5 * radius * radius * (u + 1.0);
        let term = |i: usize| {
            let sum = |(u, w): (&f64, &f64)| {
                w * sag(square(*u)) * crate::num::legendre::values(terms, *u)[i]
            };
            let scale = 0.5 * (2 * i + 1) as f64;
            scale * nodes.iter().zip(&weights).map(sum).sum::<f64>()
        };
        let series = Series::from_fn(terms, 1, |i, _| term(i));
        Mirror {
            surface: Surface::Radial(RadialLegendre::new(series, [0.0, radius], 1.0)),
            chart: Chart::on_axis(0.0, 7.0),
            outline: Outline::Ring { inner: 0.0, outer: radius },
            folded: false,
            mirror_symmetric: [true; 2],
        }
    }

    #[test]
    fn a_sphere_has_no_departure_from_its_sphere() {
        for (radius, bulge) in [(25.0, -1.0), (25.0, 1.0), (1e4, -1.0), (20.5, -1.0)] {
            let sag = |r2: f64| bulge * r2 / (radius + f64::sqrt(radius * radius - r2));
            let sphere = Form::of(&disc(40, 20.0, sag)).sphere;
            let BestFitSphere { radius_of_curvature_mm, radius_mm, centre_mm, departure } = sphere;
            let found = radius_of_curvature_mm.unwrap();
            assert_eq!(radius_mm, Some(-found));
            // The steepest is known no better than its series.
            let off = if radius < 21.0 { 1e-3 } else { 1e-9 };
            assert!((found / (bulge * radius) - 1.0).abs() < off, "{found} for {radius}");
            let centre = DVec3::from_array(centre_mm.unwrap());
            let exact = DVec3::new(0.0, 0.0, 7.0 + bulge * radius);
            assert!((centre - exact).length() < off * radius, "{centre} {exact}");
            assert!(departure.largest_mm < off && departure.sag_pv_mm.unwrap() < 30.0 * off);
            if off < 1e-6 {
                assert!(departure.normal_max_mrad < 1e-6, "{}", departure.normal_max_mrad);
            }
        }
    }

    /// A paraboloid lacks the term r^4 / 8R^3 of the sphere's series. The best sphere makes up for
    /// what a + b r^2 can of it, which leaves, with t = r^2 / rim^2 uniform on the disc, the shifted
    /// Legendre polynomial t^2 - t + 1/6, from 1/6 down to -1/12.
    #[test]
    fn a_shallow_paraboloid_departs_by_the_spheres_next_term() {
        for radius in [400.0, 800.0] {
            let rim = 10.0;
            let form = Form::of(&disc(2, rim, |r2| -r2 / (2.0 * radius)));
            let next = rim * rim * rim * rim / (8.0 * radius * radius * radius);
            let pv = form.sphere.departure.sag_pv_mm.unwrap();
            let small = (rim / radius) * (rim / radius);
            assert!((pv / (0.25 * next) - 1.0).abs() < 3.0 * small, "{pv} {next}");
            let square = form.sphere.departure.pv_mm;
            assert!((square / pv - 1.0).abs() < small, "{pv} {square}");
            let largest = form.sphere.departure.largest_mm;
            assert!((largest / (next / 6.0) - 1.0).abs() < 3.0 * small, "{largest} {next}");
            // The slope's departure is 2 r (2 t - 1) next / rim^2, at the rim 2 next / rim.
            let turn = form.sphere.departure.normal_max_mrad * 1e-3;
            assert!((turn / (2.0 * next / rim) - 1.0).abs() < 3.0 * small, "{turn}");
            // From the plane it departs by its whole sag.
            let sag = rim * rim / (2.0 * radius);
            let plane = form.plane;
            assert!((plane.departure.sag_pv_mm.unwrap() / sag - 1.0).abs() < 1e-12);
            assert!((plane.height_mm - 7.0 + 0.5 * sag).abs() < 1e-12);
            let steepest = 1e3 * crate::num::atan(rim / radius);
            assert!((plane.departure.normal_max_mrad / steepest - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_tilted_plane_is_flat() {
        let series = Series::from_fn(2, 2, |i, j| [[1.0, -2.0], [3.0, 0.0]][i][j]);
        let (centre, half) = (DVec2::new(3.0, -2.0), DVec2::new(4.0, 5.0));
        let mirror = Mirror {
            surface: Surface::Tensor(TensorLegendre { series, centre, half, scale_mm: 1.0 }),
            chart: Chart::on_axis(0.0, 10.0),
            outline: Outline::Rect(Rect { min: centre - half, max: centre + half }),
            folded: false,
            mirror_symmetric: [false; 2],
        };
        let Form { sphere, plane } = Form::of(&mirror);
        assert!((plane.slope[0] - 0.75).abs() < 1e-14 && (plane.slope[1] + 0.4).abs() < 1e-14);
        assert!((plane.height_mm - (11.0 - 0.75 * 3.0 - 0.4 * 2.0)).abs() < 1e-12);
        for Departure { sag_pv_mm, pv_mm, largest_mm, normal_max_mrad } in
            [plane.departure, sphere.departure]
        {
            assert!(
                pv_mm < 1e-12
                    && sag_pv_mm.unwrap() < 1e-12
                    && largest_mm < 1e-12
                    && normal_max_mrad < 1e-9
            );
        }
    }

    #[test]
    fn a_mirror_wider_than_its_sphere_has_no_sag_on_it() {
        // A cone of 60 degrees, as a ring about the axis.
        let series = Series::from_fn(2, 1, |i, _| [0.0, -7.0][i]);
        let surface = Surface::Radial(RadialLegendre::new(series, [2.0, 10.0], 1.0));
        let chart = Chart::on_axis(0.0, 20.0);
        let outline = Outline::Ring { inner: 2.0, outer: 10.0 };
        let mirror = Mirror { surface, chart, outline, folded: false, mirror_symmetric: [true; 2] };
        let Departure { sag_pv_mm, pv_mm, largest_mm, .. } = Form::of(&mirror).sphere.departure;
        assert!(sag_pv_mm.is_none() && pv_mm > largest_mm && largest_mm > 0.1);
    }

    #[test]
    fn a_roof_counts_both_its_panels() {
        // Z = 10 - |Y| over [-4, 4] x [-3, 3]: the plane is Z = 8.5, 45 degrees off.
        let series = Series::from_fn(1, 2, |_, j| [-1.5, -1.5][j]);
        let (centre, half) = (DVec2::new(0.0, 1.5), DVec2::new(4.0, 1.5));
        let mirror = Mirror {
            surface: Surface::Tensor(TensorLegendre { series, centre, half, scale_mm: 1.0 }),
            chart: Chart::on_axis(0.0, 10.0),
            outline: Outline::Rect(Rect { min: centre - half, max: centre + half }),
            folded: true,
            mirror_symmetric: [true, false],
        };
        let plane = Form::of(&mirror).plane;
        assert!((plane.height_mm - 8.5).abs() < 1e-12 && plane.slope[1].abs() < 1e-14);
        assert!((plane.departure.sag_pv_mm.unwrap() - 3.0).abs() < 1e-12);
        let eighth = 1e3 * std::f64::consts::FRAC_PI_4;
        assert!((plane.departure.normal_max_mrad - eighth).abs() < 1e-9);
    }
}
