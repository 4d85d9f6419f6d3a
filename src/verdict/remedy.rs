//! Ways out of a negative verdict on the picture, for its reasons: each has been tried, or is a width that
//! follows from the camera.

use crate::design::{Design, design};
use crate::optics::CameraModel;
use crate::profile::{Layout, Profile, ProjectionSpec, ShapeSpec, StripLawSpec};
use crate::results::{LeastFilled, PictureFault, Reason, ReasonKind};

/// How much less of an error another law must leave to be worth a change.
const WORTH: f64 = 0.7;
/// A mirror narrower than this share of what the camera sees leaves room.
const NARROW: f64 = 0.999;

/// Adds to the first reason of its kind how to do better.
pub(crate) fn add(profile: &Profile, designed: &Design, reasons: &mut [Reason]) {
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
    amend(is_off, &|_| another_law(profile, designed));
    let is_unfilled = |fault: &PictureFault| matches!(fault, PictureFault::FrameFilled { .. });
    amend(is_unfilled, &|fault| filling(profile, fault));
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

/// The law that leaves a smaller error, if it is much smaller, with that error.
fn another_law(profile: &Profile, designed: &Design) -> Option<String> {
    let Some(ProjectionSpec::Strip(strip)) = &profile.projection else { return None };
    if strip.law == StripLawSpec::LeastCurl || !matches!(profile.shape, ShapeSpec::Designed(_)) {
        return None;
    }
    let mut other = profile.clone();
    let law = StripLawSpec::LeastCurl;
    other.projection =
        Some(ProjectionSpec::Strip(crate::profile::StripSpec { law, ..strip.clone() }));
    let now = designed.facts.pixel_error_px?.rms;
    let found = design(&other).ok()?.facts.pixel_error_px?;
    (found.rms < WORTH * now).then(|| {
        format!(
            "[projection.best] in the place of this law is off by {:.3} px rms, {:.3} px at most",
            found.rms, found.max
        )
    })
}

/// How more of the frame is filled, or, where only obstacles hide what is missing, how that is accepted.
pub(crate) fn filling(profile: &Profile, fault: &PictureFault) -> Option<String> {
    if let PictureFault::FrameFilled { filled, hidden, least, .. } = *fault
        && hidden > 0.0
        && filled + hidden >= least.share()
    {
        // Rounded down, so that the number written down is kept.
        let share = (filled * 1e4).floor() / 1e4;
        return Some(match least {
            LeastFilled::Accepted(_) => {
                format!("write frame_filled = {share} in [accept] to accept what obstacles hide")
            }
            LeastFilled::Asked(_) => format!("ask for {share} to accept what obstacles hide"),
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
