//! The witness's shortcuts, and shapes that are given in two ways, change no answer.

use super::{HYPERBOLIC, hidden_by, scene, traced};
use crate::support::builds::{folder, parsed, save};
use crate::support::designed;
use morion::internals::geom::{Obstacle, ObstacleShape, Ray};
use morion::internals::pipeline::load;
use morion::internals::trace::{CameraTrace, Outcome};

/// A folded mirror whose panels shadow each other, as its ridge is sunk into it.
const VALLEY: &str = "\
camera.orthographic.pixels = [160, 120]
projection.cylindrical = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }
layout.conquistador = { panel = \"refit\", ridge = \"valley\", fill_frame = true }
method.vector-field.degree = 8
part = { width_mm = 15, base_mm = 2 }
mesh.facet_px = 3
export.formats = [\"stl\"]
";

/// Two legs, one of which stands in the valley's light, and a wall.
const BODIES: &str = "
[[obstacle]]
cylinder = { from_mm = [6, 2, 2], to_mm = [6, 30, 9], radius_mm = 0.7 }
[[obstacle]]
cylinder = { from_mm = [-30, -3, -2], to_mm = [30, -3, 3], radius_mm = 0.4, solid = false }
[[obstacle]]
box = { centre_mm = [60, 0, 20], size_mm = [5, 60, 90] }
";

#[test]
fn no_shortcut_changes_what_is_hidden() {
    let profile = parsed(&format!("{VALLEY}{BODIES}"));
    let design = designed(&profile);
    let scene = scene(&profile, &design);
    let trace = CameraTrace::new(&scene, &design.camera, scene.above_mm());
    let (found, counts) = trace.run();
    let (plain, _) = trace.clone().without_shortcuts().run();
    assert!(found == plain);
    assert!(counts.proven > 0 && counts.followed > 0, "{counts:?}");
    let [columns, _] = design.camera.pixels;
    let (mut shadowed, mut hidden) = (0, [0; 3]);
    for (k, end) in found.iter().enumerate() {
        let ray = trace.ray(k as u32 % columns, k as u32 / columns);
        assert_eq!(*end, scene.trace(&ray));
        shadowed += usize::from(matches!(end.outcome, Outcome::Shadowed(_)));
        if let Some(number) = hidden_by(end) {
            hidden[number as usize] += 1;
        }
    }
    assert!(shadowed > 0 && hidden.iter().all(|count| *count > 50), "{shadowed} {hidden:?}");
}

/// Whatever a ray meets first ends it: by all meetings of each ray with each body, one by one.
#[test]
fn what_is_met_first_counts() {
    let profile = parsed(&format!("{VALLEY}{BODIES}"));
    let design = designed(&profile);
    let bare = parsed(VALLEY);
    let plain = scene(&bare, &designed(&bare));
    let scene = scene(&profile, &design);
    let trace = CameraTrace::new(&scene, &design.camera, scene.above_mm());
    let first = |ray: &Ray, clear: f64| {
        let met = |Obstacle { shape, .. }: &Obstacle| match shape {
            ObstacleShape::Cuboid(cuboid) => cuboid.meeting(ray, clear),
            ObstacleShape::Cylinder(cylinder) => cylinder.meeting(ray, clear),
            _ => None,
        };
        let all = design.obstacles.iter().map(|obstacle| met(obstacle).unwrap_or(f64::INFINITY));
        (0u32..).zip(all).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
    };
    let [columns, rows] = design.camera.pixels;
    let (mut before, mut between) = (0, 0);
    for k in 0..columns * rows {
        let ray = trace.ray(k % columns, k / columns);
        let (expected, facet) = (plain.trace(&ray), plain.nearest_hit(&ray));
        let (number, t) = first(&ray, 0.0);
        let found = scene.trace(&ray).outcome;
        if t < facet.map_or(f64::INFINITY, |hit| hit.t) {
            assert_eq!(found, Outcome::Obstructed(number));
            before += 1;
            continue;
        }
        if !matches!(expected.outcome, Outcome::Hit | Outcome::Shadowed(_)) {
            assert_eq!(found, expected.outcome);
            continue;
        }
        let leaving = Ray { origin: ray.at(expected.t), direction: expected.direction };
        let (number, t) = first(&leaving, 1e-9);
        // The nearest facet of the part that the reflected ray meets beyond its own.
        let start = Ray { origin: leaving.at(1e-7), direction: leaving.direction };
        let part = match expected.outcome {
            Outcome::Shadowed(_) => plain.nearest_hit(&start).map_or(f64::INFINITY, |hit| hit.t),
            _ => f64::INFINITY,
        };
        let wanted = if t < part { Outcome::Obstructed(number) } else { expected.outcome };
        let same = match (found, wanted) {
            (Outcome::Shadowed(_), Outcome::Shadowed(_)) => true,
            (found, wanted) => found == wanted,
        };
        assert!(same || !t.is_finite(), "pixel {k}: {found:?} for {wanted:?}, {t} and {part}");
        between += usize::from(t < part && part.is_finite());
    }
    assert!(before > 50 && between > 0, "{before} {between}");
}

/// A binary STL of a box.
fn box_stl(lo: [f64; 3], hi: [f64; 3]) -> Vec<u8> {
    let corner =
        |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { lo[axis] } else { hi[axis] });
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut bytes = vec![0; 80];
    bytes.extend(12u32.to_le_bytes());
    for [a, b, c, d] in faces {
        for facet in [[a, b, c], [a, c, d]] {
            bytes.extend([0; 12]);
            for x in facet.iter().flat_map(|k| corner(*k)) {
                bytes.extend((x as f32).to_le_bytes());
            }
            bytes.extend([0; 2]);
        }
    }
    bytes
}

#[test]
fn an_stl_of_a_box_hides_what_the_box_does() {
    let folder = folder();
    std::fs::write(folder.path().join("wall.stl"), box_stl([12.0, -8.0, -20.0], [14.0, 9.0, 15.0]))
        .unwrap();
    let text = format!("{HYPERBOLIC}[[obstacle]]\nname = \"wall\"\nstl.file = \"wall.stl\"\n");
    let path = save(folder.path(), &text);
    let (_, of_mesh) = traced(&load(path.to_str().unwrap()).unwrap());
    let same = "[[obstacle]]\nbox = { centre_mm = [13, 0.5, -2.5], size_mm = [2, 17, 35] }\n";
    let (_, of_box) = traced(&parsed(&format!("{HYPERBOLIC}{same}")));
    let [mesh, cuboid] =
        [&of_mesh, &of_box].map(|ends| ends.iter().map(hidden_by).collect::<Vec<_>>());
    assert!(mesh == cuboid);
    assert!(mesh.iter().flatten().count() > 1000);
}
