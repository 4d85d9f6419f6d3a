//! The material around a mirror, once its outline is known.

use super::DesignError;
use crate::geom::{Contour, DVec2, Drilled, Land, Outline, Stock};
use crate::mirror::Mirror;
use crate::num::{cos, radians, sin};
use crate::profile::{Border, Footprint, Profile, Spot};

/// Steps along each side of the outline, which is curved under a pinhole: finer than a mesh's.
const STEPS: usize = 1024;
/// A land whose rim rises and falls by less is flat, mm.
const FLAT_MM: f64 = 1e-6;

/// What the profile puts around `mirror`.
///
/// # Errors
/// [`DesignError::Border`] when a hole, a mark or rounded corners do not fit.
pub fn around(profile: &Profile, mirror: &Mirror) -> Result<Option<Stock>, DesignError> {
    let Some(border) = &profile.part.border else { return Ok(None) };
    let footprint = footprint(mirror);
    if let Some(misfit) = border.misfits(&footprint).into_iter().next() {
        return Err(DesignError::Border { message: misfit.message, hint: misfit.hint });
    }
    let contour = match footprint {
        Footprint::Rect { half_mm } => {
            let half = DVec2::from_array(half_mm) + border.width_mm;
            let (corner, most) = (border.corner_radius_mm, half.min_element());
            // Arcs that meet but for rounding meet.
            let corner_mm =
                if (corner - most).abs() <= Border::ROUNDING_MM { most } else { corner };
            Contour::Rect { half, corner_mm }
        }
        Footprint::Round { radius_mm, .. } => {
            Contour::Circle { radius_mm: radius_mm + border.width_mm }
        }
    };
    let drilled = |spot: &Spot| Drilled {
        at: DVec2::new(spot.x_mm, spot.y_mm),
        diameter_mm: spot.diameter_mm,
    };
    let (in_land, holes): (Vec<&Spot>, Vec<&Spot>) =
        border.holes.iter().partition(|hole| footprint.has_in_land(hole));
    let land = match in_land.first() {
        None => None,
        Some(hole) => Some(Land {
            z_mm: land(mirror, hole)?,
            holes: in_land.into_iter().map(drilled).collect(),
        }),
    };
    Ok(Some(Stock {
        contour,
        top_mm: border.rim_mm,
        holes: holes.into_iter().map(drilled).collect(),
        marks: border.marks.iter().map(drilled).collect(),
        land,
    }))
}

/// Z of the land inside a ring, which must be flat for `hole` to go through it.
fn land(mirror: &Mirror, hole: &Spot) -> Result<f64, DesignError> {
    let Outline::Ring { inner, .. } = mirror.outline else { unreachable!("a ring has a land") };
    let z = mirror.rim_mm(inner);
    let off = (0..360).map(|degrees| {
        let angle = radians(f64::from(degrees));
        let q = inner * DVec2::new(cos(angle), sin(angle));
        (mirror.place(q, &mirror.surface.at(q)).z - z).abs()
    });
    let off = off.fold(0.0, f64::max);
    if off <= FLAT_MM {
        return Ok(z);
    }
    Err(DesignError::Border {
        message: format!(
            "part.holes_mm must leave out the land of a mirror that is not round, found [{}, {}, {}]; \
             the land's rim is not flat, it rises and falls by {off:.4} mm",
            hole.x_mm, hole.y_mm, hole.diameter_mm
        ),
        hint: "drill the hole through a mirror without terms, or move it to the flat rim"
            .to_owned(),
    })
}

/// The rectangle or circle about the axis that holds the mirror.
fn footprint(mirror: &Mirror) -> Footprint {
    let at = |q: DVec2| mirror.place(q, &mirror.row(q.y).at(q.x)).truncate();
    match mirror.whole() {
        // A mirror under a pinhole has a round outline only if it is round itself.
        Outline::Ring { inner, outer } => {
            let radius = |q: f64| if q == 0.0 { 0.0 } else { at(DVec2::new(q, 0.0)).x };
            Footprint::Round { radius_mm: radius(outer), land_mm: radius(inner) }
        }
        Outline::Rect(rect) => {
            let rim = (0..=STEPS).flat_map(|k| {
                let q = rect.min + rect.size() * (k as f64 / STEPS as f64);
                let q = q.min(rect.max);
                let across = [rect.min.y, rect.max.y].map(|y| DVec2::new(q.x, y));
                let along = [rect.min.x, rect.max.x].map(|x| DVec2::new(x, q.y));
                [across, along].concat()
            });
            let half = rim.map(|q| at(q).abs()).fold(DVec2::ZERO, DVec2::max);
            Footprint::Rect { half_mm: half.to_array() }
        }
    }
}
