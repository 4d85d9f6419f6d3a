//! Rays of a made system for look-up tables: at the nodes, between them, and for the places of maps.

use crate::geom::{DVec2, Ray};
use crate::lookup::{
    BilinearField, Direction, FieldErrors, MOST_STEPS, MapFrame, NodeSight, PixelGrid, PlaceMap,
    PlaceMapDraft, Pole,
};
use crate::optics::Camera;
use crate::tolerance::{Engine, PerturbedSystem};

/// Steps to a place of a map: from a quarter of a pixel to some thousandths, where the picture changes most over a cell.
const STEPS: usize = 3;
/// How far the rays are that a node's is compared with, px.
const BESIDE_PX: f64 = 0.25;

/// A made system.
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
pub(super) struct TracedTable {
    /// The nodes.
    pub grid: PixelGrid,
    /// Nodes that show the mirror.
    shown: Vec<Option<NodeSight>>,
    /// Places between the nodes that show it, px, with their rays.
    between: Vec<([f64; 2], Ray)>,
}

impl MountedSystem<'_> {
    /// The rays of places of the frame, px, and whether each shows the mirror.
    fn rays(&self, places: &[DVec2]) -> (Vec<Option<Ray>>, Vec<bool>) {
        let points = self.points(places);
        let lines = self.engine.mounted_sight_lines(&points);
        (lines.rays(self.made), lines.on_mirror)
    }

    /// Image points of places of the frame.
    fn points(&self, places: &[DVec2]) -> Vec<DVec2> {
        places.iter().map(|place| self.camera.image_point(place.x, place.y)).collect()
    }

    /// The rays of a table.
    pub(super) fn table(&self, grid: PixelGrid) -> TracedTable {
        let nodes: Vec<DVec2> = (0..grid.count()).map(|k| grid.node(k).into()).collect();
        let lines = self.engine.sight_lines(&self.points(&nodes));
        let rays = lines.rays(self.made);
        let covariances = lines.covariances(self.is_mounted);
        // (Y of the image goes up, rows go down.)
        let beside = [[-DVec2::X, DVec2::X], [DVec2::Y, -DVec2::Y]].map(|ways| {
            ways.map(|way| {
                let places: Vec<DVec2> = nodes.iter().map(|at| at + BESIDE_PX * way).collect();
                self.rays(&places).0
            })
        });
        let node = |k: usize| {
            let [x, y] = [&beside[0], &beside[1]].map(|pair| Some([pair[0][k]?, pair[1][k]?]));
            let sight = NodeSight {
                ray: rays[k]?,
                beside: [x?, y?],
                beside_px: BESIDE_PX,
                covariance: covariances[k],
            };
            lines.on_mirror[k].then_some(sight)
        };
        let shown = (0..nodes.len()).map(node).collect();
        TracedTable { grid, shown, between: self.between(grid) }
    }

    /// Places between the nodes that show the mirror, with their rays.
    fn between(&self, grid: PixelGrid) -> Vec<([f64; 2], Ray)> {
        let between = grid.places_between();
        let places: Vec<DVec2> = between.iter().map(|&place| place.into()).collect();
        let (rays, on_mirror) = self.rays(&places);
        let all = between.into_iter().zip(rays).zip(on_mirror);
        all.filter_map(|((at, ray), on_mirror)| Some((at, ray.filter(|_| on_mirror)?))).collect()
    }

    /// The places of the frame that show the pixels of a picture, of which `field` holds what `of` says of rays.
    pub(super) fn map(
        &self,
        picture: MapFrame,
        (field, pole): (&BilinearField, Pole),
        of: impl Fn(&Ray) -> Option<[f64; 2]>,
    ) -> PlaceMap {
        let mut draft = PlaceMapDraft::new(picture, field, pole);
        for _ in 0..STEPS {
            let (rays, _) = self.rays(&draft.places());
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

impl TracedTable {
    /// How many places between nodes it is held against.
    pub(super) fn known(&self) -> usize {
        self.between.len()
    }

    /// Nodes that show the mirror.
    pub(super) fn shown(&self) -> &[Option<NodeSight>] {
        &self.shown
    }

    /// The pole that is away from all directions.
    pub(super) fn pole(&self) -> Pole {
        Pole::away_from(self.between.iter().map(|(_, ray)| ray))
    }

    /// The field of what `of` says of the rays, in whole steps of 16 bits.
    pub(super) fn field(
        &self,
        of: impl Fn(&Ray) -> Option<[f64; 2]>,
    ) -> (BilinearField, FieldErrors) {
        let nodes = self.shown.iter().map(|node| of(&node.as_ref()?.ray)).collect();
        let between = self.between.iter().filter_map(|(at, ray)| Some((*at, of(ray)?)));
        let between: Vec<([f64; 2], [f64; 2])> = between.collect();
        BilinearField::new(self.grid, nodes, MOST_STEPS, &between)
    }

    /// A panorama of all elevations that are shown, in whole pixels.
    pub(super) fn panorama(&self, asked_deg: f64) -> MapFrame {
        let deg_per_px = 360.0 / (360.0 / asked_deg).round();
        let elevations = self.between.iter().map(|(_, ray)| Direction::of(ray).elevation_deg);
        let [low, high] =
            elevations.fold([90.0, -90.0], |[low, high]: [f64; 2], e| [low.min(e), high.max(e)]);
        MapFrame::Panorama {
            top_deg: deg_per_px * (high / deg_per_px).ceil(),
            bottom_deg: deg_per_px * (low / deg_per_px).floor().min((high / deg_per_px).ceil()),
            deg_per_px,
        }
    }
}
