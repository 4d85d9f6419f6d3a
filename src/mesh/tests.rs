//! Whole meshes of every kind of mirror, sampled against their proven bounds by independent code.

use super::mesher::{Mesher, SmoothPanels};
use super::refine::probe::{ProbeOutcome, RefinementProbe};
use super::{ErrorBound, ErrorBounder, Face, Limits, MeshError, SurfaceVertex, mesh};
use crate::geom::{Chart, DVec2, DVec3, Outline, Precision, Rect, turn};
use crate::mirror::{Mirror, RadialLegendre, Surface, TensorLegendre};
use crate::num::legendre::{Series, values};
use crate::num::quadrature::gauss_legendre;
use crate::num::sample::Draws;
use crate::num::{atan2, cos, exp, log, radians, sin};
use crate::optics::{
    ImagingTask, PictureMap, Projection, RadialLaw, RadialLawKind, RimConditions, Strip, StripLaw,
    Target,
};
use std::collections::{HashMap, HashSet};

const PARALLEL: Chart = Chart::on_axis(0.0, 20.0);
const PINHOLE: Chart = Chart::on_axis(0.008, 20.0);

/// Legendre coefficients of a function of (u, v).
fn series(shape: [usize; 2], f: impl Fn(f64, f64) -> f64) -> Series {
    let (nodes, weights) = gauss_legendre(40);
    let basis: Vec<_> = nodes.iter().map(|&x| values(40, x)).collect();
    let mut sums = vec![0.0; shape[0] * shape[1]];
    for (a, u) in nodes.iter().enumerate() {
        for (b, v) in nodes.iter().enumerate() {
            let f = f(*u, *v) * weights[a] * weights[b];
            for (k, sum) in sums.iter_mut().enumerate() {
                let (i, j) = (k / shape[1], k % shape[1]);
                *sum += f * basis[a][i] * basis[b][j] * ((2 * i + 1) * (2 * j + 1)) as f64 / 4.0;
            }
        }
    }
    Series::from_fn(shape[0], shape[1], |i, j| sums[i * shape[1] + j])
}

/// A mirror of height `f` over a rectangle.
fn sheet(rect: Rect, chart: Chart, degree: usize, f: impl Fn(DVec2) -> f64) -> Mirror {
    let (centre, half) = (rect.centre(), 0.5 * rect.size());
    let at = |u: f64, v: f64| f(centre + half * DVec2::new(u, v));
    let series = series([degree + 1; 2], at);
    let surface = Surface::Tensor(TensorLegendre { series, centre, half, scale_mm: 1.0 });
    let outline = Outline::Rect(rect);
    Mirror { surface, chart, outline, folded: false, mirror_symmetric: [false; 2] }
}

/// A mirror of height `f` over radii.
fn ring([inner, outer]: [f64; 2], chart: Chart, f: impl Fn(f64) -> f64) -> Mirror {
    let at = |u: f64, _: f64| {
        let disc = outer * (0.5 * (u + 1.0)).sqrt();
        f(if inner == 0.0 { disc } else { inner + 0.5 * (u + 1.0) * (outer - inner) })
    };
    let surface = Surface::Radial(RadialLegendre::new(series([17, 1], at), [inner, outer], 1.0));
    let outline = Outline::Ring { inner, outer };
    Mirror { surface, chart, outline, folded: false, mirror_symmetric: [true; 2] }
}

fn strip(law: StripLaw, target: Target) -> ImagingTask {
    let projection = Projection::Strip(Strip { law, scale_mm: 19.0, azimuth: 0.0, z: -0.3 });
    ImagingTask { projection, target, origin_mm: 20.0, fold: None, picture: PictureMap::default() }
}

/// The field of `view` summed up along lines from `from`: a mirror that about fits.
fn towards<'a>(view: &'a ImagingTask, chart: &'a Chart, from: DVec2) -> impl Fn(DVec2) -> f64 + 'a {
    let (nodes, weights) = gauss_legendre(12);
    move |q: DVec2| {
        let part = |(x, w): (&f64, &f64)| {
            let at = from + (q - from) * (0.5 + 0.5 * x);
            let field = DVec2::from_array(view.field(chart, at.to_array(), 0.0));
            0.5 * w * field.dot(q - from)
        };
        nodes.iter().zip(&weights).map(part).sum()
    }
}

