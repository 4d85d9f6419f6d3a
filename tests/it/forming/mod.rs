//! Moulds and mandrels: parallel surfaces of closed forms, closed bodies in every format, the picture of what is formed on
//! them, and refusals where no sheet follows the mirror.

mod closed_forms;

use crate::support::builds::{folder, parsed};
use crate::support::parts::{ANNULUS, CONQUISTADOR, DISC, GIVEN, PINHOLE, STRIP};
use crate::support::{designed, meshed, share, unlimited, with_limits};
use morion::internals::design::{DesignError, design};
use morion::internals::forming::{FormedFace, FormingFault, FormingTool, ParallelSurface};
use morion::internals::geom::{DVec2, DVec3, Precision};
use morion::internals::mirror::PlanJacobian;
use morion::internals::pipeline::{
    Command, DrawingOptions, MachiningOptions, Silent, build, verify,
};
use morion::internals::profile::Profile;
use morion::internals::results::{BuildReport, Reason, ReasonKind, ShapeFault, Verdict};

const FORMATS: (&str, &str) =
    ("[\"stl\", \"obj\"]", "[\"stl\", \"obj\", \"3mf\", \"glb\", \"step\"]");

/// A part of such a form with a flat rim.
fn part(form: &str) -> String {
    format!(
        "part = {{ width_mm = 60, base_mm = 12, border_mm = 25, rim_mm = 5, form = \"{form}\", \
         holes_mm = [[50, 3, 3]], marks_mm = [[-50, 3, 1]] }}\n"
    )
}

/// The same without holes and marks.
fn bare(form: &str) -> String {
    let part = part(form);
    let (rim, _) = part.split_once(", holes_mm").unwrap();
    format!("{rim} }}\n")
}

/// A dome of a conic with a vertex radius of 80 mm and a flat rim.
fn conic(conic: f64, form: &str, forming: &str) -> Profile {
    let text =
        GIVEN.replace(", terms = [[3, 0, 1e-5], [0, 1, 0.01]]", &format!(", conic = {conic}"));
    let text = format!("{text}layout.disc = {{}}\n{}forming = {{ {forming} }}\n", part(form));
    parsed(&text.replace(FORMATS.0, FORMATS.1))
}

/// A dome of a sphere of 80 mm with a flat rim.
fn dome(form: &str, forming: &str) -> Profile {
    conic(0.0, form, forming)
}

fn built(profile: &Profile) -> BuildReport {
    let folder = folder();
    build(profile, folder.path(), &Silent).unwrap_or_else(|error| panic!("{error}"))
}

/// Facets of the tool, moved back through the sheet along the normals that they tell, are those of the mirror.
#[test]
fn what_is_formed_on_a_dome_has_the_mirrors_facets() {
    for (form, forming) in [
        ("mandrel", "sheet_mm = 3, shrinkage_ppm = 5000"),
        ("mould", "sheet_mm = 3, mirror_side = \"free\""),
        ("mould", ""),
    ] {
        let profile = dome(form, forming);
        let design = designed(&profile);
        let tool = design.tool.as_ref().unwrap();
        let face = meshed(&profile, &design).unwrap();
        let solid = closed(&design, tool, &face);
        let FormedFace { mesh, worst_vertex } = FormedFace::of(tool, &design.mirror, solid.mesh());
        assert_eq!(mesh.triangles.len(), face.mesh.triangles.len(), "{form} {forming}");
        assert!(worst_vertex.unwrap().1 < 1e-8, "{form} {forming}: {worst_vertex:?}");
        let centre = DVec3::Z * (12.0 - 80.0 * f64::sqrt(1.0 - 0.140625));
        for t in 0..mesh.triangles.len() {
            assert!(mesh.area_vector(t).z > 0.0);
            for v in mesh.corners(t) {
                let off = ((v - centre).length() - 80.0).abs();
                // Facets on one side tell less of a normal: a tenth of the chord may be left.
                let on_edge = v.truncate().length() > 29.9;
                assert!(off < if on_edge { 2e-3 } else { 1e-5 }, "{form} {forming}: {v} {off:e}");
            }
        }
        let reach = mesh.vertices.iter().map(|v| v.truncate().length()).fold(0.0, f64::max);
        assert!((30.0..30.1).contains(&reach), "{form} {forming}: {reach}");
    }
}

fn closed(
    design: &morion::internals::design::Design,
    tool: &FormingTool,
    face: &morion::internals::mesh::Face,
) -> morion::internals::solid::Solid {
    let made = tool.face(&design.mirror, face.mesh.clone());
    morion::internals::solid::Solid::from_face(&made, tool.features(), Precision::Double).unwrap()
}

