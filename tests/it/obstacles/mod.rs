//! What hides what: pixels that obstacles hide are those that closed forms name, in the witness's trace, in the
//! figures of `frame` and in pictures.

mod closed_forms;
mod commands;
mod shortcuts;

use crate::support::{designed, meshed};
use morion::internals::design::Design;
use morion::internals::geom::Precision;
use morion::internals::profile::Profile;
use morion::internals::solid::Solid;
use morion::internals::trace::{CameraTrace, Obstacles, Outcome, RayEnd, Scene};
use std::sync::Arc;

/// A hyperboloid of 20 mm under a pinhole 60 mm over its rim: from there, tan(110 degrees) away, all it shows is seen.
const HYPERBOLIC: &str = "\
camera.pinhole = { pixels = [240, 240], focal_px = 720, distance_mm = 60 }
projection.hyperbolic.outer_polar_deg = 110
layout.disc = {}
method.vector-field.degree = 20
part = { width_mm = 20, base_mm = 3 }
mesh.facet_px = 1
export.formats = [\"stl\"]
accept.frame_filled = 0.1
";

/// A paraboloid of 20 mm under a telecentric camera.
const PARABOLIC: &str = "\
camera.orthographic.pixels = [240, 240]
projection.parabolic.outer_polar_deg = 110
layout.disc = {}
method.vector-field.degree = 20
part = { width_mm = 20, base_mm = 3 }
mesh.facet_px = 1
export.formats = [\"stl\"]
accept.frame_filled = 0.1
";

/// The mirror's mesh among the obstacles of its profile.
fn scene(profile: &Profile, design: &Design) -> Scene {
    let face = meshed(profile, design).unwrap();
    let solid = Solid::from_face(&face.mesh, design.features(), Precision::Single).unwrap();
    let obstacles = Obstacles::new(&design.obstacles, design.view.as_ref());
    Scene::new(solid.mesh().clone()).among(obstacles.map(Arc::new))
}

/// A design and the ends of its camera's rays, row by row.
fn traced(profile: &Profile) -> (Design, Vec<RayEnd>) {
    let design = designed(profile);
    let scene = scene(profile, &design);
    let (ends, _) = CameraTrace::new(&scene, &design.camera, scene.above_mm()).run();
    (design, ends)
}

/// The obstacle that hides a ray.
fn hidden_by(end: &RayEnd) -> Option<u32> {
    match end.outcome {
        Outcome::Obstructed(number) => Some(number),
        _ => None,
    }
}
