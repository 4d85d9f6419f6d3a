//! Rays of a made system for look-up tables, with what parts differ by.

use super::mounted_system::{MountedSystem, TracedFrame};
use crate::geom::{DVec2, Ray};
use crate::lookup::{
    BilinearField, Direction, FieldErrors, MOST_STEPS, MapFrame, NodeSight, PixelGrid, PlaceMap,
    Pole,
};

/// How far the rays are that a node's is compared with, px.
const BESIDE_PX: f64 = 0.25;

/// Rays over a frame.
pub(super) struct TracedTable {
    /// The rays.
    frame: TracedFrame,
    /// Nodes that show the mirror.
    shown: Vec<Option<NodeSight>>,
}

impl MountedSystem<'_> {
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
        let shown: Vec<Option<NodeSight>> = (0..nodes.len()).map(node).collect();
        let nodes = shown.iter().map(|node| Some(node.as_ref()?.ray)).collect();
        TracedTable { frame: TracedFrame { grid, nodes, between: self.between(grid) }, shown }
    }

    /// The map of a picture, of which `field` holds what `of` says of rays.
    pub(super) fn map(
        &self,
        frame: MapFrame,
        (field, pole): (&BilinearField, Pole),
        of: impl Fn(&Ray) -> Option<[f64; 2]>,
    ) -> PlaceMap {
        let [width, height] = frame.size();
        let wanted = |k: usize| frame.wanted(k, pole);
        PlaceMap { frame, places: self.places((width * height, wanted), (field, 0.0), of) }
    }
}

impl TracedTable {
    /// The nodes' grid.
    pub(super) fn grid(&self) -> PixelGrid {
        self.frame.grid
    }

    /// How many places between nodes it is held against.
    pub(super) fn known(&self) -> usize {
        self.frame.between.len()
    }

    /// Nodes that show the mirror.
    pub(super) fn shown(&self) -> &[Option<NodeSight>] {
        &self.shown
    }

    /// All rays.
    pub(super) fn rays(&self) -> impl Iterator<Item = &Ray> {
        self.frame.rays()
    }

    /// The pole that is away from all directions.
    pub(super) fn pole(&self) -> Pole {
        self.frame.pole()
    }

    /// The field of what `of` says of the rays, in whole steps of 16 bits.
    pub(super) fn field(
        &self,
        of: impl Fn(&Ray) -> Option<[f64; 2]>,
    ) -> (BilinearField, FieldErrors) {
        self.frame.field(MOST_STEPS, of)
    }

    /// A panorama of all elevations that are shown, in whole pixels.
    pub(super) fn panorama(&self, asked_deg: f64) -> MapFrame {
        let deg_per_px = 360.0 / (360.0 / asked_deg).round();
        let elevations = self.frame.between.iter().map(|(_, ray)| Direction::of(ray).elevation_deg);
        let [low, high] =
            elevations.fold([90.0, -90.0], |[low, high]: [f64; 2], e| [low.min(e), high.max(e)]);
        MapFrame::Panorama {
            top_deg: deg_per_px * (high / deg_per_px).ceil(),
            bottom_deg: deg_per_px * (low / deg_per_px).floor().min((high / deg_per_px).ceil()),
            deg_per_px,
        }
    }
}
