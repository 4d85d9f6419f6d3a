//! A plan of a floor, as commands are asked for it.

use super::Error;
use crate::geom::{DVec2, Ray};
use crate::lookup::{FloorPlane, MapFrame, PlanRows};
use crate::raster::{MOST_PIXELS, MOST_SIDE};

/// Range of a floor over its distance: where it is seen 11 degrees below the horizon.
const RANGE: f64 = 5.0;
/// Pixels across half of a plan.
const HALF_PLAN: f64 = 250.0;

/// A floor, and the scale of its plan.
#[derive(Debug, Clone, Copy)]
pub(super) struct FloorPlan {
    /// Z of the floor in the part's frame, mm.
    pub z_mm: f64,
    /// Farthest place of the floor from the axis, mm; none: five times as far as the floor.
    pub range_mm: Option<f64>,
    /// Millimetres to a pixel; none: 500 pixels across.
    pub mm_per_px: Option<f64>,
}

impl FloorPlan {
    /// The floor.
    pub(super) fn plane(&self) -> FloorPlane {
        let range_mm = self.range_mm.unwrap_or(RANGE * self.z_mm.abs());
        FloorPlane { z_mm: self.z_mm, range_mm }
    }

    /// The floor as far as steps on the way to a place may lead: beyond the range.
    pub(super) fn beyond(&self) -> FloorPlane {
        FloorPlane { range_mm: 2.0 * self.plane().range_mm, ..self.plane() }
    }

    /// Millimetres to a pixel.
    pub(super) fn mm_per_px(&self) -> f64 {
        self.mm_per_px.unwrap_or(self.plane().range_mm / HALF_PLAN)
    }

    /// The plan, with Y up.
    pub(super) fn map(&self) -> MapFrame {
        self.framed(PlanRows::AgainstY)
    }

    /// The floor as seen from the mirror, which is at Z = 0: with Y up below it, and down above it.
    pub(super) fn seen_from_mirror(&self) -> MapFrame {
        self.framed(self.rows_seen())
    }

    /// Y of a row less that of the row above it in the floor as seen from the mirror, mm.
    pub(super) fn row_seen_mm(&self) -> f64 {
        self.rows_seen().step_mm(self.mm_per_px())
    }

    fn rows_seen(&self) -> PlanRows {
        if self.z_mm < 0.0 { PlanRows::AgainstY } else { PlanRows::AlongY }
    }

    fn framed(&self, rows: PlanRows) -> MapFrame {
        MapFrame::Floor { plane: self.plane(), mm_per_px: self.mm_per_px(), rows }
    }

    /// Refuses a floor of which `rays` show nothing within its range; `option` is the one that gives its Z.
    ///
    /// # Errors
    /// [`Error::Option`] of the range, with that of the nearest place that is shown, or of a floor that no ray meets.
    pub(super) fn check_shown<'r>(
        &self,
        rays: impl Iterator<Item = &'r Ray>,
        option: &'static str,
    ) -> Result<(), Error> {
        let FloorPlane { z_mm, range_mm } = self.plane();
        let everywhere = FloorPlane { z_mm, range_mm: f64::INFINITY };
        let far = rays.filter_map(|ray| everywhere.meets(ray)).map(|at| DVec2::from(at).length());
        let nearest = far.filter(|mm| mm.is_finite()).reduce(f64::min);
        let (option, must, found) = match nearest {
            Some(mm) if mm <= range_mm => return Ok(()),
            Some(mm) => {
                let must = format!(
                    "more than {:.0}: nothing of the floor at Z = {z_mm} mm is seen nearer to the axis",
                    mm.ceil()
                );
                ("--range-mm", must, range_mm)
            }
            None => {
                let must = "where the mirror's rays go; Z is positive past the camera and negative behind the mirror";
                (option, must.to_owned(), z_mm)
            }
        };
        Err(Error::Option { option, must, found: found.to_string() })
    }

    /// Whether there can be such a plan; `option` is the one that gives the floor's Z.
    ///
    /// # Errors
    /// [`Error::Option`] of the first option that has a value without a meaning.
    pub(super) fn check(&self, option: &'static str) -> Result<(), Error> {
        let bad = |option, must: String, found: f64| {
            Err(Error::Option { option, must, found: found.to_string() })
        };
        if !(self.z_mm.is_finite() && self.z_mm != 0.0) {
            return bad(option, "finite, and not 0".into(), self.z_mm);
        }
        for (option, mm) in [("--range-mm", self.range_mm), ("--mm-per-px", self.mm_per_px)] {
            if let Some(mm) = mm.filter(|mm| !(mm.is_finite() && *mm > 0.0)) {
                return bad(option, "positive, and finite".into(), mm);
            }
        }
        let across_mm = 2.0 * self.plane().range_mm;
        let pixels = across_mm / self.mm_per_px();
        let fits = (2.0..=f64::from(MOST_SIDE)).contains(&pixels);
        if !fits || pixels * pixels > MOST_PIXELS as f64 {
            let most = (MOST_PIXELS as f64).sqrt().floor().min(f64::from(MOST_SIDE));
            let must =
                format!("such that the plan of {across_mm} mm has 2 to {most} pixels a side");
            return bad("--mm-per-px", must, self.mm_per_px());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;

    /// Rays that go down at 45 and 30 degrees, and one that goes up.
    #[test]
    fn a_floor_that_no_ray_shows_is_refused_with_what_would_do() {
        let ray = |z: f64| Ray { origin: DVec3::ZERO, direction: DVec3::new(1.0, 0.0, z) };
        let rays = [ray(-1.0), ray(-0.5), ray(0.5), ray(0.0)];
        let said = |z_mm: f64, range_mm: f64, rays: &[Ray]| {
            let plan = FloorPlan { z_mm, range_mm: Some(range_mm), mm_per_px: None };
            plan.check_shown(rays.iter(), "--floor-mm").map_err(|error| error.to_string())
        };
        assert_eq!(said(-100.0, 100.5, &rays), Ok(()));
        assert_eq!(said(100.0, 201.0, &rays), Ok(()));
        let near = said(-100.0, 99.0, &rays).unwrap_err();
        assert!(near.starts_with("--range-mm must be more than 100: "), "{near}");
        assert!(near.ends_with("found 99"), "{near}");
        let none = said(100.0, 1e6, &rays[..2]).unwrap_err();
        assert!(none.starts_with("--floor-mm must be where the mirror's rays go"), "{none}");
    }
}
