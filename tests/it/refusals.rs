//! Limits and sizes at the far ends: a face within its limits, or a typed refusal, and soon.

use crate::support::{self, designed, limits, meshed, profile, share, shipped, with_limits};
use morion::internals::design::design;
use morion::internals::geom::{PartFeatures, Precision};
use morion::internals::mesh::{Face, MeshError};
use morion::internals::profile::Profile;
use morion::internals::solid::Solid;

/// A face, if there is one, is finite, within its limits and closes; a refusal has figures.
fn sound(what: &str, profile: &Profile, face: &Result<Face, MeshError>) {
    let limits = limits(profile, &designed(profile));
    match face {
        Ok(face) => {
            assert!(face.mesh.vertices.iter().all(|v| v.is_finite()), "{what}");
            assert!(limits.hold(&face.bound), "{what}: {:?} over {limits:?}", face.bound);
            let solid = Solid::from_face(&face.mesh, PartFeatures::NONE, Precision::Double);
            assert!(solid.is_ok(), "{what}: {}", solid.unwrap_err());
        }
        Err(MeshError::TooMany { facets, most }) => assert!(facets > most, "{what}: {facets}"),
        Err(MeshError::NotRefinable { at, size_mm, bound, .. }) => {
            assert!(at.is_finite() && size_mm.is_finite(), "{what}: {at} {size_mm}");
            assert!(!limits.hold(bound), "{what}: {bound:?} keeps {limits:?}");
        }
        Err(MeshError::PrecisionLimit { at, chord_mm, facet_mm }) => {
            let over = |reached: &Option<f64>, limit: Option<f64>| {
                reached.is_some_and(|r| limit.is_some_and(|limit| r >= limit))
            };
            let exceeds = over(chord_mm, limits.chord_mm) || over(facet_mm, limits.facet_mm);
            assert!(at.is_finite() && exceeds, "{what}: {chord_mm:?} {facet_mm:?} of {limits:?}");
        }
        Err(MeshError::OnAxis { at } | MeshError::SizeContrast { at }) => {
            assert!(at.is_finite(), "{what}: {at}")
        }
        Err(error) => panic!("{what}: {error}"),
    }
}

#[test]
fn limits_that_no_memory_holds_are_refused() {
    for (chord_um, facet_px) in [(None, Some(1e-3)), (None, Some(0.01)), (Some(5e-3), Some(1e-3))] {
        let profile = with_limits(shipped("panoramic"), chord_um, facet_px);
        let face = meshed(&profile, &designed(&profile));
        let what = format!("{chord_um:?} um, {facet_px:?} px");
        assert!(matches!(face, Err(MeshError::TooMany { .. })), "{what}: {:?}", face.err());
        sound(&what, &profile, &face);
    }
}

#[test]
fn limits_below_single_precision_are_refused() {
    let degree: &[(&str, &str)] = &[("[-180, 180]", "[0, 1]"), ("[-30, 30]", "[0, 1]")];
    for (what, edits, chord_um) in [
        ("the whole turn", &[][..], 1e-3),
        ("one degree", degree, 1e-4),
        ("one degree, a little more", degree, 2e-3),
        ("far above the base", &[("base_mm = 5", "base_mm = 100000")], 2.0),
    ] {
        let profile = with_limits(profile(edits), Some(chord_um), None);
        let face = meshed(&profile, &designed(&profile));
        let refused =
            matches!(face, Err(MeshError::NotRefinable { .. } | MeshError::PrecisionLimit { .. }));
        assert!(refused, "{what}: {:?}", face.err());
        sound(what, &profile, &face);
    }
}

#[test]
fn a_picture_finer_than_rounded_slopes_is_refused() {
    // A thousandth of a degree over 60 mm: rounding the sags tilts facets by more than a pixel.
    let edits = [("[-180, 180]", "[0, 0.001]"), ("[-30, 30]", "[0, 0.001]")];
    let profile = with_limits(profile(&edits), None, Some(1.0));
    let face = meshed(&profile, &designed(&profile));
    let refused =
        matches!(face, Err(MeshError::NotRefinable { .. } | MeshError::PrecisionLimit { .. }));
    assert!(refused, "{:?}", face.err());
    sound("a thousandth of a degree", &profile, &face);
}

/// What is advised works.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_picture_too_near_to_the_horizon_or_a_pole_is_refused_for_that() {
    let plane = "[-40, -2], target_plane_mm = -800";
    for (what, elevation, further, facet_px, said) in [
        ("horizon", plane, "[-40, -6], target_plane_mm = -800", 3.0, "further from the horizon"),
        ("pole", "[-75, 75]", "[-60, 60]", 60.0, "further from +-90 degrees"),
    ] {
        let of = |elevation: &str| {
            let profile = with_limits(profile(&[("[-30, 30]", elevation)]), None, Some(facet_px));
            let face = meshed(&profile, &designed(&profile));
            sound(what, &profile, &face);
            face
        };
        let error = of(elevation).expect_err(what);
        let floor = matches!(error, MeshError::NotRefinable { singularity: Some(_), .. });
        assert!(floor && error.to_string().contains(said), "{what}: {error}");
        assert!(of(further).is_ok(), "{what}");
    }
}

