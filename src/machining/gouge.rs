//! Where the ball does not fit: hollow ground, and the valley between two panels.

use super::{Place, beyond};
use crate::geom::DVec2;
use crate::mirror::{Curvature, Mirror};
use crate::optics::Camera;
use rayon::prelude::*;
use serde::Serialize;

/// Whether a ball that touches the mirror at `place` stays on its own side of the ridge of a folded
/// mirror: in a valley the other panel is in the way of one that does not.
#[must_use]
pub fn touches(mirror: &Mirror, place: &Place, ball_mm: f64) -> bool {
    !mirror.folded || clear(place, ball_mm) >= 0.0
}

/// How far the centre of a ball on `place` is from the plane of the ridge, on the place's own side, mm.
fn clear(place: &Place, ball_mm: f64) -> f64 {
    let side = if place.at.y < 0.0 { -1.0 } else { 1.0 };
    side * (place.at.y + ball_mm * place.normal().y)
}

/// What the ball leaves of the valley of a folded mirror: a hollow edge becomes a fillet of the ball's
/// radius between the places where it touches both panels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fillet {
    /// Width where it is widest, in the plan, mm.
    pub width_max_mm: f64,
    /// Mean width along the valley, mm.
    pub width_mean_mm: f64,
    /// Height that it leaves over the valley's bottom, at most, mm.
    pub left_max_mm: f64,
    /// Pixels of the image that it takes.
    pub pixels: f64,
}

/// Places along the ridge.
const ALONG: usize = 256;

impl Fillet {
    /// The fillet of a ball in the valley of `mirror`; none where there is no valley.
    #[must_use]
    pub fn new(mirror: &Mirror, camera: &Camera, ball_mm: f64) -> Option<Self> {
        let bounds = mirror.outline.bounds();
        let step = bounds.size().x / ALONG as f64;
        let (mut widths, mut area, mut left) = (Vec::new(), 0.0, 0.0f64);
        for k in 0..=ALONG {
            let x = bounds.min.x + step * k as f64;
            let Some(q) = foot(mirror, x, ball_mm) else {
                widths.push(0.0);
                continue;
            };
            let (foot, bottom) = (Place::of(mirror, q), Place::of(mirror, DVec2::new(x, 0.0)));
            let end = if k == 0 || k == ALONG { 0.5 } else { 1.0 };
            widths.push(2.0 * foot.at.y.abs());
            area += 2.0 * q.y.abs() * step * end;
            let lowest = foot.at.z + ball_mm * (foot.normal().z - 1.0);
            left = left.max(lowest - bottom.at.z);
        }
        let widest = widths.iter().copied().fold(0.0, f64::max);
        (widest > 0.0).then(|| Self {
            width_max_mm: widest,
            width_mean_mm: widths.iter().sum::<f64>() / widths.len() as f64,
            left_max_mm: left,
            pixels: area / (camera.pixel_mm * camera.pixel_mm),
        })
    }
}

/// Where on the designed panel, at `x` of the chart, a ball touches that lies in the valley on both panels;
/// none where there is no valley. The panel's far rim where it touches nowhere.
#[must_use]
pub fn foot(mirror: &Mirror, x: f64, ball_mm: f64) -> Option<DVec2> {
    if !mirror.folded {
        return None;
    }
    let bounds = mirror.outline.bounds();
    let far = if bounds.centre().y < 0.0 { bounds.min.y } else { bounds.max.y };
    let at = |share: f64| DVec2::new(x, far * share);
    // On the ridge itself the designed panel's side counts.
    let clear = |share: f64| {
        let place = Place::of(mirror, at(share));
        far.signum() * (place.at.y + ball_mm * place.normal().y)
    };
    const STEPS: usize = 64;
    let share = |k: usize| k as f64 / STEPS as f64;
    // Where the panels meet without an edge, what is less is rounding.
    if clear(0.0) >= -1e-9 * ball_mm {
        return None;
    }
    let Some(first) = (1..=STEPS).find(|&k| clear(share(k)) >= 0.0) else { return Some(at(1.0)) };
    let [mut lo, mut hi] = [share(first - 1), share(first)];
    for _ in 0..50 {
        let middle = 0.5 * (lo + hi);
        if clear(middle) < 0.0 { lo = middle } else { hi = middle }
    }
    Some(at(hi))
}

