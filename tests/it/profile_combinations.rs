//! Valid combinations of camera, projection, layout, shape and part, and the types they come to.

use crate::support::least::{strip_of, with};
use morion::internals::optics::{CameraModel, RadialLawKind, StripLaw, Target};
use morion::internals::profile::{
    Conic, Layout, Method, MethodKind, Monomial, Polynomial, ProjectionSpec, RadialLawSpec,
    RadialSpec, ShapeSpec, StripLawSpec, StripSpec,
};

const STRIP: (&str, &str) = ("layout.conquistador", "layout.strip");
const DISC: (&str, &str) = ("layout.conquistador = {}", "layout.disc = {}");
const ANNULUS: (&str, &str) =
    ("layout.conquistador = {}", "layout.annulus = { inner_width_mm = 20 }");
const PINHOLE: (&str, &str) = (
    "camera.orthographic.pixels = [640, 480]",
    "camera.pinhole = { pixels = [640, 480], focal_px = 800, distance_mm = 100 }",
);
const PROJECTION: &str =
    "projection.cylindrical = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }";
const METHOD: &str = "method.vector-field.degree = 12";

#[test]
fn a_pinhole_is_given_by_focal_length_or_angle_of_view() {
    let focal = CameraModel::Pinhole { pixels: [640, 480], focal_px: 800.0, distance_mm: 100.0 };
    assert_eq!(with(&[PINHOLE]).expect("valid").camera, focal);
    assert_eq!(focal.pixels(), [640, 480]);
    // A lens of 12.5 mm over pixels of 3.45 um.
    let lens = with(&[PINHOLE, ("focal_px = 800", "lens_mm = 12.5, pixel_um = 3.45")]);
    let CameraModel::Pinhole { focal_px, .. } = lens.expect("valid").camera else {
        panic!("a pinhole")
    };
    assert!((focal_px - 12.5 / 3.45e-3).abs() < 1e-9, "{focal_px}");
    let view = with(&[PINHOLE, ("focal_px = 800", "hfov_deg = 90")]).expect("valid");
    let CameraModel::Pinhole { focal_px, .. } = view.camera else { panic!("{:?}", view.camera) };
    assert!((focal_px - 320.0).abs() < 1e-10);
    // The frame is 80 mm wide at 100 mm, and the part must be.
    let fill = ("layout.conquistador = {}", "layout.conquistador = { fill_frame = true }");
    assert!(with(&[PINHOLE, fill]).is_err());
    assert!(with(&[PINHOLE, fill, ("width_mm = 60", "width_mm = 79.9999")]).is_err());
    assert!(with(&[PINHOLE, fill, ("width_mm = 60", "width_mm = 80")]).is_ok());
    let strip = ("layout.conquistador = {}", "layout.strip = { fill_frame = true }");
    assert!(with(&[PINHOLE, strip]).is_err());
    assert!(with(&[strip]).is_ok());
}

#[test]
fn strip_laws_and_targets() {
    for (name, law) in [
        ("cylindrical", StripLawSpec::Named(StripLaw::Cylindrical)),
        ("mercator", StripLawSpec::Named(StripLaw::Mercator)),
        ("equirectangular", StripLawSpec::Named(StripLaw::Equirectangular)),
        ("equal-area", StripLawSpec::Named(StripLaw::EqualArea)),
        ("best", StripLawSpec::LeastCurl),
    ] {
        for layout in [STRIP, ("layout.conquistador", "layout.conquistador")] {
            let profile = with(&[layout, ("cylindrical", name)]).expect("valid");
            let expected = StripSpec {
                law: law.clone(),
                azimuth_deg: [-180.0, 180.0],
                elevation_deg: [-30.0, 30.0],
                target: Target::Infinity,
            };
            assert_eq!(strip_of(&profile), &expected);
        }
    }
    let rows = "[[-7.5, 40], [0, 10], [100, -20]]";
    let table = with(&[("cylindrical", "table"), ("[-30, 30]", rows)]).expect("valid");
    let table = strip_of(&table);
    assert_eq!(table.law, StripLawSpec::Table(vec![[-7.5, 40.0], [0.0, 10.0], [100.0, -20.0]]));
    assert_eq!(table.elevation_deg, [-20.0, 40.0]);
    for (elevation, target, expected) in [
        ("[-30, 30]", "radius_mm = 30.01", Target::Cylinder { radius_mm: 30.01 }),
        ("[-30, 30]", "radius_mm = 1e12", Target::Cylinder { radius_mm: 1e12 }),
        ("[0.1, 30]", "plane_mm = 200", Target::Plane { height_mm: 200.0 }),
        ("[-30, -1]", "plane_mm = -1e-3", Target::Plane { height_mm: -1e-3 }),
    ] {
        let range = format!("{elevation}, target_{target}");
        let profile = with(&[("[-30, 30]", &range)]).expect("valid");
        assert_eq!(strip_of(&profile).target, expected);
        assert_eq!(*profile.projection.expect("there").target(), expected);
    }
}

