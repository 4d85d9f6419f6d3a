//! Passes as straight moves of the ball's centre.

use super::Passes;
use super::pass::Pass;
use crate::geom::DVec3;
use crate::parallel;

/// The path of a ball's centre along one pass, by straight moves.
#[derive(Debug, Clone, PartialEq)]
pub struct BallPath {
    /// Places of the centre, mm: two at least, on the pass itself.
    pub centres: Vec<DVec3>,
    /// Directions of the pass, of unit length, at its first and its last place.
    pub directions: [DVec3; 2],
}

/// The paths of all passes of a raster.
#[derive(Debug, Clone, PartialEq)]
pub struct BallPaths {
    /// Those of each line, in the order along it; lines in the order across, none without a pass.
    pub lines: Vec<Vec<BallPath>>,
    /// Those along the ridge of a folded mirror.
    pub ridge: Vec<BallPath>,
}

impl Passes {
    /// The passes as straight moves of at most `longest_mm`, no more than `chord_mm` off the passes.
    #[must_use]
    pub fn paths(&self, chord_mm: f64, longest_mm: f64) -> BallPaths {
        let path = |pass: &Pass| pass.path(chord_mm, longest_mm);
        let lines = parallel::map_slice(&self.lines, 4, |line| line.iter().map(path).collect());
        let lines = lines.into_iter().filter(|line: &Vec<BallPath>| !line.is_empty()).collect();
        BallPaths { lines, ridge: self.ridge.iter().map(path).collect() }
    }
}

impl Pass {
    fn path(&self, chord_mm: f64, longest_mm: f64) -> BallPath {
        let last = self.centres.len() - 1;
        let mut centres = vec![self.centres[0][0]];
        for k in 0..last {
            let begin = k as f64;
            // Between two points a pass is a cubic, whose second derivative is straight: largest at an end.
            let [first, middle] = [begin, begin + 0.5].map(|t| self.at(t)[2]);
            let bend = first.length().max((2.0 * middle - first).length());
            let to = self.centres[k + 1][0];
            let by_chord = (bend / (8.0 * chord_mm)).sqrt();
            let by_length = (to - self.centres[k][0]).length() / longest_mm;
            let parts = by_chord.max(by_length).ceil().max(1.0);
            centres.extend((1..parts as usize).map(|n| self.at(begin + n as f64 / parts)[0]));
            centres.push(to);
        }
        let direction = |k: usize| self.centres[k][1].normalize();
        BallPath { centres, directions: [direction(0), direction(last)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec2;
    use crate::machining::BallRaster;
    use crate::mirror::fixtures::quadric;
    use crate::num::radians;

    /// The middle of no move is farther from a ball's distance over the mirror than asked, but for what cubics lack of it.
    #[test]
    fn chords_keep_to_the_passes() {
        let mirror = quadric([-0.05, 0.0, -0.02], 0.0);
        let raster = BallRaster { ball_mm: 2.0, stepover_mm: 0.5, angle: radians(30.0) };
        let corners = [DVec2::splat(-4.0), DVec2::splat(4.0)];
        let passes = Passes::new(&mirror, corners, raster).unwrap();
        let mut counts = Vec::new();
        for chord_mm in [1e-4, 1e-6, 1e-7] {
            let paths = passes.paths(chord_mm, 10.0);
            let (mut worst, mut count) = (0.0f64, 0);
            for path in paths.lines.iter().flatten() {
                count += path.centres.len();
                for pair in path.centres.windows(2) {
                    let middle = 0.5 * (pair[0] + pair[1]);
                    // The distance of a ball's centre from the mirror, by its foot.
                    let mut foot = middle.truncate();
                    for _ in 0..60 {
                        let place = mirror.extended_surface(foot);
                        foot = (middle - 2.0 * place.normal()).truncate();
                    }
                    let off = middle.distance(mirror.extended_surface(foot).at) - 2.0;
                    worst = worst.max(off.abs());
                }
            }
            assert!(worst <= chord_mm + 1e-9, "{chord_mm}: {worst}");
            counts.push(count);
        }
        assert!(counts[2] > 2 * counts[0], "{counts:?}");
    }
}