/// Every layout, as a mould and as a mandrel, with and without a sheet's thickness between mirror and tool: closed, of the
/// expected volume, each vertex and curved face where it is designed, and the picture of what is formed that of the part.
#[test]
#[ignore = "long: .ci/nightly"]
fn tools_of_every_layout_pass_in_every_format() {
    let bases = [
        (STRIP, "sheet_mm = 1.5, mirror_side = \"free\""),
        (CONQUISTADOR, "sheet_mm = 1, mirror_side = \"tool\", shrinkage_ppm = 4000"),
        (DISC, "sheet_mm = 1, mirror_side = \"free\", draft_deg = 10"),
        (ANNULUS, "sheet_mm = 0.8, mirror_side = \"free\", shrinkage_ppm = 4000"),
        (PINHOLE, "sheet_mm = 1.5, mirror_side = \"free\""),
        (GIVEN, "sheet_mm = 1.5, mirror_side = \"free\", draft_deg = 30"),
    ];
    let cases = bases.into_iter().flat_map(|base| [(base, "mould"), (base, "mandrel")]);
    // (A conquistador's mould and an annulus's mandrel, which are written in every format.)
    for ((base, forming), form) in share(5, 2, cases) {
        let layout = if base == GIVEN { "layout.disc = {}\n" } else { "" };
        let formats = match base {
            // A round outline with a mirror that is not round has no spline of a tool.
            GIVEN => "[\"stl\", \"obj\", \"glb\"]",
            ANNULUS | CONQUISTADOR => FORMATS.1,
            _ => "[\"stl\", \"step\"]",
        };
        let text = format!("{base}{layout}{}forming = {{ {forming} }}\n", part(form));
        let source = unlimited(parsed(&text.replace(FORMATS.0, formats)));
        // With the facets that the tool has, which keep to a share of the limits.
        let share = design(&source).unwrap().tool.unwrap().mesh_share();
        let plain = part("part").replace(", form = \"part\"", "");
        let text = format!("{base}{layout}{plain}");
        let plain = unlimited(parsed(&text.replace(FORMATS.0, "[\"stl\"]")));
        let [chord_um, facet_px] = [plain.mesh.chord_um(), plain.mesh.facet_px()];
        let [chord_um, facet_px] = [chord_um, facet_px].map(|limit| limit.map(|x| share * x));
        let of_part = built(&with_limits(plain, chord_um, facet_px));
        let report = built(&source);
        assert_eq!(report.verdict, Verdict::Pass, "{text}: {:?}", report.reasons);
        for trace in &report.trace {
            assert_eq!(trace.solid.check.euler, 0, "{text}");
            let (here, there) = (&trace.errors, &of_part.trace[0].errors);
            if let (Some(here), Some(there)) = (&here.pixel_error_px, &there.pixel_error_px) {
                let off = (here.rms - there.rms).abs();
                assert!(off < 0.02 * there.rms, "{text}: {} {}", here.rms, there.rms);
            }
        }
        assert_eq!(report.holes.len(), 1);
        let side = if form == "mould" { -3.0 } else { 3.0 };
        assert_eq!(report.holes[0].at_mm, [50.0, side]);
    }
}

/// Newton's method finds the place beside which a parallel surface has any X and Y.
#[test]
fn places_beside_a_parallel_surface_are_found_again() {
    for base in [STRIP, PINHOLE, ANNULUS] {
        let design = designed(&parsed(&format!("{base}{}", part("part"))));
        for offset_mm in [-2.0, 0.0, 1.5] {
            let surface = ParallelSurface { mirror: &design.mirror, offset_mm };
            for (q, _) in design.mirror.outline.samples(12).concat() {
                let place = design.mirror.extended_surface(q);
                let beside = surface.beside(&place);
                let found = surface.place_over(beside.truncate()).unwrap();
                assert!(found.at.distance(place.at) < 1e-9, "{base} {q}: {}", found.at);
                // The derivative of one by the other.
                let step = 1e-5;
                let moved = |by: DVec2| {
                    let q = design.mirror.extended_surface_over(place.at.truncate() + by).unwrap();
                    surface.beside(&q).truncate()
                };
                let PlanJacobian { x, y } = surface.plan_jacobian(&place);
                let by_x = (moved(DVec2::X * step) - moved(DVec2::NEG_X * step)) / (2.0 * step);
                let by_y = (moved(DVec2::Y * step) - moved(DVec2::NEG_Y * step)) / (2.0 * step);
                let off = [x.x - by_x.x, x.y - by_y.x, y.x - by_x.y, y.y - by_y.y];
                let inside = design.mirror.outline.contains(q * 1.001);
                assert!(!inside || off.iter().all(|off| off.abs() < 1e-6), "{base} {q}: {off:?}");
            }
        }
    }
}

