//! Which part of the world the filled pixels cover, up to their edges: around the horizon, at the
//! seam of a full turn, and up and down each column.
//!
//! A flat facet under parallel rays shows one direction all over its area, so a ray at a pixel's edge
//! says no more than the facet error allows. Neighbouring pixels of a panel are taken to cover what
//! lies between the directions of their centres, and what an edge sees is carried on by a straight
//! line from the centres of the nearest pixels, in which facet errors average out.

use super::{Fate, Seen, Witness};
use crate::geom::DVec3;
use crate::num::{asin, atan2, degrees, wrap_turn};
use crate::optics::{Camera, Fold, ImagingTask, Projection};
use crate::parallel;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Pixels from which an edge's direction is carried on.
const NEAREST: usize = 8;
/// A gap in azimuth that rounding leaves between neighbours, radians.
const SLIT: f64 = 1e-9;

/// What the filled pixels cover of the world. Directions are those from the target's origin.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coverage {
    /// Azimuth that at least one pixel sees, degrees, 360 for all around.
    pub azimuth_deg: f64,
    /// Azimuth that none sees, from and to, degrees, eastward; one that crosses +-180 ends beyond 180.
    pub gaps_deg: Vec<[f64; 2]>,
    /// Where a picture of the full turn is cut, and its ends meet in the world.
    pub seams: Vec<Seam>,
    /// Least elevation of a column's pixels, over the columns that see any, degrees.
    pub lowest_deg: Option<Range>,
    /// Greatest elevation of a column's pixels, degrees.
    pub highest_deg: Option<Range>,
    /// Every column, from the left.
    #[serde(skip)]
    pub columns: Vec<Column>,
}

/// Two edges of the picture that show the same azimuth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Seam {
    /// Which edges of the picture meet: of a strip its left and its right one, of a folded mirror the
    /// edges of both panels on one side.
    pub edges: &'static str,
    /// Azimuth lost between them, row by row, in pixels of the picture's scale; negative where they
    /// overlap.
    pub gap_px: Range,
    /// The same in degrees.
    pub gap_deg: Range,
}

/// Least, mean and greatest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Range {
    /// Least.
    pub min: f64,
    /// Mean.
    pub mean: f64,
    /// Greatest.
    pub max: f64,
}

impl Range {
    /// Of `values`; none without any.
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

/// What one column sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// Filled pixels.
    pub filled: usize,
    /// Least and greatest elevation up to their edges, degrees.
    pub elevation_deg: Option<[f64; 2]>,
}

/// The directions that the filled pixels' centres show.
struct Panorama<'a> {
    camera: &'a Camera,
    view: &'a ImagingTask,
    /// Azimuth and elevation, radians, row by row.
    angles: Vec<Option<[f64; 2]>>,
}

impl Coverage {
    /// What the pixels of `witness` with [`Fate::Filled`] cover, as `camera` shows them; each panel of
    /// the mirror is `width_mm` wide in the image.
    #[must_use]
    pub fn new(
        witness: &Witness,
        fates: &[Fate],
        camera: &Camera,
        view: &ImagingTask,
        width_mm: f64,
    ) -> Self {
        let angles = |k: usize| {
            let seen: &Seen = &witness.seen[k];
            let shown = || view.direction_from_origin(seen.at, seen.direction);
            let angles = |d: DVec3| [atan2(d.x, d.y), asin(d.z.clamp(-1.0, 1.0))];
            (fates[k] == Fate::Filled).then(|| angles(shown()))
        };
        let angles = parallel::map(witness.seen.len(), 1, angles);
        let panorama = Panorama { camera, view, angles };
        let [width, height] = camera.pixels;
        let around = parallel::map(height as usize, 1, |row| union(panorama.around(row as u32)));
        let covered = union(around.concat());
        let columns = parallel::map(width as usize, 1, |column| panorama.column(column as u32));
        let over = |end: usize| {
            let ends: Vec<f64> =
                columns.iter().filter_map(|c| c.elevation_deg).map(|e| e[end]).collect();
            Range::of(&ends)
        };
        Self {
            azimuth_deg: degrees(covered.iter().fold(0.0, |sum, [a, b]| sum + (b - a))),
            gaps_deg: gaps(&covered).into_iter().map(|gap| gap.map(degrees)).collect(),
            seams: panorama.seams(width_mm),
            lowest_deg: over(0),
            highest_deg: over(1),
            columns,
        }
    }
}

