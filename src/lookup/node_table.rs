//! What stands at the nodes of a table: angles, places of a floor, and how far parts differ in them.

use super::{Direction, FloorPlane, PixelGrid};
use crate::geom::Ray;
use crate::num::stats::Summary;
use crate::raster::npy;
use std::fmt::Write;

/// A node that shows something: its ray, and the rays beside it.
#[derive(Debug, Clone, Copy)]
pub struct NodeSight {
    /// Its ray.
    pub ray: Ray,
    /// The rays before and after it along X of the image, and along Y.
    pub beside: [[Ray; 2]; 2],
    /// How far before and after, px.
    pub beside_px: f64,
    /// Covariance, px^2, along X, along both and along Y of the image, of where that belongs which the node shows; none where it
    /// is not known.
    pub covariance: Option<[f64; 3]>,
}

/// Two numbers with their standard deviations among parts.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Figures {
    values: [f64; 2],
    deviations: Option<[f64; 2]>,
}

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
struct NodeRow {
    /// Azimuth and elevation, degrees.
    direction: Figures,
    /// Standard deviation of the direction, mrad.
    angle_mrad: Option<f64>,
    /// X and Y of the floor, mm.
    floor: Option<Figures>,
}

/// The rows of all nodes.
#[derive(Debug, Clone)]
pub struct NodeTable {
    grid: PixelGrid,
    has_floor: bool,
    rows: Vec<Option<NodeRow>>,
}

/// A number of a node: its name, its decimals, and what it is.
type Column = (&'static str, usize, fn(&NodeRow) -> Option<f64>);

const DIRECTIONS: [Column; 4] = [
    ("azimuth_deg", 4, |row| Some(row.direction.values[0])),
    ("elevation_deg", 4, |row| Some(row.direction.values[1])),
    ("azimuth_sd_deg", 4, |row| Some(row.direction.deviations?[0])),
    ("elevation_sd_deg", 4, |row| Some(row.direction.deviations?[1])),
];
const FLOOR: [Column; 4] = [
    ("floor_x_mm", 2, |row| Some(row.floor?.values[0])),
    ("floor_y_mm", 2, |row| Some(row.floor?.values[1])),
    ("floor_x_sd_mm", 2, |row| Some(row.floor?.deviations?[0])),
    ("floor_y_sd_mm", 2, |row| Some(row.floor?.deviations?[1])),
];

impl NodeTable {
    /// The table of the nodes of `grid`, with the floor if there is one.
    #[must_use]
    pub fn new(grid: PixelGrid, nodes: &[Option<NodeSight>], floor: Option<FloorPlane>) -> Self {
        let row = |node: &Option<NodeSight>| node.as_ref().map(|node| NodeRow::new(node, floor));
        Self { grid, has_floor: floor.is_some(), rows: nodes.iter().map(row).collect() }
    }

    /// Standard deviation of the directions among parts, mrad, over the nodes.
    #[must_use]
    pub fn angle_deviation(&self) -> Option<Summary> {
        Summary::of(self.rows.iter().flatten().filter_map(|row| row.angle_mrad).collect())
    }

    /// Standard deviation of the places of the floor among parts, mm, over the nodes.
    #[must_use]
    pub fn floor_deviation(&self) -> Option<Summary> {
        let of = |row: &NodeRow| {
            let [x, y] = row.floor?.deviations?;
            Some((x * x + y * y).sqrt())
        };
        Summary::of(self.rows.iter().flatten().filter_map(of).collect())
    }

    fn columns(&self) -> Vec<Column> {
        let floor = if self.has_floor { &FLOOR[..] } else { &[] };
        DIRECTIONS.iter().chain(floor).copied().collect()
    }

    /// A NumPy array of shape (rows, columns, numbers) in single precision; not a number where nothing is shown or known.
    #[must_use]
    pub fn npy(&self) -> Vec<u8> {
        let ([across, down], columns) = (self.grid.nodes(), self.columns());
        let number = |row: &Option<NodeRow>, of: fn(&NodeRow) -> Option<f64>| {
            row.as_ref().and_then(of).map_or(f32::NAN, |x| x as f32)
        };
        let all = self.rows.iter().flat_map(|row| columns.iter().map(|(.., of)| number(row, *of)));
        npy(&[down, across, columns.len()], all)
    }

    /// A line for each node that shows something, with its place in pixels; empty where a number is not known.
    #[must_use]
    pub fn csv(&self) -> String {
        let columns = self.columns();
        let names: Vec<&str> = columns.iter().map(|(name, ..)| *name).collect();
        let mut text = format!("x_px,y_px,{}\n", names.join(","));
        for (k, row) in self.rows.iter().enumerate() {
            let Some(row) = row else { continue };
            let [x, y] = self.grid.node(k);
            let _ = write!(text, "{x},{y}");
            for (_, decimals, of) in &columns {
                let _ = match of(row) {
                    Some(value) => write!(text, ",{value:.decimals$}"),
                    None => write!(text, ","),
                };
            }
            text.push('\n');
        }
        text
    }

    /// Names of the numbers, in their order.
    #[must_use]
    pub fn names(&self) -> Vec<&'static str> {
        self.columns().into_iter().map(|(name, ..)| name).collect()
    }
}

