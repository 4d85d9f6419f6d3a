//! Projections given as data: the direction that each of a grid of image points must see.
//!
//! Stereographic coordinates of the directions are interpolated, which needs no normalising and knows no seam: by
//! the bicubic spline through them, twice differentiable. The way back, from a direction to its image point, is
//! found by Newton's method, and proven where bounds are asked for.

use super::bounded_spline::BoundedSpline;
use super::stereographic;
use crate::geom::{BicubicSpline, DVec2, DVec3, GridAxis, Rect};
use crate::num::{PlaneFn, Scalar, least_bending};
use crate::parallel;
use thiserror::Error;

/// Fewest samples along an axis: a spline takes four, and its error is told from every second one.
const LEAST: usize = 8;
/// Largest departure of a direction's length from 1: single precision, and a table of four digits, are far within.
const UNIT: f64 = 1e-3;
/// Samples across a gap in the data that an error next to it is not the interpolation's.
const BESIDE: usize = 4;
/// Rings of samples that go on beyond the frame, or a panel's part of it, at most, where those within are fewer.
const RINGS: f64 = 512.0;

/// Wanted directions over the frame that are a picture of the world: one at the centre of each of a grid of even cells.
#[derive(Clone, PartialEq)]
pub struct DirectionSamples {
    columns: usize,
    rows: usize,
    /// Row by row from the upper left.
    directions: Vec<DVec3>,
}

impl std::fmt::Debug for DirectionSamples {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} x {} directions", self.columns, self.rows)
    }
}

/// Reason why samples are no projection of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum MapFault {
    /// Too few samples.
    #[error("a map must have at least {LEAST} x {LEAST} samples, found {columns} x {rows}")]
    TooFew {
        /// Columns.
        columns: usize,
        /// Rows.
        rows: usize,
    },
    /// Nothing is wanted.
    #[error("a map must have directions, found only NaN")]
    Empty,
    /// A vector that is no direction.
    #[error(
        "row {row}, column {column}: a direction must have the length 1, found {length:.6}; angles and points in mm \
         are no directions"
    )]
    Length {
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
        /// Its length.
        length: f64,
    },
    /// A vector of which some components are missing.
    #[error(
        "row {row}, column {column}: a direction must have three finite numbers, or NaN for all three"
    )]
    Partial {
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
    },
    /// Straight through the mirror.
    #[error(
        "row {row}, column {column}: the direction leads straight down into the part, where no mirror sends a ray"
    )]
    Down {
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
    },
    /// Directions that are met again.
    #[error(
        "row {row}, column {column}: the picture folds over there, so that neighbours show the world now as it is and \
         now mirrored; a map must have one of the two everywhere"
    )]
    Folds {
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
    },
}

