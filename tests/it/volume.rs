//! The volume of the solid is that of the design, as far as the chord error lets it.

use crate::support::{designed, meshed, panel, profile, sag, shipped};
use morion::internals::design::Design;
use morion::internals::geom::{DVec2, DVec3, PartFeatures, Precision, TriMesh, turn};
use morion::internals::profile::{MeshGoal, Profile};
use morion::internals::solid::Solid;

/// The integral of the sag over all panels by Boole's rule, which the design does not know.
fn quadrature(design: &Design) -> f64 {
    const STEPS: usize = 512;
    let weight = |k: usize| match (k, k % 4) {
        (0 | STEPS, _) => 7.0,
        (_, 0) => 14.0,
        (_, 2) => 12.0,
        _ => 32.0,
    };
    let panel = panel(design);
    let cell = panel.size() / STEPS as f64;
    let line = |j: usize| {
        let y = panel.min.y + cell.y * j as f64;
        let at = |i: usize| sag(design, DVec2::new(panel.min.x + cell.x * i as f64, y));
        (0..=STEPS).map(|i| weight(i) * at(i)).sum::<f64>()
    };
    let sum: f64 = (0..=STEPS).map(|j| weight(j) * line(j)).sum();
    let rule = 2.0 / 45.0;
    let panels = if design.mirror.folded { 2.0 } else { 1.0 };
    panels * sum * rule * rule * cell.x * cell.y
}

/// Uneven, folded, filled, high and steep ones.
const CASES: [(&str, &[(&str, &str)]); 5] = [
    ("uneven azimuth", &[("[-180, 180]", "[-170, 60]"), ("[-30, 30]", "[-10, 45]")]),
    ("valley", &[("layout.strip = {}", "layout.conquistador = { ridge = \"valley\" }")]),
    ("section", &[("layout.strip = {}", "layout.conquistador = { panel = \"section\" }")]),
    ("60 degrees", &[("[-30, 30]", "[-60, 60]"), ("cylindrical", "mercator")]),
    ("high degree", &[("degree = 12", "degree = 24")]),
];

fn profiles() -> Vec<(&'static str, Profile)> {
    let shipped = ["panoramic", "conquistador", "conformal"].map(|name| (name, shipped(name)));
    let edited = CASES.map(|(what, edits)| (what, profile(edits)));
    shipped.into_iter().chain(edited).collect()
}

#[test]
fn the_designs_volume_is_the_integral_of_its_sag() {
    for (what, profile) in profiles() {
        let design = designed(&profile);
        let (found, expected) = (design.mirror.volume(), quadrature(&design));
        assert!((found / expected - 1.0).abs() < 1e-10, "{what}: {found} for {expected}");
    }
}

#[test]
fn the_solids_volume_is_the_designs_within_the_chord_bound() {
    for (what, mut profile) in profiles() {
        profile.mesh = MeshGoal::limits(profile.mesh.chord_um(), Some(4.0));
        let design = designed(&profile);
        let face = meshed(&profile, &design).unwrap();
        let slack = design.mirror.full_outline().area() * face.bound.chord_mm;
        for precision in [Precision::Single, Precision::Double] {
            let solid = Solid::from_face(&face.mesh, PartFeatures::NONE, precision).unwrap();
            let off = solid.check().volume_mm3 - design.mirror.volume();
            println!("{what} {precision:?}: off by {:.4} of the slack", off.abs() / slack);
            assert!(off.abs() <= slack, "{what}, {precision:?}: off by {off}, allowed {slack}");
            // A thin slack: the check can tell a part that is a hundredth of a millimetre too high.
            assert!(slack < 0.01 * design.mirror.full_outline().area() || what == "60 degrees");
        }
    }
}

/// Volume between the face and the mirror, mm^3, without sign: on saddles what lies above and what
/// lies below cancel.
fn gap(design: &Design, mesh: &TriMesh) -> f64 {
    const PLACES: [[f64; 3]; 4] =
        [[1.0, 1.0, 1.0], [4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]];
    let over = |t: usize| {
        let corners = mesh.corners(t);
        let at = |weights: [f64; 3]| {
            let sum: f64 = weights.iter().sum();
            let point: DVec3 = corners.iter().zip(weights).map(|(v, w)| *v * (w / sum)).sum();
            (point.z - sag(design, point.truncate())).abs()
        };
        let [a, b, c] = corners.map(DVec3::truncate);
        0.5 * turn(a, b, c) * PLACES.map(at).iter().sum::<f64>() / PLACES.len() as f64
    };
    (0..mesh.triangles.len()).map(over).sum()
}

#[test]
fn the_volume_error_falls_with_the_square_of_the_facets_size() {
    for law in ["cylindrical", "mercator"] {
        let profile = profile(&[("cylindrical", law)]);
        let [coarse, fine] = [4.0, 1.0].map(|chord_um| {
            let mesh = MeshGoal::limits(Some(chord_um), None);
            let profile = Profile { mesh, ..profile.clone() };
            let design = designed(&profile);
            let face = meshed(&profile, &design).unwrap().mesh;
            let solid = Solid::from_face(&face, PartFeatures::NONE, Precision::Double).unwrap();
            let (off, gap) =
                (solid.check().volume_mm3 - design.mirror.volume(), gap(&design, &face));
            println!("{law}, {chord_um} um: off by {off}, gap {gap}");
            assert!(off.abs() < 1.1 * gap, "{law}: off by {off}, gap {gap}");
            let area = design.mirror.outline.area() / face.triangles.len() as f64;
            [gap, area]
        });
        let (gap, area) = (coarse[0] / fine[0], coarse[1] / fine[1]);
        println!("{law}: gap by {gap}, mean area by {area}");
        assert!(area > 2.5 && (gap / area - 1.0).abs() < 0.25, "{law}: {gap} for {area}");
    }
}
