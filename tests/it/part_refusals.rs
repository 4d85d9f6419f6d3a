//! What does not fit around a mirror is refused with its place; what is not refused closes.

use crate::support::builds::parsed;
use crate::support::draws::Draws;
use crate::support::meshed;
use crate::support::parts::{ANNULUS, CONQUISTADOR, DISC, GIVEN, PINHOLE, STRIP};
use morion::internals::design::{DesignError, design};
use morion::internals::export::step::{FitError, fit_splines};
use morion::internals::geom::Precision;
use morion::internals::profile::Profile;
use morion::internals::solid::Solid;
use std::f64::consts::PI;

/// What does not fit is refused at its place, or by the design where the profile cannot tell.
#[test]
fn what_does_not_fit_is_refused_with_its_place() {
    let refused = |base: &str, part: &str| {
        let text = format!("{}[part]\n{part}\n", base.trim_start());
        let complaints = Profile::parse("p", "p.toml", text.as_bytes()).expect_err(part);
        complaints.0.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let sized = "width_mm = 60\nbase_mm = 8";
    for (base, part, expected) in [
        (
            STRIP,
            "holes_mm = [[36.5, 0, 3]]\nborder_mm = 8",
            "p.toml:8:13: part.holes_mm must stay 0.1 mm clear of the part's side",
        ),
        (
            STRIP,
            "border_mm = 8\nholes_mm = [[34, 0, 3],[20, 5, 4]]",
            "p.toml:9:24: part.holes_mm must stay 0.1 mm clear of the mirror, found [20, 5, 4], which \
             cuts",
        ),
        (
            CONQUISTADOR,
            "border_mm = 8\nmarks_mm = [[0, 22.9, 1]]",
            "p.toml:9:13: part.marks_mm must stay 0.1 mm clear of the mirror, found [0, 22.9, 1]",
        ),
        (
            DISC,
            "border_mm = 8\nholes_mm = [[22, 22, 3]]",
            "p.toml:9:13: part.holes_mm must stay 0.1 mm clear of the mirror",
        ),
        (
            ANNULUS,
            "border_mm = 8\nholes_mm = [[0, 0, 10], [4, 6, 3]]",
            "p.toml:9:25: part.holes_mm must stay 0.1 mm clear of the mirror, found [4, 6, 3], which cuts",
        ),
        (
            ANNULUS,
            "border_mm = 8\nmarks_mm = [[0, 0, 2]]",
            "p.toml:9:13: part.marks_mm must stay 0.1 mm clear of the mirror",
        ),
        (
            ANNULUS,
            "border_mm = 8\nmarks_mm = [[34, 0, 1], [34, 0.5, 1]]",
            "p.toml:9:25: part.marks_mm must stay 0.1 mm clear of the mark [34, 0, 1]",
        ),
        (
            GIVEN,
            "border_mm = 8\nheight_mm = 40\nholes_mm = [[36.2, 26.2, 2]]\ncorner_radius_mm = 8",
            "p.toml:8:13: part.holes_mm must stay 0.1 mm clear of the part's side",
        ),
        (
            DISC,
            "border_mm = 8\ncorner_radius_mm = 4",
            "p.toml:9:20: part.corner_radius_mm must be left out with [layout.disc], found 4",
        ),
        (STRIP, "border_mm = 8\ncorner_radius_mm = 28", "p.toml:9:20: part.corner_radius_mm must "),
        (STRIP, "rim_mm = 2", "p.toml:8:10: part.rim_mm must go with border_mm"),
        (STRIP, "edge_chamfer_mm = 1", "p.toml:8:19: part.edge_chamfer_mm must go with border_mm"),
        (
            STRIP,
            "border_mm = 8\nedge_chamfer_mm = 0.05",
            "p.toml:9:19: part.edge_chamfer_mm must be a number from 0.1 to 1000000, found 0.05",
        ),
        (
            STRIP,
            "border_mm = 8\nedge_chamfer_mm = 2",
            "p.toml:9:19: part.edge_chamfer_mm must leave 0.1 mm of side between them, found 2 for rim_mm \
             = 4\n  hint: set edge_chamfer_mm = 1.95",
        ),
        (
            DISC,
            "border_mm = 1\nrim_mm = 4\nedge_chamfer_mm = 1",
            "p.toml:10:19: part.edge_chamfer_mm must leave 0.1 mm of flat rim, found 1 for border_mm = 1\n  \
             hint: set edge_chamfer_mm = 0.9",
        ),
        // The width of a pinhole's strip is not known yet.
        (
            PINHOLE,
            "border_mm = 8\ncorner_radius_mm = 1\nedge_chamfer_mm = 1",
            "p.toml:10:19: part.edge_chamfer_mm must leave 0.1 mm of radius of the corners, found 1 for \
             corner_radius_mm = 1\n  hint: set edge_chamfer_mm = 0.9",
        ),
        (
            STRIP,
            "border_mm = 8\nedge_chamfer_mm = 1\nmarks_mm = [[0, 28, 2]]",
            "p.toml:10:13: part.marks_mm must stay 0.1 mm clear of the chamfer of the part's edge, found [0, 28, 2]",
        ),
        (
            STRIP,
            "border_mm = 8\nrim_mm = 8",
            "p.toml:9:10: part.rim_mm must be from 0.01 to 0.99 of base_mm = 8, found 8",
        ),
        (
            STRIP,
            "rim_mm = 1\nborder_mm = 8\nmarks_mm = [[34, 0, 1], [34, 5, 2]]",
            "p.toml:10:25: part.marks_mm must be less deep than 0.99 of rim_mm = 1, found a mark 1 mm",
        ),
        (STRIP, "border_mm = 0.01", "p.toml:8:13: part.border_mm must be a number from 0.1"),
        (
            STRIP,
            "border_mm = 8\nholes_mm = [[34, 0]]",
            "p.toml:9:13: part.holes_mm must hold entries [x, y, diameter], found a list of 2",
        ),
        (
            STRIP,
            "border_mm = 8\nholes_mm = [[34, 0, -3]]",
            "p.toml:9:21: the diameters in part.holes_mm must be numbers from 0.1 to 1000000",
        ),
        (
            STRIP,
            "border_mm = 8\nholes_mm = []",
            "p.toml:9:12: part.holes_mm must be a list of 1 to 200 entries",
        ),
    ] {
        let found = refused(base, &format!("{part}\n{sized}"));
        let first = found.first().map(String::as_str).unwrap_or_default();
        assert!(found.len() == 1 && first.starts_with(expected), "{part}: {found:#?}");
        assert!(found.iter().all(|c| c.contains("\n  hint: ")), "{found:#?}");
    }

    // A land is flat where the mirror is round.
    let text = |terms: &str| {
        let part = "width_mm = 60, base_mm = 8, border_mm = 8, holes_mm = [[1, 0, 4]]";
        let layout = "layout.annulus.inner_width_mm = 16";
        let base = GIVEN.replace("[[3, 0, 1e-5], [0, 1, 0.01]]", terms);
        format!("{layout}{base}part = {{ {part} }}\n")
    };
    let even = design(&parsed(&text("[[2, 0, 1e-3], [0, 2, 1e-3]]"))).unwrap();
    assert_eq!(even.holes(), 1);
    // Only a surface of revolution has a plane land in STEP.
    let carried = fit_splines(&even.mirror).unwrap().check_land(even.border.as_ref());
    assert_eq!(carried, Err(FitError::Land));
    let error = design(&parsed(&text("[[2, 0, 1e-3]]"))).unwrap_err().to_string();
    assert!(error.contains("found [1, 0, 4]; the land's rim is not flat"), "{error}");
    assert!(error.contains("by 0.0320 mm"), "{error}");

    // The footprint of a designed strip under a pinhole is an outcome of the design.
    let profile = parsed(&format!(
        "{PINHOLE}part = {{ width_mm = 60, base_mm = 8, border_mm = 8, holes_mm = [[27, 3, 4]] }}\n"
    ));
    let error = design(&profile).unwrap_err();
    assert!(matches!(error, DesignError::Border { .. }));
    let error = error.to_string();
    assert!(
        error.starts_with("part.holes_mm must stay 0.1 mm clear of the mirror, found [27, 3, 4]")
    );
    assert!(error.contains("move the hole outwards, to ["), "{error}");
}

/// Half of 2.1 mm and 2.3 mm of border are 3.35 mm, but for rounding.
#[test]
fn corners_that_take_up_a_side_but_for_rounding_take_it_up() {
    for (height, border, corner) in [(2.1, 2.3, 3.35), (2.1, 1.1, 2.15)] {
        let part = format!(
            "part = {{ width_mm = 30, height_mm = {height}, base_mm = 8, border_mm = {border}, \
             corner_radius_mm = {corner} }}\n"
        );
        let profile = parsed(&format!("{GIVEN}{part}"));
        let contour = design(&profile).unwrap().border.unwrap().contour;
        let corners = contour.polygon();
        let next = corners.iter().cycle().skip(1);
        let least = corners.iter().zip(next).map(|(a, b)| a.distance(*b)).fold(1.0, f64::min);
        assert!(least > 1e-3, "{height} {border} {corner}: {least}");
    }
}

/// Random borders with random holes: refused with a reason, or a proven solid.
#[test]
#[ignore = "long: .ci/nightly"]
fn random_parts_close_or_are_refused() {
    let bases = [STRIP, CONQUISTADOR, DISC, ANNULUS, PINHOLE, GIVEN];
    let (mut r, mut of_edges) = (Draws::new(7), Draws::new(8));
    let [mut closed, mut refused] = [0, 0];
    for k in 0..120 {
        let base = bases[k % bases.len()];
        let size = r.octaves([1.0, 1000.0]);
        let border = r.octaves([0.1, 1.0]) * size;
        let reach = 0.5 * size + border;
        let thick = r.octaves([0.05, 1.0]) * size;
        let mut spots = |most: f64| {
            let count = 1 + (r.unit() * 4.0) as usize;
            let spot = |_| {
                let way = r.inside([0.0, 2.0 * PI]);
                let far = r.inside([0.4, 1.0]) * reach;
                let across = r.octaves([0.1, most.max(0.11)]);
                format!(
                    "[{}, {}, {across}]",
                    far * morion::internals::num::cos(way),
                    far * morion::internals::num::sin(way)
                )
            };
            (0..count).map(spot).collect::<Vec<_>>().join(", ")
        };
        let (holes, marks) = (spots(0.5 * border), spots(0.5 * border));
        let corner = r.octaves([0.1, 3.0]) * border;
        let height =
            if base == GIVEN { format!("height_mm = {}\n", 0.7 * size) } else { String::new() };
        let corner = match base {
            DISC | ANNULUS => String::new(),
            _ => format!("corner_radius_mm = {corner}\n"),
        };
        let holes = if r.chance(0.6) { format!("holes_mm = [{holes}]\n") } else { String::new() };
        let marks = if r.chance(0.6) { format!("marks_mm = [{marks}]\n") } else { String::new() };
        let scale = size / 60.0;
        let base = base
            .replace("distance_mm = 150", &format!("distance_mm = {}", 150.0 * scale))
            .replace("distance_mm = 100", &format!("distance_mm = {}", 100.0 * scale))
            .replace("radius_mm = -80", &format!("radius_mm = {}", -80.0 * scale))
            .replace(", terms = [[3, 0, 1e-5], [0, 1, 0.01]]", "")
            .replace("inner_width_mm = 16", &format!("inner_width_mm = {}", 16.0 * scale))
            .replace("chord_um = 20", &format!("chord_um = {}", 20.0 * scale));
        // (Chamfers of thin parts are refused, as are their holes.)
        let leg = of_edges.octaves([0.1, (0.1 * thick.min(border)).max(0.11)]);
        let is_chamfered = of_edges.chance(0.6) && thick.min(border) > 1.0;
        let edges = if is_chamfered { format!("edge_chamfer_mm = {leg}\n") } else { String::new() };
        let text = format!(
            "{base}[part]\nwidth_mm = {size}\nbase_mm = {thick}\nborder_mm = {border}\n{height}{corner}\
             {edges}{holes}{marks}"
        );
        let Ok(profile) = Profile::parse("p", "p.toml", text.as_bytes()) else {
            refused += 1;
            continue;
        };
        let design = match design(&profile) {
            Ok(design) => design,
            Err(DesignError::Border { .. }) => {
                refused += 1;
                continue;
            }
            Err(error) => panic!("{error}\n{text}"),
        };
        let face = meshed(&profile, &design).unwrap_or_else(|e| panic!("{e}\n{text}"));
        for precision in [Precision::Single, Precision::Double] {
            let solid = Solid::from_face(&face.mesh, design.features(), precision);
            let solid = solid.unwrap_or_else(|e| panic!("{e}\n{text}"));
            assert_eq!(solid.check().euler, 2 - 2 * design.holes() as i64);
        }
        closed += 1;
    }
    println!("{closed} closed, {refused} refused");
    assert!(closed > 30 && refused > 30, "{closed} closed, {refused} refused");
}