impl DirectionSamples {
    /// Samples of so many `columns`, row by row from the upper left: unit vectors in the part's frame, of
    /// not-a-numbers where the picture may show anything.
    ///
    /// # Errors
    /// The first [`MapFault`] met.
    pub fn new(columns: usize, directions: Vec<DVec3>) -> Result<Self, MapFault> {
        let rows = directions.len() / columns.max(1);
        if columns < LEAST || rows < LEAST {
            return Err(MapFault::TooFew { columns, rows });
        }
        let place = |k: usize| (k / columns + 1, k % columns + 1);
        for (k, direction) in directions.iter().enumerate() {
            let (row, column) = place(k);
            if direction.to_array().iter().all(|x| x.is_nan()) {
                continue;
            }
            let length = direction.length();
            if !length.is_finite() {
                return Err(MapFault::Partial { row, column });
            }
            if !((length - 1.0).abs() <= UNIT) {
                return Err(MapFault::Length { row, column, length });
            }
            if direction.z <= -1.0 + UNIT * UNIT {
                return Err(MapFault::Down { row, column });
            }
        }
        let samples = Self { columns, rows, directions };
        match samples.first_fold()?.map(place) {
            Some((row, column)) => Err(MapFault::Folds { row, column }),
            None => Ok(samples),
        }
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    /// The first cell whose neighbours to the right and below show it the other way round than most.
    fn first_fold(&self) -> Result<Option<usize>, MapFault> {
        let sigma: Vec<DVec2> = self.directions.iter().map(|d| sigma(*d)).collect();
        let turn = |k: usize| {
            let inside = k % self.columns + 1 < self.columns && k + self.columns < sigma.len();
            let turn = inside
                .then(|| (sigma[k + 1] - sigma[k]).perp_dot(sigma[k + self.columns] - sigma[k]));
            turn.filter(|turn| !turn.is_nan())
        };
        let cells = || (0..sigma.len()).filter_map(|k| Some((k, turn(k)?)));
        let mirrored = cells().filter(|(_, turn)| *turn > 0.0).count();
        let count = cells().count();
        if count == 0 {
            return Err(MapFault::Empty);
        }
        let most = if 2 * mirrored > count { 1.0 } else { -1.0 };
        Ok(cells().find(|(_, turn)| !(most * turn > 0.0)).map(|(k, _)| k))
    }
}

/// Stereographic coordinates of a direction of about unit length.
fn sigma(direction: DVec3) -> DVec2 {
    DVec2::from_array(stereographic::sigma(direction.normalize().to_array()))
}

/// A projection through sampled directions.
#[derive(Debug, PartialEq)]
pub struct SampledMap {
    /// Columns and rows of samples.
    size: [usize; 2],
    /// Stereographic coordinates over the image.
    sigma: [BoundedSpline; 2],
    /// Where the picture may show anything.
    gaps: Option<Gaps>,
    /// Image points here and there with their stereographic coordinates: where a search begins that finds nothing from
    /// its own start.
    starts: Vec<[DVec2; 2]>,
    is_symmetric: [bool; 2],
    radians_per_mm: f64,
    interpolation: f64,
}

/// Samples of a map that are not there, over the image, row by row upwards.
#[derive(Debug, PartialEq)]
struct Gaps {
    axes: [GridAxis; 2],
    missing: Vec<bool>,
}

impl Gaps {
    /// Whether the sample nearest to an image point is missing.
    fn have(&self, image: DVec2) -> bool {
        let nearest = |axis: &GridAxis, x: f64| {
            let steps = ((x - axis.first_mm) / axis.step_mm).round().max(0.0);
            (steps as usize).min(axis.count - 1)
        };
        let [x, y] = &self.axes;
        self.missing[nearest(y, image.y) * x.count + nearest(x, image.x)]
    }
}

impl SampledMap {
    /// The projection of `samples` over the `frame` (mm of the image), going on linearly beyond it as far as `cover`.
    #[must_use]
    pub fn new(samples: &DirectionSamples, frame: Rect, cover: Rect) -> Self {
        let DirectionSamples { columns, rows, ref directions } = *samples;
        let axis = |first: f64, size: f64, count: usize| {
            let step_mm = size / count as f64;
            GridAxis { first_mm: first + 0.5 * step_mm, step_mm, count }
        };
        let axes =
            [axis(frame.min.x, frame.size().x, columns), axis(frame.min.y, frame.size().y, rows)];
        // Upwards.
        let upwards =
            |k: usize| sigma(directions[(rows - 1 - k / columns) * columns + k % columns]);
        let given: Vec<DVec2> = parallel::map(columns * rows, columns, upwards);
        let missing: Vec<bool> = given.iter().map(|sigma| sigma.is_nan()).collect();
        let rings = [0, 1].map(|axis| {
            let beyond = (frame.min - cover.min).max(cover.max - frame.max)[axis];
            let count = axes[axis].count as f64;
            // (An eighth more, as bounds look beyond the mirror.)
            let most = count.max(RINGS);
            ((beyond.max(0.0) / axes[axis].step_mm).min(most) + count / 8.0) as usize + 1
        });
        let filled = [0, 1].map(|part| {
            let mut values: Vec<f64> = given.iter().map(|sigma| sigma[part]).collect();
            least_bending::fill(&mut values, columns);
            values
        });
        let splines = [0, 1].map(|part| spline(axes, &filled[part]));
        let gaps = missing.contains(&true).then_some(Gaps { axes, missing });
        let interpolation = interpolation_error(axes, &filled, gaps.as_ref());
        let sigma = splines.map(|spline| BoundedSpline::new(&spline, rings));
        let radians_per_mm = radians_per_mm(&sigma, frame.centre());
        let starts = starts(&sigma, frame);
        let is_symmetric = [0, 1]
            .map(|axis| frame.min[axis] == -frame.max[axis] && is_symmetric(&given, columns, axis));
        let size = samples.size();
        Self { size, sigma, gaps, starts, is_symmetric, radians_per_mm, interpolation }
    }

