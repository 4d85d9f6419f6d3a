//! Lists of measured points: lines of X, Y and Z, and PLY.

use morion::internals::align::align_points;
use morion::internals::design::{Design, design};
use morion::internals::export::{PointFormat, read_points};
use morion::internals::geom::DVec3;
use morion::internals::inspection::fit_form;
use morion::internals::profile::Profile;
use std::sync::LazyLock;

/// A dome that the points may be of.
static DOME: LazyLock<Design> = LazyLock::new(|| {
    let text = "\
camera.orthographic.pixels = [16, 12]
mirror.polynomial = { radius_mm = -40, conic = -2 }
part = { width_mm = 40, height_mm = 30, base_mm = 5 }
mesh.chord_um = 5
export.formats = [\"stl\"]
";
    let profile = Profile::parse("dome", "dome.toml", text.as_bytes()).expect("a valid profile");
    design(&profile).expect("a mirror")
});

/// Most points that are aligned: of more it takes its time.
const MOST: usize = 400;

pub fn holds(bytes: &[u8]) {
    for format in [PointFormat::Text, PointFormat::Ply] {
        match read_points(format, bytes) {
            Ok(points) => of_points(&points),
            Err(error) => {
                let said = error.to_string();
                assert!(!said.contains(char::is_control), "{said:?}");
            }
        }
    }
}

fn of_points(points: &[DVec3]) {
    assert!(points.iter().all(|point| point.is_finite()));
    let line = |point: &DVec3| format!("{},{},{}\n", point.x, point.y, point.z);
    let text: String = points.iter().map(line).collect();
    let again = read_points(PointFormat::Text, text.as_bytes()).expect("points that were read");
    assert_eq!(again, points);
    if points.len() > MOST {
        return;
    }
    for ball_mm in [0.0, 1.0] {
        let Ok(found) = align_points(&DOME.mirror, points, ball_mm) else { continue };
        assert!(found.residuals.len() == points.len() && found.alignment.rms_mm.is_finite());
        let Some(form) = fit_form(&DOME.mirror, &found) else { continue };
        assert!(form.rest_mm >= 0.0, "{form:?}");
        for term in form.terms {
            assert!(term.pv_mm.is_finite() && term.uncertainty_mm >= 0.0, "{term:?}");
        }
    }
}
