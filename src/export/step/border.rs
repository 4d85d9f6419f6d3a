//! The material around a mirror: outer walls, flat top, holes, marks and base plane.

use super::face_role::FaceRole;
use super::hole::write_hole;
use super::part21::{DataSection, InstanceId, real};
use super::topology::{BrepEdge, BrepVertex, OrientedEdge, reversed};
use crate::geom::{Border, Contour, DVec2, DVec3, NumberedHole};
use std::f64::consts::FRAC_PI_4;

/// Writes the faces of `border` around the mirror's walls, whose feet run counterclockwise from
/// above, with its own and blind `holes`, and the lower ends of other holes in its base.
pub(super) fn write_border(
    data: &mut DataSection,
    border: &Border,
    feet: &[OrientedEdge],
    (lows, holes): (&[BrepEdge], &[NumberedHole]),
    faces: &mut Vec<InstanceId>,
) {
    let [low, high] = write_side(data, border, faces);
    let (mut base, mut top) = (vec![reversed(&low)], vec![high, reversed(feet)]);
    for hole in holes {
        let [low, high] = write_hole(data, hole, faces);
        base.push(vec![low.forward()]);
        if hole.blind.is_none() {
            top.push(vec![high.backward()]);
        }
    }
    base.extend(lows.iter().map(|low| vec![low.forward()]));
    for (k, mark) in border.marks.iter().enumerate() {
        let radius = 0.5 * mark.diameter_mm;
        let centre = mark.at.extend(border.top_mm);
        let rim = data.circle_edge(centre, radius);
        let place = data.placement(centre, DVec3::Z, DVec3::X);
        let (radius_mm, angle) = (real(radius), FRAC_PI_4);
        let cone = data.add(format_args!("CONICAL_SURFACE('',{place},{radius_mm},{angle})"));
        let apex = data.vertex(centre - DVec3::Z * radius);
        faces.push(data.fan_face(FaceRole::Mark(k + 1), apex, rim, cone, false));
        top.push(vec![rim.backward()]);
    }
    faces.push(data.plane_face(FaceRole::Rim, &top, DVec3::Z * border.top_mm, DVec3::Z));
    faces.push(data.plane_face(FaceRole::Base, &base, DVec3::ZERO, DVec3::NEG_Z));
}

/// Writes the side and the chamfers of its edges; the loops around the base and around the flat top, counterclockwise from
/// above.
fn write_side(
    data: &mut DataSection,
    border: &Border,
    faces: &mut Vec<InstanceId>,
) -> [Vec<OrientedEdge>; 2] {
    let mut edges = border.side_edges();
    edges.reverse();
    let role = |[low, high]: [DVec2; 2]| match low.x == high.x {
        true => FaceRole::Side,
        false => FaceRole::Chamfer,
    };
    let loops: Vec<Vec<BrepEdge>> = match border.contour {
        Contour::Circle { radius_mm } => {
            let rings: Vec<BrepEdge> = edges
                .iter()
                .map(|edge| data.circle_edge(DVec3::Z * edge.y, radius_mm - edge.x))
                .collect();
            for (k, ring) in rings.windows(2).enumerate() {
                let ends = [edges[k], edges[k + 1]];
                let turned = ends.map(|edge| DVec2::new(radius_mm - edge.x, edge.y));
                let surface = data.cylinder_or_cone(DVec2::ZERO, turned);
                faces.push(data.turned_face(role(ends), [ring[0], ring[1]], surface, true));
            }
            rings.into_iter().map(|ring| vec![ring]).collect()
        }
        Contour::Rect { half, corner_mm } => {
            let outlines: Vec<(Vec<ContourPiece>, f64)> = edges
                .iter()
                .map(|edge| (contour_pieces(half, corner_mm, edge.x), edge.y))
                .collect();
            let loops: Vec<Vec<BrepEdge>> =
                outlines.iter().map(|(pieces, z)| outline(data, pieces, *z)).collect();
            for k in 0..loops.len() - 1 {
                let pieces = [&outlines[k].0[..], &outlines[k + 1].0[..]];
                let ends = [&loops[k][..], &loops[k + 1][..]];
                walls(data, role([edges[k], edges[k + 1]]), pieces, ends, faces);
            }
            loops
        }
    };
    [0, loops.len() - 1].map(|k| loops[k].iter().copied().map(BrepEdge::forward).collect())
}

