//! Rest material: what a ball leaves where the mirror is too hollow for it, stands in its way elsewhere, or has a
//! valley between two panels.

use super::clears_ridge;
use super::closing::closing_height;
use super::drop_cutter::{DropCutter, surface_on_face};
use crate::geom::DVec2;
use crate::mirror::{LocalSurface, Mirror};
use crate::parallel;

/// What a ball from above leaves on the face: the closing of the mirror by the ball (the lowest places that it
/// reaches anywhere without cutting into the mirror), less the mirror. Places are those of a grid over X and Y, what
/// is left on them is that of the mirror itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Gouge {
    /// Columns and rows of the grid.
    pub size: [usize; 2],
    /// X and Y of its first place, mm.
    pub first: DVec2,
    /// Distance of its places, mm.
    pub step: f64,
    /// What is left, mm, row by row with Y rising: 0 for less than [`FLOOR_MM`]; none off the mirror.
    pub rest_mm: Vec<Option<f64>>,
    /// The most that is left anywhere, mm, and where; none where the ball fits everywhere.
    pub largest: Option<(f64, DVec2)>,
    /// The same outside the fillet of a valley.
    pub largest_outside_fillet: Option<(f64, DVec2)>,
}

/// Steps of the grid along its longer side, where the ball is not too large.
const STEPS: f64 = 240.0;
/// Balls that are laid on places, at most.
const WORK: f64 = 4e7;
/// What counts as left, mm: a tenth of a micrometre.
pub const FLOOR_MM: f64 = 1e-4;

impl Gouge {
    /// Lays the ball over `mirror`, whose places lie between the corners `lo` and `hi` of X and Y. At `hollow`, X and Y
    /// of a place with a smaller radius of curvature than the ball's, whatever is left counts.
    #[must_use]
    pub fn new(mirror: &Mirror, [lo, hi]: [DVec2; 2], ball_mm: f64, hollow: Option<DVec2>) -> Self {
        let size = hi - lo;
        let step = step(size, ball_mm);
        // Symmetric about the axis, so that a ridge is a row of its own.
        let half = (lo.abs().max(hi.abs()) / step).floor() + 1.0;
        let [columns, rows] = [2 * half.x as usize + 1, 2 * half.y as usize + 1];
        let first = -half * step;
        let places = parallel::map(columns * rows, 1, |k| {
            surface_on_face(mirror, node(first, step, columns, k))
        });
        let heights = places.iter().map(|place| place.map_or(f64::NAN, |p| p.at.z)).collect();
        let cutter = DropCutter::new(mirror, ball_mm, step, first, [columns, rows], heights);
        let centres = BallCentres::new(&cutter);
        let rest_mm = parallel::map_slice(&places, 1, |place| {
            let rest = centres.rest_mm(&(*place)?);
            Some(if rest > FLOOR_MM { rest } else { 0.0 })
        });
        // The most where `counts`, from the best place of the grid and from the hollow one.
        let largest = |counts: &dyn Fn(&LocalSurface) -> bool| {
            let on_grid = rest_mm.iter().zip(&places).filter_map(|(rest, place)| {
                let place =
                    place.filter(|place| rest.is_some_and(|mm| mm > 0.0) && counts(place))?;
                Some(((*rest)?, place.at.truncate()))
            });
            let highest = on_grid.reduce(|most, next| if next.0 > most.0 { next } else { most });
            let hollow = hollow.and_then(|xy| {
                let place = cutter.surface_over(xy).filter(|place| counts(place))?;
                Some((centres.rest_mm(&place), xy))
            });
            let starts = [highest, hollow].into_iter().flatten();
            starts
                .map(|start| centres.deepest(start, counts))
                .reduce(|most, next| if next.0 > most.0 { next } else { most })
        };
        let outside = |place: &LocalSurface| clears_ridge(mirror, place, ball_mm);
        let (largest, largest_outside_fillet) = (largest(&|_| true), largest(&outside));
        let size = [columns, rows];
        Self { size, first, step, rest_mm, largest, largest_outside_fillet }
    }

    /// Place number `k` of the grid.
    #[must_use]
    pub fn place(&self, k: usize) -> DVec2 {
        node(self.first, self.step, self.size[0], k)
    }

