//! One pass: a curve of ball centres, and the height of its cut.

use crate::geom::{DVec2, DVec3};

/// Steps of Newton's method, which starts next to the lowest ball.
const MOST_STEPS: usize = 4;
/// What the centre of a ball that does not come over a place counts for, mm: more than any height.
const OUT_OF_REACH: f64 = 1e9;

/// Ball centres along one line without a break.
#[derive(Debug, Clone)]
pub(super) struct Pass {
    /// What a place's part along it gives the parameter of.
    pub along: DVec2,
    /// Parameter of the first point, and the step from each to the next.
    pub start: f64,
    pub step: f64,
    /// Centres and their derivatives by the parameter.
    pub centres: Vec<[DVec3; 2]>,
}

impl Pass {
    /// Lowest Z of the balls over `xy`; none where none comes there.
    pub(super) fn height(&self, xy: DVec2, ball: f64) -> Option<f64> {
        let (k, lowest) = self.lowest_node(xy, ball)?;
        let last = self.centres.len() - 1;
        // Newton's method between the neighbours of the lowest point.
        let (lo, hi) = (k.saturating_sub(1) as f64, (k + 1).min(last) as f64);
        let (mut t, mut least) = (k as f64, lowest);
        for _ in 0..MOST_STEPS {
            let [c, d, e] = self.at(t);
            let away = xy - c.truncate();
            let square = ball * ball - away.length_squared();
            if !(square > 0.0) {
                break;
            }
            least = least.min(c.z - square.sqrt());
            let (root, drift) = (square.sqrt(), away.dot(d.truncate()));
            let slope = d.z - drift / root;
            let second = e.z
                + (d.truncate().length_squared() - away.dot(e.truncate())) / root
                + drift * drift / (root * square);
            if !(second > 0.0) {
                break;
            }
            t = (t - slope / second).clamp(lo, hi);
        }
        Some(lower_side(self.at(t)[0], xy, ball).map_or(least, |height| height.min(least)))
    }

    /// The point of the pass whose ball is lowest over `xy`, by descent from the nearest along the line, and Z of its
    /// lower side; none where none comes there.
    fn lowest_node(&self, xy: DVec2, ball: f64) -> Option<(usize, f64)> {
        let last = self.centres.len() - 1;
        // Balls that do not come there count for higher the farther they are.
        let node = |k: usize| {
            let centre = self.centres[k][0];
            let away = || OUT_OF_REACH + (xy - centre.truncate()).length();
            lower_side(centre, xy, ball).unwrap_or_else(away)
        };
        let guess = (xy.dot(self.along) - self.start) / self.step;
        let mut k = (guess.round().max(0.0) as usize).min(last);
        let mut least = node(k);
        for up in [true, false] {
            loop {
                let next = if up { k + 1 } else { k.wrapping_sub(1) };
                if next > last {
                    break;
                }
                let height = node(next);
                if !(height < least) {
                    break;
                }
                (k, least) = (next, height);
            }
        }
        (least < OUT_OF_REACH).then_some((k, least))
    }

    /// The centre at `t` steps from the first, with its first two derivatives by t.
    pub(super) fn at(&self, t: f64) -> [DVec3; 3] {
        let k = (t.floor() as usize).min(self.centres.len() - 2);
        let s = t - k as f64;
        let ([a, da], [b, db]) = (self.centres[k], self.centres[k + 1]);
        let (da, db) = (da * self.step, db * self.step);
        // a + s (da + s (p + s q)).
        let p = 3.0 * (b - a) - 2.0 * da - db;
        let q = 2.0 * (a - b) + da + db;
        [a + s * (da + s * (p + s * q)), da + s * (2.0 * p + 3.0 * s * q), 2.0 * p + 6.0 * s * q]
    }
}

/// Z over `xy` of the lower side of a ball about `centre`; none out of its reach.
fn lower_side(centre: DVec3, xy: DVec2, ball: f64) -> Option<f64> {
    let square = ball * ball - (xy - centre.truncate()).length_squared();
    (square > 0.0).then(|| centre.z - square.sqrt())
}
