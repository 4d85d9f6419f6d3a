//! What each obstacle hides of the world: the azimuths and elevations of its pixels.
//!
//! The direction of a hidden pixel is that which its ray would leave the mirror in. Hidden pixels belong to one range of
//! azimuth where their edges overlap, which are halfway to the directions of their neighbours. The range ends at centres
//! of pixels: edges of the wide pixels near the axis would make a leg wider than it is.

use super::coverage::union;
use super::pixel_trace::PixelTrace;
use super::ray_end::Outcome;
use super::trace_strip::TraceStrip;
use crate::geom::DVec3;
use crate::num::{asin, atan2, degrees, wrap_turn};
use crate::optics::{Camera, ImagingTask};
use crate::parallel;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// What an obstacle hides.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Obstruction {
    /// Name of the obstacle.
    pub name: String,
    /// Number of pixels aimed at the mirror that it hides.
    pub pixels: usize,
    /// Azimuths from and to which it hides the centre of at least one pixel, degrees, eastward; one that crosses +-180
    /// ends beyond 180.
    pub azimuth_deg: Vec<[f64; 2]>,
    /// Least and greatest elevation of the hidden pixels' centres, degrees; none without such pixels.
    pub elevation_deg: Option<[f64; 2]>,
}

/// A pixel that is aimed at the mirror and reflected: azimuth and elevation of its direction, radians, and the
/// obstacle that hides it.
type Seen = Option<([f64; 2], Option<u32>)>;

/// What an obstacle hides, angles in radians.
#[derive(Debug, Clone, Default)]
struct Hidden {
    pixels: usize,
    /// Azimuths of pixels up to their edges, as a union.
    edges: Vec<[f64; 2]>,
    /// Azimuths between centres of hidden neighbours, and of centres alone, as a union.
    centres: Vec<[f64; 2]>,
    elevation: Option<[f64; 2]>,
}

impl Hidden {
    fn add(&mut self, [azimuth, elevation]: [f64; 2]) {
        self.pixels += 1;
        self.centres.push([azimuth; 2]);
        self.add_elevation(elevation);
    }

    fn add_elevation(&mut self, elevation: f64) {
        let [lo, hi] = self.elevation.unwrap_or([elevation; 2]);
        self.elevation = Some([lo.min(elevation), hi.max(elevation)]);
    }

    fn join(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.edges.extend(other.edges);
        self.centres.extend(other.centres);
        other.elevation.into_iter().flatten().for_each(|end| self.add_elevation(end));
    }

    fn united(self) -> Self {
        Self { edges: union(self.edges), centres: union(self.centres), ..self }
    }

    /// Ranges of azimuth between centres whose edges overlap.
    fn azimuths(&self) -> Vec<[f64; 2]> {
        let range = |[from, to]: [f64; 2]| {
            if to - from >= TAU {
                return [from, to];
            }
            let turns = [0.0, TAU].into_iter();
            let all = turns.flat_map(|turn| self.centres.iter().map(move |c| c.map(|a| a + turn)));
            let inside = all.filter(|[a, b]| *a >= from - SLACK && *b <= to + SLACK);
            inside.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).unwrap_or([from, to])
        };
        across_the_cut(self.edges.clone()).map(range).collect()
    }
}

/// By how much an azimuth may leave its range by rounding, radians.
const SLACK: f64 = 1e-9;

/// What obstacles hide of a frame of which strip after strip is added: it keeps a row of directions.
#[derive(Debug)]
pub struct ObstructionBuilder<'a> {
    camera: &'a Camera,
    view: &'a ImagingTask,
    hidden: Vec<Hidden>,
    /// The last row, whose neighbours below are to come.
    last: Option<Vec<Seen>>,
}

impl<'a> ObstructionBuilder<'a> {
    /// Of so many obstacles and the pixels of `camera`: nothing yet.
    #[must_use]
    pub fn new(camera: &'a Camera, view: &'a ImagingTask, obstacles: usize) -> Self {
        Self { camera, view, hidden: vec![Hidden::default(); obstacles], last: None }
    }

