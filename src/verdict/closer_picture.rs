//! Ways out where the picture is off its projection: a law, facets or a degree that follow it more closely. Every design has been
//! tried, and every mesh foreseen; what finer facets leave is in proportion to their limit.

use crate::design::{Design, design_alone};
use crate::num::hypot;
use crate::num::rounding::two_digits_below;
use crate::num::stats::Summary;
use crate::part::plan;
use crate::profile::{
    MeshGoal, Method, Profile, ProjectionSpec, ShapeSpec, StripLawSpec, StripSpec,
};

/// How much less of an error another law must leave to be worth a change.
const WORTH: f64 = 0.7;
/// Share of what the limits leave that facets or another design take: errors of both are independent in the mean alone.
const SHARE: f64 = 0.9;
/// Degrees above that of the profile that are tried, and the largest.
const MORE: [usize; 2] = [4, 10];
const MOST_DEGREE: usize = 40;
/// The least limit for facets that a profile may name, px.
const LEAST_FACET_PX: f64 = 1e-3;

/// What brings the picture nearer to its projection, where `facets` are what those of the files displace it by.
pub(super) fn closer_picture(
    profile: &Profile,
    designed: &Design,
    facets: Option<Summary>,
) -> Option<String> {
    let law = another_law(profile, designed);
    // (Across the edges of a target's facets there is no limit for the mirror's.)
    let facets = facets.filter(|_| designed.view.as_ref().is_some_and(|view| view.has_bounds()));
    let finer = || finer_facets(profile, designed, facets?);
    law.or_else(finer).or_else(|| higher_degree(profile, designed, facets?))
}

/// The law that leaves a smaller error, if it is much smaller, with that error.
fn another_law(profile: &Profile, designed: &Design) -> Option<String> {
    let Some(ProjectionSpec::Strip(strip)) = &profile.projection else { return None };
    if strip.law == StripLawSpec::LeastCurl || !matches!(profile.shape, ShapeSpec::Designed(_)) {
        return None;
    }
    let mut other = profile.clone();
    let law = StripLawSpec::LeastCurl;
    other.projection = Some(ProjectionSpec::Strip(StripSpec { law, ..strip.clone() }));
    let now = designed.facts.pixel_error_px?.rms;
    let found = design_alone(&other).ok()?.facts.pixel_error_px?;
    (found.rms < WORTH * now).then(|| {
        format!(
            "[projection.best] in the place of this law is off by {:.3} px rms, {:.3} px at most",
            found.rms, found.max
        )
    })
}

/// The limit for facets with which the picture keeps the profile's limits, where the design does and so fine a mesh can be made.
fn finer_facets(profile: &Profile, designed: &Design, facets: Summary) -> Option<String> {
    let own = designed.facts.pixel_error_px?;
    let limits = profile.acceptance_limits();
    let [rms, max] = [limits.pixel_error_rms_px.value, limits.pixel_error_max_px.value];
    if !(own.rms < rms && own.max < max) {
        return None;
    }
    let by_rms = (rms * rms - own.rms * own.rms).sqrt() / facets.rms;
    let share = by_rms.min((max - own.max) / facets.max);
    let px = two_digits_below(SHARE * share * facets.max);
    let place = match profile.mesh {
        MeshGoal::Budget(_) => "[mesh] in the place of max_triangles",
        MeshGoal::Limits { .. } => "[mesh]",
    };
    let mesh = MeshGoal::limits(profile.mesh.chord_um(), Some(px));
    let can_be_made = || plan(&Profile { mesh, ..profile.clone() }, designed).is_ok();
    (share < 1.0 && px >= LEAST_FACET_PX && can_be_made()).then(|| {
        format!(
            "the design is off by {:.3} px rms, {:.3} px at most, and its flat facets by the rest: write facet_px = {px} in {place}",
            own.rms, own.max
        )
    })
}

/// A degree of the design with which the picture keeps the profile's limits.
fn higher_degree(profile: &Profile, designed: &Design, facets: Summary) -> Option<String> {
    let ShapeSpec::Designed(method) = profile.shape else { return None };
    let limits = profile.acceptance_limits();
    let most_rms = SHARE * limits.pixel_error_rms_px.value;
    // (Every mirror's error is larger than the least one, whatever its degree.)
    let least = designed.facts.least_error.as_ref().map_or(0.0, |least| least.pixel_rms_px);
    if hypot(least, facets.rms) > most_rms {
        return None;
    }
    let degrees = MORE.map(|more| method.degree + more).into_iter();
    degrees.filter(|&degree| degree <= MOST_DEGREE).find_map(|degree| {
        let shape = ShapeSpec::Designed(Method { degree, ..method });
        let found =
            design_alone(&Profile { shape, ..profile.clone() }).ok()?.facts.pixel_error_px?;
        let keeps = hypot(found.rms, facets.rms) <= most_rms
            && found.max + facets.max <= SHARE * limits.pixel_error_max_px.value;
        keeps.then(|| {
            format!(
                "degree = {degree} in [method.{}] is off by {:.3} px rms, {:.3} px at most",
                method.kind.name(),
                found.rms,
                found.max
            )
        })
    })
}
