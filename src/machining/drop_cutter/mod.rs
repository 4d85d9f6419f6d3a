//! Drop cutter: the height at which a ball that is let down over a place of the plan comes to rest on a mirror.
//!
//! A ball with its centre over c touches the mirror at Q when the centre is at Q_z + sqrt(R^2 - |Q - c|^2), and it
//! rests at the largest of these. Each local maximum over Q is a contact. A grid over the face and nodes along its
//! rims find all of them to a step; from there an ascent goes on on the mirror itself. Beyond the rim there is
//! nothing.

mod ascent;
mod rim;

use crate::geom::{DVec2, DVec3};
use crate::mirror::{Hessian, LocalSurface, Mirror};
use rim::RimEdge;

/// Contacts that are looked for under one ball, at most: the ball rests in three, and a search of the lowest ball
/// needs those that come next.
const MOST_CONTACTS: usize = 8;

/// The second derivatives of a ball's lower side where its surface is `off` in the plan and `root` below the centre.
pub(super) fn ball_hessian(off: DVec2, root: f64) -> Hessian {
    let lean = off / root;
    Hessian {
        xx: (1.0 + lean.x * lean.x) / root,
        xy: lean.x * lean.y / root,
        yy: (1.0 + lean.y * lean.y) / root,
    }
}

/// A point of the designed panel.
#[derive(Debug, Clone, Copy)]
enum PanelPoint {
    /// By the chart's coordinates.
    Inside(DVec2),
    /// On a rim: the number of its edge, and steps along that.
    Rim(usize, f64),
}

/// A point of a panel from which an ascent starts; of the reflected one by its image on the designed panel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seed {
    point: PanelPoint,
    reflected: bool,
}

/// A contact of a ball with the mirror: it would rest there but for others that are higher.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    pub seed: Seed,
    /// The point of the mirror, mm.
    pub at: DVec3,
    /// Z of the ball's centre, mm.
    pub centre_z: f64,
    /// The first derivatives of that as the centre moves in the plan and the contact with it.
    pub slope: DVec2,
    /// The second derivatives, 1/mm.
    pub hessian: Hessian,
}

/// A mirror under a ball, with the nodes of a search.
pub(super) struct DropCutter<'a> {
    pub mirror: &'a Mirror,
    pub ball_mm: f64,
    /// Distance of the grid's nodes, mm.
    pub step: f64,
    /// X and Y of the first, columns and rows.
    pub first: DVec2,
    pub size: [usize; 2],
    /// Z over them, mm; none (no number) off the face.
    pub heights: Vec<f64>,
    edges: Vec<RimEdge>,
    /// Nodes of each edge and of its image, with its number, and whether they are the image's.
    rim: Vec<(Vec<DVec3>, usize, bool)>,
}

impl<'a> DropCutter<'a> {
    /// A grid of `size` nodes, `step` apart from `first` on, over `mirror`.
    pub(super) fn new(
        mirror: &'a Mirror,
        ball_mm: f64,
        step: f64,
        first: DVec2,
        size: [usize; 2],
        heights: Vec<f64>,
    ) -> Self {
        let edges = RimEdge::all(&mirror.outline, step);
        let sides = if mirror.folded { &[false, true][..] } else { &[false] };
        let nodes = |(k, edge): (usize, &RimEdge)| {
            let all: Vec<DVec3> =
                (0..=edge.steps).map(|n| mirror.extended_surface(edge.at(n as f64)).at).collect();
            sides
                .iter()
                .map(|&reflected| {
                    (all.iter().map(|p| flipped(*p, reflected)).collect(), k, reflected)
                })
                .collect::<Vec<_>>()
        };
        let rim = edges.iter().enumerate().flat_map(nodes).collect();
        Self { mirror, ball_mm, step, first, size, heights, edges, rim }
    }

    /// Z of the centre over `c` of a ball that touches `at`; none out of its reach.
    fn centre_z(&self, c: DVec2, at: DVec3) -> Option<f64> {
        let square = self.ball_mm * self.ball_mm - (at.truncate() - c).length_squared();
        (square > 0.0).then(|| at.z + square.sqrt())
    }

    /// The columns and rows of nodes under a ball over `c`, each the first and how many.
    fn window(&self, c: DVec2) -> [(usize, usize); 2] {
        let (at, reach) = ((c - self.first) / self.step, self.ball_mm / self.step);
        let range = |at: f64, count: usize| {
            let from = (at - reach).ceil().max(0.0);
            let to = (at + reach).floor().min(count as f64 - 1.0);
            (from as usize, if to < from { 0 } else { (to - from) as usize + 1 })
        };
        [range(at.x, self.size[0]), range(at.y, self.size[1])]
    }

    /// Writes the heights of the ball's centre over `c` on the nodes of one row.
    fn row_heights(&self, c: DVec2, row: usize, (from, count): (usize, usize), out: &mut [f64]) {
        let dy = self.first.y + self.step * row as f64 - c.y;
        let left = self.ball_mm * self.ball_mm - dy * dy;
        let start = self.first.x - c.x;
        let heights = &self.heights[row * self.size[0] + from..][..count];
        for (k, (value, &z)) in out.iter_mut().zip(heights).enumerate() {
            let dx = start + self.step * (from + k) as f64;
            // No number becomes no height.
            *value = (z + (left - dx * dx).sqrt()).max(f64::NEG_INFINITY);
        }
    }

