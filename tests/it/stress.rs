//! Whole builds at the far ends of every scale: a right file, or a refusal that leaves none.

use crate::support::builds::{SMALL, edited, files, folder, parsed};
use crate::support::share;
use morion::internals::pipeline::{Silent, build};
use morion::internals::results::{BuildReport, RayFault, Reason};
use serde_json::Value;

/// The small profile with a frame of so few pixels that its rays take no time, and limits that suit.
fn tiny(edits: &[(&str, &str)]) -> String {
    let few = edited(SMALL, &[("[160, 120]", "[64, 48]"), ("chord_um = 20", "chord_um = 50")]);
    let accept = few.find("[accept]").unwrap();
    edited(&few[..accept], edits)
}

/// A round mirror under a pinhole.
fn round(width_mm: f64, distance_mm: f64) -> String {
    let focal_px = 64.0 * distance_mm / width_mm;
    format!(
        "[camera.pinhole]\npixels = [64, 64]\nfocal_px = {focal_px}\ndistance_mm = {distance_mm}\n\
         [projection.equiangular]\nouter_polar_deg = 110\n[layout.disc]\n\
         [method.vector-field]\ndegree = 24\n[part]\nwidth_mm = {width_mm}\nbase_mm = {width_mm}\n\
         [mesh]\nfacet_px = 0.5\n[export]\nformats = [\"stl\", \"obj\"]\n"
    )
}

/// Numbers in `value` that are none, by their path: JSON has null in their place.
fn missing(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        // What a profile may leave open, or a mirror not have.
        Value::Null if path.ends_with(".limit") || path.contains(".over_optimum") => (),
        Value::Null if path.ends_with(".worst_vertex") => (),
        // Without a lens near by, and before a world far away.
        Value::Null if [".layout.pupil_mm", ".layout.target_origin_mm"].contains(&path) => (),
        // Where no pixel is filled.
        Value::Null if path.starts_with(".frame.") => (),
        Value::Null => found.push(path.to_owned()),
        Value::Object(all) => {
            all.iter().for_each(|(k, v)| missing(v, &format!("{path}.{k}"), found))
        }
        Value::Array(all) => all.iter().for_each(|v| missing(v, path, found)),
        _ => (),
    }
}

/// Builds the profile: its report if there is a file, which is then whole, closed, within what was
/// proven of it, and seen so by the witness; or why there is none, and then there is nothing.
fn right_or_refused(what: &str, text: &str) -> Result<BuildReport, String> {
    let folder = folder();
    let source = parsed(text);
    let made = build(&source, folder.path(), &Silent);
    let left = folder.path().join("small");
    let report = match made {
        Ok(report) => report,
        Err(error) => {
            let error = error.to_string();
            println!("{what}: {error}");
            assert!(!left.exists() || files(&left).is_empty(), "{what}: files in spite of {error}");
            assert!(error.len() > 20 && !error.contains("NaN"), "{what}: {error}");
            return Err(error);
        }
    };
    let mesh = report.mesh.unwrap();
    println!("{what}: {} triangles, {:?} {:?}", mesh.triangles, report.verdict, report.reasons);
    let seen = report.trace.iter().all(|trace| trace.rays > 0);
    let mut nothing = Vec::new();
    missing(&serde_json::from_str(&report.json()).unwrap(), "", &mut nothing);
    // Where no ray is aimed at the mirror there is nothing to say of rays, and the verdict is negative.
    assert!(nothing.is_empty() || !seen, "{what}: {nothing:?}");
    let blind = |reason: &Reason| reason.kind == RayFault::NothingAimed.into();
    assert!(seen || report.reasons.iter().any(blind), "{what}: {:?}", report.reasons);
    for bound in [mesh.chord_um, mesh.facet_px] {
        assert!(bound.limit.is_none_or(|limit| bound.bound <= limit), "{what}: {bound:?}");
    }
    let solid = report.solid.as_ref().unwrap();
    assert!(solid.reasons.is_empty(), "{what}: {:?}", solid.reasons);
    for trace in &report.trace {
        assert!(trace.solid.reasons.is_empty(), "{what}: {:?}", trace.solid.reasons);
        assert_eq!(
            trace.hit + trace.missed + trace.shadowed + trace.back_face,
            trace.rays,
            "{what}"
        );
        assert_eq!((trace.missed, trace.back_face), (0, 0), "{what}");
        // The bound holds for the mirror's points; the witness's rays are a rounding aside.
        let most = mesh.facet_px.bound * (1.0 + 1e-6) + 1e-6;
        let found = trace.errors.facet_error_px.map_or(0.0, |error| error.max);
        assert!(found <= most, "{what}: {found} px, proven {most}");
    }
    let on_disk = files(&left);
    for file in &report.files {
        assert_eq!(on_disk[&file.name].len() as u64, file.bytes, "{what}: {}", file.name);
    }
    Ok(report)
}

fn pixel_rms(report: &BuildReport) -> f64 {
    report.trace[0].errors.pixel_error_px.unwrap().rms
}

