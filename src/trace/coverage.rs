//! Coverage of the world by the filled pixels, up to their edges: around the horizon, at the seam of a
//! full turn, and up and down each column.
//!
//! A flat facet under parallel rays shows one direction all over its area, so a ray at a pixel's edge
//! says no more than the facet error allows. Neighbouring pixels of a panel are taken to cover all
//! between the directions of their centres, and the direction of an edge is extrapolated by a straight
//! line through the centres of the nearest pixels, in which facet errors average out.

use super::pixel_class::PixelClass;
use super::pixel_trace::PixelTrace;
use super::trace_strip::TraceStrip;
use crate::geom::DVec3;
use crate::num::{asin, atan2, degrees, wrap_turn};
use crate::optics::{Camera, Fold, ImagingTask, Projection};
use crate::parallel;
use serde::Serialize;
use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Pixels from which the direction of an edge is extrapolated.
const NEAREST: usize = 8;
/// Largest gap in azimuth that rounding leaves between neighbours, radians.
const ROUNDING_GAP: f64 = 1e-9;

/// Azimuths and elevations covered by the filled pixels, as directions from the target's origin.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Coverage {
    /// Azimuth that at least one pixel sees, degrees, 360 for all around.
    pub azimuth_deg: f64,
    /// Azimuth that none sees, from and to, degrees, eastward; one that crosses +-180 ends beyond 180.
    pub gaps_deg: Vec<[f64; 2]>,
    /// Seams of a picture of the full turn, where its ends meet in the world.
    pub seams: Vec<Seam>,
    /// Least elevation of a column's pixels, over the columns that see any, degrees.
    pub lowest_deg: Option<MinMeanMax>,
    /// Greatest elevation of a column's pixels, degrees.
    pub highest_deg: Option<MinMeanMax>,
    /// Every column, from the left.
    #[serde(skip)]
    pub columns: Vec<ColumnCoverage>,
}

/// Two edges of the picture that show the same azimuth.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Seam {
    /// The edges of the picture that meet: of a strip its left and its right one, of a folded mirror
    /// those of both panels on one side.
    pub edges: &'static str,
    /// Azimuth lost between them, row by row, in pixels of the picture's scale; negative where they
    /// overlap.
    pub gap_px: MinMeanMax,
    /// The same in degrees.
    pub gap_deg: MinMeanMax,
}

/// Least, mean and greatest of some values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MinMeanMax {
    /// Least.
    pub min: f64,
    /// Mean.
    pub mean: f64,
    /// Greatest.
    pub max: f64,
}

impl MinMeanMax {
    /// The three of `values`; `None` without any.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let (min, max) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
        (!values.is_empty()).then_some(Self { min, mean, max })
    }

    /// The same in another unit.
    #[must_use]
    pub fn scaled(self, unit: f64) -> Self {
        Self { min: self.min * unit, mean: self.mean * unit, max: self.max * unit }
    }
}

/// Coverage of one column of pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColumnCoverage {
    /// Filled pixels.
    pub filled: usize,
    /// Least and greatest elevation up to their edges, degrees.
    pub elevation_deg: Option<[f64; 2]>,
}

/// Coverage of a frame of which strip after strip is added: it keeps a row of directions, some points of each
/// column, and the ends of each row.
#[derive(Debug)]
pub struct CoverageBuilder<'a> {
    camera: &'a Camera,
    view: &'a ImagingTask,
    /// Azimuths that the rows cover so far, radians.
    covered: Vec<[f64; 2]>,
    /// By row, what [`ends`] gives.
    ends: Vec<Option<[f64; 4]>>,
    columns: Vec<ColumnRuns>,
    /// The directions of the last row, whose neighbours below are to come.
    last: Option<Vec<Direction>>,
}

/// Azimuth and elevation, radians, that the centre of a filled pixel shows.
type Direction = Option<[f64; 2]>;

impl<'a> CoverageBuilder<'a> {
    /// Coverage by the pixels of `camera`, nothing yet.
    #[must_use]
    pub fn new(camera: &'a Camera, view: &'a ImagingTask) -> Self {
        let columns = vec![ColumnRuns::default(); camera.pixels[0] as usize];
        Self { camera, view, covered: vec![], ends: vec![], columns, last: None }
    }

