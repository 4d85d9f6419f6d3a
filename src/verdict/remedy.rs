//! Ways out of a negative verdict on the picture, for its reasons: each has been tried, or is a width that
//! follows from the camera.

use super::closer_picture::closer_picture;
use crate::design::Design;
use crate::num::stats::Summary;
use crate::optics::CameraModel;
use crate::profile::{Layout, Profile, ProjectionSpec};
use crate::results::{LeastFilled, PictureFault, RayFault, Reason, ReasonKind};

/// A mirror narrower than this share of what the camera sees leaves room.
const NARROW: f64 = 0.999;

/// Adds to the first reason of its kind how to do better, where each file fills so much of the frame at least and facets
/// displace the picture by as much.
pub(crate) fn add(
    (profile, designed): (&Profile, &Design),
    filled: f64,
    facets: Option<Summary>,
    reasons: &mut [Reason],
) {
    if designed.mirror.has_steps() {
        add_between_panels(filled, reasons);
    }
    let mut amend = |is_kind: fn(&PictureFault) -> bool,
                     way: &dyn Fn(&PictureFault) -> Option<String>| {
        let of_picture = reasons.iter_mut().find_map(|reason| match &reason.kind {
            ReasonKind::Picture(fault) if is_kind(fault) => Some((way(fault), reason)),
            _ => None,
        });
        if let Some((way_out, reason)) = of_picture {
            reason.way_out = way_out;
        }
    };
    let is_off = |fault: &PictureFault| matches!(fault, PictureFault::PixelError { .. });
    amend(is_off, &|_| closer_picture(profile, designed, facets));
    let is_unfilled = |fault: &PictureFault| matches!(fault, PictureFault::FrameFilled { .. });
    amend(is_unfilled, &|fault| filling(profile, fault, filled));
}

/// Adds to a reason that walls between panels shadow too much how a frame is accepted of which that share is filled.
fn add_between_panels(filled: f64, reasons: &mut [Reason]) {
    let is_shadowed =
        |reason: &&mut Reason| matches!(reason.kind, ReasonKind::Rays(RayFault::Shadowed { .. }));
    if let Some(reason) = reasons.iter_mut().find(is_shadowed) {
        let accept = written(filled, "what walls between panels shadow");
        reason.way_out = Some(format!("put the views in another order in the frame, or {accept}"));
    }
}

/// Adds to the first reason of a face as cut that is off the picture how to do better.
pub(crate) fn add_as_cut(reasons: &mut [Reason]) {
    let is_off = |reason: &&mut Reason| {
        matches!(reason.kind, ReasonKind::Picture(PictureFault::PixelError { .. }))
    };
    if let Some(reason) = reasons.iter_mut().find(is_off) {
        let way_out = "scallops displace the picture: polish the mirror, or cut it with a larger ball or nose, a smaller stepover or feed";
        reason.way_out = Some(way_out.to_owned());
    }
}

/// How more of the frame is filled, or, where what is missing is hidden or in shadow, how the share that
/// every file fills is accepted.
pub(crate) fn filling(profile: &Profile, fault: &PictureFault, every: f64) -> Option<String> {
    let PictureFault::FrameFilled { filled, hidden, shadowed, least, .. } = *fault else {
        return None;
    };
    // A build refuses shadows, but for those of walls between panels.
    let is_accepted = matches!(least, LeastFilled::Asked(_)) || !profile.is_one_surface();
    let shadowed = if is_accepted { shadowed } else { 0.0 };
    if hidden + shadowed > 0.0 && filled + hidden + shadowed >= least.share() {
        let what = match [hidden, shadowed].map(|share| share > 0.0) {
            [true, true] => "what obstacles hide and the part shadows",
            [true, false] => "what obstacles hide",
            [false, _] => "what the part shadows",
        };
        return Some(match least {
            LeastFilled::Accepted(_) => written(every, what),
            LeastFilled::Asked(_) => format!("ask for {} to accept {what}", kept(every)),
        });
    }
    let Some(ProjectionSpec::Strip(strip)) = &profile.projection else { return wider(profile) };
    let [first, last] = strip.azimuth_deg;
    let folds = matches!(profile.layout, Layout::Strip { .. }) && [first, last] == [-180.0, 180.0];
    let fold = folds.then(|| "[layout.conquistador] folds the turn into the frame".to_owned());
    let fills = match profile.layout {
        Layout::Strip { fill_frame } | Layout::Conquistador { fill_frame, .. } => fill_frame,
        _ => false,
    };
    let fill = (!fills && fold.is_none())
        .then(|| "fill_frame = true makes the mirror as high as the frame".to_owned());
    let ways: Vec<String> = wider(profile).into_iter().chain(fold).chain(fill).collect();
    (!ways.is_empty()).then(|| ways.join(", or "))
}

/// A share rounded down, so that what is written down is kept.
fn kept(share: f64) -> f64 {
    (share * 1e4).floor() / 1e4
}

/// How a profile accepts that this share of the frame is filled, and not the rest.
fn written(filled: f64, rest: &str) -> String {
    format!("write frame_filled = {} in [accept] to accept {rest}", kept(filled))
}

/// The width of the frame at the mirror, where the mirror is narrower.
fn wider(profile: &Profile) -> Option<String> {
    let CameraModel::Pinhole { pixels, focal_px, distance_mm } = profile.camera else {
        return None;
    };
    let round = matches!(profile.layout, Layout::Disc | Layout::Annulus { .. });
    let across = if round { pixels[0].min(pixels[1]) } else { pixels[0] };
    let frame = f64::from(across) * distance_mm / focal_px;
    // Rounded up, so that the number written down is enough.
    let enough = (frame * 1e3).ceil() / 1e3;
    (profile.part.width_mm < NARROW * frame)
        .then(|| format!("write width_mm = {enough}, as wide as the frame is at the mirror"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Accepting a share of the frame is no way out of shadows that a build refuses.
    #[test]
    fn shadows_are_accepted_between_panels_alone() {
        let text = "camera.pinhole = { pixels = [32, 24], hfov_deg = 30, distance_mm = 150 }\nlayout.rectangle = {}\n\
                    method.vector-field.degree = 4\npart = { width_mm = 80.4, base_mm = 5 }\nmesh.chord_um = 20\n\
                    export.formats = [\"stl\"]\naccept.frame_filled = 0.9\n";
        let view = "centre_deg = [0, 60]\nhfov_deg = 30\n";
        let one = format!("{text}[projection.perspective]\n{view}");
        let panel = |columns| format!("[[panel]]\ncolumns = {columns}\nrows = [0, 24]\n{view}");
        let several = format!("{text}{}{}", panel("[0, 16]"), panel("[16, 32]"));
        let said = |text: &str, [hidden, shadowed]: [f64; 2]| {
            let profile = Profile::parse("p", "p.toml", text.as_bytes()).unwrap();
            let least = LeastFilled::Accepted(profile.acceptance_limits().frame_filled);
            let fault = PictureFault::FrameFilled {
                filled: 0.81239,
                tolerance_px: 1.0,
                least,
                hidden,
                shadowed,
            };
            filling(&profile, &fault, 0.80001)
        };
        let accepted = "write frame_filled = 0.8 in [accept] to accept what the part shadows";
        assert_eq!(said(&one, [0.0, 0.18]), None);
        assert_eq!(said(&several, [0.0, 0.18]).unwrap(), accepted);
        assert!(said(&one, [0.18, 0.0]).unwrap().ends_with("what obstacles hide"));
        let both = said(&several, [0.09, 0.09]).unwrap();
        assert!(both.ends_with("what obstacles hide and the part shadows"), "{both}");
    }
}
