//! Is every vertex of a file where the part has one: on the designed mirror, on the base, on the
//! skirt between them, on the land inside a ring, or on the stock around the mirror?

use super::plan_edge::PlanEdge;
use crate::design::{Cavity, Design};
use crate::geom::{Border, DVec2, DVec3, HoleMeridian, Outline, Rect};
use crate::mirror::Mirror;
use crate::num::{cos, sin};
use crate::parallel;
use std::f64::consts::TAU;

/// Vertices that a thread handles at a time; fixed, so that results do not depend on the threads.
const CHUNK: usize = 16_384;

/// The vertex farthest from the part's surface, and how far that is, mm (along Z on the mirror and
/// the base, across it beside the outline). None without vertices.
pub(crate) fn worst_vertex(design: &Design, vertices: &[DVec3]) -> Option<(usize, f64)> {
    let Design { mirror, border, .. } = design;
    let blind = design.made_body().0.from_below();
    let on_floor = design.cavity.as_ref().map(on_floor);
    let room = on_floor.as_ref().map(RoomSurfaces::new);
    let around = Around { border: border.as_ref(), blind: &blind };
    let farther = |a: (usize, f64), b: (usize, f64)| if b.1 <= a.1 { a } else { b };
    let land = land(mirror);
    let leaning = PlanEdge::new(mirror);
    let panels = if mirror.has_steps() { mirror.panels() } else { Vec::new() };
    let chunks: Vec<_> = vertices.chunks(CHUNK).enumerate().collect();
    let worst = parallel::map_slice(&chunks, 1, |&(chunk, vertices)| {
        let places: Vec<DVec2> = vertices.iter().map(|&v| mirror.chart.coordinates(v).0).collect();
        let (mut k, mut worst) = (chunk * CHUNK, (chunk * CHUNK, 0.0));
        for line in places.chunk_by(|a, b| a.y == b.y) {
            // Some meshes list rows of equal Y together; for one vertex a row is costly to begin.
            let row = (line.len() > SHORT).then(|| mirror.row(line[0].y));
            for &q in line {
                let v = vertices[k - chunk * CHUNK];
                let f = match &row {
                    _ if mirror.has_steps() => panels[mirror.panel_at(v)].height(q),
                    Some(row) => row.at(q.x).f,
                    None => mirror.height(q),
                };
                let on_mirror = mirror.chart.point(q, f);
                let mut off = distance(mirror, on_mirror, q, v, land, leaning.as_ref(), around);
                if let Some(room) = room.as_ref().filter(|_| off > 0.0) {
                    off = off.min(room.distance(v));
                }
                worst = farther(worst, (k, off));
                k += 1;
            }
        }
        worst
    });
    worst.into_iter().reduce(farther)
}

/// How far rounding to single precision may take a vertex off the mirror, as a share of its size, and how far inside
/// its outline the edge is farther away than that under every camera.
const ROUNDED: f64 = 1e-6;
const FAR_INSIDE: f64 = 1e-3;

/// Vertices of equal Y for which a row is not begun.
const SHORT: usize = 4;

/// Directions in which a land's rim is looked at.
const WAYS: usize = 64;

/// Radius of the land inside a ring, and its heights: those of its rim, which may not be flat.
fn land(mirror: &Mirror) -> Option<(f64, [f64; 2])> {
    let Outline::Ring { inner, .. } = mirror.outline else { return None };
    let way = |k: usize| {
        let angle = TAU * k as f64 / WAYS as f64;
        DVec2::new(cos(angle), sin(angle))
    };
    let heights = (0..WAYS).map(|k| rim(mirror, way(k), inner).z);
    let range =
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], z| [lo.min(z), hi.max(z)]);
    (inner > 0.0).then(|| (rim(mirror, DVec2::X, inner).x, range))
}

/// The mirror's point in direction `way` at `reach` mm of the chart from the axis.
fn rim(mirror: &Mirror, way: DVec2, reach: f64) -> DVec3 {
    let q = way * reach;
    mirror.position(q, &mirror.row(q.y).at(q.x))
}

/// The point of the mirror's edge next to `v`, and how far `v` lies beyond it or beyond the skirt below it in the plan,
/// mm: in the direction from the part's axis, or the nearest where the camera stands beside the axis or the skirt lies along
/// the camera's rays.
fn edge_at(mirror: &Mirror, leaning: Option<&PlanEdge>, v: DVec3) -> (DVec3, f64) {
    let across = v.truncate();
    if let (true, Outline::Rect(Rect { min, max })) = (mirror.has_steps(), mirror.outline) {
        // Inside, the nearest side is that of the least distance.
        let q = mirror.chart.coordinates(v).0;
        let (below, above) = (q - min, max - q);
        let inside = below.min(above).min_element();
        let mut edge = q.clamp(min, max);
        if inside > 0.0 {
            let axis = usize::from(below.y.min(above.y) < below.x.min(above.x));
            edge[axis] = if below[axis] < above[axis] { min[axis] } else { max[axis] };
        }
        let beside = if inside > 0.0 { -inside } else { q.distance(edge) };
        let at = mirror.position_on(mirror.panel_at(v), edge);
        return (at, beside * mirror.chart.view_scale(v.z));
    }
    if let Some(edge) = leaning {
        return edge.nearest(across);
    }
    let edge = rim(mirror, across.normalize_or_zero(), mirror.full_outline().reach(across));
    (edge, across.length() - edge.truncate().length())
}

