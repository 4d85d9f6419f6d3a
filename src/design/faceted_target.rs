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

/// Halvings of the way between two pixels in the search for a jump: what changes evenly is a thousandth of a pixel's then.
const HALVINGS: usize = 14;

/// What a place of the picture is to show.
#[derive(Clone, Copy)]
struct WantedPlace {
    /// Column and row, pixels from the upper left corner of the frame.
    pixel: DVec2,
    /// Unit direction from the viewpoint.
    wanted: DVec3,
    /// Unit direction from the mirror's reference plane to the place less that; none where the target is not met.
    parallax: Option<DVec3>,
}

impl WantedPlace {
    /// Column and row of the pixel that it is in, from 0.
    fn column_and_row(&self) -> [usize; 2] {
        self.pixel.to_array().map(|at| at as usize)
    }
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
        let pixel = [columns[k % columns.len()], rows[k / columns.len()]];
        wanted_place(problem, DVec2::from_array(pixel.map(|at| at as f64 + 0.5)))
    });
    let missing = places.iter().flatten().filter(|place| place.parallax.is_none());
    if let Some(first) = missing.clone().next() {
        return Err(FailureCause::MissedTarget {
            pixel: first.column_and_row(),
            angles_deg: angles_deg(first.wanted),
            share_percent: 100.0 * missing.count() as f64 / places.len() as f64,
        });
    }
    let most_px = profile.acceptance_limits().pixel_error_max_px.value;
    let beside = |k: usize, other: usize| {
        let pair = [places[k]?, (*places.get(other)?)?];
        // On one side of a jump a mirror without steps is off by half of it at the least.
        let is_too_far = |pair: &[WantedPlace; 2]| {
            change_px(pair, pair).is_some_and(|px| !(0.5 * px <= most_px))
        };
        is_too_far(&pair).then(|| jump(problem, &pair))?
    };
    let jumps = (0..places.len()).flat_map(|k| {
        let right = (k % columns.len() + 1 < columns.len()).then(|| beside(k, k + 1)).flatten();
        [right, beside(k, k + columns.len())]
    });
    let worst = jumps.flatten().max_by(|a, b| a.0.total_cmp(&b.0));
    match worst {
        Some((jump_px, pixel)) if !(0.5 * jump_px <= most_px) => {
            Err(FailureCause::DepthJump { pixel, jump_px, most_px })
        }
        _ => Ok(()),
    }
}

/// Change of the parallax between two places, in pixels of the picture between two others.
fn change_px([a, b]: &[WantedPlace; 2], [from, to]: &[WantedPlace; 2]) -> Option<f64> {
    let change = (a.parallax? - b.parallax?).length();
    Some(change / (from.wanted - to.wanted).length() * (from.pixel - to.pixel).length())
}

/// The largest jump between two pixels, px, and the pixel beside which it is: what is left of the parallax's change where
/// the places come together.
fn jump(problem: &DesignProblem, pair: &[WantedPlace; 2]) -> Option<(f64, [usize; 2])> {
    let [mut a, mut b] = *pair;
    for _ in 0..HALVINGS {
        let Some(middle) = wanted_place(problem, 0.5 * (a.pixel + b.pixel)) else { break };
        let halves = [[a, middle], [middle, b]];
        let [first, second] = halves.map(|half| change_px(&half, pair).unwrap_or(0.0));
        [a, b] = halves[usize::from(second > first)];
    }
    Some((change_px(&[a, b], pair)?, a.column_and_row()))
}

/// What the picture is to show at a place in pixels; none where nothing is wanted of it.
fn wanted_place(problem: &DesignProblem, pixel: DVec2) -> Option<WantedPlace> {
    let DesignProblem { camera, view, outline, .. } = problem;
    let image = camera.image_point(pixel.x, pixel.y);
    let q = camera.picture.chart_point(image);
    if !(view.projection.wants(image) && outline.contains(q)) {
        return None;
    }
    let sigma = view.projection.direction_of(image.to_array());
    let wanted = stereographic::direction(sigma);
    let from = camera.chart.point(q, 0.0) - DVec3::Z * view.origin_mm;
    let sent = stereographic::direction(view.target.direction_at(from.to_array(), sigma));
    let parallax = sent.is_finite().then(|| sent - wanted);
    Some(WantedPlace { pixel, wanted, parallax })
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
