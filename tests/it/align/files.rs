//! Files of other makers through the whole program: units, form error, verdict, files, exit codes.

use super::copies::{Part, kept, moved, profile_text};
use crate::support::builds::{files, folder, morion, told};
use crate::support::draws::Draws;
use crate::support::refused;
use morion::internals::geom::TriMesh;
use morion::internals::num::cos;
use morion::internals::pipeline::{Command, LengthUnit, Silent, Verify, VerifyOptions, load};
use morion::internals::report::{Answer, TextLayout};
use morion::internals::results::{Verdict, VerifyReport};
use std::path::{Path, PathBuf};

/// Limits that the design keeps with little to spare, and such that large facets keep too.
const TIGHT: [f64; 2] = [1.2, 5.5];
const WIDE: [f64; 2] = [3.0, 10.0];

/// The conquistador's profile with limits for what it shows, in `folder`.
fn profile(folder: &Path, [rms, max]: [f64; 2]) -> PathBuf {
    let path = folder.join("small.toml");
    let limits = format!(
        "accept = {{ pixel_error_rms_px = {rms}, pixel_error_max_px = {max}, frame_filled = 0.98 }}\n"
    );
    std::fs::write(&path, format!("{limits}{}", profile_text("conquistador"))).unwrap();
    path
}