impl Panorama<'_> {
    fn at(&self, column: u32, row: u32) -> Option<[f64; 2]> {
        let [width, height] = self.camera.pixels;
        let inside = column < width && row < height;
        inside.then(|| self.angles[row as usize * width as usize + column as usize])?
    }

    /// On the reflected panel.
    fn reflects(&self, row: u32) -> bool {
        self.view.reflects(self.camera.image_point(0.5, f64::from(row) + 0.5))
    }

    /// Intervals of azimuth that the pixels of `row` cover, to their neighbours to the right and
    /// below, and to both ends.
    fn around(&self, row: u32) -> Vec<[f64; 2]> {
        let mut intervals = Vec::new();
        let mut span = |from: f64, to: f64| {
            let step = wrap_turn(to - from);
            // Opposite sides of the zenith have everything between them, and nothing.
            if step.abs() < FRAC_PI_2 {
                intervals.push(if step < 0.0 { [to, to - step] } else { [from, from + step] });
            }
        };
        let below = row + 1 < self.camera.pixels[1] && self.reflects(row) == self.reflects(row + 1);
        for column in 0..self.camera.pixels[0] {
            let Some([azimuth, _]) = self.at(column, row) else { continue };
            if let Some([next, _]) = self.at(column + 1, row) {
                span(azimuth, next);
            }
            if let (true, Some([next, _])) = (below, self.at(column, row + 1)) {
                span(azimuth, next);
            }
        }
        if let Some([first, left, right, last]) = self.ends(row) {
            span(first, left);
            span(last, right);
        }
        intervals
    }

    /// Azimuth of the first filled pixel's centre in `row` and of its left edge, of the last one's
    /// right edge and centre, continued from one to the other.
    fn ends(&self, row: u32) -> Option<[f64; 4]> {
        let mut line: Vec<[f64; 2]> = Vec::new();
        for column in 0..self.camera.pixels[0] {
            if let Some([azimuth, _]) = self.at(column, row) {
                let before = line.last().map_or(azimuth, |last| last[1]);
                line.push([f64::from(column), before + wrap_turn(azimuth - before)]);
            }
        }
        let (first, last) = (*line.first()?, *line.last()?);
        let near = line.len().min(NEAREST);
        let left = carried(&line[..near], first[0] - 0.5);
        let right = carried(&line[line.len() - near..], last[0] + 0.5);
        Some([first[1], left, right, last[1]])
    }

    fn column(&self, column: u32) -> Column {
        let height = self.camera.pixels[1];
        let mut filled = 0;
        let mut range: Option<[f64; 2]> = None;
        let mut runs: Vec<Vec<[f64; 2]>> = vec![vec![]];
        for row in 0..height {
            let Some([_, elevation]) = self.at(column, row) else {
                runs.push(vec![]);
                continue;
            };
            if row > 0 && self.reflects(row) != self.reflects(row - 1) {
                runs.push(vec![]);
            }
            filled += 1;
            runs.last_mut().expect("never empty").push([f64::from(row), elevation]);
        }
        for run in runs.iter().filter(|run| !run.is_empty()) {
            let near = run.len().min(NEAREST);
            let top = carried(&run[..near], run[0][0] - 0.5);
            let bottom = carried(&run[run.len() - near..], run[run.len() - 1][0] + 0.5);
            let all = run.iter().map(|point| point[1]).chain([top, bottom]);
            let with = range.into_iter().flatten();
            range = Range::of(&all.chain(with).collect::<Vec<_>>()).map(|r| [r.min, r.max]);
        }
        Column { filled, elevation_deg: range.map(|range| range.map(degrees)) }
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
        let height = self.camera.pixels[1];
        let ends: Vec<Option<[f64; 4]>> =
            parallel::map(height as usize, 1, |row| self.ends(row as u32));
        let seam = |edges: &'static str, gaps: &[f64]| {
            let range = Range::of(gaps)?;
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

/// The straight line through `points`, in the sense of least squares, at `x`.
fn carried(points: &[[f64; 2]], x: f64) -> f64 {
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

/// The union of intervals of azimuth (radians, first end in [-pi, pi]), within -pi to pi and in
/// order.
fn union(intervals: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
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
            Some(last) if a <= last[1] + SLIT => last[1] = last[1].max(b),
            _ => merged.push([a, b]),
        }
    }
    merged
}

/// What a union leaves of the full turn; the part across +-pi in one piece, its end beyond pi.
fn gaps(covered: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let (Some(first), Some(last)) = (covered.first(), covered.last()) else {
        return vec![[-PI, PI]];
    };
    let between = covered.windows(2).map(|pair| [pair[0][1], pair[1][0]]);
    let across = [last[1], first[0] + TAU];
    between.chain([across]).filter(|[a, b]| b - a > 2.0 * SLIT).collect()
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
    fn a_line_is_carried_on_through_noise() {
        let noisy = [0.3, -0.3, 0.3, -0.3].iter().enumerate();
        let points: Vec<[f64; 2]> =
            noisy.map(|(k, e)| [k as f64, 2.0 - 3.0 * k as f64 + e]).collect();
        assert!((carried(&points, 3.5) - (2.0 - 10.5)).abs() < 0.3);
        assert!((carried(&[[1.0, 5.0], [3.0, 9.0]], 3.5) - 10.0).abs() < 1e-14);
        assert_eq!(carried(&[[1.0, 5.0]], 9.0), 5.0);
    }

    #[test]
    fn a_range_holds_its_values() {
        assert_eq!(Range::of(&[3.0, 1.0, 2.0]), Some(Range { min: 1.0, mean: 2.0, max: 3.0 }));
        assert_eq!(Range::of(&[]), None);
    }
}
