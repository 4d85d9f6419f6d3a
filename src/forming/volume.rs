//! The volume of a forming tool: below its face, its walls and a land, and of what is around it.

use super::tool_frame::ToolFrame;
use crate::geom::{Border, DVec2, DVec3, Outline};
use crate::mirror::Mirror;
use crate::parallel;

/// Steps of the rule of Clenshaw and Curtis in each direction of a panel.
const NODES: usize = 128;

/// Volume of a tool's body, mm^3: of the plate below the plane of its foot, and of what stands on it or is cut into it.
pub(super) fn body_mm3(tool: &ToolFrame, border: Option<&Border>, mirror: &Mirror) -> f64 {
    let above = above_foot_mm3(tool, mirror);
    let plate = border.map_or(0.0, |border| border.volume(0.0));
    // (Of a hollow one the heights above the plane are negative.)
    plate + above
}

/// Integral of the height over the plane of the foot, mm^3: below the face, the walls beside it and a land inside a ring.
fn above_foot_mm3(tool: &ToolFrame, mirror: &Mirror) -> f64 {
    let foot = DVec3::Z * tool.flange_mm;
    let over = |p: DVec3| p - foot;
    let outer: Vec<(DVec3, DVec3)> = tool
        .rim(mirror, 0)
        .into_iter()
        .map(|(q, p)| (over(p), tool.foot_below(mirror, q, p).extend(0.0)))
        .collect();
    let next = outer.iter().cycle().skip(1);
    let walls: f64 = outer
        .iter()
        .zip(next)
        .map(|((a, below_a), (b, below_b))| {
            prism([*a, *below_b, *b]) + prism([*a, *below_a, *below_b])
        })
        .sum();
    let inner: Vec<DVec3> = tool.rim(mirror, 1).into_iter().map(|(_, p)| over(p)).collect();
    let mean = inner.iter().map(|p| p.z).sum::<f64>() / inner.len().max(1) as f64;
    let next = inner.iter().cycle().skip(1);
    let land: f64 = inner.iter().zip(next).map(|(a, b)| prism([*a, *b, DVec3::Z * mean])).sum();
    // A mould's face runs the other way round, seen from above.
    let turn = if tool.is_hollow() { -1.0 } else { 1.0 };
    turn * (walls + land) + below_face_mm3(tool, mirror, foot.z)
}

/// Volume below a triangle that is counter-clockwise from above, mm^3; below Z = 0 it is negative.
fn prism([a, b, c]: [DVec3; 3]) -> f64 {
    let area = 0.5 * (b - a).truncate().perp_dot((c - a).truncate());
    area * (a.z + b.z + c.z) / 3.0
}

/// Integral over the plan of a tool's face of its height over the plane at `foot_mm`.
fn below_face_mm3(tool: &ToolFrame, mirror: &Mirror, foot_mm: f64) -> f64 {
    let surface = tool.surface(mirror);
    let growth = tool.spec.growth();
    let panels = if mirror.folded { 2.0 } else { 1.0 };
    let lines = match mirror.outline {
        Outline::Rect(_) => mirror.outline.samples(NODES),
        // Rings are sampled along a quarter as many radii.
        Outline::Ring { .. } => mirror.outline.samples(4 * NODES),
    };
    let places: Vec<(DVec2, f64)> = lines.concat();
    let heights = parallel::map_slice(&places, 64, |&(q, weight)| {
        let (place, jacobian) = mirror.extended_surface_and_jacobian(q);
        let stretch = surface.plan_jacobian(&place).area();
        let area = growth * growth * stretch * jacobian.area();
        let height = tool.from_part(surface.beside(&place)).z - foot_mm;
        weight * area * height
    });
    panels * heights.iter().sum::<f64>()
}