/// What a ball from above leaves on the face, over a grid of X and Y: the closing of the mirror by
/// the ball (the lowest places that it reaches anywhere without cutting into the mirror), less the mirror.
#[derive(Debug, Clone, PartialEq)]
pub struct Gouge {
    /// Columns and rows of the grid.
    pub size: [usize; 2],
    /// X and Y of its first place, mm.
    pub first: DVec2,
    /// Distance of its places, mm.
    pub step: f64,
    /// What is left, mm, row by row with Y rising; none off the mirror.
    pub left: Vec<Option<f64>>,
}

/// Steps of the grid along its longer side, where the ball is not too large.
const STEPS: f64 = 240.0;
/// Balls that are laid on places, at most.
const WORK: f64 = 8e7;
/// What is less is the grid's own error, mm: a tenth of a micrometre.
pub const FLOOR_MM: f64 = 1e-4;

/// A height over a grid.
struct Field {
    columns: i64,
    rows: i64,
    values: Vec<f64>,
}

impl Field {
    fn at(&self, i: i64, j: i64) -> f64 {
        if i < 0 || j < 0 || i >= self.columns || j >= self.rows {
            return f64::NAN;
        }
        self.values[(j * self.columns + i) as usize]
    }
}

impl Gouge {
    /// Lays the ball over `mirror`, whose places lie between the corners `lo` and `hi` of X and Y.
    #[must_use]
    pub fn new(mirror: &Mirror, [lo, hi]: [DVec2; 2], ball_mm: f64) -> Self {
        let size = hi - lo;
        let step = step(size, ball_mm);
        // Symmetric about the axis, so that a ridge is a row of its own.
        let half = (lo.abs().max(hi.abs()) / step).floor() + 2.0;
        let [columns, rows] = [2 * half.x as usize + 1, 2 * half.y as usize + 1];
        let first = -half * step;
        let whole = mirror.whole();
        let place =
            |k: usize| first + step * DVec2::new((k % columns) as f64, (k / columns) as f64);
        // The ground goes on for two places beyond the rim, so that those on it have neighbours.
        let (ground, on_face): (Vec<f64>, Vec<bool>) = (0..columns * rows)
            .into_par_iter()
            .map(|k| {
                let Some(found) = Place::over(mirror, place(k)) else { return (f64::NAN, false) };
                let off = beyond(&whole, mirror.chart.coordinates(found.at).0);
                (if off <= 2.5 * step { found.at.z } else { f64::NAN }, off <= 0.0)
            })
            .unzip();
        let ground = Field { columns: columns as i64, rows: rows as i64, values: ground };
        let reach = (ball_mm / step).ceil() as i64;
        let ball = Ball { radius: ball_mm, step, ridge: mirror.folded.then_some(half.y as i64) };
        // Centres may lie beyond the rim.
        let (wide, high) = (ground.columns + 2 * reach, ground.rows + 2 * reach);
        let centres = (0..wide * high)
            .into_par_iter()
            .map(|k| {
                ball.over(&ground, DVec2::new((k % wide - reach) as f64, (k / wide - reach) as f64))
            })
            .collect();
        let centres = Field { columns: wide, rows: high, values: centres };
        let left = (0..columns * rows)
            .into_par_iter()
            .map(|k| {
                if !on_face[k] {
                    return None;
                }
                let at = DVec2::new((k % columns) as f64, (k / columns) as f64);
                let left = ball.under(&centres, at + reach as f64) - ground.values[k];
                Some(if left > FLOOR_MM && !ball.touches(&ground, first, mirror, place(k)) {
                    left
                } else {
                    0.0
                })
            })
            .collect();
        Self { size: [columns, rows], first, step, left }
    }