    /// Adds the pixels of a strip, of which those of the class [`PixelClass::Filled`] count.
    pub fn add(&mut self, strip: &TraceStrip) {
        let (view, width) = (self.view, strip.frame[0]);
        let direction = |k: usize| {
            let pixel: &PixelTrace = &strip.pixels[k];
            let shown = || view.direction_from_origin(pixel.hit_point, pixel.direction);
            let angles = |d: DVec3| [atan2(d.x, d.y), asin(d.z.clamp(-1.0, 1.0))];
            (strip.classes[k] == PixelClass::Filled).then(|| angles(shown()))
        };
        let directions: Vec<Direction> = parallel::map(strip.pixels.len(), 1, direction);
        let rows: Vec<&[Direction]> = directions.chunks(width).collect();
        let above = self.last.take();
        let first = strip.rows.start;
        let lines: Vec<(u32, &[Direction])> = above
            .as_deref()
            .map(|above| (first as u32 - 1, above))
            .into_iter()
            .chain((first as u32..).zip(rows.iter().copied()))
            .collect();
        let covered = parallel::map(lines.len() - 1, 1, |k| {
            let ((row, line), (_, below)) = (lines[k], lines[k + 1]);
            union(self.azimuths(row, line, Some(below)))
        });
        self.covered.extend(covered.into_iter().flatten());
        self.ends.extend(parallel::map_slice(&rows, 1, |row| ends(row)));
        let (camera, view) = (self.camera, self.view);
        parallel::for_each_mut(&mut self.columns, 1, |column, runs| {
            let panel = |row: usize| panel_of(camera, view, column, row as u32);
            for (k, directions) in rows.iter().enumerate() {
                let row = first + k;
                let starts_panel = row > 0 && panel(row) != panel(row - 1);
                runs.add(row as f64, directions[column], starts_panel);
            }
        });
        self.last = rows.last().map(|row| row.to_vec());
    }

    /// The coverage by all rows; each panel of the mirror is `width_mm` wide in the image.
    #[must_use]
    pub fn finish(mut self, width_mm: f64) -> Coverage {
        let last = self.last.take().unwrap_or_default();
        let row = self.camera.pixels[1] - 1;
        self.covered.extend(union(self.azimuths(row, &last, None)));
        let covered = union(std::mem::take(&mut self.covered));
        let columns: Vec<ColumnCoverage> =
            std::mem::take(&mut self.columns).into_iter().map(ColumnRuns::finish).collect();
        let over = |end: usize| {
            let ends: Vec<f64> =
                columns.iter().filter_map(|c| c.elevation_deg).map(|e| e[end]).collect();
            MinMeanMax::of(&ends)
        };
        Coverage {
            azimuth_deg: degrees(covered.iter().fold(0.0, |sum, [a, b]| sum + (b - a))),
            gaps_deg: gaps(&covered).into_iter().map(|gap| gap.map(degrees)).collect(),
            seams: self.seams(width_mm),
            lowest_deg: over(0),
            highest_deg: over(1),
            columns,
        }
    }

    /// Intervals of azimuth covered by the pixels of a row and between them and those below, panel by panel.
    fn azimuths(&self, row: u32, line: &[Direction], below: Option<&[Direction]>) -> Vec<[f64; 2]> {
        let panel = |column: usize, row: u32| panel_of(self.camera, self.view, column, row);
        let mut intervals = Vec::new();
        let mut from = 0;
        while from < line.len() {
            let this = panel(from, row);
            let ends = |column: &usize| panel(*column, row) != this;
            let to = (from + 1..line.len()).find(ends).unwrap_or(line.len());
            let below = below.map(|below| -> Vec<Direction> {
                let on_panel =
                    |column: usize| below[column].filter(|_| panel(column, row + 1) == this);
                (from..to).map(on_panel).collect()
            });
            intervals.extend(azimuths(&line[from..to], below.as_deref()));
            from = to;
        }
        intervals
    }