#[test]
fn mirrors_with_a_flat_place_are_refused() {
    // Of too low a degree, the mirror has a place without slope, which shows the zenith.
    for degree in ["degree = 1", "degree = 3"] {
        let edits = [("degree = 12", degree), ("[-30, 30]", "[-75, 75]")];
        for law in ["cylindrical", "mercator"] {
            let profile = profile(&[&edits[..], &[("cylindrical", law)]].concat());
            let face = meshed(&profile, &designed(&profile));
            assert!(face.is_err(), "{law}, {degree}");
            sound(degree, &profile, &face);
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn elevations_up_to_the_poles_give_a_right_answer_or_a_refusal() {
    let (mut made, mut refused) = (0, 0);
    for law in ["cylindrical", "mercator"] {
        for (k, degree) in ["degree = 12", "degree = 24"].into_iter().enumerate() {
            let ranges = ["[-75, 75]", "[-85, 85]", "[-89, 89]", "[-89.9, 89.9]"];
            for elevation in share(2, k, ranges) {
                let edits =
                    [("cylindrical", law), ("degree = 12", degree), ("[-30, 30]", elevation)];
                let what = format!("{law}, {degree}, {elevation}");
                let profile = with_limits(profile(&edits), None, Some(60.0));
                let Ok(design) = design(&profile) else {
                    refused += 1;
                    continue;
                };
                let face = meshed(&profile, &design);
                sound(&what, &profile, &face);
                println!("{what}: {:?}", face.as_ref().map(|f| f.mesh.triangles.len()));
                if face.is_ok() { made += 1 } else { refused += 1 }
            }
        }
    }
    let least = (made + refused) / 4;
    assert!(made >= least && refused >= least, "{made} made, {refused} refused");
}

#[test]
fn results_are_the_same_at_every_size() {
    let at = |width: &str| {
        // Both limits rule in places; what nothing limits depends on how coordinates round.
        let chord_um = 0.05 * width.parse::<f64>().unwrap();
        let width = format!("width_mm = {width}, base_mm = {width}");
        let profile = profile(&[("width_mm = 60, base_mm = 5", &width)]);
        with_limits(profile, Some(chord_um), Some(4.0))
    };
    let shape = |width: &str| {
        let profile = at(width);
        let design = designed(&profile);
        let face = meshed(&profile, &design).unwrap();
        sound(width, &profile, &Ok(face.clone()));
        let scale = design.view.as_ref().unwrap().projection.scale_mm();
        [
            face.mesh.triangles.len() as f64,
            face.bound.facet_mm / scale,
            face.bound.chord_mm / scale,
            face.optimum.facet(0.01 * scale).unwrap(),
            design.mirror.volume() / (scale * scale * scale),
        ]
    };
    let usual = shape("60");
    for width in ["0.001", "0.1", "1", "1000", "1000000"] {
        let found = shape(width);
        for (found, usual) in found.iter().zip(usual) {
            assert!((found / usual - 1.0).abs() < 0.05, "{width}: {found} for {usual}");
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn sizes_that_do_not_go_together_are_sound() {
    for (k, width) in ["0.001", "1", "1000", "1000000"].into_iter().enumerate() {
        for base in share(2, k, ["0.001", "5", "1000000"]) {
            let sizes = format!("width_mm = {width}, base_mm = {base}");
            for (chord_um, facet_px) in [(None, Some(4.0)), (Some(1000.0), None)] {
                let profile = profile(&[("width_mm = 60, base_mm = 5", &sizes)]);
                let profile = with_limits(profile, chord_um, facet_px);
                sound(&sizes, &profile, &meshed(&profile, &designed(&profile)));
            }
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn frames_of_any_shape_are_sound() {
    let layouts = ["strip = {}", "strip = { fill_frame = true }", "conquistador = {}"];
    for (k, pixels) in ["1, 1", "3, 2", "32767, 1", "1, 32767", "2, 3"].into_iter().enumerate() {
        for layout in share(2, k, layouts) {
            let edits = [("640, 480", pixels), ("strip = {}", layout)];
            for (chord_um, facet_px) in [(None, Some(40.0)), (Some(20.0), None)] {
                let profile = with_limits(profile(&edits), chord_um, facet_px);
                let what = format!("{pixels}, {layout}");
                let Ok(design) = design(&profile) else { continue };
                let face = meshed(&profile, &design);
                sound(&what, &profile, &face);
            }
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn a_frame_too_high_for_the_law_is_refused() {
    let fill = ("layout.strip = {}", "layout.strip = { fill_frame = true }");
    let high = ("[640, 480]", "[90, 120]");
    for (law, refused) in [
        ("equirectangular", true),
        ("equal-area", true),
        ("mercator", false),
        ("cylindrical", false),
    ] {
        let profile = profile(&[("cylindrical", law), fill, high]);
        let error = design(&profile).err().map(|error| error.to_string());
        assert_eq!(
            error.as_ref().is_some_and(|error| error.contains("leave fill_frame out")),
            refused,
            "{law}: {error:?}"
        );
        // What it asks for helps.
        assert!(design(&support::profile(&[("cylindrical", law), high])).is_ok(), "{law}");
    }
}
