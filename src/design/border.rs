//! The material around a mirror, once its outline is known.

use super::DesignError;
use crate::geom::{Border, Contour, DVec2, Drilled, Hole, Land, Outline, Rect};
use crate::mirror::Mirror;
use crate::num::rounding::significant;
use crate::num::{cos, radians, sin};
use crate::profile::{BorderConflict, BorderFeature, BorderSpec, Profile, is_in_land};

/// Steps along each side of the outline, which is curved under a pinhole: finer than a mesh's.
const STEPS: usize = 1024;
/// A land whose rim rises and falls by less is flat, mm.
const FLAT_MM: f64 = 1e-6;

/// Border that the profile puts around `mirror`.
///
/// # Errors
/// [`DesignError::Border`] when a hole, a mark or rounded corners do not fit.
pub(super) fn around(profile: &Profile, mirror: &Mirror) -> Result<Option<Border>, DesignError> {
    let part = &profile.part;
    if part.border.is_none() && part.holes.is_empty() {
        return Ok(None);
    }
    let rim_mm = part.border.as_ref().map_or(0.0, |border| border.rim_mm);
    let outline = outline_about_axis(mirror, rim_mm);
    if let Some(conflict) = part.conflicts(&outline).into_iter().next() {
        let border = part.border.as_ref();
        let hint = border.and_then(|border| fitting(border, &outline, &conflict));
        let hint = hint.unwrap_or(conflict.hint);
        return Err(DesignError::Border { message: conflict.message, hint });
    }
    let Some(border) = &part.border else { return Ok(None) };
    let plain = border.holes.iter().map(|spot| Hole::plain(spot.at, spot.diameter_mm));
    let through = part.holes.iter().filter(|spec| spec.blind.is_none());
    let (in_land, holes): (Vec<Hole>, Vec<Hole>) = plain
        .chain(through.clone().map(|spec| spec.hole))
        .partition(|hole| is_in_land(&outline, hole.at));
    let land = match in_land.first() {
        None => None,
        Some(hole) => Some(Land { z_mm: land(mirror, hole)?, holes: in_land }),
    };
    for spec in through.filter(|spec| is_in_land(&outline, spec.hole.at)) {
        let z_mm = land.as_ref().map_or(0.0, |land| land.z_mm);
        if let Some((message, least_mm)) = spec.shallow(z_mm) {
            let base_mm = digits(part.base_mm + least_mm - z_mm + 5e-4);
            return Err(DesignError::Border { message, hint: format!("set base_mm = {base_mm}") });
        }
    }
    Ok(Some(Border {
        contour: border.contour(&outline),
        top_mm: border.rim_mm,
        edge_chamfer_mm: border.edge_chamfer_mm,
        holes,
        marks: border.marks.clone(),
        land,
    }))
}

/// Remedy of a conflict, in numbers that have been tried.
fn fitting(border: &BorderSpec, mirror: &Outline, conflict: &BorderConflict) -> Option<String> {
    let fits = |tried: &BorderSpec| {
        let conflicts = tried.conflicts(mirror);
        // (Chamfers that do not fit keep the others from being told.)
        let is_there =
            |left: BorderFeature| left == conflict.feature || left == BorderFeature::Edges;
        !conflicts.iter().any(|left| is_there(left.feature))
    };
    let name = match conflict.feature {
        BorderFeature::Corners => {
            let smaller = |c: &f64| Some(digits(0.8 * c));
            let radii = std::iter::successors(Some(border.corner_radius_mm), smaller).take(60);
            // One as large as the border is wide is concentric to the mirror's corner.
            let mut radii = radii.chain([border.width_mm]);
            let fitting = |&c: &f64| fits(&BorderSpec { corner_radius_mm: c, ..border.clone() });
            return radii.find(fitting).map(|c| format!("set corner_radius_mm = {c}"));
        }
        BorderFeature::Hole(_) => "hole",
        BorderFeature::Mark(_) => "mark",
        // (Its diameter is that of a drill; the chamfers have their own remedy.)
        BorderFeature::Drilling(_) | BorderFeature::Edges => return None,
    };
    let leg = border.edge_chamfer_mm;
    let wide = digits(border.width_mm.max(BorderSpec::LEAST_MM + 4.0 * BorderSpec::CLEAR_MM + leg));
    [border.width_mm, wide].into_iter().find_map(|width_mm| {
        let mut tried = BorderSpec { width_mm, ..border.clone() };
        let spot = match conflict.feature {
            BorderFeature::Hole(k) => &mut tried.holes[k],
            BorderFeature::Mark(k) => &mut tried.marks[k],
            _ => return None,
        };
        let before = spot.at.length();
        *spot = middle(mirror, width_mm - leg, spot);
        let way = if spot.at.length() < before { "inwards" } else { "outwards" };
        let found = format!("[{}, {}, {}]", spot.at.x, spot.at.y, spot.diameter_mm);
        let widen = match width_mm > border.width_mm {
            true => format!("set border_mm = {width_mm} and "),
            false => String::new(),
        };
        let said = format!("{widen}move the {name} {way}, to {found}");
        fits(&tried).then_some(said)
    })
}

