//! Profiles and faces that several test files make.

pub mod builds;
pub mod draws;
pub mod oracle;
pub mod parts;
pub mod random;
pub mod surfaces;
mod thorough;

pub use thorough::times;

use builds::{SMALL, edited};
use morion::design::{Design, design};
use morion::geom::{DVec2, Outline, Precision, Rect};
use morion::mesh::{Face, Limits, MeshError, mesh};
use morion::pipeline::load;
use morion::profile::Profile;

/// The small profile with one edit.
pub fn small_but(from: &str, to: &str) -> String {
    edited(SMALL, &[(from, to)])
}

/// The small profile as a strip, which leaves rows of the frame empty.
pub fn small_strip() -> String {
    let conquistador =
        "[layout.conquistador]\npanel = \"refit\"\nridge = \"crest\"\nfill_frame = true\n";
    edited(SMALL, &[(conquistador, "[layout.strip]\n"), ("frame_filled = 0.99\n", "")])
}

/// A small full-turn panorama, with the edits of one case: each names a text and what replaces it.
pub fn profile(edits: &[(&str, &str)]) -> Profile {
    let mut text = "\
camera.orthographic.pixels = [640, 480]
projection.cylindrical = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }
layout.strip = {}
method.vector-field.degree = 12
part = { width_mm = 60, base_mm = 5 }
mesh = { facet_px = 4 }
export.formats = [\"stl\"]
"
    .to_owned();
    for (old, new) in edits {
        assert!(text.contains(old), "{old}");
        text = text.replace(old, new);
    }
    Profile::parse("case", "case.toml", text.as_bytes()).unwrap_or_else(|c| panic!("{c}"))
}

/// A shipped profile.
pub fn shipped(name: &str) -> Profile {
    load(name).unwrap_or_else(|error| panic!("{error}")).profile
}

/// The rectangle of a panel.
pub fn panel(design: &Design) -> Rect {
    match design.mirror.outline {
        Outline::Rect(rect) => rect,
        ring => panic!("{ring:?} is no rectangle"),
    }
}

/// Z of the designed panel over (X, Y), for an orthographic camera.
pub fn sag(design: &Design, q: DVec2) -> f64 {
    design.mirror.place(q, &design.mirror.surface.at(q)).z
}

/// The profile's design, which must succeed.
pub fn designed(profile: &Profile) -> Design {
    design(profile, None).unwrap_or_else(|error| panic!("{error}"))
}

/// The profile's limits on the mirror of `design`.
pub fn limits(profile: &Profile, design: &Design) -> Limits {
    Limits {
        chord_mm: profile.mesh.chord_um.map(|um| um * 1e-3),
        facet_mm: profile.mesh.facet_px.map(|px| px * design.camera.pixel_mm),
        precision: Precision::Single,
    }
}

/// The face that keeps the profile's limits, if there is one.
pub fn meshed(profile: &Profile, design: &Design) -> Result<Face, MeshError> {
    mesh(&design.mirror, &design.camera.chart, design.view.as_ref(), limits(profile, design))
}
