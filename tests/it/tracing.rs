//! The witness's rays: shortcuts change no answer, no ray slips between facets, and hits are those
//! of exact arithmetic.

use crate::support::builds::parsed;
use crate::support::draws::Draws;
use crate::support::parts::case;
use crate::support::{designed, meshed, profile, share, shipped};
use morion::internals::geom::{Chart, DVec3, PartFeatures, Precision, Ray, TriMesh};
use morion::internals::optics::{Camera, CameraModel, Distortion, Mount, PictureMap};
use morion::internals::profile::{MeshGoal, Profile};
use morion::internals::solid::Solid;
use morion::internals::trace::{CameraTrace, Outcome, RayEnd, Scene, TraceCounts};
use rayon::prelude::*;

/// Numbers in [0, 1), the same for the same `k` (splitmix64).
fn random(k: u64) -> f64 {
    Draws::new(k).unit()
}

fn above(scene: &Scene) -> f64 {
    scene.bounds().map_or(1.0, |(lo, hi)| hi.z + (hi - lo).max_element())
}

/// Holds a trace against the same without shortcuts, and returns how it was traced.
fn compared(what: &str, scene: &Scene, camera: &Camera) -> (Vec<RayEnd>, TraceCounts) {
    let trace = CameraTrace::new(scene, camera, above(scene));
    let (found, counts) = trace.run();
    let (expected, plain) = trace.without_shortcuts().run();
    assert_eq!((plain.rasterized, plain.proven), (0, 0));
    for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let same = found.t.to_bits() == expected.t.to_bits() && found == expected;
        assert!(same, "{what}, ray {k}: {found:?} for {expected:?}");
    }
    let reflected = |seen: &&RayEnd| matches!(seen.outcome, Outcome::Hit | Outcome::Shadowed(_));
    assert_eq!(counts.proven + counts.followed, found.iter().filter(reflected).count(), "{what}");
    assert_eq!(counts.rasterized + counts.searched, found.len(), "{what}");
    // Without a grid, and with one once it is needed.
    let bare = Scene::for_cameras(scene.mesh().clone(), false);
    assert!(
        CameraTrace::new(&bare, camera, above(scene)).run() == (found.clone(), counts),
        "{what}"
    );
    (found, counts)
}

/// The same for the mirror of `profile` under its own camera with fewer pixels.
fn swept(what: &str, profile: &Profile, precision: Precision) -> (Vec<RayEnd>, TraceCounts) {
    let design = designed(profile);
    let face = meshed(profile, &design).unwrap();
    let solid = Solid::from_face(&face.mesh, design.features(), precision).unwrap();
    let scene = Scene::new(solid.mesh().clone());
    let fewer = f64::from(design.camera.pixels[0]) / 170.0;
    let camera = Camera {
        pixels: design.camera.pixels.map(|n| (f64::from(n) / fewer) as u32),
        pixel_mm: design.camera.pixel_mm * fewer,
        ..design.camera
    };
    compared(what, &scene, &camera)
}

#[test]
#[ignore = "long: .ci/nightly"]
fn shortcuts_change_nothing_for_shipped_mirrors() {
    let names: Vec<&str> = morion::internals::profile::shipped().iter().map(|p| p.name).collect();
    let names: Vec<&str> = share(3, 1, names).collect();
    names.par_iter().for_each(|name| {
        let mut profile = shipped(name);
        profile.mesh = MeshGoal::limits(None, Some(8.0));
        let (_, counts) = swept(name, &profile, Precision::Single);
        println!("{name}: {counts:?}");
        assert_eq!(counts.searched, 0, "{name}");
        assert!(counts.followed < counts.proven, "{name}: {counts:?}");
    });
}

#[test]
#[ignore = "long: .ci/nightly"]
fn shortcuts_change_nothing_where_there_is_shadow() {
    let shadowed = |found: &[RayEnd]| {
        found.iter().filter(|seen| matches!(seen.outcome, Outcome::Shadowed(_))).count()
    };
    let fold = |ridge: &str| format!("layout.conquistador = {{ fill_frame = true, {ridge} }}");
    let valley = fold("ridge = \"valley\"");
    let valley = profile(&[("layout.strip = {}", &valley)]);
    // Rims around a mirror, in and out of the way; pinholes; strips.
    let rim = case("conquistador, rounded").replace("rim_mm = 3", "rim_mm = 11.5");
    let cases = [
        ("valley", valley, true),
        ("panorama", profile(&[]), false),
        ("high rim", parsed(&rim), true),
        ("conquistador, holes", parsed(&case("conquistador, holes")), false),
        ("annulus, land", parsed(&case("annulus, land")), false),
        ("pinhole, rounded", parsed(&case("pinhole, rounded")), false),
    ];
    cases.into_par_iter().for_each(|(what, profile, shadow)| {
        let (found, counts) = swept(what, &profile, Precision::Double);
        let shadowed = shadowed(&found);
        println!("{what}: {shadowed} shadowed, {counts:?}");
        assert_eq!(shadowed > 100, shadow, "{what}: {shadowed}");
        assert!(counts.proven > 100, "{what}: {counts:?}");
    });
}