/// Every radial law with every camera and outline, at a target far away: what is valid, and what
/// becomes of the inner polar angle.
#[test]
fn radial_laws_with_every_camera_and_outline() {
    use RadialLawKind::*;
    for (name, law) in [
        ("parabolic", Parabolic),
        ("hyperbolic", Hyperbolic),
        ("conical", Conical),
        ("equiangular", Equiangular),
        ("tangent-proportional", TangentProportional),
        ("area-proportional", AreaProportional),
        ("plane", Plane),
        ("equi-areal", EquiAreal),
        ("cylinder", Cylinder),
    ] {
        for (camera, pinhole) in [(("640", "640"), false), (PINHOLE, true)] {
            for (layout, annulus) in [(DISC, false), (ANNULUS, true)] {
                for inner in [None, Some(0.0), Some(20.0), Some(60.0)] {
                    let key = inner.map_or(String::new(), |f| format!(", inner_polar_deg = {f}"));
                    let text = format!("projection.{name} = {{ outer_polar_deg = 60{key} }}");
                    let found = with(&[camera, layout, (PROJECTION, &text)]);
                    let camera_fits = match law {
                        Parabolic => !pinhole,
                        Hyperbolic | Conical => pinhole,
                        _ => true,
                    };
                    let inner_fits = match inner {
                        _ if !law.has_two_parameters() => inner.is_none(),
                        None => !annulus,
                        Some(f) if annulus => f < 60.0 && (f > 0.0 || law != Cylinder),
                        Some(f) => f == 0.0,
                    };
                    let valid = camera_fits && inner_fits && (annulus || !law.needs_annulus());
                    assert_eq!(found.is_ok(), valid, "{text} {layout:?} {found:?}");
                    let Ok(profile) = found else { continue };
                    let expected = RadialSpec {
                        law: RadialLawSpec::Named(law),
                        inner_polar_deg: inner.filter(|_| annulus),
                        outer_polar_deg: 60.0,
                        target: Target::Infinity,
                    };
                    assert_eq!(profile.projection, Some(ProjectionSpec::Radial(expected)));
                    let outline = match annulus {
                        true => Layout::Annulus { inner_width_mm: 20.0 },
                        false => Layout::Disc,
                    };
                    assert_eq!(profile.layout, outline);
                }
            }
        }
    }
}

/// A table of polar angles with every camera and outline: what is valid, and what becomes of its ends.
#[test]
fn tables_of_polar_angles_with_every_camera_and_outline() {
    let table = |rows: &[[f64; 2]]| format!("projection.table = {{ polar_deg = {rows:?} }}");
    for camera in [("640", "640"), PINHOLE] {
        for (layout, annulus) in [(DISC, false), (ANNULUS, true), (STRIP, false)] {
            for first in [0.0, 25.0] {
                let rows = vec![[0.0, first], [0.25, 40.0], [1.0, 179.9]];
                let found = with(&[camera, layout, (PROJECTION, &table(&rows))]);
                let valid = layout != STRIP && (annulus || first == 0.0);
                assert_eq!(found.is_ok(), valid, "{layout:?} {first} {found:?}");
                let Ok(profile) = found else { continue };
                let expected = RadialSpec {
                    law: RadialLawSpec::Table(rows),
                    inner_polar_deg: annulus.then_some(first),
                    outer_polar_deg: 179.9,
                    target: Target::Infinity,
                };
                assert_eq!(profile.projection, Some(ProjectionSpec::Radial(expected)));
            }
        }
    }
    for rows in [
        &[[0.0, 0.0]][..],
        &[[0.0, 0.0], [0.5, 20.0]],
        &[[0.5, 0.0], [1.0, 20.0]],
        &[[0.0, 0.0], [0.5, 20.0], [0.5, 30.0], [1.0, 40.0]],
        &[[0.0, 0.0], [0.5, 20.0], [1.0, 20.0]],
        &[[0.0, 0.0], [1.0, 180.0]],
        &[[0.0, 0.0], [1.5, 80.0]],
    ] {
        assert!(with(&[DISC, (PROJECTION, &table(rows))]).is_err(), "{rows:?}");
    }
}