#[test]
fn parts_from_a_micron_to_a_kilometre_are_alike() {
    let at = |width: f64| {
        let size = format!("width_mm = {width}\nbase_mm = {}", (width / 5.0).max(1e-3));
        let chord = format!("chord_um = {}", width * 10.0 / 15.0);
        let text = tiny(&[("width_mm = 15\nbase_mm = 2", &size), ("chord_um = 50", &chord)]);
        pixel_rms(&right_or_refused(&size, &text).unwrap())
    };
    let usual = at(15.0);
    for width in [1e-3, 1e-2, 1.0, 1e3, 1e6] {
        let found = at(width);
        assert!((found / usual - 1.0).abs() < 0.02, "{width}: {found} px for {usual} px");
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn elevations_up_to_the_poles() {
    let (mut asked, mut made) = (0, 0);
    let ranges = ["[-89.9, 89.9]", "[0, 89.9]", "[-89.9, -45]", "[89, 89.9]", "[-0.01, 0.01]"];
    for (k, law) in
        ["cylindrical", "mercator", "equirectangular", "equal-area"].into_iter().enumerate()
    {
        for range in share(3, k, ranges) {
            asked += 1;
            let text = tiny(
                &[
                    ("cylindrical", law),
                    ("[-30, 30]", range),
                    ("chord_um = 20\n", ""),
                    ("facet_px = 3", "facet_px = 10"),
                    ("fill_frame = true\n", ""),
                ]
                .map(|(a, b)| if a == "chord_um = 20\n" { ("chord_um = 50\n", b) } else { (a, b) }),
            );
            made += usize::from(right_or_refused(&format!("{law} {range}"), &text).is_ok());
        }
    }
    assert!((asked / 3..asked).contains(&made), "{made} of {asked} made");
}

#[test]
#[ignore = "long: .ci/nightly"]
fn frames_a_hundred_times_as_long_as_wide() {
    let mut made = 0;
    for pixels in ["[1200, 12]", "[12, 1200]", "[200, 2]", "[2, 200]", "[1, 1]"] {
        for layout in ["[layout.strip]", "[layout.conquistador]\npanel = \"refit\""] {
            let text = tiny(&[
                ("[64, 48]", pixels),
                (
                    "[layout.conquistador]\npanel = \"refit\"\nridge = \"crest\"\nfill_frame = true",
                    layout,
                ),
            ]);
            made += usize::from(right_or_refused(&format!("{pixels} {layout}"), &text).is_ok());
        }
    }
    assert!(made >= 6, "{made} made");
}

#[test]
#[ignore = "long: .ci/nightly"]
fn degrees_from_2_to_40_by_every_method() {
    for (turn, method) in [(1, "vector-field"), (0, "fixed-surface"), (0, "distribution")] {
        let mut last = f64::INFINITY;
        for degree in share(4, turn, [2, 3, 5, 10, 20, 40]) {
            let degree = format!("degree = {degree}");
            let what = format!("{method} {degree}");
            let text = tiny(&[("vector-field", method), ("degree = 8", &degree)]);
            let report =
                right_or_refused(&what, &text).unwrap_or_else(|why| panic!("{what}: {why}"));
            let rms = report.design.ray_error_mrad.unwrap().rms;
            // More degrees are no worse, but for what another norm makes of it.
            assert!(rms <= 1.01 * last, "{what}: {rms} after {last}");
            last = rms;
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn targets_from_the_mirrors_rim_to_infinity() {
    let at = |target: &str| {
        let range = format!("[-30, 30]{target}");
        let found = right_or_refused(target, &tiny(&[("[-30, 30]", &range)]))?;
        Ok::<_, String>(found.design.pixel_error_px.unwrap().rms)
    };
    let far = at("").unwrap();
    let made = ["7.6", "8", "9", "12", "20", "100", "1e4", "1e7", "1e9", "1e12"]
        .map(|radius| at(&format!("\ntarget_radius_mm = {radius}")));
    assert!(made[5..].iter().all(Result::is_ok), "{made:?}");
    for (found, off) in made[6..].iter().zip([1e-2, 1e-5, 1e-7, 1e-9]) {
        let found = found.as_ref().unwrap();
        assert!((found / far - 1.0).abs() < off, "{found} px, {far} px at infinity");
    }
}

#[test]
fn pinholes_from_just_above_to_a_thousand_kilometres_away() {
    let mut made = Vec::new();
    for distance in [1.01, 2.0, 5.0, 15.0, 60.0, 1e3, 1e5, 1e7, 1e9] {
        let found = {
            // Focal lengths go up to 1e7 pixels.
            let width = f64::max(30.0, 6.5e-6 * distance);
            right_or_refused(&format!("pinhole at {distance}"), &round(width, distance))
        };
        made.push(found.map(|report| pixel_rms(&report)));
    }
    assert!(made[4..].iter().all(Result::is_ok), "{made:?}");
    // Far away nothing changes any more.
    let [.., b, a] = &made[..] else { unreachable!() };
    let (a, b) = (a.as_ref().unwrap(), b.as_ref().unwrap());
    assert!((a / b - 1.0).abs() < 0.05, "{a} {b}");
}

#[test]
#[ignore = "long: .ci/nightly"]
fn limits_over_eight_decades() {
    let mut made = 0;
    let (mut asked, facets) = (0, [None, Some("1e-3"), Some("0.5"), Some("1e3")]);
    for (k, chord) in ["1e-4", "1e-2", "1", "100", "1e4"].into_iter().enumerate() {
        for facet in share(2, k, facets) {
            asked += 1;
            let facet = facet.map_or(String::new(), |px| format!("facet_px = {px}"));
            let text = tiny(&[
                ("chord_um = 50", &format!("chord_um = {chord}")),
                ("facet_px = 3", &facet),
                ("[\"stl\", \"obj\"]", "[\"stl\"]"),
            ]);
            made += usize::from(right_or_refused(&format!("{chord} um, {facet}"), &text).is_ok());
        }
    }
    assert!((asked * 9 / 20..asked).contains(&made), "{made} of {asked} made");
}
