//! Whether a tool with a round nose fits the sections of a mirror.

use super::TurningError;
use super::meridian::MeridianPlace;
use crate::num::{atan, degrees};

/// That a nose of radius `nose_mm` which leaves `allowance_mm` fits where sections are most hollow.
///
/// # Errors
/// [`TurningError::Hollow`].
pub(super) fn holds(
    places: impl Iterator<Item = MeridianPlace>,
    nose_mm: f64,
    allowance_mm: f64,
) -> Result<(), TurningError> {
    let hollow = places.max_by(|a, b| a.curvature.total_cmp(&b.curvature));
    match hollow {
        Some(place) if place.curvature * (nose_mm + allowance_mm) >= 1.0 => {
            let (radius_mm, hollow_mm) = (place.at.x, 1.0 / place.curvature);
            Err(TurningError::Hollow { radius_mm, hollow_mm, nose_mm, allowance_mm })
        }
        _ => Ok(()),
    }
}

/// That straight edges of these angles, degrees, on the axis' and on the rim's side of the nose touch nothing.
///
/// # Errors
/// [`TurningError::Steep`].
pub(super) fn clears(
    places: impl Iterator<Item = MeridianPlace> + Clone,
    [inner_deg, outer_deg]: [f64; 2],
) -> Result<(), TurningError> {
    for (sign, edge_deg, key) in
        [(-1.0, inner_deg, "inner_edge_deg"), (1.0, outer_deg, "outer_edge_deg")]
    {
        let steepest = places.clone().max_by(|a, b| (sign * a.slope).total_cmp(&(sign * b.slope)));
        let Some(place) = steepest else { continue };
        let slope_deg = degrees(atan(sign * place.slope));
        if slope_deg > edge_deg {
            let radius_mm = place.at.x;
            return Err(TurningError::Steep { radius_mm, slope_deg, edge_deg, key });
        }
    }
    Ok(())
}
