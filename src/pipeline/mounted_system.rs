//! A system as it is mounted: its rays over a frame, and the places of the frame that show what is wanted.

use super::pose::KnownErrors;
use crate::geom::{DVec2, Ray};
use crate::lookup::{BilinearField, FieldErrors, PixelGrid, PlaceMapDraft, Pole};
use crate::optics::Camera;
use crate::tolerance::{Engine, PerturbedSystem};

/// Most steps to a place of a map.
const MOST_STEPS_TO_PLACE: usize = 10;

/// Places whose rays are traced at a time: half a kilobyte is kept of each.
const PLACES_AT_A_TIME: usize = 1 << 16;

/// Nodes of a frame from which on they are farther apart than its pixels.
const MANY_NODES: f64 = 1e6;
/// Steps of the numbers at the nodes: so many that none is felt.
pub(super) const FINE_STEPS: f64 = 1e12;
/// Cells beyond those that are told in which places are looked for: beside the frame's edge and a ridge half of one.
pub(super) const BEYOND_CELLS: f64 = 1.5;

/// A system with the errors that are known of it.
#[derive(Debug)]
pub(super) struct MadeSystem {
    engine: Engine,
    made: PerturbedSystem,
    is_mounted: bool,
}

impl MadeSystem {
    /// The system with the errors of `pose`; without one that which was designed.
    pub(super) fn new(engine: Engine, pose: Option<&KnownErrors>) -> Self {
        let errors = pose.map_or(&[][..], |pose| &pose.errors);
        let made = engine.with_errors(errors);
        Self { engine, made, is_mounted: pose.is_some() }
    }

    /// The same with its camera, which is given as designed.
    pub(super) fn before<'a>(&'a self, camera: &'a Camera) -> MountedSystem<'a> {
        let Self { engine, made, is_mounted } = self;
        MountedSystem { engine, camera, made, is_mounted: *is_mounted }
    }
}

/// A made system and its camera.
pub(super) struct MountedSystem<'a> {
    /// Engine of the study of tolerances.
    pub engine: &'a Engine,
    /// The camera as designed.
    pub camera: &'a Camera,
    /// The system.
    pub made: &'a PerturbedSystem,
    /// Whether its mounting and its camera are known.
    pub is_mounted: bool,
}

/// Rays over a frame.
pub(super) struct TracedFrame {
    /// The nodes.
    pub grid: PixelGrid,
    /// Rays of the nodes that show the mirror.
    pub nodes: Vec<Option<Ray>>,
    /// Places between the nodes that show it, px, with their rays.
    pub between: Vec<([f64; 2], Ray)>,
}

impl MountedSystem<'_> {
    /// A node in each pixel of the sensor, or in each block of a large one.
    pub(super) fn grid(&self) -> PixelGrid {
        let frame = self.camera.pixels.map(|x| x as usize);
        let every = ((frame[0] * frame[1]) as f64 / MANY_NODES).sqrt().ceil() as usize;
        PixelGrid { frame, every: every.max(1) }
    }

    /// The rays of places of the frame, px, and whether each shows the mirror.
    pub(super) fn rays(&self, places: &[DVec2]) -> (Vec<Option<Ray>>, Vec<bool>) {
        let (mut rays, mut on_mirror) = (Vec::new(), Vec::new());
        for places in places.chunks(PLACES_AT_A_TIME) {
            let lines = self.engine.mounted_sight_lines(&self.points(places));
            rays.extend(lines.rays(self.made));
            on_mirror.extend(lines.on_mirror);
        }
        (rays, on_mirror)
    }

    /// Image points of places of the frame.
    pub(super) fn points(&self, places: &[DVec2]) -> Vec<DVec2> {
        places.iter().map(|place| self.camera.image_point(place.x, place.y)).collect()
    }

    /// The rays of a frame.
    pub(super) fn traced(&self, grid: PixelGrid) -> TracedFrame {
        let nodes: Vec<DVec2> = (0..grid.count()).map(|k| grid.node(k).into()).collect();
        let (rays, on_mirror) = self.rays(&nodes);
        let nodes = rays.into_iter().zip(on_mirror).map(|(ray, is_on)| ray.filter(|_| is_on));
        TracedFrame { grid, nodes: nodes.collect(), between: self.between(grid) }
    }

    /// Places between the nodes that show the mirror, with their rays.
    pub(super) fn between(&self, grid: PixelGrid) -> Vec<([f64; 2], Ray)> {
        let between = grid.places_between();
        let places: Vec<DVec2> = between.iter().map(|&place| place.into()).collect();
        let (rays, on_mirror) = self.rays(&places);
        let all = between.into_iter().zip(rays).zip(on_mirror);
        all.filter_map(|((at, ray), on_mirror)| Some((at, ray.filter(|_| on_mirror)?))).collect()
    }

    /// The places of the frame that show what is `wanted` of each of `count` pixels, of which `field` holds what `of` says of rays,
    /// also as many cells beyond those that it tells as `beyond` says.
    pub(super) fn places(
        &self,
        (count, wanted): (usize, impl Fn(usize) -> Option<[f64; 2]>),
        (field, beyond): (&BilinearField, f64),
        of: impl Fn(&Ray) -> Option<[f64; 2]>,
    ) -> Vec<Option<[f64; 2]>> {
        let mut draft = PlaceMapDraft::new(count, wanted, (field, beyond));
        for _ in 0..MOST_STEPS_TO_PLACE {
            let open = draft.open();
            if open.is_empty() {
                break;
            }
            let (rays, _) = self.rays(&open);
            draft.step(rays.iter().map(|ray| ray.as_ref().and_then(&of)));
        }
        let places = draft.places();
        let on_mirror = self.engine.shows_mirror(&self.points(&places));
        let [width, height] = field.grid.frame.map(|pixels| pixels as f64);
        let is_shown = |(at, on_mirror): (&DVec2, bool)| {
            on_mirror && (0.0..=width).contains(&at.x) && (0.0..=height).contains(&at.y)
        };
        let is_shown: Vec<bool> = places.iter().zip(on_mirror).map(is_shown).collect();
        draft.finish(&is_shown)
    }
}

impl TracedFrame {
    /// All rays.
    pub(super) fn rays(&self) -> impl Iterator<Item = &Ray> {
        self.nodes.iter().flatten().chain(self.between.iter().map(|(_, ray)| ray))
    }

    /// The pole that is away from all directions.
    pub(super) fn pole(&self) -> Pole {
        Pole::away_from(self.between.iter().map(|(_, ray)| ray))
    }

    /// The field of what `of` says of the rays, in whole steps of which the largest number has `most`.
    pub(super) fn field(
        &self,
        most: f64,
        of: impl Fn(&Ray) -> Option<[f64; 2]>,
    ) -> (BilinearField, FieldErrors) {
        let nodes = self.nodes.iter().map(|ray| of(ray.as_ref()?)).collect();
        let between = self.between.iter().filter_map(|(at, ray)| Some((*at, of(ray)?)));
        let between: Vec<([f64; 2], [f64; 2])> = between.collect();
        BilinearField::new(self.grid, nodes, most, &between)
    }
}