struct Case {
    mirror: Mirror,
    camera: Chart,
    view: ImagingTask,
}

impl Case {
    fn mesh(&self, chord_mm: Option<f64>, facet_mm: Option<f64>) -> Face {
        let limits = Limits { chord_mm, facet_mm, precision: Precision::Single };
        let face = mesh(&self.mirror, &self.camera, Some(&self.view), limits);
        let face = face.unwrap_or_else(|error| panic!("{error}"));
        assert!(limits.hold(&face.bound), "{:?}", face.bound);
        face
    }

    fn vertex(&self, bounder: &ErrorBounder, at: DVec3) -> SurfaceVertex {
        let q = self.mirror.chart.coordinates(at).0;
        bounder.vertex_at(q)
    }

    /// Chord and facet error where the camera sees the point `p` of the facet with `corners`.
    fn errors(&self, corners: [DVec3; 3], p: DVec3) -> [f64; 2] {
        let (mirror, camera) = (&self.mirror, &self.camera);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let met = |chart: &Chart| {
            let ray = chart.ray(chart.coordinates(p).0, 50.0);
            ray.at((corners[0] - ray.origin).dot(normal) / ray.direction.dot(normal))
        };
        let along = met(&mirror.chart);
        let (q, _) = mirror.chart.coordinates(along);
        let chord = along.distance(mirror.position(q, &mirror.surface.at(q)));

        let at = met(camera);
        let image = camera.coordinates(at).0;
        let slope = -normal.truncate() / normal.z;
        let content = |at: DVec3, slope: DVec2| {
            let content = self.view.image_of_seen(camera, at.to_array(), slope.to_array(), image);
            DVec2::from_array(content)
        };
        let under = mirror.intersect_camera_ray(camera, image).unwrap();
        let point = mirror.surface.at(under);
        let smooth = content(mirror.position(under, &point), mirror.slope(under, &point));
        [chord, content(at, slope).distance(smooth)]
    }

    /// Holds every facet to its own bound, at `n` steps per edge; the share of the face's bounds
    /// that samples reach.
    fn hold(&self, face: &Face, n: usize) -> [f64; 2] {
        let bounder =
            ErrorBounder::new(&self.mirror, &self.camera, Some(&self.view), Precision::Single);
        let mut largest = [0.0f64; 2];
        for t in 0..face.designed {
            let exact = face.mesh.corners(t);
            let [a, b, c] = exact.map(|at| self.vertex(&bounder, at));
            let bound = bounder.bound([&a, &b, &c]);
            for corners in [exact, exact.map(|p| p.as_vec3().as_dvec3())] {
                // Most facets in a few places, some in many.
                let n = if t % 8 == 0 { n } else { 2 };
                for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                    let [x, y] = [i, j].map(|i| i as f64 / n as f64);
                    let p = corners[0] * (1.0 - x - y) + corners[1] * x + corners[2] * y;
                    let [chord, facet] = self.errors(corners, p);
                    assert!(
                        chord <= bound.chord_mm + 1e-13 && facet <= bound.facet_mm + 1e-13,
                        "{corners:?} {p}: {chord} {facet} over {bound:?}"
                    );
                    largest = [largest[0].max(chord), largest[1].max(facet)];
                }
            }
        }
        let ErrorBound { chord_mm, facet_mm, .. } = face.bound;
        [largest[0] / chord_mm, largest[1] / facet_mm]
    }

    /// Facets tile the outline, rims are round, the mesh has one piece and its holes.
    fn is_whole(&self, face: &Face) {
        let q = |at: DVec3| self.mirror.chart.coordinates(at).0;
        let area = |t: usize| {
            let [a, b, c] = face.mesh.corners(t).map(q);
            assert!(turn(a, b, c) > 0.0);
            0.5 * turn(a, b, c)
        };
        let sum: f64 = (0..face.mesh.triangles.len()).map(area).sum();
        let exact = self.mirror.full_outline().area();
        let mut open: HashSet<u32> = HashSet::new();
        let mut edges = HashMap::new();
        for t in &face.mesh.triangles {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                *edges.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
            }
        }
        for (edge, count) in &edges {
            assert!(*count == 1 || *count == 2);
            if *count == 1 {
                open.extend(edge);
            }
        }
        let euler =
            face.mesh.vertices.len() as i64 - edges.len() as i64 + face.mesh.triangles.len() as i64;
        match self.mirror.outline {
            Outline::Rect(_) => {
                assert!((sum / exact - 1.0).abs() < 1e-12 && euler == 1);
            }
            Outline::Ring { inner, outer } => {
                assert_eq!(euler, i64::from(inner == 0.0));
                let mut rims = [Vec::new(), Vec::new()];
                for &v in &open {
                    let q = q(face.mesh.vertices[v as usize]);
                    let which = usize::from(q.length() > 0.5 * (inner + outer));
                    assert!((q.length() / [inner, outer][which] - 1.0).abs() < 1e-6);
                    rims[which].push(atan2(q.y, q.x));
                }
                assert!(rims[0].is_empty() == (inner == 0.0));
                // The area that the chords cut off, exactly; and no chord cuts too deep.
                let mut polygons = 0.0;
                for (mut rim, radius) in rims.into_iter().zip([-inner, outer]) {
                    rim.sort_by(f64::total_cmp);
                    rim.extend(rim.first().map(|first| first + radians(360.0)));
                    for w in rim.windows(2) {
                        let half = 0.5 * (w[1] - w[0]);
                        assert!(1.0 - cos(half) < Outline::EDGE);
                        let triangle = sin(half) * cos(half) * radius * radius;
                        polygons += triangle.copysign(radius);
                    }
                }
                assert!((sum / polygons - 1.0).abs() < 1e-6, "{sum} {polygons} {exact}");
            }
        }
    }
}

