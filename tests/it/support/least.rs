//! The least that a profile has to say.

use super::builds::edited;
use morion::internals::profile::{Profile, ProjectionSpec, StripSpec};

/// The least that is a profile, with the edits of one test.
pub fn with(edits: &[(&str, &str)]) -> Result<Profile, String> {
    let text = "\
camera.orthographic.pixels = [640, 480]
projection.cylindrical = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }
layout.conquistador = {}
method.vector-field.degree = 12
part = { width_mm = 60, base_mm = 5 }
mesh.chord_um = 2
export.formats = [\"stl\"]
";
    let text = edited(text, edits);
    Profile::parse("least", "least.toml", text.as_bytes()).map_err(|c| c.to_string())
}

/// The strip that a profile projects onto.
pub fn strip_of(profile: &Profile) -> &StripSpec {
    match &profile.projection {
        Some(ProjectionSpec::Strip(strip)) => strip,
        other => panic!("{other:?}"),
    }
}
