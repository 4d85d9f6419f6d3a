//! All rays of a camera at once: where they meet facets is drawn, not searched, and reflected rays
//! that provably leave are not followed.
//!
//! Every facet is drawn over the pixel centres near its picture with the same intersection, to the
//! last bit, as the general search uses; so both answer alike.

use super::drawing::{Drawing, ROWS, Shown};
use super::ground::{Bundle, Ground};
use super::rays::Rays;
use super::witness::{glance, reflected, shadowed};
use super::{Hit, Outcome, Scene};
use crate::geom::{DVec3, Ray};
use crate::optics::Camera;
use crate::parallel::{self, Scratch};
use std::ops::Add;

/// Side of the smallest squares of pixels whose reflected rays are proven free together; the largest
/// are as high as a band.
const LEAST: usize = 2;

/// How a camera ray ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glimpse {
    /// Its end.
    pub outcome: Outcome,
    /// The facet that it meets first, or [`Glimpse::NO_FACET`].
    pub facet: u32,
    /// Distance along the ray, mm; infinite for a ray that meets nothing.
    pub t: f64,
    /// The direction in which it is reflected, or the zero vector.
    pub direction: DVec3,
}

impl Glimpse {
    /// In the place of a facet's number.
    pub const NO_FACET: u32 = u32::MAX;
    /// Of a ray that meets nothing.
    pub const NOTHING: Self = Self {
        outcome: Outcome::Missed,
        facet: Self::NO_FACET,
        t: f64::INFINITY,
        direction: DVec3::ZERO,
    };
}

impl From<(Outcome, Option<Hit>, DVec3)> for Glimpse {
    /// From what [`super::look`] says.
    fn from((outcome, hit, direction): (Outcome, Option<Hit>, DVec3)) -> Self {
        let (facet, t) = hit.map_or((Self::NO_FACET, f64::INFINITY), |hit| (hit.facet, hit.t));
        Self { outcome, facet, t, direction }
    }
}

/// How many rays were traced, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Camera rays whose facet was drawn.
    pub drawn: usize,
    /// Camera rays whose facet was searched for.
    pub searched: usize,
    /// Reflected rays that were proven to leave.
    pub proven: usize,
    /// Reflected rays that were followed.
    pub followed: usize,
}

impl Add for Tally {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            drawn: self.drawn + other.drawn,
            searched: self.searched + other.searched,
            proven: self.proven + other.proven,
            followed: self.followed + other.followed,
        }
    }
}

/// The rays through the pixel centres of a camera, and what they are traced in.
#[derive(Debug, Clone, Copy)]
pub struct Sweep<'a> {
    scene: &'a Scene,
    camera: Camera,
    top_mm: f64,
    shortcuts: bool,
}

impl<'a> Sweep<'a> {
    /// The rays of `camera`, where they are parallel from height `top_mm`, in `scene`.
    #[must_use]
    pub fn new(scene: &'a Scene, camera: &Camera, top_mm: f64) -> Self {
        Self { scene, camera: *camera, top_mm, shortcuts: true }
    }

    /// The same with nothing drawn and nothing proven: every ray is searched for and followed. It
    /// must change no answer.
    #[must_use]
    pub fn without_shortcuts(self) -> Self {
        Self { shortcuts: false, ..self }
    }

    /// What is traced.
    #[must_use]
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Columns and rows.
    #[must_use]
    pub fn pixels(&self) -> [u32; 2] {
        self.camera.pixels
    }

    /// The ray of a pixel.
    #[inline]
    #[must_use]
    pub fn ray(&self, column: u32, row: u32) -> Ray {
        let point = self.camera.image_point(f64::from(column) + 0.5, f64::from(row) + 0.5);
        self.camera.ray(point, self.top_mm)
    }

    /// Every ray's end, row by row.
    #[must_use]
    pub fn run(&self) -> (Vec<Glimpse>, Tally) {
        let [columns, rows] = self.pixels().map(|n| n as usize);
        let mut found = vec![Glimpse::NOTHING; columns * rows];
        let tally = self.run_into(&mut found);
        (found, tally)
    }

    /// Every ray's end into `found`, row by row: one entry a pixel.
    pub fn run_into(&self, found: &mut [Glimpse]) -> Tally {
        let rays = Rays::new(&self.camera, self.top_mm);
        let means = Means::new(self, &rays);
        let tallies =
            parallel::map_chunks_mut(found, self.pixels()[0] as usize * ROWS, |number, found| {
                self.trace(&means, number * ROWS, found)
            });
        tallies.into_iter().fold(Tally::default(), Add::add)
    }