    /// Place number `k` of the grid.
    #[must_use]
    pub fn place(&self, k: usize) -> DVec2 {
        let [columns, _] = self.size;
        self.first + self.step * DVec2::new((k % columns) as f64, (k / columns) as f64)
    }

    /// The most that is left where `counts`, mm, and where; none where the ball fits everywhere.
    #[must_use]
    pub fn most(&self, counts: impl Fn(DVec2) -> bool) -> Option<(f64, DVec2)> {
        let all =
            self.left.iter().enumerate().filter_map(|(k, left)| Some(((*left)?, self.place(k))));
        let left = all.filter(|(left, at)| *left > 0.0 && counts(*at));
        left.reduce(|most, next| if next.0 > most.0 { next } else { most })
    }

    /// The share of the face's area, in the plan, where something is left.
    #[must_use]
    pub fn share(&self) -> f64 {
        let face = self.left.iter().flatten();
        let (mut left, mut all) = (0, 0);
        for &value in face {
            all += 1;
            left += usize::from(value > 0.0);
        }
        f64::from(left as u32) / f64::from(all.max(1) as u32)
    }
}

/// A step that keeps the work in bounds: each place is held against as many as lie under a ball.
fn step(size: DVec2, ball_mm: f64) -> f64 {
    let long = size.max_element();
    let mut steps = STEPS;
    let work = |steps: f64| {
        let per_mm = steps / long;
        let under = std::f64::consts::PI * ball_mm * ball_mm * per_mm * per_mm;
        let face = size.x * size.y * per_mm * per_mm;
        let around = (size.x + 2.0 * ball_mm) * (size.y + 2.0 * ball_mm) * per_mm * per_mm;
        around * under.min(face) + face * under
    };
    while work(steps) > WORK {
        steps *= 0.9;
    }
    long / steps
}

/// A ball over a grid.
struct Ball {
    radius: f64,
    step: f64,
    /// The row where the ground has an edge.
    ridge: Option<i64>,
}

impl Ball {
    /// The least Z of its centre over `at`, in steps from the first place, where it meets no ground.
    fn over(&self, ground: &Field, at: DVec2) -> f64 {
        self.largest(ground, at, 1.0, self.ridge)
    }

    /// The least Z of its lower side over `at` for all centres.
    fn under(&self, centres: &Field, at: DVec2) -> f64 {
        -self.largest(centres, at, -1.0, None)
    }

    /// Whether it can touch the mirror over `xy` without cutting into it elsewhere.
    fn touches(&self, ground: &Field, first: DVec2, mirror: &Mirror, xy: DVec2) -> bool {
        Place::over(mirror, xy).is_some_and(|place| {
            let centre = place.at + self.radius * place.normal();
            let least = self.over(ground, (centre.truncate() - first) / self.step);
            least - centre.z <= FLOOR_MM
        })
    }