    /// The share of the face's area, in the plan, where something is left.
    #[must_use]
    pub fn share(&self) -> f64 {
        let face = self.rest_mm.iter().flatten();
        let (mut left, mut all) = (0, 0);
        for &value in face {
            all += 1;
            left += usize::from(value > 0.0);
        }
        f64::from(left as u32) / f64::from(all.max(1) as u32)
    }
}

/// X and Y of node `k` of a grid.
fn node(first: DVec2, step: f64, columns: usize, k: usize) -> DVec2 {
    first + step * DVec2::new((k % columns) as f64, (k / columns) as f64)
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

/// Heights of the ball's centre where it rests over the nodes of a grid, from which the search for the lowest ball over
/// a point starts.
struct BallCentres<'a> {
    cutter: &'a DropCutter<'a>,
    /// Nodes by which centres may lie beyond the face's.
    reach: usize,
    columns: usize,
    rows: usize,
    /// Z of the centres, mm.
    centres: Vec<f64>,
}

impl<'a> BallCentres<'a> {
    fn new(cutter: &'a DropCutter<'a>) -> Self {
        let reach = (cutter.ball_mm / cutter.step).ceil() as usize;
        let [columns, rows] = cutter.size.map(|count| count + 2 * reach);
        let mut grid = Self { cutter, reach, columns, rows, centres: Vec::new() };
        grid.centres = parallel::map(columns * rows, 1, |k| {
            cutter.height_over_nodes(node(grid.first(), cutter.step, columns, k))
        });
        grid
    }

    /// X and Y of the first centre.
    fn first(&self) -> DVec2 {
        self.cutter.first - DVec2::splat(self.reach as f64 * self.cutter.step)
    }

    /// What the ball leaves on `place`, mm.
    fn rest_mm(&self, place: &LocalSurface) -> f64 {
        if !self.gouges(place) {
            return 0.0;
        }
        let xy = place.at.truncate();
        let [anywhere, on_face] = self.starts(xy);
        let height = closing_height(self.cutter, xy, anywhere);
        let other =
            if on_face == anywhere { height } else { closing_height(self.cutter, xy, on_face) };
        (height.min(other) - place.at.z).max(0.0)
    }

    /// Whether a ball that touches `place` cuts into the mirror elsewhere, or may.
    fn gouges(&self, place: &LocalSurface) -> bool {
        let DropCutter { ball_mm, step, .. } = *self.cutter;
        if !(place.largest_curvature() * ball_mm < 1.0) {
            return true;
        }
        let centre = place.at + ball_mm * place.normal();
        let c = centre.truncate();
        let seeds = self.cutter.seeds(c);
        // A contact is no farther above its nearest node than a step.
        let near = seeds.iter().take_while(|(z, _)| *z > centre.z - step);
        let cuts = |z: f64| z > centre.z + FLOOR_MM;
        near.into_iter().any(|(z, seed)| {
            cuts(*z) || self.cutter.ascend(c, seed).is_some_and(|found| cuts(found.centre_z))
        })
    }

    /// The centre of the lowest ball over `p` of those over the nodes, and of those over nodes of the face: beside a rim
    /// a ball may come low from within and from outside.
    fn starts(&self, p: DVec2) -> [DVec2; 2] {
        let DropCutter { ball_mm, step, size, .. } = *self.cutter;
        let (at, reach) = ((p - self.first()) / step, ball_mm / step);
        let range = |at: f64, count: usize| {
            let last = (at + reach).floor().min(count as f64 - 1.0);
            (at - reach).ceil().max(0.0) as usize..=last as usize
        };
        let on_face = |column: usize, row: usize| {
            let (x, y) = (column.wrapping_sub(self.reach), row.wrapping_sub(self.reach));
            x < size[0] && y < size[1] && self.cutter.heights[y * size[0] + x].is_finite()
        };
        let mut best = [(f64::INFINITY, p); 2];
        for row in range(at.y, self.rows) {
            let dy = (row as f64 - at.y) * step;
            for column in range(at.x, self.columns) {
                let dx = (column as f64 - at.x) * step;
                let centre = self.centres[row * self.columns + column];
                let lower = centre - (ball_mm * ball_mm - dx * dx - dy * dy).sqrt();
                if !(lower < best[1].0) || !centre.is_finite() {
                    continue;
                }
                let found = (lower, p + DVec2::new(dx, dy));
                if lower < best[0].0 {
                    best[0] = found;
                }
                if on_face(column, row) {
                    best[1] = found;
                }
            }
        }
        best.map(|found| found.1)
    }

