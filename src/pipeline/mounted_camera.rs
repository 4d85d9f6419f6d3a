//! The camera with its mirror, as designed or as mounted: from pixels to the rays that they see, and from points of the world back to pixels.

use super::Error;
use super::mounted_system::{BEYOND_CELLS, FINE_STEPS, MadeSystem, MountedSystem};
use super::observer::Silent;
use super::pose::KnownErrors;
use super::run::Run;
use super::tolerance_spec::engine;
use crate::design::Design;
use crate::geom::{DVec2, DVec3, Ray};
use crate::lookup::{CellSearch, Pole};
use crate::parallel;
use glam::DMat2;
use std::path::Path;
use std::sync::OnceLock;

/// Rounds in which a near point is looked for from where the last place's ray leaves the mirror: each brings it nearer by the mirror's
/// size over the distance.
const MOST_ROUNDS: usize = 8;
/// A place that a round moves by less is near enough for Newton's method, px.
const NEAR_PX: f64 = 0.5;
/// Places all over the mirror, of which one is near enough to whatever the mirror shows.
const SAMPLES: usize = 1024;
/// Most steps of Newton's method.
const MOST_STEPS: usize = 16;
/// Longest of them, px: the derivatives hold no farther.
const LONGEST_STEP_PX: f64 = 16.0;
/// Half of the distance over which differences stand for derivatives, px: both what they leave out and rounding are below 1e-9 of them.
const BESIDE_PX: f64 = 0.01;
/// A step so short leaves less by many orders, px.
const CONVERGED_PX: f64 = 1e-7;

/// A camera with the mirror that it looks into, as designed or as mounted. The frame of its rays and points is that of the designed part:
/// X to the right in the picture, Y up in it, Z towards the camera, the base at Z = 0; mm.
///
/// Shadows are not looked for: where one panel or a body hides what a pixel would show, the pixel shows it all the same.
#[derive(Debug)]
pub struct MountedCamera {
    design: Design,
    made: MadeSystem,
    warning: Option<String>,
    search: OnceLock<DirectionSearch>,
}

/// What the frame shows, to start a search from.
#[derive(Debug)]
struct DirectionSearch {
    /// Places by directions.
    cells: CellSearch,
    /// Pole from which directions are projected.
    pole: Pole,
    /// Places all over the mirror, px, with their rays.
    samples: Vec<(DVec2, Ray)>,
}

/// What a pixel is looked for of.
#[derive(Debug, Clone, Copy)]
enum Aim {
    /// A point, mm.
    Point(DVec3),
    /// A unit direction, of what is far away.
    Direction(DVec3),
}

impl Aim {
    /// Unit direction towards it from a place.
    fn direction_from(self, place: DVec3) -> DVec3 {
        match self {
            Self::Point(point) => (point - place).normalize(),
            Self::Direction(direction) => direction,
        }
    }
}

/// A place of the frame, px, on the way to what it is to show.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// Number of what is looked for.
    number: usize,
    aim: Aim,
    place: DVec2,
}

impl Design {
    /// The camera with this mirror: as designed, or as mounted by a file as `tolerance --replay` writes it (`pose.json`), with the errors
    /// of its camera.
    ///
    /// ```
    /// # let profile = morion::Profile::parse("part", "part.toml", include_bytes!("../../examples/small.toml"))?;
    /// let camera = profile.design()?.mounted(None)?;
    /// // What a pixel sees, and the pixel that sees a point of its ray, 2 m away.
    /// let pixel = [100.5, 60.5];
    /// let [from, way] = camera.unproject(&[pixel])[0].expect("the mirror");
    /// let point = [0, 1, 2].map(|k| from[k] + 2000.0 * way[k]);
    /// let back = camera.project(&[point])[0].expect("a pixel");
    /// assert!((back[0] - pixel[0]).abs() < 1e-6 && (back[1] - pixel[1]).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`enum@Error`] of a profile without a projection, and of a file that is no pose.
    pub fn mounted(&self, pose: Option<&Path>) -> Result<MountedCamera, Error> {
        let pose = pose.map(KnownErrors::read).transpose()?;
        let run = Run::in_memory(&self.profile, &Silent);
        let (engine, _) = engine(&run, self)?;
        Ok(MountedCamera {
            design: self.clone(),
            made: MadeSystem::new(engine, pose.as_ref()),
            warning: pose.and_then(|pose| pose.warning(&self.profile)),
            search: OnceLock::new(),
        })
    }
}

