//! The material around a mirror, once its outline is known.

use super::DesignError;
use crate::geom::{Contour, DVec2, Drilled, Outline, Stock};
use crate::mirror::Mirror;
use crate::profile::{Footprint, Profile, Spot};

/// Steps along each side of the outline, which is curved under a pinhole: finer than a mesh's.
const STEPS: usize = 1024;

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
        Footprint::Rect { half_mm } => Contour::Rect {
            half: DVec2::from_array(half_mm) + border.width_mm,
            corner_mm: border.corner_radius_mm,
        },
        Footprint::Round { radius_mm } => {
            Contour::Circle { radius_mm: radius_mm + border.width_mm }
        }
    };
    let drilled = |spot: &Spot| Drilled {
        at: DVec2::new(spot.x_mm, spot.y_mm),
        diameter_mm: spot.diameter_mm,
    };
    Ok(Some(Stock {
        contour,
        top_mm: border.rim_mm,
        holes: border.holes.iter().map(drilled).collect(),
        marks: border.marks.iter().map(drilled).collect(),
    }))
}

/// The rectangle or circle about the axis that holds the mirror.
fn footprint(mirror: &Mirror) -> Footprint {
    let at = |q: DVec2| mirror.place(q, &mirror.row(q.y).at(q.x)).truncate();
    match mirror.whole() {
        // A mirror under a pinhole has a round outline only if it is round itself.
        Outline::Ring { outer, .. } => Footprint::Round { radius_mm: at(DVec2::new(outer, 0.0)).x },
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