/// Where the sheet is thicker than the radius of curvature, the place is told, and the hint works.
#[test]
fn a_sheet_that_cannot_follow_the_mirror_is_refused_with_its_place() {
    let bowl = |sheet: &str| {
        let text = GIVEN.replace(
            "radius_mm = -80, terms = [[3, 0, 1e-5], [0, 1, 0.01]]",
            "radius_mm = 40, conic = 0",
        );
        let forming = format!("forming = {{ sheet_mm = {sheet}, mirror_side = \"free\" }}\n");
        parsed(&format!("{text}layout.disc = {{}}\n{}{forming}", bare("mould")))
    };
    let Err(DesignError::Forming(fault)) = design(&bowl("41")) else { panic!("not refused") };
    let FormingFault::Curved { sheet_mm, radius_mm, at } = &fault else { panic!("{fault}") };
    assert!(*sheet_mm == 41.0 && (radius_mm - 40.0).abs() < 1e-6, "{fault}");
    assert!(at.truncate().length() <= 30.0 + 1e-9, "{fault}");
    let said = fault.to_string();
    let hint = said.split("forming.sheet_mm = ").nth(1).unwrap();
    let tool = design(&bowl(hint.split(' ').next().unwrap())).unwrap().tool.unwrap();
    assert!((tool.least_stretch - 0.1).abs() < 1e-6);
    // A dome's mandrel is thick at will only on the other side.
    assert!(design(&dome("mandrel", "sheet_mm = 85")).is_err());
    assert!(design(&dome("mould", "sheet_mm = 79.5, mirror_side = \"tool\"")).is_err());
}

/// The face of a mandrel may sink into its rim: the hint lifts it.
#[test]
fn a_face_below_its_flat_rim_is_refused_and_the_hint_works() {
    let thick = |base: &str| {
        let text = format!("{STRIP}{}forming = {{ sheet_mm = 9 }}\n", bare("mandrel"));
        parsed(&text.replace("base_mm = 12", &format!("base_mm = {base}")))
    };
    let error = design(&thick("12")).unwrap_err().to_string();
    let (_, hint) = error.split_once("set part.base_mm = ").unwrap_or_else(|| panic!("{error}"));
    let tool = design(&thick(hint.split(' ').next().unwrap())).unwrap().tool.unwrap();
    assert!(tool.size_mm[2] > tool.flange_mm);
}

#[test]
fn a_vertex_off_the_face_of_a_tool_fails() {
    let text = format!("{STRIP}{}forming = {{ sheet_mm = 1 }}\n", part("mandrel"));
    let (source, folder) = (unlimited(parsed(&text)), folder());
    assert_eq!(build(&source, folder.path(), &Silent).unwrap().verdict, Verdict::Pass);
    let path = folder.path().join("small/mirror.obj");
    let obj = std::fs::read_to_string(&path).unwrap();
    assert_eq!(verify(&source, &path, &Silent).unwrap().verdict, Verdict::Pass);
    let vertex = obj.lines().filter(|line| line.starts_with("v ")).nth(200).unwrap();
    let (head, z) = vertex.rsplit_once(' ').unwrap();
    let moved = format!("{head} {}", z.parse::<f64>().unwrap() + 0.03);
    std::fs::write(&path, obj.replacen(vertex, &moved, 1)).unwrap();
    let report = verify(&source, &path, &Silent).unwrap();
    let off = |reason: &Reason| matches!(&reason.kind, ReasonKind::Shape(ShapeFault::OffSurface { off_mm, .. }) if (0.011..0.03).contains(off_mm));
    assert!(report.reasons.iter().any(off), "{:?}", report.reasons);
}

/// Rays would meet the tool and not what is formed on it.
#[test]
fn a_step_file_of_a_tool_is_not_traced_as_a_mirror() {
    let text = format!("{STRIP}{}", part("mandrel")).replace(FORMATS.0, "[\"step\"]");
    let (source, folder) = (unlimited(parsed(&text)), folder());
    assert_eq!(build(&source, folder.path(), &Silent).unwrap().verdict, Verdict::Pass);
    let path = folder.path().join("small/mirror.step");
    let error = verify(&source, &path, &Silent).unwrap_err().to_string();
    assert!(error.contains("formed on a mandrel is traced at facets alone"), "{error}");
}