impl MountedCamera {
    /// A warning where the pose was written for another profile.
    #[must_use]
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// The ray that each picture point sees: its origin on the mirror, mm, and its unit direction; none where the point is beyond the
    /// frame, or does not show the mirror. Picture points are in pixels from the frame's upper left corner, to the right and down; pixel
    /// centres are at halves. These are the rays of `morion table`.
    #[must_use]
    pub fn unproject(&self, pixels: &[[f64; 2]]) -> Vec<Option<[[f64; 3]; 2]>> {
        let is_framed = |pixel: &&[f64; 2]| self.frames(DVec2::from_array(**pixel));
        let places: Vec<DVec2> = pixels.iter().filter(is_framed).map(|&p| p.into()).collect();
        let (rays, on_mirror) = self.system().rays(&places);
        let mut seen = rays.into_iter().zip(on_mirror).map(|(ray, is_on)| ray.filter(|_| is_on));
        let ray = |ray: Ray| [ray.origin.to_array(), ray.direction.to_array()];
        let of = |pixel: &[f64; 2]| is_framed(&pixel).then(|| seen.next()).flatten().flatten();
        pixels.iter().map(of).map(|found| found.map(ray)).collect()
    }

    /// The picture point, px, that shows each point of the world, mm; none where none does. Where several do, as beside the ridge of a
    /// conquistador, it is one of them. It is off by less than 1e-6 px, by the rays of [`MountedCamera::unproject`].
    #[must_use]
    pub fn project(&self, points: &[[f64; 3]]) -> Vec<Option<[f64; 2]>> {
        let aims = points.iter().map(|point| Aim::Point(DVec3::from_array(*point)));
        self.places(aims.collect())
    }

    /// The same of what is far away in each direction, of any length.
    #[must_use]
    pub fn project_directions(&self, directions: &[[f64; 3]]) -> Vec<Option<[f64; 2]>> {
        let aims = directions.iter().map(|way| DVec3::from_array(*way).normalize());
        self.places(aims.map(Aim::Direction).collect())
    }

