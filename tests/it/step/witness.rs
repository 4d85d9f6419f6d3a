//! The witness at bodies of curved faces: proofs and rows of rays change no answer, and nothing is lost.

use super::{Case, fitted, written};
use crate::support::{share, shipped};
use morion::internals::brep::Body;
use morion::internals::design::{Design, design};
use morion::internals::trace::{BodyScene, CameraTrace, Obstacles, Outcome, RayEnd};
use std::sync::Arc;

/// Mirrors of every layout and camera: folded, round, mounted, in panels, behind a lens, among obstacles.
const MIRRORS: [&str; 9] = [
    "conquistador",
    "panoramic",
    "conical",
    "dome",
    "soccer",
    "four-views",
    "calibrated",
    "driver",
    "machine-vision",
];

fn scene(name: &str) -> (Design, BodyScene) {
    let design = design(&shipped(name)).unwrap();
    let case = Case {
        name: name.into(),
        mirror: design.mirror.clone(),
        stock: design.border.clone(),
        blind: design.blind_holes.clone(),
    };
    let body = Body::read(&written(&case, &fitted(&case))).unwrap();
    let obstacles = Obstacles::new(&design.obstacles, design.view.as_ref());
    let scene = BodyScene::new(body, obstacles.map(Arc::new));
    (design, scene)
}

/// Whether two ends are the same but for rounding.
fn is_same(a: &RayEnd, b: &RayEnd) -> bool {
    let near = a.t == b.t || (a.t - b.t).abs() < 1e-9;
    a.outcome == b.outcome && a.facet == b.facet && near && a.direction.distance(b.direction) < 1e-8
}

#[test]
fn curved_faces_end_rays_as_they_do_without_shortcuts() {
    for name in share(3, 0, MIRRORS) {
        let (design, scene) = scene(name);
        let camera = design.camera.with_pixels([120, 90]);
        let trace = CameraTrace::new(&scene, &camera, scene.above_mm());
        let (quick, counts) = trace.run();
        let (slow, _) = trace.without_shortcuts().run();
        let off = quick.iter().zip(&slow).position(|(a, b)| !is_same(a, b));
        assert!(
            off.is_none(),
            "{name}: {off:?} {:?} {:?}",
            quick[off.unwrap()],
            slow[off.unwrap()]
        );
        let hit = quick.iter().filter(|end| end.outcome == Outcome::Hit).count();
        assert!(hit > 2000, "{name}: {hit}");
        // What is proven need not be followed: nearly all of it.
        assert!(counts.proven > 4 * counts.followed, "{name}: {counts:?}");
    }
}
