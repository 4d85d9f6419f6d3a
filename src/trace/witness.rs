//! One ray a sensor pixel: what each one meets, where it goes, and how far that is from intended.

use super::sweep::{Glimpse, Sweep, Tally};
use super::{Hit, Scene};
use crate::geom::{DVec2, DVec3, Ray, angle};
use crate::num::stats::Summary;
use crate::optics::{ImagingTask, reflect};
use crate::parallel;

/// What a camera ray is meant to do: an entry of the table handed to the witness.
#[derive(Debug, Clone, Copy)]
pub struct Intent {
    /// The camera's ray.
    pub ray: Ray,
    /// Its image point (X, Y), mm.
    pub point: DVec2,
    /// Whether the mirror is meant to be there.
    pub aimed: bool,
    /// The unit direction that the projection wants it to see.
    pub wanted: DVec3,
    /// The image point where that belongs which the smooth, designed mirror shows.
    pub designed: DVec2,
}

/// How a ray ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It is reflected into the world.
    Hit,
    /// It meets nothing.
    Missed,
    /// It is reflected and then meets this facet.
    Shadowed(u32),
    /// The nearest facet shows it its back.
    BackFace,
}

/// Errors of one ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Angle between the direction seen and the one wanted, radians.
    pub ray: f64,
    /// How far away in the image the content belongs, mm on the mirror.
    pub image_mm: f64,
    /// How far away it belongs from what the designed mirror shows, mm on the mirror.
    pub facet_mm: f64,
}

/// What became of one ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Its end.
    pub outcome: Outcome,
    /// Whether the mirror was meant to be there.
    pub aimed: bool,
    /// The direction wanted.
    pub wanted: DVec3,
    /// The direction in which the ray leaves, for rays that hit.
    pub direction: DVec3,
    /// Where it leaves from, for rays that hit, mm.
    pub at: DVec3,
    /// Errors by the facet's own normal, for aimed rays that hit, where something is wanted.
    pub errors: Option<Errors>,
    /// Errors by the file's interpolated normals, where it has any.
    pub smooth: Option<Errors>,
}

impl Seen {
    const NOTHING: Self = Self {
        outcome: Outcome::Missed,
        aimed: false,
        wanted: DVec3::ZERO,
        direction: DVec3::ZERO,
        at: DVec3::ZERO,
        errors: None,
        smooth: None,
    };
}

/// What became of all rays, row by row.
#[derive(Debug, Clone)]
pub struct Witness {
    /// One entry a sensor pixel.
    pub seen: Vec<Seen>,
}

impl Witness {
    /// Traces `rows` rows of `columns` rays against `scene`: nearest hit over the whole mesh,
    /// reflection by the facet that is hit, shadow by the mesh itself. `table` gives the intended
    /// rays of a row, `view` carries errors back to the image (without it there are outcomes only),
    /// `normals` are the file's own at each facet's corners.
    pub fn trace(
        scene: &Scene,
        normals: Option<&[[DVec3; 3]]>,
        view: Option<&ImagingTask>,
        [columns, rows]: [u32; 2],
        table: impl Fn(u32) -> Vec<Intent> + Sync,
    ) -> Self {
        let mut seen = vec![Seen::NOTHING; columns as usize * rows as usize];
        parallel::map_chunks_mut(&mut seen, columns as usize, |row, line| {
            for (seen, intent) in line.iter_mut().zip(table(row as u32)) {
                let found = Glimpse::from(look(scene, &intent.ray));
                *seen = judge(scene, normals, view, &intent, &found);
            }
        });
        Self { seen }
    }

    /// The same for a table of the rays of `sweep`, all at once; with how they were traced.
    pub fn sweep(
        sweep: &Sweep,
        normals: Option<&[[DVec3; 3]]>,
        view: Option<&ImagingTask>,
        table: impl Fn(u32) -> Vec<Intent> + Sync,
    ) -> (Self, Tally) {
        let [columns, rows] = sweep.pixels().map(|n| n as usize);
        let mut seen = vec![Seen::NOTHING; columns * rows];
        let tally = sweep.bands(&mut seen, |first, found, seen| {
            let lines = seen.chunks_mut(columns).zip(found.chunks(columns));
            for (row, (line, found)) in (first..).zip(lines) {
                for ((seen, intent), found) in line.iter_mut().zip(table(row)).zip(found) {
                    *seen = judge(sweep.scene(), normals, view, &intent, found);
                }
            }
        });
        (Self { seen }, tally)
    }