#[test]
fn radial_targets() {
    let parse = |layout, law: &str| with(&[layout, (PROJECTION, &format!("projection.{law}"))]);
    for (layout, law, valid) in [
        (ANNULUS, "parabolic = { outer_polar_deg = 120, target_radius_mm = 200 }", true),
        (DISC, "parabolic = { outer_polar_deg = 120, target_radius_mm = 200 }", false),
        (DISC, "plane = { outer_polar_deg = 89, target_plane_mm = 200 }", true),
        (ANNULUS, "plane = { outer_polar_deg = 89, target_plane_mm = -200 }", false),
        // tan 80 over 3 is more than tan 45, tan 60 over 3 is less.
        (ANNULUS, "parabolic = { outer_polar_deg = 160, target_plane_mm = -200 }", true),
        (ANNULUS, "parabolic = { outer_polar_deg = 120, target_plane_mm = -200 }", false),
        (
            ANNULUS,
            "equiangular = { inner_polar_deg = 91, outer_polar_deg = 120, target_plane_mm = -9 }",
            true,
        ),
        (
            ANNULUS,
            "equiangular = { inner_polar_deg = 0, outer_polar_deg = 80, target_plane_mm = 9 }",
            true,
        ),
        (DISC, "table = { polar_deg = [[0, 0], [1, 89]], target_plane_mm = 200 }", true),
        (DISC, "table = { polar_deg = [[0, 0], [1, 90]], target_plane_mm = 200 }", false),
        (DISC, "table = { polar_deg = [[0, 0], [1, 89]], target_radius_mm = 200 }", false),
        (DISC, "table = { polar_deg = [[0, 0], [1, 89]], target_plane_mm = -200 }", false),
        (ANNULUS, "table = { polar_deg = [[0, 91], [1, 120]], target_plane_mm = -9 }", true),
        (ANNULUS, "table = { polar_deg = [[0, 90], [1, 120]], target_plane_mm = -9 }", false),
        (ANNULUS, "table = { polar_deg = [[0, 1], [1, 120]], target_radius_mm = 200 }", true),
        (ANNULUS, "table = { polar_deg = [[0, 0], [1, 120]], target_radius_mm = 200 }", false),
    ] {
        assert_eq!(parse(layout, law).is_ok(), valid, "{law}");
    }
}

#[test]
fn methods() {
    for (name, kind) in [
        ("vector-field", MethodKind::VectorField),
        ("fixed-surface", MethodKind::FixedSurface),
        ("distribution", MethodKind::Distribution),
    ] {
        assert_eq!(kind.name(), name);
        let text = format!("method.{name} = {{ degree = 7, minimax = true }}");
        let profile = with(&[(METHOD, &text)]).expect("valid");
        assert_eq!(profile.shape, ShapeSpec::Designed(Method { kind, degree: 7, minimax: true }));
    }
}

#[test]
fn given_mirrors() {
    let dome = "mirror.polynomial = { radius_mm = -80, conic = -1, terms = [[2, 1, 1e-5]] }";
    let polynomial = ShapeSpec::Polynomial(Polynomial {
        conic: Some(Conic { radius_mm: -80.0, conic: -1.0 }),
        terms: vec![Monomial { i: 2, j: 1, c: 1e-5 }],
    });
    let bare = (PROJECTION, "");
    let rectangle = [(METHOD, dome), bare, ("layout.conquistador = {}", "")];
    let tall = ("width_mm = 60", "width_mm = 60, height_mm = 40");
    let profile = with(&[&rectangle[..], &[tall]].concat()).expect("valid");
    assert_eq!(profile.shape, polynomial);
    assert_eq!(profile.layout, Layout::Rectangle { height_mm: Some(40.0) });
    assert_eq!(profile.projection, None);
    assert!(with(&rectangle).is_err());
    for (layout, expected) in
        [(DISC, Layout::Disc), (ANNULUS, Layout::Annulus { inner_width_mm: 20.0 })]
    {
        let profile = with(&[(METHOD, dome), bare, layout]).expect("valid");
        assert_eq!((profile.layout, profile.projection), (expected, None));
        assert!(with(&[(METHOD, dome), bare, layout, tall]).is_err());
    }
    let strip = with(&[(METHOD, dome), STRIP]).expect("valid");
    assert_eq!(strip.shape, polynomial);
    assert_eq!(strip_of(&strip).law, StripLawSpec::Named(StripLaw::Cylindrical));
    let grid = with(&[(METHOD, "mirror.grid.file = \"sag.csv\""), bare, DISC]).expect("valid");
    assert_eq!(grid.shape, ShapeSpec::Grid { file: "sag.csv".into() });
    let one = with(&[(METHOD, "mirror.polynomial.terms = [[0, 40, -1]]"), bare, DISC]);
    let terms = vec![Monomial { i: 0, j: 40, c: -1.0 }];
    let polynomial = Polynomial { conic: None, terms };
    assert_eq!(one.expect("valid").shape, ShapeSpec::Polynomial(polynomial));
}

#[test]
fn a_misspelt_parent_draws_one_complaint() {
    for (old, new) in [
        ("camera.orthographic", "camra.orthographic"),
        ("projection.cylindrical", "projecton.cylindrical"),
        ("projection.cylindrical", "projection.cylindricl"),
        ("layout.conquistador", "layuot.conquistador"),
        ("method.vector-field", "methd.vector-field"),
        ("method.vector-field.degree", "miror.polynomial.radius_mm"),
        ("part =", "parts ="),
        ("mesh.chord_um", "msh.chord_um"),
    ] {
        let complaints = with(&[(old, new)]).expect_err("misspelt");
        assert_eq!(complaints.matches("least.toml:").count(), 1, "{complaints}");
    }
}