    /// Direction that image point `q` must see, as a stereographic coordinate.
    #[inline]
    pub fn direction_of<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        [0, 1].map(|part| S::of_plane(q[0], q[1], &self.sigma[part]))
    }

    /// The image point near `near` that must see `sigma`; not finite where there is none.
    #[inline]
    pub fn image_of<S: Scalar>(&self, sigma: [S; 2], near: DVec2) -> [S; 2] {
        let found = self.inverse(sigma, near);
        // (Far beyond its grid a spline of linear ends is no picture.)
        if self.sigma[0].grid().contains(DVec2::from_array(found.map(Scalar::mid))) {
            return found;
        }
        self.inverse(sigma, self.start(DVec2::from_array(sigma.map(Scalar::mid))))
    }

    fn inverse<S: Scalar>(&self, sigma: [S; 2], near: DVec2) -> [S; 2] {
        S::invert_plane(&self.sigma, self.sigma[0].step_mm(), sigma, near.to_array())
    }

    /// The image point among [`Self::starts`] that sees the nearest to `sigma`.
    fn start(&self, sigma: DVec2) -> DVec2 {
        let towards = stereographic::direction(sigma.to_array());
        let off = |[_, seen]: &[DVec2; 2]| {
            (stereographic::direction(seen.to_array()) - towards).length_squared()
        };
        let nearest = self.starts.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.map_or(DVec2::ZERO, |[image, _]| *image)
    }

    /// Whether something is wanted of an image point.
    #[must_use]
    pub fn wants(&self, image: DVec2) -> bool {
        !self.gaps.as_ref().is_some_and(|gaps| gaps.have(image))
    }

    /// Columns and rows of samples.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Whether reflecting the picture in X = 0 (`axis` 0) or Y = 0 (1) reflects the world: to far less than any use of it shows.
    #[must_use]
    pub fn is_symmetric(&self, axis: usize) -> bool {
        self.is_symmetric[axis]
    }

    /// Share of the samples of which nothing is wanted.
    #[must_use]
    pub fn gap_share(&self) -> f64 {
        let missing = |gaps: &Gaps| gaps.missing.iter().filter(|missing| **missing).count();
        let all = self.size[0] * self.size[1];
        self.gaps.as_ref().map_or(0, missing) as f64 / all as f64
    }

    /// Radians of the world to a millimetre of the image, at the frame's centre: the geometric mean of all ways.
    #[must_use]
    pub fn radians_per_mm(&self) -> f64 {
        self.radians_per_mm
    }

    /// Largest error of the interpolation between samples, about, radians: a sixteenth of that through every second
    /// one, whose order is the fourth.
    #[must_use]
    pub fn interpolation_error(&self) -> f64 {
        self.interpolation
    }
}

fn spline([x, y]: [GridAxis; 2], values: &[f64]) -> BicubicSpline {
    BicubicSpline::new(x, y, values).expect("a checked grid")
}

/// How far a unit step of stereographic coordinates turns a direction at `sigma`.
fn turn_per_sigma(sigma: DVec2) -> f64 {
    2.0 / (1.0 + sigma.length_squared())
}