/// Tetrahedra, some cutting each other, over a plate; `turned` of them inside out.
fn heap(seed: u64, turned: usize) -> TriMesh {
    let corners = [(-20.0, -20.0), (20.0, -20.0), (20.0, 20.0), (-20.0, 20.0)];
    let plate = [-9.0, -7.0].map(|z| corners.map(|(x, y)| DVec3::new(x, y, z)));
    let mut mesh = TriMesh { vertices: plate.as_flattened().to_vec(), triangles: vec![] };
    mesh.triangles.extend([[4, 5, 6], [4, 6, 7], [0, 2, 1], [0, 3, 2]]);
    for k in 0..4 {
        let [a, b] = [k, (k + 1) % 4];
        mesh.triangles.extend([[a, b, b + 4], [a, b + 4, a + 4]]);
    }
    for k in 0..16u64 {
        let r = |j: u64| random(seed * 1000 + k * 16 + j) - 0.5;
        let (centre, size) = (DVec3::new(24.0 * r(0), 24.0 * r(1), 8.0 * r(2)), 5.0);
        let first = mesh.vertices.len() as u32;
        // Some in whole numbers: corners and edges right under pixel centres, facets edge-on.
        let place = |v: DVec3| if k % 2 == 0 { v.round() } else { v };
        mesh.vertices.extend((0..4).map(|corner| {
            place(centre + size * DVec3::new(r(3 + corner), r(7 + corner), r(11 + corner)))
        }));
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| mesh.vertices[(first + k) as usize]);
        let inside_out = ((b - a).cross(c - a).dot(d - a) > 0.0) != ((k as usize) < turned);
        for [a, b, c] in [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]] {
            let facet = [a, b, c].map(|k| first + k);
            mesh.triangles.push(if inside_out { [facet[0], facet[2], facet[1]] } else { facet });
        }
    }
    mesh
}

#[test]
fn shortcuts_change_nothing_for_any_mesh_and_camera() {
    let counts: Vec<[usize; 3]> = (0..60u64)
        .into_par_iter()
        .map(|seed| {
            let mut mesh = heap(seed, (seed % 3) as usize);
            if seed % 5 == 4 {
                // Not closed: nothing can be proven.
                mesh.triangles.pop();
            }
            let vergence = [0.0, 0.01, 0.04, 0.2][(seed % 4) as usize];
            let scene = Scene::new(mesh);
            let camera = Camera {
                pixels: [67, 45],
                pixel_mm: [0.5, 0.37, 1.0][(seed % 3) as usize],
                chart: Chart::on_axis(vergence, 2.0 * random(seed)),
                picture: PictureMap::default(),
            };
            let (found, counts) = compared(&format!("heap {seed}"), &scene, &camera);
            let is = |pick: fn(&RayEnd) -> bool| found.iter().filter(|seen| pick(seen)).count();
            if seed % 5 == 4 {
                assert_eq!(counts.proven, 0);
            }
            // The last pinhole is among the facets.
            // A pinhole may be among the facets.
            assert!(counts.searched == 0 || vergence > 0.0, "heap {seed}");
            [
                is(|seen| matches!(seen.outcome, Outcome::Shadowed(_))),
                is(|seen| seen.outcome == Outcome::BackFace),
                counts.proven,
            ]
        })
        .collect();
    let sum = |k: usize| counts.iter().map(|counts| counts[k]).sum::<usize>();
    let [shadowed, back, proven] = [sum(0), sum(1), sum(2)];
    println!("{shadowed} shadowed, {back} back faces, {proven} proven");
    assert!(shadowed > 1000 && back > 1000 && proven > 1000);
}

