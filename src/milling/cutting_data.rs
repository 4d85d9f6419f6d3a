//! Feeds and speeds to begin with, by the material of the stock.

use super::motions::Pace;
use crate::num::rounding::significant;
use crate::profile::{MachineSpec, MillSpec, StockMaterial};
use serde::Serialize;

/// Speed of the spindle and feeds of a cutter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Speeds {
    /// Speed of the spindle, 1/min.
    pub spindle_rpm: f64,
    /// Feed of cutting moves, mm/min.
    pub feed_mm_min: f64,
    /// Feed of moves into the stock, mm/min.
    pub entry_feed_mm_min: f64,
}

/// What is usual of a material, of carbide cutters without coolant on light machines.
struct CuttingData {
    /// Speed of the teeth, m/min.
    cutting_m_min: f64,
    /// Feed of a tooth over the cutter's diameter.
    tooth_share: f64,
    /// Step from level to level over the diameter.
    stepdown_share: f64,
}

/// Feed into the stock over that of cutting moves: a third, as plunging edges near the tip hardly move.
const ENTRY_SHARE: f64 = 1.0 / 3.0;

/// Values that handbooks give for cutters of 3 to 10 mm, at their lower end.
fn usual(material: StockMaterial) -> CuttingData {
    let [cutting_m_min, tooth_share, stepdown_share] = match material {
        StockMaterial::Aluminium => [200.0, 0.008, 0.15],
        StockMaterial::Brass => [150.0, 0.007, 0.12],
        StockMaterial::Pmma => [150.0, 0.012, 0.25],
        StockMaterial::Wax => [250.0, 0.02, 0.5],
    };
    CuttingData { cutting_m_min, tooth_share, stepdown_share }
}

impl Speeds {
    /// Those of a ball of radius `ball_mm` at the feed that the profile names, if it does.
    #[must_use]
    pub(super) fn new(spec: &MillSpec, ball_mm: f64, feed_mm_min: Option<f64>) -> Self {
        let MachineSpec { max_feed_mm_min, max_spindle_rpm, .. } = spec.machine;
        let data = usual(spec.material);
        let diameter_mm = 2.0 * ball_mm;
        let usual_rpm = 1e3 * data.cutting_m_min / (std::f64::consts::PI * diameter_mm);
        let asked = spec.speeds.spindle_rpm;
        let spindle_rpm = asked.unwrap_or_else(|| significant(usual_rpm, 2)).min(max_spindle_rpm);
        let tooth_mm = data.tooth_share * diameter_mm;
        let usual_feed = tooth_mm * f64::from(spec.speeds.teeth) * spindle_rpm;
        let feed = feed_mm_min.unwrap_or_else(|| significant(usual_feed, 2)).min(max_feed_mm_min);
        let entry_feed_mm_min = significant(ENTRY_SHARE * feed, 2);
        Self { spindle_rpm, feed_mm_min: feed, entry_feed_mm_min }
    }

    /// Feed of a move, mm/min; none of a rapid one.
    #[must_use]
    pub fn feed_of(&self, pace: Pace) -> Option<f64> {
        match pace {
            Pace::Rapid => None,
            Pace::Entry => Some(self.entry_feed_mm_min),
            Pace::Cut => Some(self.feed_mm_min),
        }
    }
}

/// Step from level to level, mm.
pub(super) fn stepdown_mm(spec: &MillSpec, ball_mm: f64) -> f64 {
    let usual = significant(2.0 * ball_mm * usual(spec.material).stepdown_share, 2);
    spec.roughing.stepdown_mm.unwrap_or(usual)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cutter of 6 mm with two teeth in aluminium: n = 1000 v / (pi D), f = n z fz, as handbooks have it.
    #[test]
    fn speeds_follow_the_shops_formulas_and_the_machines_limits() {
        let spec = MillSpec::default();
        let found = Speeds::new(&spec, 3.0, None);
        assert_eq!(
            (found.spindle_rpm, found.feed_mm_min, found.entry_feed_mm_min),
            (11_000.0, 1100.0, 370.0)
        );
        assert_eq!(stepdown_mm(&spec, 3.0), 0.9);
        let small = Speeds::new(&spec, 0.5, None);
        assert_eq!(small.spindle_rpm, 24_000.0);
        let named = Speeds::new(&spec, 3.0, Some(4000.0));
        assert_eq!(named.feed_mm_min, 3000.0);
    }
}