    /// The least Z of a ball's centre over `c` that clears the nodes of the grid.
    pub(super) fn height_over_nodes(&self, c: DVec2) -> f64 {
        let [columns, rows] = self.window(c);
        let mut line = vec![0.0; columns.1];
        let mut most = f64::NEG_INFINITY;
        for row in rows.0..rows.0 + rows.1 {
            self.row_heights(c, row, columns, &mut line);
            most = line.iter().copied().fold(most, f64::max);
        }
        most
    }

    /// The nodes next to contacts under a ball over `c`, with the centre's height on them, the highest first.
    pub(super) fn seeds(&self, c: DVec2) -> Vec<(f64, Seed)> {
        let [columns, rows] = self.window(c);
        let width = columns.1 + 2;
        let mut values = vec![f64::NEG_INFINITY; width * (rows.1 + 2)];
        for k in 0..rows.1 {
            let out = &mut values[(k + 1) * width + 1..][..columns.1];
            self.row_heights(c, rows.0 + k, columns, out);
        }
        let mut found = Vec::new();
        let around = [1, width - 1, width, width + 1];
        for k in 0..rows.1 {
            for n in (k + 1) * width + 1..(k + 1) * width + 1 + columns.1 {
                let value = values[n];
                let is_highest = value > f64::NEG_INFINITY
                    && around.iter().all(|d| value >= values[n - d] && value >= values[n + d]);
                if is_highest {
                    let node = (rows.0 + k, columns.0 + n - (k + 1) * width - 1);
                    found.extend(self.node_seeds(node).into_iter().map(|seed| (value, seed)));
                }
            }
        }
        for (nodes, edge, reflected) in &self.rim {
            let value = |n: usize| self.centre_z(c, nodes[n]).unwrap_or(f64::NEG_INFINITY);
            let last = nodes.len() - 1;
            for n in 0..=last {
                let here = value(n);
                let is_highest = here > f64::NEG_INFINITY
                    && here >= value(n.saturating_sub(1))
                    && here >= value((n + 1).min(last));
                if is_highest {
                    let point = PanelPoint::Rim(*edge, n as f64);
                    found.push((here, Seed { point, reflected: *reflected }));
                }
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found
    }

    /// The node in this row and column, on each panel that it belongs to.
    fn node_seeds(&self, (row, column): (usize, usize)) -> Vec<Seed> {
        let xy = self.first + self.step * DVec2::new(column as f64, row as f64);
        let z = self.heights[row * self.size[0] + column];
        let (q, _) = self.mirror.chart.coordinates(xy.extend(z));
        let side = self.mirror.outline.bounds().centre().y;
        let seed = |reflected: bool| {
            let q = if reflected { q * DVec2::new(1.0, -1.0) } else { q };
            Seed { point: PanelPoint::Inside(self.mirror.outline.nearest(q)), reflected }
        };
        match (self.mirror.folded, q.y.abs() < 1e-9 * self.step) {
            (false, _) => vec![seed(false)],
            (true, true) => vec![seed(false), seed(true)],
            (true, false) => vec![seed(q.y * side < 0.0)],
        }
    }

    /// The contacts under a ball over `c`, the highest first.
    pub(super) fn contacts(&self, c: DVec2) -> Vec<Contact> {
        let seeds = self.seeds(c);
        let ascended =
            seeds.iter().take(MOST_CONTACTS).filter_map(|(_, seed)| self.ascend(c, seed));
        let mut all: Vec<Contact> = ascended.collect();
        all.sort_by(|a, b| b.centre_z.total_cmp(&a.centre_z));
        let mut apart: Vec<Contact> = Vec::new();
        for contact in all {
            let near = |other: &Contact| (other.at - contact.at).length() < 1e-4 * self.step;
            if !apart.iter().any(near) {
                apart.push(contact);
            }
        }
        apart
    }

    /// The mirror's point over `xy` where that is on the face.
    pub(super) fn surface_over(&self, xy: DVec2) -> Option<LocalSurface> {
        surface_on_face(self.mirror, xy)
    }
}

/// The point of `mirror` over `xy`; none off the face.
#[must_use]
pub fn surface_on_face(mirror: &Mirror, xy: DVec2) -> Option<LocalSurface> {
    let place = mirror.extended_surface_over(xy)?;
    let q = mirror.chart.coordinates(place.at).0;
    // A rounding error beyond the rim is on it.
    (mirror.full_outline().distance_outside(q)
        <= 1e-9 * mirror.outline.bounds().size().max_element())
    .then_some(place)
}

/// The point, or its reflection in the plane Y = 0.
fn flipped(p: DVec3, reflected: bool) -> DVec3 {
    if reflected { p * DVec3::new(1.0, -1.0, 1.0) } else { p }
}