/// Lenses bend the edges of facets, wide ones over many pixels: none is lost.
#[test]
fn shortcuts_change_nothing_behind_a_lens() {
    let lenses = [
        Distortion::BrownConrady {
            radial: [-0.28, 0.06, 0.0, 0.0, 0.0, 0.0],
            tangential: [0.004, -0.003],
            prism: [0.0; 4],
        },
        Distortion::KannalaBrandt { radial: [-0.02, 0.004, 0.0, 0.0] },
    ];
    let mounts =
        [Mount::default(), Mount { fold_deg: 50.0, towards_deg: 70.0, shift_mm: [2.0, -1.0] }];
    let hits: Vec<usize> = (0..24u64)
        .into_par_iter()
        .map(|seed| {
            let [lens, mount, focal] = [seed % 2, seed / 2 % 2, seed / 4 % 3].map(|k| k as usize);
            let focal_px = [40.0, 60.0, 160.0][focal];
            let model = CameraModel::Calibrated {
                pixels: [67, 45],
                focal_px: [focal_px, 1.05 * focal_px],
                principal_px: [34.1, 20.3],
                distortion: lenses[lens],
                distance_mm: 60.0,
            };
            let camera = Camera::new(&model, &mounts[mount], 40.0);
            let scene = Scene::new(heap(seed, (seed % 3) as usize));
            let (found, counts) = compared(&format!("lens {seed}"), &scene, &camera);
            assert_eq!(counts.searched, 0, "lens {seed}");
            found.iter().filter(|seen| seen.outcome == Outcome::Hit).count()
        })
        .collect();
    println!("{hits:?} hits");
    assert!(hits.iter().all(|&hits| hits > 100));
}

/// One whole unit, mm: small enough that triple products of coordinates fit 128 bits, and a power of
/// two, so that coordinates are exact.
const UNIT: f64 = 1.0 / (1u64 << 33) as f64;
/// Half the size of the body, mm.
const HALF: f64 = 8.0;

fn whole(v: DVec3) -> [i128; 3] {
    v.to_array().map(|x| (x / UNIT) as i128)
}

fn on_grid(v: DVec3) -> DVec3 {
    (v / UNIT).round() * UNIT
}

/// A bumpy closed body around the origin: every plane through a facet has the origin and its
/// neighbourhood on the inner side. `n` x `n` quads on each side of a cube, its corners in whole
/// units.
fn body(n: u32) -> TriMesh {
    let mut welder = morion::internals::geom::Welder::new(0);
    for side in 0..6u32 {
        let axis = (side / 2) as usize;
        let outwards = side % 2 == 0;
        let corner = |i: u32, j: u32| {
            let [u, v] = [i, j].map(|k| 2.0 * f64::from(k) / f64::from(n) - 1.0);
            let mut p = [0.0; 3];
            p[axis] = if outwards { 1.0 } else { -1.0 };
            p[(axis + 1) % 3] = if outwards { u } else { v };
            p[(axis + 2) % 3] = if outwards { v } else { u };
            let p = DVec3::from_array(p);
            let shift = p.x * 3.0 + p.y * 5.0 + p.z * 7.0;
            let bump = 1.0 - 0.2 * (shift * shift * 0.37).fract() / f64::from(n);
            on_grid(p.normalize() * 0.6 * HALF * bump)
        };
        for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
            let [a, b, c, d] =
                [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| corner(i, j));
            welder.add([a, b, c]);
            welder.add([a, c, d]);
        }
    }
    welder.finish()
}

#[test]
fn a_million_rays_from_within_never_slip_between_facets() {
    let scene = Scene::new(body(6));
    let mesh = scene.mesh();
    let (facets, vertices) = (mesh.triangles.len() as u64, mesh.vertices.len());
    assert_eq!(facets as usize, 2 * vertices - 4, "closed");
    let aim = |k: u64| {
        let r = |j: u64| random(5 * k + j);
        let [a, b, c] = mesh.corners((r(0) * facets as f64) as usize);
        // A place of the facet: inside, on an edge, at a corner, or a few ulps beside these.
        let (u, v) = [(r(1), r(2) * (1.0 - r(1))), (r(1), 0.0), (0.0, 0.0), (1.0 - r(1), r(1))]
            [(k % 4) as usize];
        let target = a + (b - a) * u + (c - a) * v;
        // From the middle, from anywhere inside, or from just within the face along it.
        let from = match k % 3 {
            0 => DVec3::ZERO,
            1 => 0.3 * HALF * DVec3::new(r(3) - 0.5, r(4) - 0.5, r(2) - 0.5),
            _ => (target + (c - b) * (r(3) - 0.5)) * (0.93 - 0.2 * r(4)),
        };
        Ray { origin: from, direction: (target - from).normalize() }
    };
    let lost = (0..1_000_000u64).into_par_iter().filter(|&k| {
        let hit = scene.nearest_hit(&aim(k));
        !hit.is_some_and(|hit| hit.t < 2.0 * HALF)
    });
    assert_eq!(lost.count(), 0);
}

