//! What a target of flat facets has to have: something for every pixel, and no jump in depth that a mirror cannot follow.

use super::cause::{FailureCause, LocalFailure};
use super::layout::DesignProblem;
use crate::geom::{DVec2, DVec3};
use crate::mirror::Mirror;
use crate::num::{asin, atan2, degrees};
use crate::optics::{ImagingTask, Target, ThinnedFrame, stereographic};
use crate::parallel;
use crate::profile::Profile;

/// Most columns of the frame that are looked at.
const COLUMNS: u32 = 200;
/// Places along and across the mirror between which no facet may lie.
const PLACES: usize = 24;

/// What a pixel is to show.
struct WantedPlace {
    column: usize,
    row: usize,
    /// Unit direction from the viewpoint.
    wanted: DVec3,
    /// Unit direction from the mirror's reference plane to the place less that; none where the target is not met.
    parallax: Option<DVec3>,
}

/// # Errors
/// [`FailureCause`] with the pixel that shows nothing, or the one beside which the target jumps in depth.
pub(super) fn check(profile: &Profile, problem: &DesignProblem) -> Result<(), FailureCause> {
    if !problem.view.target.is_faceted() {
        return Ok(());
    }
    let thinned = ThinnedFrame::at_most(problem.camera.pixels, COLUMNS);
    let columns: Vec<usize> = thinned.columns().collect();
    let rows: Vec<usize> = thinned.rows(0..problem.camera.pixels[1] as usize).collect();
    let places = parallel::map(columns.len() * rows.len(), 64, |k| {
        wanted_place(problem, columns[k % columns.len()], rows[k / columns.len()])
    });
    let all = places.iter().flatten().count();
    let missing = places.iter().flatten().filter(|place| place.parallax.is_none());
    if let Some(first) = missing.clone().next() {
        return Err(FailureCause::MissedTarget {
            pixel: [first.column, first.row],
            angles_deg: angles_deg(first.wanted),
            share_percent: 100.0 * missing.count() as f64 / all as f64,
        });
    }
    let most_px = profile.acceptance_limits().pixel_error_max_px.value;
    let beside = |k: usize, other: usize| {
        let (a, b) = (places[k].as_ref()?, places.get(other)?.as_ref()?);
        let jump = (a.parallax? - b.parallax?).length();
        let pixels = DVec2::new(a.column as f64 - b.column as f64, a.row as f64 - b.row as f64);
        let jump_px = jump / (a.wanted - b.wanted).length() * pixels.length();
        Some((jump_px, [a.column, a.row]))
    };
    let jumps = (0..places.len()).flat_map(|k| {
        let right = (k % columns.len() + 1 < columns.len()).then(|| beside(k, k + 1)).flatten();
        [right, beside(k, k + columns.len())]
    });
    let worst = jumps.flatten().max_by(|a, b| a.0.total_cmp(&b.0));
    match worst {
        // On one side of it a mirror without steps is off by half of it at the least.
        Some((jump_px, pixel)) if !(0.5 * jump_px <= most_px) => {
            Err(FailureCause::DepthJump { pixel, jump_px, most_px })
        }
        _ => Ok(()),
    }
}

/// What a pixel is to show; none where nothing is wanted of it.
fn wanted_place(problem: &DesignProblem, column: usize, row: usize) -> Option<WantedPlace> {
    let DesignProblem { camera, view, outline, .. } = problem;
    let image = camera.image_point(column as f64 + 0.5, row as f64 + 0.5);
    let q = camera.picture.chart_point(image);
    if !(view.projection.wants(image) && outline.contains(q)) {
        return None;
    }
    let sigma = view.projection.direction_of(image.to_array());
    let wanted = stereographic::direction(sigma);
    let from = camera.chart.point(q, 0.0) - DVec3::Z * view.origin_mm;
    let sent = stereographic::direction(view.target.direction_at(from.to_array(), sigma));
    let parallax = sent.is_finite().then(|| sent - wanted);
    Some(WantedPlace { column, row, wanted, parallax })
}

fn angles_deg(direction: DVec3) -> [f64; 2] {
    let DVec3 { x, y, z } = direction;
    [degrees(atan2(x, y)), degrees(asin(z.clamp(-1.0, 1.0)))]
}

/// # Errors
/// [`FailureCause`] with the place at which facets of the target reach through the mirror.
pub(super) fn check_mirror(mirror: &Mirror, view: &ImagingTask) -> Result<(), FailureCause> {
    let Target::Posed(target) = &view.target else { return Ok(()) };
    if !target.is_faceted() {
        return Ok(());
    }
    let place = |q: DVec2| mirror.position(q, &mirror.at(q)) - DVec3::Z * view.origin_mm;
    let lines = mirror.full_outline().samples(PLACES);
    let along = lines.iter().flat_map(|line| line.windows(2).map(|pair| [pair[0].0, pair[1].0]));
    let across = lines
        .windows(2)
        .flat_map(|pair| pair[0].iter().zip(&pair[1]).map(|(a, b)| [a.0, b.0]).collect::<Vec<_>>());
    let cut = along.chain(across).find(|pair| target.parts(place(pair[0]), place(pair[1])));
    match cut {
        Some([at, _]) => {
            let at = place(at).truncate();
            Err(FailureCause::At { at, failure: LocalFailure::ThroughTarget, stage: None })
        }
        None => Ok(()),
    }
}