/// A binary STL, every coordinate times `factor`.
fn stl(mesh: &TriMesh, factor: f64) -> Vec<u8> {
    let mut bytes = vec![b'x'; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in 0..mesh.triangles.len() {
        bytes.extend([0; 12]);
        for corner in mesh.corners(t) {
            corner
                .to_array()
                .iter()
                .for_each(|x| bytes.extend(((x * factor) as f32).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

/// An OBJ with a normal at each corner, all of them along `normals` of the vertices.
fn obj(mesh: &TriMesh, normals: &[morion::internals::geom::DVec3]) -> String {
    let mut text = String::new();
    for v in &mesh.vertices {
        text += &format!("v {} {} {}\n", v.x, v.y, v.z);
    }
    for n in normals {
        text += &format!("vn {} {} {}\n", n.x, n.y, n.z);
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v + 1)) {
        text += &format!("f {a}//{a} {b}//{b} {c}//{c}\n");
    }
    text
}

fn look(file: &Path, limits: [f64; 2], units: Option<LengthUnit>, aligned: bool) -> VerifyReport {
    let folder = file.parent().unwrap();
    let source = load(profile(folder, limits).to_str().unwrap()).unwrap();
    let verify = Verify {
        path: file,
        options: VerifyOptions { units, align: aligned, ..VerifyOptions::default() },
    };
    let report = match aligned {
        true => verify.publish(&source, &folder.join("made"), &Silent),
        false => verify.in_memory(&source, &Silent).map(|(report, _)| report),
    };
    report.unwrap_or_else(|error| panic!("{error}"))
}

/// The scan of a conquistador whose surface is off along its normal by `mm(x)`.
fn rippled(part: &Part, steps: usize, mm: impl Fn(f64) -> f64) -> TriMesh {
    let mirror = &part.design.mirror;
    let mut mesh = part.scan(steps);
    for v in &mut mesh.vertices {
        let q = mirror.chart.coordinates(*v).0;
        *v += mirror.normal(q, &mirror.row(q.y).at(q.x)).normalize() * mm(v.x);
    }
    mesh
}

/// Steps of a scan along its longer side.
const STEPS: usize = 320;

#[test]
#[ignore = "long: .ci/nightly"]
fn a_known_form_error_is_reported_and_judged_by_what_it_does() {
    let part = Part::conquistador();
    let folder = folder();
    let home = folder.path();
    let mut draws = Draws::new(9);
    let plain = home.join("plain.stl");
    std::fs::write(&plain, stl(&part.scan(STEPS), 1.0)).unwrap();
    let chords = look(&plain, TIGHT, None, true).form_error_um.unwrap().all;
    assert!(chords.pv < 5.0 && chords.rms < 0.5, "{chords:?}");
    for (amplitude_um, period_mm, verdict) in
        [(5.0, 6.0, Verdict::Pass), (40.0, 4.0, Verdict::Fail)]
    {
        let wave = |x: f64| 1e-3 * amplitude_um * cos(2.0 * std::f64::consts::PI * x / period_mm);
        let mesh = rippled(&part, STEPS, wave);
        let pose = draws.pose(20.0, 0.2, part.width());
        let file = home.join("scan.stl");
        std::fs::write(&file, stl(&moved(&mesh, &pose), 1.0)).unwrap();
        let report = look(&file, TIGHT, None, true);
        let error = report.form_error_um.unwrap();
        // Chords of the mirror come on top of what was put in, and those of the ripple off its crests:
        // a k^2 h^2 / 8 for facets of length h.
        let steps = 2.0 * std::f64::consts::PI / period_mm * part.width() / STEPS as f64;
        let crest = amplitude_um * steps * steps / 8.0;
        let [low, high] = [error.all.lowest + amplitude_um, error.all.highest - amplitude_um];
        assert!((chords.lowest - 0.1..crest + 0.1).contains(&low), "{error:?} {chords:?}");
        assert!((-crest - 0.1..chords.highest + 0.1).contains(&high), "{error:?} {chords:?}");
        let rms = amplitude_um / f64::sqrt(2.0);
        assert!((error.all.rms - rms).abs() < 0.02 * rms, "{error:?}");
        assert!(error.outliers == 0.0 && error.pixels > 76_000, "{error:?}");
        let alignment = report.alignment.as_ref().unwrap();
        assert!((alignment.rms_um / rms - 1.0).abs() < 0.12, "{alignment:?}");
        assert_eq!(report.verdict, verdict, "{:#?}", report.reasons);
        // The ripple's slopes turn the rays by twice as much, where the mirror is level.
        let slope = 2.0 * std::f64::consts::PI / period_mm * rms;
        let turned = report.trace[0].errors.ray_error_mrad.unwrap().rms;
        assert!(turned < 2.2 * slope + 8.0 && turned > 0.8 * slope, "{turned} {slope}");
        let over = report
            .reasons
            .iter()
            .any(|r| r.to_string().contains(" px of accept.pixel_error_rms_px"));
        assert_eq!(over, verdict == Verdict::Fail, "{:#?}", report.reasons);
        // It is open, which is said and not held against it.
        let solid = &report.trace[0].solid;
        let rim = solid.check.open.unwrap();
        assert!(
            !solid.check.closed && rim.loops == 1 && rim.edges == 2 * (STEPS + 3 * STEPS / 4),
            "{rim:?}"
        );
        let layout = TextLayout { details: true, ..TextLayout::default() };
        let text = report.laid_out(&layout);
        for part in [
            "  units    mm (by size)",
            "  pose     turned by (",
            "  error    ",
            "rim edges in 1 loop",
        ] {
            assert!(text.contains(part), "{text}");
        }
        let json: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
        // Reading decimals quickly may cost the last bit.
        let pv = json["form_error_um"]["pv"].as_f64().unwrap();
        assert!((pv / error.all.pv - 1.0).abs() <= f64::EPSILON, "{pv} {error:?}");
        assert_eq!(json["units"]["mm_per_unit"], 1.0);
        assert_eq!(json["alignment"]["shift_mm"].as_array().unwrap().len(), 3);
        let written = std::fs::read_to_string(home.join("made/small-verify/report.json")).unwrap();
        assert_eq!(written, report.json());
        assert!(
            std::fs::read(home.join("made/small-verify/form_error.png"))
                .unwrap()
                .starts_with(b"\x89PNG")
        );
    }
    // In the part frame, but open: no solid, as ever.
    std::fs::write(home.join("face.stl"), stl(&part.scan(100), 1.0)).unwrap();
    let report = look(&home.join("face.stl"), WIDE, None, false);
    assert_eq!(report.verdict, Verdict::Fail);
    assert!(
        report.reasons.iter().any(|r| r.to_string().contains("open: only facet")),
        "{:#?}",
        report.reasons
    );
    assert!(report.alignment.is_none() && report.form_error_um.is_none());
}

/// Once so slow that it seemed to hang: the search saw the whole mirror in one of its cells.
#[test]
fn a_facet_far_away_does_not_hinder() {
    let part = Part::conquistador();
    let folder = folder();
    let file = folder.path().join("far.stl");
    let mut mesh = part.solid.clone();
    let first = mesh.vertices.len() as u32;
    let far = morion::internals::geom::DVec3::new(1e4, 0.0, 0.0);
    mesh.vertices.extend([
        far,
        far + morion::internals::geom::DVec3::Y,
        far + morion::internals::geom::DVec3::Z,
    ]);
    mesh.triangles.push([first, first + 1, first + 2]);
    std::fs::write(&file, stl(&mesh, 1.0)).unwrap();
    let said = "1 facets lie far from the part";
    let report = look(&file, WIDE, Some(LengthUnit::Mm), true);
    assert_eq!(report.verdict, Verdict::Pass, "{:#?}", report.reasons);
    assert!(report.warnings.iter().any(|w| w.contains(said)), "{:#?}", report.warnings);
    let report = look(&file, WIDE, Some(LengthUnit::Mm), false);
    assert_eq!(report.verdict, Verdict::Fail);
    assert!(report.reasons.iter().any(|r| r.to_string().contains(said)), "{:#?}", report.reasons);
}

/// Without limits for the picture a measured part's form decides.
#[test]
fn a_part_of_another_form_does_not_pass_for_want_of_limits() {
    let part = Part::conquistador();
    let folder = folder();
    let profile = folder.path().join("small.toml");
    // The chords of the copy's own facets are 20 um.
    let text = format!("mesh.chord_um = 25\n{}", profile_text("conquistador"));
    std::fs::write(&profile, text).unwrap();
    let source = load(profile.to_str().unwrap()).unwrap();
    assert!(source.accept.pixel_error_max_px.is_none());
    let options = VerifyOptions { align: true, ..VerifyOptions::default() };
    for (stretch, verdict) in [(1.0, Verdict::Pass), (1.02, Verdict::Fail)] {
        let mut mesh = part.solid.clone();
        mesh.vertices.iter_mut().for_each(|v| v.z *= stretch);
        let file = folder.path().join("stretched.stl");
        std::fs::write(&file, stl(&mesh, 1.0)).unwrap();
        let report = Verify { path: &file, options }
            .publish(&source, &folder.path().join("made"), &Silent)
            .unwrap();
        assert_eq!(report.verdict, verdict, "{stretch}: {:#?}", report.reasons);
        let form = report.reasons.iter().any(|reason| reason.to_string().contains("form error"));
        assert_eq!(form, verdict == Verdict::Fail, "{:#?}", report.reasons);
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn units_are_found_or_taken_as_told() {
    let part = Part::conquistador();
    let folder = folder();
    let home = folder.path();
    let mut draws = Draws::new(4);
    for (k, unit) in LengthUnit::ALL.into_iter().enumerate() {
        for (units, aligned) in [(None, true), (Some(unit), false)] {
            let pose = draws.pose(20.0, 0.2, part.width());
            let mesh = if aligned { moved(&part.solid, &pose) } else { part.solid.clone() };
            let file = home.join(format!("{k}.stl"));
            std::fs::write(&file, stl(&mesh, 1.0 / unit.mm())).unwrap();
            let report = look(&file, WIDE, units, aligned);
            let found = report.units.unwrap();
            let chosen = if units.is_some() { "asked" } else { "by size" };
            assert_eq!(
                (found.name, found.mm_per_unit, found.chosen),
                (unit.name(), unit.mm(), chosen)
            );
            assert_eq!(report.verdict, Verdict::Pass, "{unit:?} {aligned}: {:#?}", report.reasons);
            assert!(report.warnings.is_empty() && report.trace[0].solid.check.closed);
        }
    }
    // Of five times the size it is nothing: said, and taken as millimetres.
    let file = home.join("large.stl");
    std::fs::write(&file, stl(&part.solid, 5.0)).unwrap();
    let report = look(&file, WIDE, None, false);
    let found = report.units.unwrap();
    assert_eq!((found.name, found.chosen, report.verdict), ("mm", "assumed", Verdict::Fail));
    assert!(report.warnings[0].contains("--units"), "{:?}", report.warnings);
}

#[test]
fn normals_of_the_file_turn_with_it() {
    let part = Part::conquistador();
    let folder = folder();
    let home = folder.path();
    let pose = Draws::new(6).pose(20.0, 0.2, part.width());
    let clean = part.scan(120);
    let mirror = &part.design.mirror;
    let normal = |v: &morion::internals::geom::DVec3| {
        let q = mirror.chart.coordinates(*v).0;
        pose.rotation * mirror.normal(q, &mirror.row(q.y).at(q.x)).normalize()
    };
    // Towards the camera, whichever way round the facets are.
    let normals: Vec<_> = clean.vertices.iter().map(normal).collect();
    for turned in [false, true] {
        let mut mesh = moved(&clean, &pose);
        if turned {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        std::fs::write(home.join("scan.obj"), obj(&mesh, &normals)).unwrap();
        let report = look(&home.join("scan.obj"), WIDE, None, true);
        assert_eq!(report.alignment.as_ref().unwrap().turned_over, turned);
        let [facets, smooth] = [Some(report.trace[0].errors), report.trace[0].interpolated_normals]
            .map(|errors| errors.unwrap().facet_error_px.unwrap());
        // But for the ridge, where this scan has one normal for two panels.
        assert!(smooth.p95 < 0.1 * facets.p95 && smooth.p95 < 0.02, "{smooth:?} {facets:?}");
        assert_eq!(report.verdict, Verdict::Pass, "{:#?}", report.reasons);
    }
}

#[test]
fn the_program_aligns_and_says_what_it_cannot() {
    let part = Part::conquistador();
    let folder = folder();
    let home = folder.path();
    profile(home, WIDE);
    let pose = Draws::new(8).pose(12.0, 0.1, part.width());
    std::fs::write(home.join("scan.stl"), stl(&moved(&part.scan(120), &pose), 0.1)).unwrap();
    let whole = part.scan(80);
    let patch = kept(&whole, |t| whole.corners(t)[0].x > 25.0);
    std::fs::write(home.join("patch.stl"), stl(&patch, 1.0)).unwrap();
    let profile = ["--profile", "small.toml"];
    let morion = |arguments: &[&str]| told(&morion(home, &[arguments, &profile].concat()));
    let (code, out, err) = morion(&["verify", "scan.stl", "--align", "--threads", "1"]);
    assert_eq!(code, 0, "{out}{err}");
    assert!(
        out.contains("cm (by size): coordinates times 10 are") && err.contains("align "),
        "{out}"
    );
    let made = |name: &str| std::fs::read(home.join("out/small-verify").join(name)).unwrap();
    let first = ["report.json", "form_error.png"].map(made);
    let (code, json, err) =
        morion(&["verify", "scan.stl", "--align", "-q", "--format", "json", "--threads", "3"]);
    assert_eq!((code, &*err), (0, ""));
    assert_eq!(json.as_bytes(), first[0]);
    assert!(first == ["report.json", "form_error.png"].map(made));

    let unable = |arguments: &[&str], words: &[&str]| {
        refused(home, &[arguments, &profile].concat(), words);
    };
    unable(
        &["verify", "patch.stl", "--align", "--out", "new"],
        &["cannot align patch.stl: ", "--units"],
    );
    assert!(!home.join("new").exists());
    unable(&["verify", "scan.stl", "--align", "--units", "um"], &["cannot align scan.stl: "]);
    assert!(first == ["report.json", "form_error.png"].map(made));
    // In the part's frame it is no part; that is written down where it is asked for.
    assert_eq!(morion(&["verify", "scan.stl", "--out", "new", "-q"]).0, 1);
    let written = files(&home.join("new/small-verify"));
    assert_eq!(written.keys().collect::<Vec<_>>(), ["report.html", "report.json"]);
    // No page of another command lies in its folder, and it links to none.
    let page = std::str::from_utf8(&written["report.html"]).unwrap();
    assert!(!page.contains("frame.html") && page.contains(">fail<"));
    unable(&["verify", "scan.stl", "--units", "ell"], &["--units", "mm"]);
    // What is no mesh is a verdict, and no map of another file stays beside it.
    std::fs::write(home.join("empty.stl"), stl(&TriMesh::default(), 1.0)).unwrap();
    let (code, out, _) = morion(&["verify", "empty.stl", "--align", "-q"]);
    assert!(code == 1 && out.contains("holds no facets"), "{out}");
    assert!(!home.join("out/small-verify/form_error.png").exists());
}