/// The place of `spot` in the middle of a flat rim of this width, on the same side, and as large as
/// it may be there.
fn middle(mirror: &Outline, width_mm: f64, spot: &Drilled) -> Drilled {
    let room = width_mm - 2.5 * BorderSpec::CLEAR_MM;
    let diameter_mm = digits(spot.diameter_mm.min(room).max(BorderSpec::LEAST_MM));
    let DVec2 { x, y } = spot.at;
    let at = match *mirror {
        Outline::Rect(rect) if x.abs() >= y.abs() => {
            DVec2::new((rect.max.x + 0.5 * width_mm) * x.signum(), 0.0)
        }
        Outline::Rect(rect) => DVec2::new(0.0, (rect.max.y + 0.5 * width_mm) * y.signum()),
        Outline::Ring { outer, .. } => (outer + 0.5 * width_mm) / spot.at.length() * spot.at,
    };
    Drilled { at: DVec2::new(digits(at.x), digits(at.y)), diameter_mm }
}

/// To six digits.
fn digits(x: f64) -> f64 {
    significant(x, 6)
}

/// Z of the land inside a ring, which must be flat for `hole` to go through it.
fn land(mirror: &Mirror, hole: &Hole) -> Result<f64, DesignError> {
    let Outline::Ring { inner, .. } = mirror.outline else { unreachable!("a ring has a land") };
    let z = mirror.rim_mm(inner);
    let off = (0..360).map(|degrees| {
        let angle = radians(f64::from(degrees));
        let q = inner * DVec2::new(cos(angle), sin(angle));
        (mirror.position(q, &mirror.surface.at(q)).z - z).abs()
    });
    let off = off.fold(0.0, f64::max);
    if off <= FLAT_MM {
        return Ok(z);
    }
    Err(DesignError::Border {
        message: format!(
            "part.holes_mm must leave out the land of a mirror that is not round, found [{}, {}, {}]; \
             the land's rim is not flat, it rises and falls by {off:.4} mm",
            hole.at.x, hole.at.y, hole.diameter_mm
        ),
        hint: "drill the hole through a mirror without terms, or move it to the flat rim"
            .to_owned(),
    })
}

/// X and Y of the point of `mirror` at `q` of its chart.
fn plan(mirror: &Mirror, q: DVec2) -> DVec2 {
    mirror.position(q, &mirror.row(q.y).at(q.x)).truncate()
}

/// The rectangle along X and Y around a part, mm.
pub(super) fn plan_bounds(mirror: &Mirror, border: Option<&Border>) -> Rect {
    let half = match border.map(|border| border.contour) {
        Some(Contour::Rect { half, .. }) => half,
        Some(Contour::Circle { radius_mm }) => DVec2::splat(radius_mm),
        None => return extent(mirror, 0.0),
    };
    Rect { min: -half, max: half }
}

/// The rectangle along X and Y around the mirror and the foot of its skirt, which is at height `foot_mm`.
pub(super) fn extent(mirror: &Mirror, foot_mm: f64) -> Rect {
    let none = Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
    let (rect, foot) = match mirror.full_outline() {
        Outline::Ring { outer, .. } => {
            // A mirror under a pinhole has a round outline only if it is round itself.
            let half = DVec2::splat(plan(mirror, DVec2::new(outer, 0.0)).x);
            return Rect { min: -half, max: half };
        }
        Outline::Rect(rect) if mirror.has_steps() => {
            // The skirt leads along the camera's rays: outwards from the rim, or, on a side over which they lean, inwards.
            let [min, max] = [rect.min, rect.max].map(|q| mirror.chart.ray_at(q, foot_mm));
            (rect, Rect { min, max })
        }
        Outline::Rect(rect) => (rect, none),
    };
    let rim = (0..=STEPS).flat_map(|k| {
        let q = rect.min + rect.size() * (k as f64 / STEPS as f64);
        let q = q.min(rect.max);
        let across = [rect.min.y, rect.max.y].map(|y| DVec2::new(q.x, y));
        let along = [rect.min.x, rect.max.x].map(|x| DVec2::new(x, q.y));
        [across, along].concat()
    });
    rim.map(|q| plan(mirror, q))
        .fold(foot, |all, p| Rect { min: all.min.min(p), max: all.max.max(p) })
}

/// The rectangle or ring about the axis that holds the mirror and the foot of its skirt, over X and Y.
fn outline_about_axis(mirror: &Mirror, foot_mm: f64) -> Outline {
    match mirror.full_outline() {
        Outline::Ring { inner, outer } => {
            let radius = |q: f64| if q == 0.0 { 0.0 } else { plan(mirror, DVec2::new(q, 0.0)).x };
            Outline::Ring { inner: radius(inner), outer: radius(outer) }
        }
        Outline::Rect(_) => {
            let extent = extent(mirror, foot_mm);
            let half = extent.max.abs().max(extent.min.abs());
            Outline::Rect(Rect { min: -half, max: half })
        }
    }
}