/// Whether one of the stereographic coordinates, row by row of so many columns, is odd along its own axis of the picture, and the other
/// one even.
fn is_symmetric(sigma: &[DVec2], columns: usize, axis: usize) -> bool {
    /// Largest departure from it: rounding of double precision.
    const ROUNDING: f64 = 1e-13;
    let reflected = |k: usize| match axis {
        0 => (sigma[k + columns - 1 - 2 * (k % columns)], DVec2::new(-1.0, 1.0)),
        _ => (sigma[sigma.len() - columns + 2 * (k % columns) - k], DVec2::new(1.0, -1.0)),
    };
    (0..sigma.len()).all(|k| {
        let (other, signs) = reflected(k);
        let off = sigma[k] - signs * other;
        let both_missing = sigma[k].is_nan() && other.is_nan();
        both_missing || off.abs().max_element() <= ROUNDING * (1.0 + sigma[k].length())
    })
}

/// Image points over the frame with their stereographic coordinates.
fn starts(sigma: &[BoundedSpline; 2], frame: Rect) -> Vec<[DVec2; 2]> {
    /// Along each side.
    const SIDE: usize = 24;
    let at = |k: usize| {
        let share = DVec2::new((k % SIDE) as f64 + 0.5, (k / SIDE) as f64 + 0.5) / SIDE as f64;
        let image = frame.min + share * frame.size();
        [image, DVec2::from_array([0, 1].map(|part: usize| sigma[part].first(image.to_array())[0]))]
    };
    (0..SIDE * SIDE).map(at).collect()
}

fn radians_per_mm(sigma: &[BoundedSpline; 2], at: DVec2) -> f64 {
    let [[a, ax, ay], [b, bx, by]] = [0, 1].map(|part: usize| sigma[part].first(at.to_array()));
    (ax * by - ay * bx).abs().sqrt() * turn_per_sigma(DVec2::new(a, b))
}

/// A sixteenth of the largest error, radians, that the spline through every second sample has at the others.
fn interpolation_error(axes: [GridAxis; 2], filled: &[Vec<f64>; 2], gaps: Option<&Gaps>) -> f64 {
    let [x, y] = axes;
    let every_second = axes.map(|axis| GridAxis {
        step_mm: 2.0 * axis.step_mm,
        count: axis.count.div_ceil(2),
        ..axis
    });
    let width = every_second[0].count;
    let coarse = [0, 1].map(|part: usize| {
        let count = width * every_second[1].count;
        let value = |k: usize| filled[part][2 * (k / width) * x.count + 2 * (k % width)];
        spline(every_second, &(0..count).map(value).collect::<Vec<_>>())
    });
    let off = |j: usize| {
        let rows = [0, 1].map(|part: usize| coarse[part].row(y.at(j)));
        let is_known = |i: usize| {
            let around = |k: usize| [k.saturating_sub(BESIDE), k, k + BESIDE];
            gaps.is_none_or(|gaps| {
                around(j).iter().all(|&j| {
                    around(i)
                        .iter()
                        .all(|&i| !gaps.missing[j.min(y.count - 1) * x.count + i.min(x.count - 1)])
                })
            })
        };
        // (The last of an even number lies beyond the coarse grid.)
        let columns = (0..2 * width - 1).filter(|&i| is_known(i));
        columns.fold(0.0f64, |most, i| {
            let exact = DVec2::new(filled[0][j * x.count + i], filled[1][j * x.count + i]);
            let [a, b] = [0, 1].map(|part: usize| rows[part].value_and_slope(x.at(i)).0);
            most.max((DVec2::new(a, b) - exact).length() * turn_per_sigma(exact))
        })
    };
    let rows = 2 * every_second[1].count - 1;
    parallel::map(rows, 1, off).into_iter().fold(0.0, f64::max) / 16.0
}

#[cfg(test)]
mod tests;