    /// The largest sum of `sign` times `field` and the ball's height around `at`. Between the grid's places the field is
    /// taken for a parabola, but across the row `ridge`.
    fn largest(&self, field: &Field, at: DVec2, sign: f64, ridge: Option<i64>) -> f64 {
        let (step, square) = (self.step, self.radius * self.radius);
        let reach = self.radius / step;
        let (mut most, mut node) = (f64::NEG_INFINITY, (0, 0));
        let range = |at: f64, count: i64| {
            ((at - reach).ceil().max(0.0) as i64)
                ..=((at + reach).floor().min((count - 1) as f64) as i64)
        };
        for v in range(at.y, field.rows) {
            let dy = (v as f64 - at.y) * step;
            for u in range(at.x, field.columns) {
                let dx = (u as f64 - at.x) * step;
                let value = sign * field.at(u, v) + (square - dx * dx - dy * dy).sqrt();
                if value > most {
                    (most, node) = (value, (u, v));
                }
            }
        }
        let (u, v) = node;
        let value = |a: i64, b: i64| sign * field.at(u + a, v + b);
        let middle = value(0, 0);
        let [w, e, s, n] = [value(-1, 0), value(1, 0), value(0, -1), value(0, 1)];
        let mixed = value(1, 1) + value(-1, -1) - value(1, -1) - value(-1, 1);
        let along = ridge != Some(v);
        let only = |x: f64| if along { x } else { 0.0 };
        let slope = DVec2::new(0.5 * (e - w), only(0.5 * (n - s))) / step;
        let (xx, xy, yy) = (e + w - 2.0 * middle, only(0.25 * mixed), only(n + s - 2.0 * middle));
        let bend = Curvature { xx, xy, yy };
        let turn = |d: DVec2| bend.times(d) / (step * step);
        // Newton's method for the top of the parabola and the ball together, no farther than the neighbours.
        let from = DVec2::new(u as f64 - at.x, v as f64 - at.y) * step;
        let mut d = DVec2::ZERO;
        for _ in 0..4 {
            let off = from + d;
            let root = (square - off.length_squared()).sqrt();
            let value = middle + d.dot(slope + 0.5 * turn(d)) + root;
            // Next to the rim there are no such neighbours.
            if value.is_nan() {
                break;
            }
            most = most.max(value);
            let rise = slope + turn(d) - off / root;
            let cubed = root * root * root;
            let xx = bend.xx / (step * step) - 1.0 / root - off.x * off.x / cubed;
            let yy = bend.yy / (step * step) - 1.0 / root - off.y * off.y / cubed;
            let xy = bend.xy / (step * step) - off.x * off.y / cubed;
            let (mut x, mut y) = (-rise.x / xx, 0.0);
            if along {
                let det = xx * yy - xy * xy;
                if !(det > 0.0 && xx < 0.0) {
                    break;
                }
                x = (rise.y * xy - rise.x * yy) / det;
                y = (rise.x * xy - rise.y * xx) / det;
            } else if !(xx < 0.0) {
                break;
            }
            d = (d + DVec2::new(x, y)).clamp(DVec2::splat(-step), DVec2::splat(step));
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machining::place::tests::quadric;

    const CORNERS: [DVec2; 2] = [DVec2::splat(-4.0), DVec2::splat(4.0)];

    #[test]
    fn a_ball_fits_on_domes_saddles_and_wide_bowls() {
        for terms in [[-0.05, 0.01, -0.02], [0.06, 0.0, -0.06], [0.05, 0.0, 0.08]] {
            let mirror = quadric(terms, 0.0);
            let gouge = Gouge::new(&mirror, CORNERS, 3.0);
            assert_eq!(gouge.most(|_| true), None, "{terms:?}");
            assert_eq!(gouge.share(), 0.0);
        }
    }

    /// In a trough Z = c Y^2 with 2 c R > 1 the ball touches both walls at Y^2 = R^2 - 1/4c^2, its centre at
    /// c Y^2 + 1/2c: it stays c R^2 + 1/4c - R over the bottom.
    #[test]
    fn a_narrow_trough_keeps_what_its_closed_form_says() {
        let (c, ball) = (0.3f64, 3.0f64);
        let mirror = quadric([0.0, 0.0, c], 0.0);
        let gouge = Gouge::new(&mirror, CORNERS, ball);
        let exact = 0.25 / c + c * ball * ball - ball;
        let (most, at) = gouge.most(|_| true).unwrap();
        assert!((most - exact).abs() < 1e-3 * exact && at.y.abs() < 1e-9, "{most} {exact} {at}");
        // Nothing is left beyond |y| = sqrt(R^2 - 1/4c^2).
        let foot = (ball * ball - 0.25 / (c * c)).sqrt();
        assert_eq!(gouge.most(|at| at.y.abs() > foot + gouge.step), None);
        assert!(gouge.most(|at| at.y.abs() > foot - 8.0 * gouge.step).is_some());
    }
}