/// The exact conformal mirror on a sheet, as large as the conquistador's panel: for the law of
/// Mercator the field is a gradient.
fn conformal() -> Case {
    let view = strip(StripLaw::Mercator, Target::Infinity);
    let rect = Rect { min: DVec2::new(-30.0, -18.0), max: DVec2::new(30.0, 22.5) };
    let f = |q: DVec2| 19.0 * exp(-(q.y / 19.0 - 0.3)) * cos(q.x / 19.0);
    let mut mirror = sheet(rect, Chart { plane_mm: 0.0, ..PARALLEL }, 20, f);
    mirror.mirror_symmetric = [true, false];
    Case { mirror, camera: Chart { plane_mm: 0.0, ..PARALLEL }, view }
}

#[test]
fn an_error_that_is_no_number_is_not_forgotten() {
    let (unknown, known) = (
        ErrorBound { facet_mm: f64::NAN, ..ErrorBound::default() },
        ErrorBound { facet_mm: 3.0, ..ErrorBound::default() },
    );
    for both in [unknown.max(known), known.max(unknown)] {
        assert!(both.facet_mm.is_nan());
    }
}

/// The rounded facet leaves the mirror beside the exact one by its own slope, not by that one's.
#[test]
fn tight_chords_hold_for_tiny_facets_rounded_to_single_precision() {
    let rims = RimConditions { radius: [10.0, 30.0], psi: [0.4, 1.9], vergence: PINHOLE.vergence };
    let projection =
        Projection::Radial { law: rims.law(RadialLawKind::Equiangular), radius: rims.radius };
    let view = ImagingTask {
        projection,
        target: Target::Infinity,
        origin_mm: 20.0,
        fold: None,
        picture: PictureMap::default(),
    };
    let mirror = ring([10.0, 30.0], PINHOLE, |r| 0.02 * r * r);
    let case = Case { mirror, camera: PINHOLE, view };
    let bounder =
        ErrorBounder::new(&case.mirror, &case.camera, Some(&case.view), Precision::Single);
    let mut draws = Draws::new(5);
    let mut largest = 0.0f64;
    for _ in 0..4000 {
        let (radius, angle) = (draws.inside([11.0, 29.0]), draws.inside([0.0, 6.2]));
        let size = radius * draws.inside([1e-5, 4e-5]);
        let start = draws.inside([0.0, 6.2]);
        let corners = [0.0, 1.9, 4.1].map(|turn| {
            let q = DVec2::new(cos(angle), sin(angle)) * radius;
            let q = q + DVec2::new(cos(start + turn), sin(start + turn)) * size;
            bounder.vertex_at(q)
        });
        let bound = bounder.bound_tightly(corners.each_ref()).chord_mm;
        let exact = corners.map(|v| v.at);
        for corners in [exact, exact.map(|p| p.as_vec3().as_dvec3())] {
            for k in 0..21 {
                let (i, j) = [(0, 0), (5, 0), (0, 5)].get(k).copied().unwrap_or((k % 5, k / 7));
                let [x, y] = [i, j].map(|i| i as f64 / 5.0);
                if x + y > 1.0 {
                    continue;
                }
                let p = corners[0] * (1.0 - x - y) + corners[1] * x + corners[2] * y;
                let [chord, _] = case.errors(corners, p);
                assert!(chord <= bound * (1.0 + 1e-6) + 1e-14, "{chord:e} over {bound:e}");
                largest = largest.max(chord / bound);
            }
        }
    }
    assert!(largest > 0.9, "{largest}");
}

