//! What a mesh of any making has to stand: being checked, traced and aligned, as `verify` does it.

use morion::internals::align::align;
use morion::internals::design::{Design, design};
use morion::internals::export::ImportedMesh;
use morion::internals::geom::{DVec3, Welder};
use morion::internals::optics::ShownContent;
use morion::internals::pipeline::{Silent, verify};
use morion::internals::profile::Profile;
use morion::internals::solid::check;
use morion::internals::trace::{CameraTrace, ExpectedRay, Outcome, PixelRay, Scene, TraceResult};
use std::sync::LazyLock;
use tempfile::tempdir;

/// A part of some millimetres, soon designed and traced.
const PART: &str = "\
camera.orthographic.pixels = [16, 12]
projection.cylindrical = { azimuth_deg = [-40, 40], elevation_deg = [-30, 30] }
layout.strip = {}
method.vector-field.degree = 4
part = { width_mm = 8, base_mm = 2 }
mesh.chord_um = 100
export.formats = [\"stl\"]
";

static SOURCE: LazyLock<Profile> = LazyLock::new(|| {
    Profile::parse("part", "part.toml", PART.as_bytes()).expect("the part is a valid one")
});
static DESIGN: LazyLock<Design> =
    LazyLock::new(|| design(&SOURCE).expect("the part can be designed"));

/// A mesh that was read: facets of finite corners that are there, each vertex once, all in use.
pub fn is_sound(read: &ImportedMesh) {
    let mesh = &read.mesh;
    assert!(!mesh.triangles.is_empty() && mesh.vertices.iter().all(|v| v.is_finite()));
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    assert!(used.iter().all(|used| *used), "a vertex of no facet");
    let mut bits: Vec<[u64; 3]> =
        mesh.vertices.iter().map(|v| v.to_array().map(f64::to_bits)).collect();
    bits.sort_unstable();
    bits.dedup();
    assert_eq!(bits.len(), mesh.vertices.len(), "a vertex twice");
    if let Some(normals) = &read.normals {
        assert_eq!(normals.len(), mesh.triangles.len());
    }
}

/// Takes a mesh that was read from `bytes` through what `verify` does; of lot 0 through `verify` itself,
/// which takes a hundred times as long.
pub fn verified(bytes: &[u8], extension: &str, read: &ImportedMesh, lot: u8) {
    let found = check(&read.mesh);
    assert!(found.defects.len() <= found.defect_count);
    traced(read);
    if lot == 0 {
        let folder = tempdir().expect("a folder");
        let path = folder.path().join("part").with_extension(extension);
        std::fs::write(&path, bytes).expect("the folder takes a file");
        let report = verify(&SOURCE, &path, &Silent).expect("a mesh that is read gets a verdict");
        assert_eq!(report.files.len(), 1);
        // The name of a temporary folder may hold any letters.
        let json = report.json().replace(&*folder.path().to_string_lossy(), "");
        assert!(!json.contains("NaN"), "{json}");
    }
    if lot < 4 {
        // Aligned or refused.
        let _ = align(&DESIGN.mirror, &read.mesh);
    }
}

/// Traces what is near the part, all rays at once and one by one, which must answer alike.
fn traced(read: &ImportedMesh) {
    const REACH_MM: f64 = 100.0;
    let mut near = Welder::new(0);
    for t in 0..read.mesh.triangles.len() {
        let corners = read.mesh.corners(t);
        if corners.iter().all(|v| v.length() <= REACH_MM) {
            near.add(corners);
        }
    }
    let scene = Scene::new(near.finish());
    let Some((lo, hi)) = scene.bounds() else { return };
    let top = hi.z + (hi - lo).max_element();
    let camera = &DESIGN.camera;
    let nothing = ShownContent::NONE;
    let expected = ExpectedRay { aimed: true, direction: DVec3::Z, designed: nothing };
    let table = |_, rays: &[PixelRay]| vec![expected; rays.len()];
    let view = DESIGN.view.as_ref();
    let trace = CameraTrace::new(&scene, camera, top);
    let (at_once, _) = TraceResult::new(&trace, None, view, table);
    let (one_by_one, _) = TraceResult::new(&trace.without_shortcuts(), None, view, table);
    for (a, b) in one_by_one.pixels.iter().zip(&at_once.pixels) {
        let alike = match (a.outcome, b.outcome) {
            // By whichever facet was found first.
            (Outcome::Shadowed(_), Outcome::Shadowed(_)) => true,
            (a, b) => a == b,
        };
        assert!(
            alike && a.hit_point == b.hit_point && a.direction == b.direction,
            "{a:?} is not {b:?}"
        );
    }
}