    fn system(&self) -> MountedSystem<'_> {
        self.made.before(&self.design.camera)
    }

    fn frames(&self, place: DVec2) -> bool {
        let [width, height] = self.design.camera.pixels.map(f64::from);
        (0.0..=width).contains(&place.x) && (0.0..=height).contains(&place.y)
    }

    /// The search for places by directions.
    fn search(&self) -> &DirectionSearch {
        self.search.get_or_init(|| {
            let system = self.system();
            let frame = system.traced(system.grid());
            let pole = frame.pole();
            let (field, _) = frame.field(FINE_STEPS, |ray| Some(pole.project(ray)));
            let apart = frame.between.len().div_ceil(SAMPLES).max(1);
            let samples = frame.between.iter().step_by(apart);
            let samples = samples.map(|(place, ray)| (DVec2::from_array(*place), *ray)).collect();
            DirectionSearch { cells: CellSearch::new(&field, BEYOND_CELLS), pole, samples }
        })
    }

    fn places(&self, aims: Vec<Aim>) -> Vec<Option<[f64; 2]>> {
        let mut places = vec![None; aims.len()];
        self.add_shown(self.converged(self.started(&aims)), &mut places);
        // What is near and seen at the rim is beyond it as seen from the mirror's middle.
        let is_open = |(number, _): &(usize, &Aim)| places[*number].is_none();
        let open: Vec<(usize, Aim)> =
            aims.iter().enumerate().filter(is_open).map(|(number, aim)| (number, *aim)).collect();
        let nearest = parallel::map_slice(&open, 16, |(number, aim)| self.nearest(*number, *aim));
        self.add_shown(self.converged(nearest.into_iter().flatten().collect()), &mut places);
        places
    }

    /// Sets the places of those that show the mirror in the frame.
    fn add_shown(&self, found: Vec<Candidate>, places: &mut [Option<[f64; 2]>]) {
        let points: Vec<DVec2> = found.iter().map(|candidate| candidate.place).collect();
        let system = self.system();
        let on_mirror = system.engine.shows_mirror(&system.points(&points));
        for (Candidate { number, place, .. }, on_mirror) in found.into_iter().zip(on_mirror) {
            places[number] = (on_mirror && self.frames(place)).then(|| place.to_array());
        }
    }

    /// The sample whose ray passes an aim at the least angle.
    fn nearest(&self, number: usize, aim: Aim) -> Option<Candidate> {
        let cosine = |ray: &Ray| ray.direction.dot(aim.direction_from(ray.origin));
        let all = self.search().samples.iter().map(|(place, ray)| (cosine(ray), *place));
        let finite = all.filter(|(cosine, _)| cosine.is_finite());
        let (_, place) = finite.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Candidate { number, aim, place })
    }

    /// Where the frame shows the direction of an aim from a place.
    fn place(&self, aim: Aim, from: DVec3) -> Option<DVec2> {
        let DirectionSearch { cells, pole, .. } = self.search();
        let direction = aim.direction_from(from);
        cells.place(pole.project(&Ray { origin: from, direction }).into())
    }

    /// Places near what is looked for; what the frame shows nowhere is left out.
    fn started(&self, aims: &[Aim]) -> Vec<Candidate> {
        let origin_mm = self.design.view.as_ref().map_or(0.0, |view| view.origin_mm);
        let all = aims.iter().enumerate();
        let start = |(number, &aim): (usize, &Aim)| {
            Some(Candidate { number, aim, place: self.place(aim, DVec3::Z * origin_mm)? })
        };
        let mut candidates: Vec<Candidate> = all.filter_map(start).collect();
        for _ in 0..MOST_ROUNDS {
            let places: Vec<DVec2> = candidates.iter().map(|candidate| candidate.place).collect();
            let (rays, _) = self.system().rays(&places);
            let mut most_px: f64 = 0.0;
            let next = candidates.iter().zip(rays).filter_map(|(candidate, ray)| {
                let place = self.place(candidate.aim, ray?.origin)?;
                most_px = most_px.max(place.distance(candidate.place));
                Some(Candidate { place, ..*candidate })
            });
            candidates = next.collect();
            if most_px <= NEAR_PX {
                break;
            }
        }
        candidates
    }

    /// Where Newton's method leads; what it does not find is left out.
    fn converged(&self, mut open: Vec<Candidate>) -> Vec<Candidate> {
        const BESIDE: [DVec2; 5] = [DVec2::ZERO, DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y];
        let pole = self.search().pole;
        let mut found = Vec::with_capacity(open.len());
        for _ in 0..MOST_STEPS {
            if open.is_empty() {
                break;
            }
            let beside = |at: &Candidate| BESIDE.map(|way| at.place + BESIDE_PX * way);
            let places: Vec<DVec2> = open.iter().flat_map(beside).collect();
            let (rays, _) = self.system().rays(&places);
            let rays = rays.as_chunks::<5>().0;
            let mut next = Vec::new();
            for (candidate, rays) in open.iter().zip(rays) {
                let Some(step) = step(candidate.aim, rays, pole) else { continue };
                let length = step.length();
                let place = candidate.place + step * (LONGEST_STEP_PX / length).min(1.0);
                let moved = Candidate { place, ..*candidate };
                if length <= CONVERGED_PX { &mut found } else { &mut next }.push(moved);
            }
            open = next;
        }
        found
    }
}

/// Newton's step, px, by the rays of a place and of those beside it along x and y, before and after; none where there is none.
fn step(aim: Aim, rays: &[Option<Ray>; 5], pole: Pole) -> Option<DVec2> {
    let off = |ray: &Option<Ray>| {
        let ray = ray.as_ref()?;
        let wanted = Ray { origin: ray.origin, direction: aim.direction_from(ray.origin) };
        Some(DVec2::from_array(pole.project(ray)) - DVec2::from_array(pole.project(&wanted)))
    };
    let [here, right, left, below, above] = rays;
    let across = (off(right)? - off(left)?) / (2.0 * BESIDE_PX);
    let down = (off(below)? - off(above)?) / (2.0 * BESIDE_PX);
    let step = DMat2::from_cols(across, down).inverse() * -off(here)?;
    step.is_finite().then_some(step)
}