/// What does not go with a tool is refused by name.
#[test]
fn what_does_not_go_with_a_tool_is_refused() {
    let said = |text: String| match Profile::parse("small", "small.toml", text.as_bytes()) {
        Ok(_) => panic!("not refused: {text}"),
        Err(complaints) => complaints.to_string(),
    };
    let bare = "part = { width_mm = 60, base_mm = 12, form = \"mould\" }\n";
    for (text, words) in [
        (format!("{STRIP}{bare}"), "must go with part.border_mm, found none"),
        (format!("{STRIP}{}", bare.replace("mould", "mold")), "did you mean \"mould\"?"),
        (
            format!("{STRIP}{}forming.sheet_mm = 1\n", bare.replace(", form = \"mould\"", "")),
            "forming must go with part.form, found it alone",
        ),
        (
            format!("{STRIP}{}forming.vents = 4\n", bare.replace("mould", "mandrel")),
            "must have part.border_mm for its vents, found none",
        ),
        (
            format!("{STRIP}{}forming.vents = 4\n", part("mould")),
            "forming.vents must go with part.form = \"mandrel\"",
        ),
        (
            format!("{STRIP}{}forming.back_mm = 4\n", part("mandrel")),
            "forming.back_mm must go with part.form = \"mould\"",
        ),
        (
            format!("{STRIP}{}forming.vent_mm = 1\n", part("mandrel")),
            "forming.vent_mm must go with vents",
        ),
        (
            format!("{CONQUISTADOR}{}forming.sheet_mm = 1\n", part("mandrel")),
            "must have the mirror of a folded layout on the tool",
        ),
        (
            format!("{STRIP}{}", part("mould")).replace(FORMATS.0, "[\"stl\", \"csv\"]"),
            "must go with other formats, found \"csv\"",
        ),
        (
            format!("{STRIP}{}export.step.schema = \"ap242\"\n", part("mould")),
            "must go with another schema of export.step",
        ),
        (
            format!(
                "{STRIP}{}[[hole]]\nat_mm = [[1, 2]]\ndowel_mm = 3\ndepth_mm = 4\n",
                part("mould")
            ),
            "must have through holes alone, found a blind one at [1, 2]",
        ),
        (format!("{STRIP}{}forming.draft_deg = 0\n", part("mould")), "from 0.1 to 60"),
    ] {
        let found = said(text.clone());
        assert!(found.contains(words), "{found}\n{text}");
    }
    let round = GIVEN.replace(FORMATS.0, "[\"step\"]");
    let text = format!("{round}layout.disc = {{}}\n{}", part("mandrel"));
    let folder = folder();
    let error = build(&parsed(&text), folder.path(), &Silent).unwrap_err().to_string();
    assert!(error.contains("only when the mirror is round"), "{error}");
}

/// Cutters and drawings are told of the part alone.
#[test]
fn machining_and_drawings_of_a_tool_are_refused() {
    let profile = unlimited(parsed(&format!("{STRIP}{}", part("mould"))));
    let folder = folder();
    let error = DrawingOptions.publish(&profile, folder.path(), &Silent).unwrap_err();
    assert!(error.to_string().contains("leave part.form out"), "{error}");
    let machining = MachiningOptions { ball_mm: 3.0, ..MachiningOptions::default() };
    let error = machining.publish(&profile, folder.path(), &Silent).unwrap_err();
    assert!(error.to_string().contains("leave part.form out"), "{error}");
}

/// Vents go through a mandrel along the foot of its walls; where there is no room for them, that is told.
#[test]
#[ignore = "long: .ci/nightly"]
fn vents_are_drilled_along_the_foot() {
    for base in [STRIP, DISC] {
        let text =
            |more: &str| format!("{base}{}forming = {{ vents = 9{more} }}\n", part("mandrel"));
        let report = built(&unlimited(parsed(&text(""))));
        assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
        assert_eq!(report.holes.len(), 10);
        assert_eq!(report.trace[0].solid.check.euler, 2 - 20);
        assert!(report.holes[1..].iter().all(|hole| hole.diameter_mm == 0.6));
        let error = design(&parsed(&text(", vent_mm = 40"))).unwrap_err().to_string();
        assert!(error.contains("holes_mm and vents of a mandrel must stay"), "{error}");
    }
}