#[test]
fn what_rounding_tilts_is_the_worse_the_smaller_it_is() {
    let Case { mirror, camera, view } = conformal();
    let corner = mirror.outline.bounds().centre() + DVec2::new(0.7, 0.3);
    let facet = |size: f64| [DVec2::ZERO, DVec2::X, DVec2::Y].map(|step| corner + step * size);
    for precision in [Precision::Single, Precision::Double] {
        let limits = Limits { chord_mm: None, facet_mm: Some(0.1), precision };
        let bounder = ErrorBounder::new(&mirror, &camera, Some(&view), precision);
        let probe = RefinementProbe::new(&bounder, limits);
        // Facet errors are as the size.
        let [once, twice] = [0.6, 1.2].map(|size| match probe.probe(facet(size)) {
            ProbeOutcome::Converges(parts) => parts,
            other => panic!("{other:?}"),
        });
        assert!((3.5..4.5).contains(&(twice / once)), "{once} {twice}");
        let holds_in_double =
            |probe: &RefinementProbe, size: f64| match probe.not_refinable(facet(size)) {
                MeshError::NotRefinable { holds_in_double, .. } => holds_in_double,
                other => panic!("{other}"),
            };
        assert!(!holds_in_double(&probe, 0.6));
        // A thousandth of that limit is beyond corners that nearly hit the mirror, too.
        let strict = RefinementProbe::new(&bounder, Limits { facet_mm: Some(1e-4), ..limits });
        let (small, is_single) = (strict.probe(facet(2e-3)), precision == Precision::Single);
        assert_eq!(small == ProbeOutcome::Diverges, is_single, "{small:?}");
        assert_eq!(holds_in_double(&strict, 2e-3), is_single);
    }
}