    /// The deepest place that a compass search finds from `start` where `counts`.
    fn deepest(
        &self,
        (mut most, mut at): (f64, DVec2),
        counts: impl Fn(&LocalSurface) -> bool,
    ) -> (f64, DVec2) {
        let mut step = self.cutter.step;
        while step > 1e-3 * self.cutter.step {
            let ways = [DVec2::X, DVec2::Y, DVec2::ONE, DVec2::new(1.0, -1.0)];
            let better = ways
                .into_iter()
                .flat_map(|way| [at + way * step, at - way * step])
                .find_map(|xy| {
                    let place = self.cutter.surface_over(xy).filter(|place| counts(place))?;
                    let left = self.rest_mm(&place);
                    (left > most).then_some((left, xy))
                });
            match better {
                Some(found) => (most, at) = found,
                None => step *= 0.5,
            }
        }
        (most, at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Outline, Rect};
    use crate::mirror::fixtures::{quadric, roof, sloping};
    use crate::num::{cos, radians, sin, tan};

    const CORNERS: [DVec2; 2] = [DVec2::splat(-4.0), DVec2::splat(4.0)];
    /// What depths are good to, mm: a nanometre.
    const GOOD: f64 = 1e-6;

    fn laid(mirror: &Mirror, ball_mm: f64) -> Gouge {
        Gouge::new(mirror, CORNERS, ball_mm, None)
    }

    /// Holds each place of a map where `exact` knows what is left to that, and counts them.
    fn compared(gouge: &Gouge, what: &str, exact: impl Fn(DVec2) -> Option<f64>) -> usize {
        let places = gouge.rest_mm.iter().enumerate().filter_map(|(k, left)| {
            let at = gouge.place(k);
            let exact = exact(at)?;
            let found = (*left)?;
            let off = (found - exact).abs();
            let fits = found == 0.0 && exact < FLOOR_MM + GOOD;
            assert!(off < GOOD || fits, "{what}, {at}: {found} {exact}");
            Some(())
        });
        places.count()
    }

    #[test]
    fn a_ball_fits_on_domes_saddles_and_wide_bowls() {
        for terms in [[-0.05, 0.01, -0.02], [0.06, 0.0, -0.06], [0.05, 0.0, 0.08]] {
            for vergence in [0.0, 0.01] {
                let gouge = laid(&quadric(terms, vergence), 3.0);
                assert_eq!((gouge.largest, gouge.share()), (None, 0.0), "{terms:?} {vergence}");
            }
        }
    }

    /// In a trough Z = k u^2 with 2 k R > 1 the ball touches both walls at u^2 = R^2 - 1/4k^2, its centre at
    /// k R^2 + 1/4k.
    #[test]
    #[ignore = "long: .ci/nightly"]
    fn troughs_off_the_grid_and_at_any_angle_keep_what_their_closed_form_says() {
        let ball = 3.0f64;
        for (k, degrees, u0) in [(0.3, 90.0, 0.05), (0.2, 90.0, 0.31), (0.22, 33.0, -0.417)] {
            let way = DVec2::new(cos(radians(degrees)), sin(radians(degrees)));
            let terms = [k * way.x * way.x, 2.0 * k * way.x * way.y, k * way.y * way.y];
            let mirror = sloping((way * (-2.0 * k * u0)).to_array(), terms, 0.0);
            let gouge = laid(&mirror, ball);
            let centre = k * ball * ball + 0.25 / k;
            let foot = (ball * ball - 0.25 / (k * k)).sqrt();
            let what = format!("{k} {degrees} {u0}");
            let (most, at) = gouge.largest.unwrap();
            assert!((most - (centre - ball)).abs() < GOOD, "{what}: {most} {}", centre - ball);
            assert!((at.dot(way) - u0).abs() < 0.01, "{what}: {at}");
            let counted = compared(&gouge, &what, |at| {
                let u = at.dot(way) - u0;
                // Where both walls are there to carry the ball, which does not reach over the ends.
                let feet = [-foot, foot].map(|foot| at + way * (foot - u));
                let ends = [-ball, ball].map(|ball| at + way.perp() * ball);
                let mut all = feet.iter().chain(&ends);
                let on_face = all.all(|p| p.abs().max_element() < 4.0);
                on_face.then(|| {
                    let inside = centre - (ball * ball - u * u).sqrt() - k * u * u;
                    if u.abs() < foot { inside } else { 0.0 }
                })
            });
            assert!(counted > 500, "{what}: {counted}");
        }
    }

    /// A trough that ends before the ball would touch its walls: the ball lies on the rim, and no ground is beyond.
    #[test]
    fn a_narrow_face_carries_the_ball_by_its_rims_alone() {
        let (k, ball) = (0.3f64, 3.0f64);
        for half in [0.3, 1.0] {
            let mut mirror = quadric([0.0, 0.0, k], 0.0);
            let corner = DVec2::new(4.0, half);
            mirror.outline = Outline::Rect(Rect { min: -corner, max: corner });
            let gouge = Gouge::new(&mirror, [-corner, corner], ball, None);
            let centre = k * half * half + (ball * ball - half * half).sqrt();
            let counted = compared(&gouge, &format!("{half}"), |at| {
                let over = centre - (ball * ball - at.y * at.y).sqrt();
                // Beside the ends a ball comes lower from outside.
                (at.x.abs() < 4.0 - ball).then_some(over - k * at.y * at.y)
            });
            assert!(counted > 200, "{counted}");
        }
        // The rim of a hill is no hollow, however steep.
        let hill = quadric([-0.4, 0.1, -0.3], 0.0);
        assert_eq!(laid(&hill, 3.0).largest, None);
    }

    /// In a bowl Z = k r^2 the ball touches all along a circle; with 2 k R hardly above 1 it is of next to no size.
    #[test]
    #[ignore = "long: .ci/nightly"]
    fn bowls_carry_the_ball_by_a_circle() {
        for (k, ball) in [(0.3, 3.0f64), (0.2, 2.6), (0.2, 2.5 + 1e-2)] {
            let mirror = sloping([-0.2 * k, 0.3 * k], [k, 0.0, k], 0.0);
            let middle = DVec2::new(0.1, -0.15);
            let centre = k * ball * ball + 0.25 / k;
            let foot = (ball * ball - 0.25 / (k * k)).sqrt();
            let gouge = laid(&mirror, ball);
            compared(&gouge, &format!("{k} {ball}"), |at| {
                let square = (at - middle).length_squared();
                let inside = centre - (ball * ball - square).sqrt() - k * square;
                Some(if square < foot * foot { inside } else { 0.0 })
            });
            let deep = centre - ball;
            assert_eq!(gouge.largest.is_some(), deep > FLOOR_MM);
            // What is told of hollow ground counts, however little is left there.
            let (most, _) = Gouge::new(&mirror, CORNERS, ball, Some(middle)).largest.unwrap();
            assert!((most - deep).abs() < 1e-3 * deep, "{most} {deep}");
        }
    }

    /// Z = |Y| tan t: the ball touches both walls R sin t off the valley.
    #[test]
    fn between_walls_the_valley_keeps_its_fillet_and_nothing_beside_it() {
        for degrees in [10.0, 30.0, 60.0] {
            let ball = 2.0;
            let gouge = laid(&roof(degrees), ball);
            let centre = ball / cos(radians(degrees));
            let foot = ball * sin(radians(degrees));
            compared(&gouge, &format!("{degrees}"), |at| {
                let inside = centre
                    - (ball * ball - at.y * at.y).max(0.0).sqrt()
                    - tan(radians(degrees)) * at.y.abs();
                let left = if at.y.abs() < foot { inside } else { 0.0 };
                (at.x.abs() < 4.0 - ball).then_some(left)
            });
            let (most, at) = gouge.largest.unwrap();
            assert!((most - (centre - ball)).abs() < GOOD && at.y == 0.0, "{most} {at}");
            assert_eq!(gouge.largest_outside_fillet, None);
        }
    }
}