    /// The rays aimed at the mirror.
    pub fn aimed(&self) -> impl Iterator<Item = &Seen> {
        self.seen.iter().filter(|seen| seen.aimed)
    }

    /// Number of aimed rays with an outcome that `pick` accepts.
    #[must_use]
    pub fn count(&self, pick: impl Fn(Outcome) -> bool) -> usize {
        self.aimed().filter(|seen| pick(seen.outcome)).count()
    }

    /// Summary over the aimed rays that hit; `None` when none did.
    #[must_use]
    pub fn summary(&self, error: impl Fn(&Seen) -> Option<f64>) -> Option<Summary> {
        let hits = self.aimed().filter(|seen| seen.outcome == Outcome::Hit);
        Summary::of(hits.filter_map(error).collect())
    }
}

/// Where one camera ray goes by its first reflection alone: its outcome but for shadow, the facet it
/// hits and the direction it leaves in (the zero vector when it is not reflected).
#[must_use]
pub fn glance(scene: &Scene, ray: &Ray) -> (Outcome, Option<Hit>, DVec3) {
    let Some(hit) = scene.first(ray) else {
        return (Outcome::Missed, None, DVec3::ZERO);
    };
    let (outcome, direction) =
        reflected(ray.direction, scene.mesh().area_vector(hit.facet as usize));
    (outcome, Some(hit), direction)
}

/// What a facet with a normal of any length makes of a ray that meets it, but for shadow.
#[inline(always)]
pub(super) fn reflected(direction: DVec3, normal: DVec3) -> (Outcome, DVec3) {
    if normal.dot(direction) < 0.0 {
        (Outcome::Hit, reflect(direction, normal))
    } else {
        (Outcome::BackFace, DVec3::ZERO)
    }
}

/// Follows one camera ray to its end: [`glance`], and shadow.
#[must_use]
pub fn look(scene: &Scene, ray: &Ray) -> (Outcome, Option<Hit>, DVec3) {
    let (outcome, hit, direction) = glance(scene, ray);
    let (Outcome::Hit, Some(found)) = (outcome, hit) else { return (outcome, hit, direction) };
    (shadowed(scene, ray, found.t, found.facet, direction), hit, direction)
}

/// The outcome of a ray that is reflected by `facet` at distance `t` and leaves in `direction`.
pub(super) fn shadowed(scene: &Scene, ray: &Ray, t: f64, facet: u32, direction: DVec3) -> Outcome {
    let leaving = Ray { origin: ray.at(t), direction };
    // The origin is rounded: neighbours of the facet may seem to lie a few ulps ahead of it.
    let clear = 1e-12 * (leaving.origin.abs().max_element() + t);
    scene.blocker(&leaving, facet, clear).map_or(Outcome::Hit, Outcome::Shadowed)
}

/// What became of a ray that ended as `found`, and how far that is from intended.
fn judge(
    scene: &Scene,
    normals: Option<&[[DVec3; 3]]>,
    view: Option<&ImagingTask>,
    intent: &Intent,
    found: &Glimpse,
) -> Seen {
    let Intent { ray, point, aimed, wanted, .. } = *intent;
    let Glimpse { outcome, facet, t, direction } = *found;
    let at = if facet == Glimpse::NO_FACET { DVec3::ZERO } else { ray.at(t) };
    let seen = Seen { outcome, aimed, wanted, direction, at, ..Seen::NOTHING };
    let (Outcome::Hit, true, Some(view)) = (outcome, aimed, view) else {
        return seen;
    };
    let errors = |direction: DVec3| {
        let content = view.image_of(at, direction, point);
        Errors {
            ray: angle(direction, wanted),
            image_mm: (content - point).length(),
            facet_mm: view.projection.image_distance(content, intent.designed),
        }
    };
    let smooth = normals.map(|normals| {
        let corners = normals[facet as usize].iter().zip(scene.weights(&ray, facet));
        errors(reflect(ray.direction, corners.map(|(n, w)| *n * w).sum()))
    });
    Seen { errors: Some(errors(direction)), smooth, ..seen }
}