#[test]
fn sheet_under_parallel_rays() {
    let case = conformal();
    for limits in [(Some(2e-3), None), (Some(2e-2), Some(0.5))] {
        let face = case.mesh(limits.0, limits.1);
        case.is_whole(&face);
        let [chord, facet] = case.hold(&face, 6);
        assert!(limits.1.is_some() || chord > 0.6, "{chord}");
        assert!(facet > 0.6, "{facet}");
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn sheets_under_a_pinhole() {
    for target in [Target::Infinity, Target::Cylinder { radius_mm: 150.0 }] {
        let view = strip(StripLaw::Cylindrical, target);
        let rect = Rect { min: DVec2::new(-28.3, -17.1), max: DVec2::new(25.2, 19.4) };
        let mirror = sheet(rect, PINHOLE, 18, towards(&view, &PINHOLE, DVec2::new(0.0, 5.0)));
        let case = Case { mirror, camera: PINHOLE, view };
        for limits in [(Some(2e-3), None), (None, Some(0.4))] {
            let face = case.mesh(limits.0, limits.1);
            case.is_whole(&face);
            let [chord, facet] = case.hold(&face, 6);
            assert!(if limits.0.is_some() { chord } else { facet } > 0.6, "{chord} {facet}");
        }
    }
}

#[test]
fn disc_in_a_cylinder() {
    let rims = RimConditions { radius: [0.0, 30.0], psi: [0.0, radians(90.0)], vergence: 0.0 };
    let projection =
        Projection::Radial { law: rims.law(RadialLawKind::Parabolic), radius: rims.radius };
    let target = Target::Cylinder { radius_mm: 200.0 };
    let view = ImagingTask {
        projection,
        target,
        origin_mm: 12.0,
        fold: None,
        picture: PictureMap::default(),
    };
    let mirror = ring([0.0, 30.0], PARALLEL, |r| -r * r / 60.0 + 1e-7 * r * r * r * r);
    let case = Case { mirror, camera: PARALLEL, view };
    for limits in [(Some(1e-3), None), (Some(2e-2), Some(0.3)), (None, Some(0.8))] {
        let face = case.mesh(limits.0, limits.1);
        case.is_whole(&face);
        let [chord, facet] = case.hold(&face, 6);
        assert!(if limits.1.is_none() { chord } else { facet } > 0.6, "{chord} {facet}");
    }
}

#[test]
fn cone_under_a_pinhole() {
    let rims = RimConditions {
        radius: [7.0, 31.0],
        psi: [0.0, radians(100.0)],
        vergence: PINHOLE.vergence,
    };
    let law = rims.law(RadialLawKind::Conical);
    let RadialLaw::Conical { slope, vergence: k } = law else { unreachable!() };
    // h is linear in the radius.
    let cone = |r: f64| -log((1.0 - slope * k * 20.0) / (1.0 - slope * k * r)) / k;
    let mirror = ring(rims.radius, PINHOLE, cone);
    let projection = Projection::Radial { law, radius: rims.radius };
    let view = ImagingTask {
        projection,
        target: Target::Infinity,
        origin_mm: 15.0,
        fold: None,
        picture: PictureMap::default(),
    };
    let case = Case { mirror, camera: PINHOLE, view };
    for limits in [(Some(1e-3), None), (None, Some(0.5)), (None, Some(1.5))] {
        let face = case.mesh(limits.0, limits.1);
        case.is_whole(&face);
        let [chord, facet] = case.hold(&face, 6);
        assert!(if limits.1.is_none() { chord } else { facet } > 0.6, "{chord} {facet}");
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn given_mirrors_under_a_pinhole() {
    let rims = RimConditions {
        radius: [0.0, 30.0],
        psi: [0.0, radians(80.0)],
        vergence: PINHOLE.vergence,
    };
    let radial =
        Projection::Radial { law: rims.law(RadialLawKind::Hyperbolic), radius: rims.radius };
    let target = Target::Cylinder { radius_mm: 300.0 };
    let bowl = |r: f64| -r * r / 60.0;
    let rect = Rect { min: DVec2::new(-20.0, 3.0), max: DVec2::new(20.0, 25.0) };
    let sheet = sheet(rect, PARALLEL, 4, |q| bowl(q.length()));
    for (mirror, view) in [
        (
            ring([0.0, 22.0], PARALLEL, bowl),
            ImagingTask {
                projection: radial,
                target,
                origin_mm: 15.0,
                fold: None,
                picture: PictureMap::default(),
            },
        ),
        (sheet, strip(StripLaw::Equirectangular, Target::Infinity)),
    ] {
        let case = Case { mirror, camera: PINHOLE, view };
        for limits in [(Some(1e-3), None), (None, Some(0.3))] {
            let face = case.mesh(limits.0, limits.1);
            case.is_whole(&face);
            let [chord, facet] = case.hold(&face, 6);
            assert!(if limits.0.is_some() { chord } else { facet } > 0.6, "{chord} {facet}");
        }
    }
}

/// Within the first limits failures spread from facet to facet.
#[test]
fn a_mesh_does_not_depend_on_the_limits_before_it() {
    let rect = Rect { min: DVec2::new(-20.0, 3.0), max: DVec2::new(20.0, 25.0) };
    let mirror = sheet(rect, PARALLEL, 4, |q| -q.length_squared() / 60.0);
    let view = strip(StripLaw::Equirectangular, Target::Infinity);
    let panels = SmoothPanels::new(&mirror, Some(&view));
    let limits = [0.3, 0.45].map(|limit| Limits {
        chord_mm: None,
        facet_mm: Some(limit),
        precision: Precision::Single,
    });
    let mesher = || Mesher::new(&panels, &PINHOLE);
    let fresh = limits.map(|limits| mesher().mesh(limits).unwrap().mesh);
    let foreseen = limits.map(|limits| mesher().forecast(limits).unwrap());
    let mut after = mesher();
    for k in [0, 1, 1, 0, 1] {
        assert_eq!(after.forecast(limits[k]).unwrap(), foreseen[k]);
        assert_eq!(after.mesh(limits[k]).unwrap().mesh, fresh[k]);
        assert!(after.estimate(limits[k]).is_ok());
        assert_eq!(after.mesh(limits[k]).unwrap().mesh, fresh[k]);
    }
}