/// A piece of a rectangle's outline, counterclockwise: where it starts, and what it turns about.
#[derive(Debug, Clone, Copy)]
struct ContourPiece {
    start: DVec2,
    about: Option<(DVec2, f64)>,
}

/// Sides and, if `corner_mm` is more than 0, round corners, everywhere `inset` mm inside. Sides without length are left out.
fn contour_pieces(half: DVec2, corner_mm: f64, inset: f64) -> Vec<ContourPiece> {
    let is_sharp = corner_mm == 0.0;
    let (inner, radius) =
        if is_sharp { (half - inset, 0.0) } else { (half - corner_mm, corner_mm - inset) };
    let normals = [DVec2::NEG_Y, DVec2::X, DVec2::Y, DVec2::NEG_X];
    let mut pieces = Vec::new();
    for (k, &out) in normals.iter().enumerate() {
        let next = normals[(k + 1) % 4];
        // From one corner of the rectangle within the round corners to the next.
        let [from, to] = [(out - next) * inner, (out + next) * inner];
        if is_sharp || (to - from).length() > 1e-7 {
            pieces.push(ContourPiece { start: from + out * radius, about: None });
        }
        if !is_sharp {
            pieces.push(ContourPiece { start: to + out * radius, about: Some((to, radius)) });
        }
    }
    pieces
}

/// The edges of an outline at height `z`.
fn outline(data: &mut DataSection, pieces: &[ContourPiece], z: f64) -> Vec<BrepEdge> {
    let vertices: Vec<BrepVertex> =
        pieces.iter().map(|piece| data.vertex(piece.start.extend(z))).collect();
    let mut edges = Vec::new();
    for (k, piece) in pieces.iter().enumerate() {
        let (from, to) = (vertices[k], vertices[(k + 1) % pieces.len()]);
        edges.push(match piece.about {
            None => data.line_edge(from, to),
            Some((centre, radius)) => {
                let circle = data.circle(centre.extend(z), radius);
                data.edge(from, to, circle)
            }
        });
    }
    edges
}

/// The faces between two outlines, the second above the first: upright, or chamfers.
fn walls(
    data: &mut DataSection,
    role: FaceRole,
    pieces: [&[ContourPiece]; 2],
    [low, high]: [&[BrepEdge]; 2],
    faces: &mut Vec<InstanceId>,
) {
    let posts: Vec<BrepEdge> = low
        .iter()
        .zip(high)
        .map(|(low, high)| match role {
            FaceRole::Chamfer => data.slanted_edge(low.from, high.from),
            _ => data.line_edge(low.from, high.from),
        })
        .collect();
    for k in 0..posts.len() {
        let next = posts[(k + 1) % posts.len()];
        let boundary =
            vec![low[k].forward(), next.forward(), high[k].backward(), posts[k].backward()];
        let [from, up] = [low, high].map(|edges| edges[k].from.at);
        let about = pieces.map(|pieces| pieces[k].about);
        faces.push(if let [Some((centre, below)), Some((_, above))] = about {
            let ends = [DVec2::new(below, from.z), DVec2::new(above, up.z)];
            let surface = data.cylinder_or_cone(centre, ends);
            data.face(role, &[boundary], surface, true)
        } else {
            let out = (low[k].to.at - from).normalize().cross(DVec3::Z);
            // 0 of an upright face and 1 or -1 of a chamfer, to the last digit: a unit vector would have ten.
            let lean = ((from - up).dot(out) / (up.z - from.z)).round();
            data.plane_face(role, &[boundary], from, out + lean * DVec3::Z)
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_run_round_without_gaps() {
        let half = DVec2::new(5.0, 3.0);
        let starts = |corner_mm: f64| -> Vec<(f64, f64)> {
            contour_pieces(half, corner_mm, 0.0).iter().map(|p| (p.start.x, p.start.y)).collect()
        };
        assert_eq!(starts(0.0), [(-5.0, -3.0), (5.0, -3.0), (5.0, 3.0), (-5.0, 3.0)]);
        let round = starts(1.0);
        assert_eq!(round.len(), 8);
        assert_eq!(round[..4], [(-4.0, -3.0), (4.0, -3.0), (5.0, -2.0), (5.0, 2.0)]);
        // Half circles at the ends leave no sides there.
        let stadium = starts(3.0);
        assert_eq!(
            stadium,
            [(-2.0, -3.0), (2.0, -3.0), (5.0, 0.0), (2.0, 3.0), (-2.0, 3.0), (-5.0, 0.0)]
        );
    }
}