#[test]
fn camera_rays_never_slip_between_facets() {
    const PIXELS: u32 = 1001;
    const CELLS: u32 = 100;
    let cases = (0..9u64).map(|case| (case, [0.0, 0.002, 0.01][(case % 3) as usize]));
    // One of each vergence, but for a long run.
    for (case, vergence) in share(4, 0, cases) {
        let chart = Chart::on_axis(vergence, 5.0);
        let camera =
            Camera { pixels: [PIXELS; 2], pixel_mm: 0.1, chart, picture: PictureMap::default() };
        // Corners lie on the rays of pixels, or, under a pinhole, a few ulps beside; so do edges.
        let side = CELLS + 1;
        let corner = |k: u32| {
            let at = [k % side, k / side].map(|k| f64::from(10 * k) + 0.5);
            let height = 0.05 * random(case * 100_000 + u64::from(k));
            chart.point(camera.image_point(at[0], at[1]), height)
        };
        let cell = |k: u32| {
            let a = k / CELLS * side + k % CELLS;
            [[a, a + side, a + side + 1], [a, a + side + 1, a + 1]]
        };
        let face = TriMesh {
            vertices: (0..side * side).map(corner).collect(),
            triangles: (0..CELLS * CELLS).flat_map(cell).collect(),
        };
        let solid =
            Solid::from_face(&face.clone().into(), PartFeatures::NONE, Precision::Double).unwrap();
        let scene = Scene::new(solid.mesh().clone());
        let (found, counts) = CameraTrace::new(&scene, &camera, above(&scene)).run();
        assert_eq!(counts.rasterized, found.len());
        let lost = (1..PIXELS - 1)
            .flat_map(|row| (1..PIXELS - 1).map(move |column| row * PIXELS + column))
            .filter(|&k| {
                let seen = &found[k as usize];
                seen.outcome != Outcome::Hit || seen.facet as usize >= face.triangles.len()
            });
        assert_eq!(lost.count(), 0, "case {case}");
    }
}

type Whole = [i128; 3];

fn minus(a: Whole, b: Whole) -> Whole {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The triple product, exact.
fn volume(a: Whole, b: Whole, c: Whole) -> i128 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

#[test]
fn hits_are_those_of_exact_arithmetic() {
    let scene = Scene::new(body(9));
    let mesh = scene.mesh();
    let rounding = 8.0 * f64::EPSILON * HALF;
    let worst = (0..300_000u64)
        .into_par_iter()
        .map(|k| {
            let r = |j: u64| random(7 * k + j);
            let [a, b, c] = mesh.corners((r(0) * mesh.triangles.len() as f64) as usize);
            let (u, v) = [(r(1), 0.4 * r(2)), (0.5, 0.0), (0.0, 0.0)][(k % 3) as usize];
            // Right through an edge or a corner, or a unit beside.
            let beside = DVec3::new(r(3), r(4), r(5)) * 3.0 - DVec3::splat(1.5);
            let beside = if k % 2 == 0 { DVec3::ZERO } else { beside.round() * UNIT };
            let target = on_grid(a + (b - a) * u + (c - a) * v * (1.0 - u)) + beside;
            let origin = on_grid(0.5 * HALF * DVec3::new(r(4) - 0.5, r(5) - 0.5, r(6) - 0.5));
            // Not of unit length, but exact: distances are then in its lengths.
            let ray = Ray { origin, direction: target - origin };
            let (o, d) = (whole(origin), whole(ray.direction));
            let hit = scene.nearest_hit(&ray).unwrap_or_else(|| panic!("ray {k} is lost: {ray:?}"));
            let corners = mesh.corners(hit.facet as usize);
            let [a, b, c] = corners.map(|v| minus(whole(v), o));
            let sides = [volume(d, b, c), volume(d, c, a), volume(d, a, b)];
            let sum: i128 = sides.iter().sum();
            for (k, &side) in sides.iter().enumerate() {
                // How far beyond the edge the exact ray passes, mm.
                let edge = corners[(k + 2) % 3] - corners[(k + 1) % 3];
                let across = ray.direction.cross(edge).length() / UNIT / UNIT;
                let beyond = -(side as f64) * (sum as f64).signum() / across * UNIT;
                assert!(beyond <= rounding, "ray {k} passes {beyond} mm beside its facet");
            }
            let exact = volume(a, b, c) as f64 / sum as f64;
            let normal = mesh.area_vector(hit.facet as usize).normalize();
            let cosine = ray.direction.normalize().dot(normal).abs();
            (hit.t - exact).abs() * ray.direction.length() * cosine / (f64::EPSILON * HALF)
        })
        .reduce(|| 0.0, f64::max);
    println!("distances are off by {worst:.2} ulps of the body's size at most");
    assert!(worst < 4.0);
}