/// The surfaces of a cavity: those of a part on its floor.
struct RoomSurfaces<'a> {
    roof: &'a Mirror,
    floor_mm: f64,
    land: Option<(f64, [f64; 2])>,
    leaning: Option<PlanEdge<'a>>,
}

/// The roof of a cavity in a frame whose origin is on the floor, and Z of the floor, mm.
fn on_floor(cavity: &Cavity) -> (Mirror, f64) {
    let floor_mm = cavity.floor.z_mm;
    let mut roof = cavity.roof.clone();
    roof.chart.plane_mm -= floor_mm;
    (roof, floor_mm)
}

impl<'a> RoomSurfaces<'a> {
    fn new((roof, floor_mm): &'a (Mirror, f64)) -> Self {
        Self { roof, floor_mm: *floor_mm, land: land(roof), leaning: PlanEdge::new(roof) }
    }

    /// Distance of `v` from them, mm.
    fn distance(&self, v: DVec3) -> f64 {
        let v = v - DVec3::Z * self.floor_mm;
        let (q, _) = self.roof.chart.coordinates(v);
        let over = self.roof.chart.point(q, self.roof.height(q));
        let around = Around { border: None, blind: &[] };
        distance(self.roof, over, q, v, self.land, self.leaning.as_ref(), around)
    }
}

/// The surfaces around and below the mirror.
#[derive(Clone, Copy)]
struct Around<'a> {
    border: Option<&'a Border>,
    blind: &'a [HoleMeridian],
}

impl Around<'_> {
    /// Distance of `v` from the base of a part without a border and from its blind holes, mm.
    fn base(self, v: DVec3) -> f64 {
        let p = v.truncate();
        let within = self.blind.iter().map(|hole| hole.mouth_radius() - p.distance(hole.axis));
        let off_base = within.fold(0.0, f64::max);
        let holes = self.blind.iter().map(|hole| hole.distance(v));
        holes.fold(DVec2::new(off_base, v.z).length(), f64::min)
    }
}

/// Distance of the vertex `v`, which is at `q` in the chart, from the part's surface, mm; `over` is the mirror's
/// point there.
fn distance(
    mirror: &Mirror,
    over: DVec3,
    q: DVec2,
    v: DVec3,
    land: Option<(f64, [f64; 2])>,
    leaning: Option<&PlanEdge>,
    around: Around,
) -> f64 {
    let outline = mirror.full_outline();
    let on_mirror = (over - v).length();
    // How far inside the outline, along X or Y or the radius, in the chart.
    let inside = match outline {
        Outline::Rect(rect) => (q - rect.min).min(rect.max - q).min_element(),
        Outline::Ring { outer, .. } => outer - q.length(),
    };
    if let (true, Some((radius, [lo, hi]))) = (inside >= 0.0, land)
        && v.truncate().length() <= radius
    {
        if let Some(border) = around.border.filter(|border| border.land.is_some()) {
            let on_border = border.distance(v, f64::NEG_INFINITY, true, around.blind);
            return on_mirror.min(on_border);
        }
        return on_mirror.min((lo - v.z).max(v.z - hi).max(0.0)).min(around.base(v));
    }
    // Most vertices are on the mirror, and there nothing else is asked: nor where only rounding takes them off it, far
    // from its edge.
    let size = outline.bounds().size().max_element();
    let is_rounded = inside >= FAR_INSIDE * size && on_mirror <= ROUNDED * size;
    if inside >= 0.0 && on_mirror <= 1e-9 * size || is_rounded {
        return on_mirror;
    }
    let (edge, beside) = edge_at(mirror, leaning, v);
    if let Some(border) = around.border {
        let on_skirt = DVec2::new(beside, v.z - v.z.min(edge.z).max(border.top_mm)).length();
        let on_border = border.distance(v, beside, false, around.blind).min(on_skirt);
        return if inside >= 0.0 { on_mirror.min(on_border) } else { on_border };
    }
    if beside > 0.0 {
        return if inside >= 0.0 { on_mirror.min(beside) } else { beside };
    }
    let on_skirt = if v.z >= 0.0 && v.z <= edge.z { -beside } else { f64::INFINITY };
    on_mirror.min(around.base(v)).min(on_skirt)
}
