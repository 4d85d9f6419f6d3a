//! What stands beside a cutter: how far a collar around its axis must be above its tip to stay clear of what is left of a block.

use super::ToolMove;
use super::band_heights::BandHeights;
use crate::geom::{DVec2, DVec3};

/// The place of what is left of a block that is highest over the tip of a cutter which passes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StockBeside {
    /// Line of the program.
    pub line: u32,
    /// The place, with Z of what was left there, mm.
    pub at: DVec3,
    /// How much that is over the tip, mm.
    pub over_tip_mm: f64,
}

/// The highest of all within a radius about a cutter's axis.
pub(super) struct HighestBeside {
    radius_mm: f64,
    pub found: Option<StockBeside>,
}

impl HighestBeside {
    pub(super) fn new(radius_mm: f64) -> Self {
        Self { radius_mm, found: None }
    }

    /// Looks at what stands beside a move before it is cut.
    pub(super) fn pass(&mut self, step: &ToolMove, heights: &mut BandHeights) {
        let ends = [step.from, step.to].map(|end| end.truncate());
        let lowest = step.from.z.min(step.to.z);
        let mut most = self.found.map_or(0.0, |found| found.over_tip_mm);
        let places = heights.within(ends, self.radius_mm);
        let (radius, found) = (self.radius_mm, &mut self.found);
        heights.each_above(places, lowest + most, |at, z| {
            let tip = lowest_tip(step, at, radius);
            if let Some(over_tip_mm) = tip.map(|tip| z - tip).filter(|over| *over > most) {
                most = over_tip_mm;
                *found = Some(StockBeside { line: step.line, at: at.extend(z), over_tip_mm });
            }
            lowest + most
        });
    }
}

/// Z of the lowest place of a tip that moves within `radius` of a place of the plan; none of a move that passes farther off.
fn lowest_tip(step: &ToolMove, at: DVec2, radius: f64) -> Option<f64> {
    let way = (step.to - step.from).truncate();
    let on = at - step.from.truncate();
    let length = way.length();
    if length == 0.0 {
        return (on.length() <= radius).then(|| step.from.z.min(step.to.z));
    }
    let [along, beside] = [on.dot(way), on.perp_dot(way)].map(|part| part / length);
    let half = radius * radius - beside * beside;
    if !(half >= 0.0) {
        return None;
    }
    let half = half.sqrt();
    let [from, to] = [(along - half).max(0.0), (along + half).min(length)];
    let z = |along: f64| step.from.z + along / length * (step.to.z - step.from.z);
    (from <= to).then(|| z(from).min(z(to)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(from: [f64; 3], to: [f64; 3]) -> ToolMove {
        ToolMove { from: from.into(), to: to.into(), feed: Some(1.0), line: 1 }
    }

    /// Against 2000 places of the tip along the move.
    #[test]
    fn the_lowest_tip_is_that_of_a_dense_row_of_places() {
        let moves = [
            step([0.0, 0.0, 5.0], [10.0, 4.0, 1.0]),
            step([3.0, -2.0, 1.0], [-4.0, 1.0, 2.0]),
            step([1.0, 1.0, 7.0], [1.0, 1.0, 2.0]),
        ];
        for (move_, radius) in moves.iter().zip([2.0, 3.5, 1.0]) {
            for k in 0..400 {
                let at = DVec2::new(f64::from(k % 20) - 6.03, f64::from(k / 20) - 8.02);
                let tips = (0..=2000).map(|i| move_.from.lerp(move_.to, f64::from(i) / 2000.0));
                let near = tips.filter(|tip| tip.truncate().distance(at) <= radius);
                let dense = near.map(|tip| tip.z).reduce(f64::min);
                match (lowest_tip(move_, at, radius), dense) {
                    (Some(exact), Some(dense)) => {
                        assert!(exact <= dense && dense < exact + 0.05, "{at}: {exact}, {dense}");
                    }
                    (None, Some(dense)) => panic!("{at}: none, {dense}"),
                    // A chord shorter than the row's steps.
                    (_, None) => {}
                }
            }
        }
    }
}