    /// The seams of a picture of the full turn.
    fn seams(&self, width_mm: f64) -> Vec<Seam> {
        let Projection::Strip(strip) = &self.view.projection else { return vec![] };
        let pixel = self.camera.pixel_mm / strip.scale_mm;
        let panels = if self.view.fold.is_some() { 2.0 } else { 1.0 };
        // Half a pixel: widths may be rounded to single precision.
        if !(panels * width_mm / strip.scale_mm >= TAU - 0.5 * pixel) {
            return Vec::new();
        }
        let ends = &self.ends;
        let seam = |edges: &'static str, gaps: &[f64]| {
            let range = MinMeanMax::of(gaps)?;
            let (gap_px, gap_deg) = (range.scaled(1.0 / pixel), range.scaled(degrees(1.0)));
            Some(Seam { edges, gap_px, gap_deg })
        };
        let Some(fold) = self.view.fold else {
            let gap = |[_, left, right, _]: &[f64; 4]| TAU - (right - left);
            let gaps: Vec<f64> = ends.iter().flatten().map(gap).collect();
            return seam("left and right", &gaps).into_iter().collect();
        };
        // Both panels reach the seam at rows as far above the ridge as below: the designed one going
        // east to the right, its reflection to the left.
        let pairs: Vec<_> = (0..ends.len() / 2)
            .filter_map(|k| ends[k].zip(ends[ends.len() - 1 - k]))
            .map(|(upper, lower)| match fold {
                Fold::Above => (upper, lower),
                Fold::Below => (lower, upper),
            })
            .collect();
        let gaps = |gap: fn(&([f64; 4], [f64; 4])) -> f64| {
            pairs.iter().map(|pair| wrap_turn(gap(pair))).collect::<Vec<f64>>()
        };
        let left = gaps(|(designed, reflected)| designed[1] - reflected[1]);
        let right = gaps(|(designed, reflected)| reflected[2] - designed[2]);
        [seam("left, upper and lower", &left), seam("right, upper and lower", &right)]
            .into_iter()
            .flatten()
            .collect()
    }
}

/// The panel of the mirror that a pixel shows.
fn panel_of(camera: &Camera, view: &ImagingTask, column: usize, row: u32) -> usize {
    view.panel_of(camera.image_point(column as f64 + 0.5, f64::from(row) + 0.5))
}

/// Intervals of azimuth covered by the pixels of a row of one panel: to their neighbours to the right and in the row
/// below, and to both ends.
fn azimuths(line: &[Direction], below: Option<&[Direction]>) -> Vec<[f64; 2]> {
    let mut intervals = Vec::new();
    let mut span = |from: f64, to: f64| {
        let step = wrap_turn(to - from);
        // Opposite sides of the zenith have everything between them, and nothing.
        if step.abs() < FRAC_PI_2 {
            intervals.push(if step < 0.0 { [to, to - step] } else { [from, from + step] });
        }
    };
    for (column, direction) in line.iter().enumerate() {
        let Some([azimuth, _]) = *direction else { continue };
        if let Some(&Some([next, _])) = line.get(column + 1) {
            span(azimuth, next);
        }
        if let Some(Some([next, _])) = below.map(|below| below[column]) {
            span(azimuth, next);
        }
    }
    if let Some([first, left, right, last]) = ends(line) {
        span(first, left);
        span(last, right);
    }
    intervals
}

/// Azimuth of the first filled pixel's centre in a row and of its left edge, of the last one's right edge
/// and centre, continuous from one to the other.
fn ends(row: &[Direction]) -> Option<[f64; 4]> {
    let mut line: Vec<[f64; 2]> = Vec::new();
    for (column, direction) in row.iter().enumerate() {
        if let Some([azimuth, _]) = *direction {
            let before = line.last().map_or(azimuth, |last| last[1]);
            line.push([column as f64, before + wrap_turn(azimuth - before)]);
        }
    }
    let (first, last) = (*line.first()?, *line.last()?);
    let near = line.len().min(NEAREST);
    let left = extrapolate(&line[..near], first[0] - 0.5);
    let right = extrapolate(&line[line.len() - near..], last[0] + 0.5);
    Some([first[1], left, right, last[1]])
}

/// Runs of filled pixels of a column, of which row after row is added; each is extrapolated to its outer
/// edges.
#[derive(Debug, Clone, Default)]
struct ColumnRuns {
    filled: usize,
    /// Elevations of the runs that have ended, radians.
    range: Option<[f64; 2]>,
    /// Rows and elevations of the run that goes on: its first, and its last, [`NEAREST`] at the most.
    head: Vec<[f64; 2]>,
    tail: VecDeque<[f64; 2]>,
}

impl ColumnRuns {
    fn add(&mut self, row: f64, direction: Direction, starts_panel: bool) {
        if starts_panel || direction.is_none() {
            self.end();
        }
        let Some([_, elevation]) = direction else { return };
        self.filled += 1;
        self.widen(elevation);
        if self.head.len() < NEAREST {
            self.head.push([row, elevation]);
        }
        if self.tail.len() == NEAREST {
            self.tail.pop_front();
        }
        self.tail.push_back([row, elevation]);
    }

    fn widen(&mut self, elevation: f64) {
        let [lo, hi] = self.range.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
        self.range = Some([lo.min(elevation), hi.max(elevation)]);
    }

