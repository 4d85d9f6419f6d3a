//! What the tests share: profiles, designs and faces that several of them make, and the program.

pub mod altered_files;
pub mod builds;
pub mod draws;
pub mod least;
pub mod oracle;
pub mod package;
pub mod parts;
pub mod random;
pub mod shipped_builds;
pub mod surfaces;
mod thorough;

pub use thorough::times;

use builds::{SMALL, edited, morion, parsed, told};
use morion::internals::design::{Design, design};
use morion::internals::geom::{DVec2, Outline, Precision, Rect};
use morion::internals::mesh::{Face, Limits, MeshError, mesh};
use morion::internals::pipeline::load;
use morion::internals::profile::{MeshGoal, Profile};
use std::path::Path;

/// Every `n`-th of `cases`, begun with another one for each `turn`; all of them in a long run.
pub fn share<T>(
    n: usize,
    turn: usize,
    cases: impl IntoIterator<Item = T>,
) -> impl Iterator<Item = T> {
    let n = times(n, 1);
    cases.into_iter().skip(turn % n).step_by(n)
}

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

/// What a command printed, without the folder that it names.
pub fn placeless(text: &str) -> String {
    text.split_inclusive('\n').filter(|line| !line.starts_with("  folder ")).collect()
}

/// Asserts that the program, run in `folder`, ends in one error that says all of `words`.
#[track_caller]
pub fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let (code, out, err) = told(&morion(folder, arguments));
    assert_eq!((code, &*out), (2, ""), "{arguments:?}: {err}");
    assert_eq!(err.matches("error: ").count(), 1, "{err}");
    for word in words {
        assert!(err.contains(word), "{arguments:?}: no {word:?} in {err}");
    }
}

/// A small full-turn panorama, with the edits of one case: each names a text and what replaces it.
pub fn profile(edits: &[(&str, &str)]) -> Profile {
    let text = "\
camera.orthographic.pixels = [640, 480]
projection.cylindrical = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }
layout.strip = {}
method.vector-field.degree = 12
part = { width_mm = 60, base_mm = 5 }
mesh = { facet_px = 4 }
export.formats = [\"stl\"]
";
    parsed(&edited(text, edits))
}

/// A shipped profile.
pub fn shipped(name: &str) -> Profile {
    load(name).unwrap_or_else(|error| panic!("{error}"))
}

/// A shipped profile's text.
pub fn shipped_text(name: &str) -> &'static str {
    let found = morion::internals::profile::shipped().iter().find(|profile| profile.name == name);
    found.unwrap_or_else(|| panic!("no {name} is shipped")).text
}

/// A shipped profile with edits.
pub fn shipped_but(name: &str, edits: &[(&str, &str)]) -> Profile {
    Profile { name: name.into(), ..parsed(&edited(shipped_text(name), edits)) }
}

/// The rectangle of a panel.
pub fn panel(design: &Design) -> Rect {
    match design.mirror.outline {
        Outline::Rect(rect) => rect,
        ring => panic!("{ring:?} is no rectangle"),
    }
}

/// Inner and outer image radius of a round mirror.
pub fn rims(design: &Design) -> [f64; 2] {
    match design.mirror.outline {
        Outline::Ring { inner, outer } => [inner, outer],
        rect => panic!("{rect:?} is not round"),
    }
}

/// Z of the designed panel over (X, Y), for an orthographic camera.
pub fn sag(design: &Design, q: DVec2) -> f64 {
    design.mirror.position(q, &design.mirror.surface.at(q)).z
}

/// The profile without limits on the picture but its own.
pub fn unlimited(mut profile: Profile) -> Profile {
    let accept = &mut profile.accept;
    accept.pixel_error_rms_px.get_or_insert(1e300);
    accept.pixel_error_max_px.get_or_insert(1e300);
    accept.frame_filled.get_or_insert(0.0);
    profile
}

/// The profile's design, which must succeed.
pub fn designed(profile: &Profile) -> Design {
    design(profile).unwrap_or_else(|error| panic!("{error}"))
}

/// The profile's limits on the mirror of `design`.
pub fn limits(profile: &Profile, design: &Design) -> Limits {
    Limits {
        chord_mm: profile.mesh.chord_um().map(|um| um * 1e-3),
        facet_mm: profile.mesh.facet_px().map(|px| px * design.camera.pixel_mm),
        precision: Precision::Single,
    }
}

/// The profile with these limits alone.
pub fn with_limits(mut profile: Profile, chord_um: Option<f64>, facet_px: Option<f64>) -> Profile {
    profile.mesh = MeshGoal::limits(chord_um, facet_px);
    profile
}

/// The face that keeps the profile's limits, if there is one.
pub fn meshed(profile: &Profile, design: &Design) -> Result<Face, MeshError> {
    mesh(&design.mirror, &design.camera.chart, design.view.as_ref(), limits(profile, design))
}