    /// Traces bands of rows side by side. `each` gets the number of the first row, what became of
    /// the band's rays, and its share of `out`, which has one entry a pixel.
    pub fn bands<T: Send>(
        &self,
        out: &mut [T],
        each: impl Fn(u32, &[Glimpse], &mut [T]) + Sync,
    ) -> Tally {
        let rays = Rays::new(&self.camera, self.top_mm);
        let means = Means::new(self, &rays);
        let scratch = Scratch::default();
        let band = |number: usize, out: &mut [T], found: &mut Vec<Glimpse>| {
            found.resize(out.len(), Glimpse::NOTHING);
            let tally = self.trace(&means, number * ROWS, found);
            each((number * ROWS) as u32, found, out);
            tally
        };
        let tallies =
            parallel::map_chunks_mut(out, self.pixels()[0] as usize * ROWS, |number, out| {
                scratch.with(|found| band(number, out, found))
            });
        tallies.into_iter().fold(Tally::default(), Add::add)
    }

    /// Traces the rays of the band from row `first` on.
    fn trace(&self, means: &Means, first: usize, found: &mut [Glimpse]) -> Tally {
        let columns = self.pixels()[0] as usize;
        let mut tally = Tally::default();
        if let Some(drawing) = &means.drawing {
            tally.drawn = found.len();
            drawing.draw(first, found, |Shown { column, row, t, facet, normal }| {
                let along = means.rays.at(column, row).direction;
                let (outcome, direction) = reflected(along, normal);
                Glimpse { outcome, facet, t, direction }
            });
        } else {
            tally.searched = found.len();
            for (k, found) in found.iter_mut().enumerate() {
                *found =
                    glance(self.scene, &means.rays.at(k % columns, first + k / columns)).into();
            }
        }
        Shade { scene: self.scene, means, columns, first, found, tally: &mut tally }.all();
        tally
    }

    /// Whether the camera's rays start outside the mesh.
    fn starts_outside(&self) -> bool {
        let chart = &self.camera.chart;
        let start = if chart.vergence == 0.0 {
            self.top_mm
        } else {
            chart.ray(Default::default(), 0.0).origin.z
        };
        self.scene.bounds().is_some_and(|(_, hi)| start > hi.z)
    }
}

/// What the rays of a sweep can be traced with.
struct Means<'a> {
    rays: &'a Rays,
    drawing: Option<Drawing<'a>>,
    /// Without one, every reflected ray is followed.
    ground: Option<&'a Ground>,
}

impl<'a> Means<'a> {
    fn new(sweep: &Sweep<'a>, rays: &'a Rays) -> Self {
        if !sweep.shortcuts {
            return Self { rays, drawing: None, ground: None };
        }
        let ground = if sweep.starts_outside() { sweep.scene.ground() } else { None };
        Self { rays, drawing: Drawing::new(sweep.scene, rays), ground }
    }
}

/// Finds which of a band's reflected rays are shadowed.
struct Shade<'a, 'b> {
    scene: &'a Scene,
    means: &'a Means<'a>,
    columns: usize,
    /// The band's first row.
    first: usize,
    found: &'b mut [Glimpse],
    tally: &'b mut Tally,
}

impl Shade<'_, '_> {
    fn all(&mut self) {
        let columns = self.columns;
        let rows = self.found.len() / columns;
        for left in (0..columns).step_by(ROWS) {
            self.square([left, 0], [(left + ROWS).min(columns), rows]);
        }
    }

    /// The rays of the pixels from the upper left corner up to, not including, the lower right one.
    fn square(&mut self, from @ [left, upper]: [usize; 2], to @ [right, lower]: [usize; 2]) {
        let Self { columns, means, .. } = *self;
        let mut bundle = Bundle::NONE;
        let mut reflected = 0;
        for row in upper..lower {
            for column in left..right {
                let Glimpse { outcome, t, direction, .. } = self.found[row * columns + column];
                if outcome == Outcome::Hit {
                    bundle.add(means.rays.place(column, self.first + row, t), direction);
                    reflected += 1;
                }
            }
        }
        if reflected == 0 {
            return;
        }
        if means.ground.is_some_and(|ground| ground.frees(&bundle)) {
            self.tally.proven += reflected;
            return;
        }
        let side = (right - left).max(lower - upper);
        if side > LEAST && means.ground.is_some() {
            let middle = [0, 1].map(|axis| from[axis] + side / 2);
            for [x, y] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                let part = |k: usize, axis: usize| {
                    let cut = middle[axis].min(to[axis]);
                    if k == 0 { [from[axis], cut] } else { [cut, to[axis]] }
                };
                let ([left, right], [upper, lower]) = (part(x, 0), part(y, 1));
                self.square([left, upper], [right, lower]);
            }
            return;
        }
        for k in (upper..lower).flat_map(|row| row * columns + left..row * columns + right) {
            let Glimpse { outcome, t, facet, direction } = self.found[k];
            if outcome == Outcome::Hit {
                let ray = means.rays.at(k % columns, self.first + k / columns);
                self.found[k].outcome = shadowed(self.scene, &ray, t, facet, direction);
                self.tally.followed += 1;
            }
        }
    }
}