impl NodeRow {
    fn new(node: &NodeSight, floor: Option<FloorPlane>) -> Self {
        let angles = |ray: &Ray| {
            let Direction { azimuth_deg, elevation_deg } = Direction::of(ray);
            Some([azimuth_deg, elevation_deg])
        };
        let turn = |[azimuth, elevation]: [f64; 2]| {
            [azimuth - 360.0 * (azimuth / 360.0).round(), elevation]
        };
        let direction = node.figures(angles, turn);
        let vector = |ray: &Ray| Some(ray.direction.to_array());
        let variance = node.variances(vector, |change| change);
        Self {
            direction: direction.unwrap_or(Figures { values: [f64::NAN; 2], deviations: None }),
            angle_mrad: variance.map(|all| 1e3 * all.into_iter().sum::<f64>().sqrt()),
            floor: floor.and_then(|plane| node.figures(|ray| plane.meets(ray), |change| change)),
        }
    }
}

impl NodeSight {
    fn figures(
        &self,
        of: impl Fn(&Ray) -> Option<[f64; 2]>,
        change: impl Fn([f64; 2]) -> [f64; 2],
    ) -> Option<Figures> {
        let deviations = self.variances(&of, change).map(|variances| variances.map(f64::sqrt));
        Some(Figures { values: of(&self.ray)?, deviations })
    }

    /// Variances of numbers of the ray, whose differences are brought into range by `change`.
    fn variances<const N: usize>(
        &self,
        of: impl Fn(&Ray) -> Option<[f64; N]>,
        change: impl Fn([f64; N]) -> [f64; N],
    ) -> Option<[f64; N]> {
        let [xx, xy, yy] = self.covariance?;
        let per_px = |[before, after]: &[Ray; 2]| {
            let (before, after) = (of(before)?, of(after)?);
            let way = change(std::array::from_fn(|k| after[k] - before[k]));
            Some(way.map(|x| x / (2.0 * self.beside_px)))
        };
        let [x, y] = [per_px(&self.beside[0])?, per_px(&self.beside[1])?];
        let of = |k: usize| xx * x[k] * x[k] + 2.0 * xy * x[k] * y[k] + yy * y[k] * y[k];
        Some(std::array::from_fn(of))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::num::{cos, radians, sin};

    /// A camera that looks along Z, 200 mm before a floor, at 0.1 degrees a pixel along X and Y of the image.
    fn ray(x_px: f64, y_px: f64) -> Ray {
        let [a, b] = [x_px, y_px].map(|px| radians(30.0 + 0.1 * px));
        let direction = DVec3::new(sin(a) * cos(b), sin(b), cos(a) * cos(b));
        Ray { origin: DVec3::new(0.0, 0.0, -200.0), direction }
    }

    #[test]
    fn deviations_follow_the_derivatives_of_angles_and_places() {
        let node = NodeSight {
            ray: ray(0.0, 0.0),
            beside: [[ray(-0.25, 0.0), ray(0.25, 0.0)], [ray(0.0, -0.25), ray(0.0, 0.25)]],
            beside_px: 0.25,
            covariance: Some([4.0, 0.0, 0.0]),
        };
        let plane = FloorPlane { z_mm: 0.0, range_mm: 1000.0 };
        let row = NodeRow::new(&node, Some(plane));
        // Two pixels of 0.1 degrees along X: X = 200 tan a, over cos(b) of the angle.
        let angle = radians(0.2);
        let floor = row.floor.unwrap();
        assert!((floor.values[0] - 200.0 * crate::num::tan(radians(30.0))).abs() < 1e-9);
        let exact = 200.0 * angle / 0.75;
        assert!((floor.deviations.unwrap()[0] / exact - 1.0).abs() < 1e-5, "{floor:?}");
        let exact = 1e3 * angle * cos(radians(30.0));
        assert!((row.angle_mrad.unwrap() / exact - 1.0).abs() < 1e-5, "{row:?}");
        let grid = PixelGrid { frame: [8, 4], every: 4 };
        let table = NodeTable::new(grid, &[Some(node), None], Some(plane));
        let csv = table.csv();
        assert!(csv.starts_with("x_px,y_px,azimuth_deg,") && csv.lines().count() == 2, "{csv}");
        assert!(csv.contains("\n2,2,"), "{csv}");
        assert_eq!(table.npy().len() % 64, 2 * 8 * 4 % 64);
    }
}
