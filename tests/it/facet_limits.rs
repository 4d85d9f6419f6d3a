//! A limit of the facet error that can be kept is followed by looser ones that can, in single precision:
//! small facets are not refused for how one of them rounds.

use crate::support::builds::parsed;
use crate::support::{designed, meshed, share, shipped, times, with_limits};
use morion::internals::mesh::{MeshError, forecast};
use morion::internals::num::{radians, tan};
use morion::internals::profile::Profile;

/// Widest step between neighbouring limits.
const STEP: f64 = 1.02;

/// Meshes the profile within `facet_px`.
fn holds(profile: &Profile, facet_px: f64) {
    let profile = with_limits(profile.clone(), None, Some(facet_px));
    let design = designed(&profile);
    let face = meshed(&profile, &design)
        .unwrap_or_else(|error| panic!("{} {facet_px}: {error}", profile.name));
    let reached = face.bound.facet_mm / design.camera.pixel_mm;
    assert!(reached <= facet_px && reached > 0.9 * facet_px, "{reached} of {facet_px}");
}

#[test]
#[ignore = "long: .ci/nightly"]
fn limits_beside_those_that_hold_do_too() {
    // These three once ended in slivers, between neighbours that did not.
    let once = [("panoramic", 0.25), ("conquistador", 0.3), ("conquistador", 0.27)];
    for (name, facet_px) in share(2, 0, once) {
        holds(&shipped(name), facet_px);
    }
    if times(0, 1) == 0 {
        return;
    }
    for name in ["panoramic", "conquistador", "conformal", "hyperbolic"] {
        let profile = shipped(name);
        let mut facet_px = 0.15;
        while facet_px <= 3.0 {
            holds(&profile, facet_px);
            facet_px *= STEP;
        }
    }
}

/// A mirror under a pinhole that fills a frame of these pixels.
fn under_a_pinhole(pixels: [u32; 2], hfov_deg: f64, part: [f64; 2], layout: &str) -> Profile {
    let ([width, height], [distance_mm, width_mm]) = (pixels, part);
    parsed(&format!(
        "[camera.pinhole]\npixels = [{width}, {height}]\nhfov_deg = {hfov_deg}\n\
         distance_mm = {distance_mm}\n[projection.mercator]\nazimuth_deg = [-180, 180]\n\
         elevation_deg = [-30, 30]\n[{layout}\n[method.vector-field]\ndegree = 14\n\
         [part]\nwidth_mm = {width_mm}\nbase_mm = 10\n[mesh]\nfacet_px = 1\n\
         [export]\nformats = [\"stl\"]\n"
    ))
}

const FILLED: &str =
    "layout.conquistador]\npanel = \"refit\"\nridge = \"crest\"\nfill_frame = true";

#[test]
#[ignore = "long: .ci/nightly"]
fn large_frames_are_within_the_reach_of_an_stl() {
    // The width that is said to be the least; 0.5 and 0.7 px were refused where 1 px was not.
    let frames = [(0.7, 40.0, [150.0, 109.192]), (0.8, 39.0, [200.0, 141.648])];
    for (facet_px, hfov_deg, part) in share(2, 1, frames) {
        holds(&under_a_pinhole([1920, 1080], hfov_deg, part, FILLED), facet_px);
    }
    // Of twelve megapixels a finer one, too, in a long run.
    for facet_px in share(2, 0, [4.8, 1.6]) {
        holds(&under_a_pinhole([4056, 3040], 40.0, [150.0, 109.192], FILLED), facet_px);
    }
}

/// Of 200 widths, three frames and two layouts: none is refused for its precision.
#[test]
fn no_width_of_a_frame_is_foreseen_as_beyond_an_stl() {
    for layout in [FILLED, "layout.strip]"] {
        for (frame, pixels) in [[640, 480], [1920, 1080], [4056, 3040]].into_iter().enumerate() {
            for k in share(200, 70 * frame, 0..200) {
                // The least width is the one that the frame sees there.
                let (hfov_deg, distance_mm) = (30.0 + 0.1 * f64::from(k), 150.0);
                let least = 2.0 * distance_mm * tan(radians(0.5 * hfov_deg));
                let width_mm = (least * 1e3).ceil() / 1e3;
                let part = [distance_mm, width_mm];
                let profile = under_a_pinhole(pixels, hfov_deg, part, layout);
                let design = designed(&profile);
                for facet_px in share(3, frame, [0.7, 1.0, 2.0]) {
                    let limits = crate::support::limits(
                        &with_limits(profile.clone(), None, Some(facet_px)),
                        &design,
                    );
                    let (camera, view) = (&design.camera.chart, design.view.as_ref());
                    match forecast(&design.mirror, camera, view, limits) {
                        Ok(_) | Err(MeshError::TooMany { .. }) => (),
                        Err(error) => panic!("{pixels:?} {hfov_deg} {facet_px}: {error}"),
                    }
                }
            }
        }
    }
}
