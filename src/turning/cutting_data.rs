//! Feeds and speeds to begin with, by the material of the bar.

use crate::num::rounding::{floor_four_digits, significant};
use crate::profile::{StockMaterial, TurnSpec};

/// What is usual of a material, of carbide inserts without coolant on light lathes.
struct FacingData {
    /// Speed of the bar's surface, m/min.
    cutting_m_min: f64,
    /// Feed of roughing in a turn, mm.
    feed_mm: f64,
    /// Step from level to level, mm.
    stepdown_mm: f64,
}

/// Values that handbooks give for small inserts, at their lower end.
fn usual(material: StockMaterial) -> FacingData {
    let [cutting_m_min, feed_mm, stepdown_mm] = match material {
        StockMaterial::Aluminium => [200.0, 0.15, 1.0],
        StockMaterial::Brass => [150.0, 0.12, 0.8],
        StockMaterial::Pmma => [150.0, 0.15, 1.0],
        StockMaterial::Wax => [250.0, 0.25, 2.0],
    };
    FacingData { cutting_m_min, feed_mm, stepdown_mm }
}

/// Speed of the spindle, 1/min, at which the side of a bar of this diameter has the material's cutting speed, unless the profile names
/// one; nowhere nearer to the axis is the speed higher.
#[must_use]
pub(super) fn usual_rpm(spec: &TurnSpec, diameter_mm: f64) -> f64 {
    let cutting = usual(spec.material).cutting_m_min;
    let at_side = 1e3 * cutting / (std::f64::consts::PI * diameter_mm);
    spec.spindle_rpm.unwrap_or_else(|| significant(at_side, 2)).min(spec.machine.max_spindle_rpm)
}

/// Feed of roughing in a turn, mm, unless the profile names one.
#[must_use]
pub fn usual_feed_mm(spec: &TurnSpec) -> f64 {
    let usual = usual(spec.material).feed_mm;
    spec.roughing.feed_mm_rev.unwrap_or(usual.min(0.5 * spec.nose.radius_mm))
}

/// Step from level to level, mm.
pub(super) fn stepdown_mm(spec: &TurnSpec) -> f64 {
    spec.roughing.stepdown_mm.unwrap_or_else(|| usual(spec.material).stepdown_mm)
}

/// What semi-finishing leaves over what roughing does: chips that are even, and no thinner than a nose's edge is sharp.
const SEMI_LEAVES: f64 = 1.0 / 3.0;
/// Largest cusps of roughing and semi-finishing over what they leave: it is to be left within 10 %.
const CUSP: f64 = 0.05;

/// Feeds of what comes before finishing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OperationFeeds {
    /// Of roughing in a turn, mm.
    pub rough_feed_mm: f64,
    /// What semi-finishing leaves, mm.
    pub even_mm: f64,
    /// Of semi-finishing in a turn, mm.
    pub even_feed_mm: f64,
}

impl OperationFeeds {
    /// Those before a finishing with this feed, mm.
    pub(super) fn new(spec: &TurnSpec, feed_mm: f64) -> Self {
        let rough = &spec.roughing;
        let even_mm = significant(SEMI_LEAVES * rough.allowance_mm, 3);
        Self {
            rough_feed_mm: rough.feed_mm_rev.unwrap_or_else(|| feed_for(spec, rough.allowance_mm)),
            even_mm,
            even_feed_mm: feed_for(spec, even_mm).max(feed_mm),
        }
    }
}

/// The feed whose cusps are within their share of what is left, mm, but no more than that of roughing.
fn feed_for(spec: &TurnSpec, left_mm: f64) -> f64 {
    let widest = f64::sqrt(8.0 * spec.nose.radius_mm * CUSP * left_mm);
    floor_four_digits(usual_feed_mm(spec).min(widest))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bar of 62 mm in aluminium: n = 1000 v / (pi D), as handbooks have it.
    #[test]
    fn speeds_follow_the_shops_formula_and_the_machines_limit() {
        let mut spec = TurnSpec::default();
        assert_eq!(usual_rpm(&spec, 62.0), 1000.0);
        assert_eq!(usual_rpm(&spec, 10.0), 3000.0);
        spec.spindle_rpm = Some(800.0);
        assert_eq!(usual_rpm(&spec, 10.0), 800.0);
        assert_eq!((usual_feed_mm(&spec), stepdown_mm(&spec)), (0.15, 1.0));
        spec.nose.radius_mm = 0.2;
        assert_eq!(usual_feed_mm(&spec), 0.1);
    }
}