    /// Adds a strip, which follows those that were added before.
    pub fn add(&mut self, strip: &TraceStrip) {
        if self.hidden.is_empty() {
            return;
        }
        let width = strip.frame[0];
        let seen: Vec<Seen> = parallel::map_slice(&strip.pixels, 4096, |p| self.seen(p));
        let first = strip.rows.start;
        let above = self.last.take();
        let mut rows: Vec<(usize, &[Seen])> = Vec::new();
        rows.extend(above.as_deref().map(|above| (first - 1, above)));
        let new = rows.len();
        rows.extend((first..).zip(seen.chunks(width)));
        let found = parallel::map(rows.len(), 1, |k| {
            let mut hidden = vec![Hidden::default(); self.hidden.len()];
            if k >= new {
                within_row(&mut hidden, rows[k].1);
            }
            if let Some(&(row, below)) = rows.get(k + 1)
                && self.reflects(row) == self.reflects(row - 1)
            {
                rows[k].1.iter().zip(below).for_each(|(a, b)| between(&mut hidden, [a, b]));
            }
            hidden.into_iter().map(Hidden::united).collect::<Vec<_>>()
        });
        for found in found {
            self.hidden.iter_mut().zip(found).for_each(|(all, found)| all.join(found));
        }
        self.hidden = self.hidden.split_off(0).into_iter().map(Hidden::united).collect();
        self.last = rows.last().map(|(_, row)| row.to_vec());
    }

    fn seen(&self, pixel: &PixelTrace) -> Seen {
        if !pixel.aimed || pixel.direction == DVec3::ZERO {
            return None;
        }
        let shown = self.view.direction_from_origin(pixel.hit_point, pixel.direction);
        let obstacle = match pixel.outcome {
            Outcome::Obstructed(number) => Some(number),
            _ => None,
        };
        Some(([atan2(shown.x, shown.y), asin(shown.z.clamp(-1.0, 1.0))], obstacle))
    }

    /// Whether a row shows the reflected panel of a folded mirror.
    fn reflects(&self, row: usize) -> bool {
        self.view.reflects(self.camera.image_point(0.5, row as f64 + 0.5))
    }

    /// What the obstacles of these names, in the order of their numbers, hide.
    #[must_use]
    pub fn finish(self, names: impl Iterator<Item = String>) -> Vec<Obstruction> {
        let of = |(hidden, name): (Hidden, String)| Obstruction {
            name,
            pixels: hidden.pixels,
            azimuth_deg: hidden.azimuths().into_iter().map(|range| range.map(degrees)).collect(),
            elevation_deg: hidden.elevation.map(|range| range.map(degrees)),
        };
        self.hidden.into_iter().zip(names).map(of).collect()
    }
}

/// Adds the hidden pixels of a row, and what is hidden between neighbours in it.
fn within_row(hidden: &mut [Hidden], row: &[Seen]) {
    for (direction, obstacle) in row.iter().flatten() {
        if let Some(number) = obstacle {
            hidden[*number as usize].add(*direction);
        }
    }
    row.windows(2).for_each(|pair| between(hidden, [&pair[0], &pair[1]]));
}

/// Adds what is hidden between two neighbours: up to the edge between them, and between both where the same obstacle hides
/// them.
fn between(hidden: &mut [Hidden], [a, b]: [&Seen; 2]) {
    let (Some(([a, _], first)), Some(([b, _], second))) = (a, b) else { return };
    let step = wrap_turn(b - a);
    // Opposite sides of the zenith have everything between them, and nothing.
    if !(step.abs() < FRAC_PI_2) {
        return;
    }
    let span = |from: f64, step: f64| [from + step.min(0.0), from + step.max(0.0)];
    if let Some(number) = first {
        hidden[*number as usize].edges.push(span(*a, 0.5 * step));
    }
    if let Some(number) = second {
        hidden[*number as usize].edges.push(span(*b, -0.5 * step));
    }
    if let (Some(number), true) = (first, first == second) {
        hidden[*number as usize].centres.push(span(*a, step));
    }
}

/// The ranges of a union, with those at both sides of +-pi as one that ends beyond pi; a full turn as it is.
fn across_the_cut(mut ranges: Vec<[f64; 2]>) -> impl Iterator<Item = [f64; 2]> {
    if let [[first, end], .., [_, last]] = ranges[..]
        && first == -PI
        && last == PI
    {
        ranges.remove(0);
        if let Some(last) = ranges.last_mut() {
            last[1] = end + TAU;
        }
    }
    ranges.into_iter()
}