    fn end(&mut self) {
        let tail = self.tail.make_contiguous();
        if let (Some(first), Some(last)) = (self.head.first(), tail.last()) {
            let top = extrapolate(&self.head, first[0] - 0.5);
            let bottom = extrapolate(tail, last[0] + 0.5);
            self.widen(top);
            self.widen(bottom);
        }
        self.head.clear();
        self.tail.clear();
    }

    fn finish(mut self) -> ColumnCoverage {
        self.end();
        let elevation_deg = self.range.map(|range| range.map(degrees));
        ColumnCoverage { filled: self.filled, elevation_deg }
    }
}

/// Value at `x` of the straight line fitted to `points` by least squares.
fn extrapolate(points: &[[f64; 2]], x: f64) -> f64 {
    let count = points.len() as f64;
    let mean = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / count);
    let off = |p: &[f64; 2]| [p[0] - mean[0], p[1] - mean[1]];
    let (mut square, mut product) = (0.0, 0.0);
    for [dx, dy] in points.iter().map(off) {
        square += dx * dx;
        product += dx * dy;
    }
    if square > 0.0 { mean[1] + product / square * (x - mean[0]) } else { mean[1] }
}

/// Union of intervals of azimuth (radians, first end in [-pi, pi]), within -pi to pi, sorted.
pub(super) fn union(intervals: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut parts = Vec::with_capacity(intervals.len());
    for [a, b] in intervals {
        if b - a >= TAU {
            return vec![[-PI, PI]];
        }
        let start = if a < -PI {
            a + TAU
        } else if a >= PI {
            a - TAU
        } else {
            a
        };
        let end = start + (b - a);
        parts.push([start, end.min(PI)]);
        if end > PI {
            parts.push([-PI, end - TAU]);
        }
    }
    parts.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut merged: Vec<[f64; 2]> = Vec::new();
    for [a, b] in parts {
        match merged.last_mut() {
            Some(last) if a <= last[1] + ROUNDING_GAP => last[1] = last[1].max(b),
            _ => merged.push([a, b]),
        }
    }
    merged
}

/// Complement of a union in the full turn; the gap across +-pi is one interval that ends beyond pi.
fn gaps(covered: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let (Some(first), Some(last)) = (covered.first(), covered.last()) else {
        return vec![[-PI, PI]];
    };
    let between = covered.windows(2).map(|pair| [pair[0][1], pair[1][0]]);
    let across = [last[1], first[0] + TAU];
    between.chain([across]).filter(|[a, b]| b - a > 2.0 * ROUNDING_GAP).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_join_across_the_cut() {
        let covered = union(vec![[3.0, 3.5], [-1.0, 0.5], [0.4, 3.0], [-2.7, -1.0]]);
        assert_eq!(covered, [[-PI, 3.5 - TAU], [-2.7, PI]]);
        assert_eq!(gaps(&covered), [[3.5 - TAU, -2.7]]);
        assert_eq!(gaps(&union(vec![[3.0, 3.5], [-2.9, 3.0]])), [] as [[f64; 2]; 0]);
        let covered = union(vec![[-3.0, -1.0], [0.0, 2.0], [1.0, 3.0]]);
        assert_eq!(covered, [[-3.0, -1.0], [0.0, 3.0]]);
        assert_eq!(gaps(&covered), [[-1.0, 0.0], [3.0, TAU - 3.0]]);
        assert_eq!(gaps(&[]), [[-PI, PI]]);
        assert_eq!(gaps(&union(vec![[-9.0, 9.0]])), [] as [[f64; 2]; 0]);
    }

    #[test]
    fn a_line_is_extrapolated_through_noise() {
        let noisy = [0.3, -0.3, 0.3, -0.3].iter().enumerate();
        let points: Vec<[f64; 2]> =
            noisy.map(|(k, e)| [k as f64, 2.0 - 3.0 * k as f64 + e]).collect();
        assert!((extrapolate(&points, 3.5) - (2.0 - 10.5)).abs() < 0.3);
        assert!((extrapolate(&[[1.0, 5.0], [3.0, 9.0]], 3.5) - 10.0).abs() < 1e-14);
        assert_eq!(extrapolate(&[[1.0, 5.0]], 9.0), 5.0);
    }

    #[test]
    fn a_range_holds_its_values() {
        assert_eq!(
            MinMeanMax::of(&[3.0, 1.0, 2.0]),
            Some(MinMeanMax { min: 1.0, mean: 2.0, max: 3.0 })
        );
        assert_eq!(MinMeanMax::of(&[]), None);
    }
}
