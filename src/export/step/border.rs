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
    let top_mm = border.top_mm;
    let [low, high] = match border.contour {
        Contour::Circle { radius_mm } => {
            let low = data.circle_edge(DVec3::ZERO, radius_mm);
            let high = data.circle_edge(DVec3::Z * top_mm, radius_mm);
            let around = (DVec2::ZERO, radius_mm);
            faces.push(data.cylinder_face(FaceRole::Side, [low, high], around, true));
            [vec![low.forward()], vec![high.forward()]]
        }
        Contour::Rect { half, corner_mm } => {
            let pieces = contour_pieces(half, corner_mm);
            let low = outline(data, &pieces, 0.0);
            let high = outline(data, &pieces, top_mm);
            walls(data, &pieces, [&low, &high], faces);
            [low, high].map(|edges| edges.into_iter().map(BrepEdge::forward).collect())
        }
    };
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
        let centre = mark.at.extend(top_mm);
        let rim = data.circle_edge(centre, radius);
        let place = data.placement(centre, DVec3::Z, DVec3::X);
        let (radius_mm, angle) = (real(radius), FRAC_PI_4);
        let cone = data.add(format_args!("CONICAL_SURFACE('',{place},{radius_mm},{angle})"));
        let apex = data.vertex(centre - DVec3::Z * radius);
        faces.push(data.fan_face(FaceRole::Mark(k + 1), apex, rim, cone, false));
        top.push(vec![rim.backward()]);
    }
    faces.push(data.plane_face(FaceRole::Rim, &top, DVec3::Z * top_mm, DVec3::Z));
    faces.push(data.plane_face(FaceRole::Base, &base, DVec3::ZERO, DVec3::NEG_Z));
}

/// A piece of a rectangle's outline, counterclockwise: where it starts, and what it turns about.
#[derive(Debug, Clone, Copy)]
struct ContourPiece {
    start: DVec2,
    about: Option<(DVec2, f64)>,
}

/// Sides and, if `corner_mm` is more than 0, round corners. Sides without length are left out.
fn contour_pieces(half: DVec2, corner_mm: f64) -> Vec<ContourPiece> {
    let inner = half - corner_mm;
    let normals = [DVec2::NEG_Y, DVec2::X, DVec2::Y, DVec2::NEG_X];
    let mut pieces = Vec::new();
    for (k, &out) in normals.iter().enumerate() {
        let next = normals[(k + 1) % 4];
        // From one corner of the rectangle within the round corners to the next.
        let [from, to] = [(out - next) * inner, (out + next) * inner];
        if corner_mm == 0.0 || (to - from).length() > 1e-7 {
            pieces.push(ContourPiece { start: from + out * corner_mm, about: None });
        }
        if corner_mm > 0.0 {
            pieces.push(ContourPiece { start: to + out * corner_mm, about: Some((to, corner_mm)) });
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

/// The faces between two outlines, one above the other.
fn walls(
    data: &mut DataSection,
    pieces: &[ContourPiece],
    [low, high]: [&[BrepEdge]; 2],
    faces: &mut Vec<InstanceId>,
) {
    let posts: Vec<BrepEdge> =
        low.iter().zip(high).map(|(low, high)| data.line_edge(low.from, high.from)).collect();
    for (k, piece) in pieces.iter().enumerate() {
        let next = posts[(k + 1) % posts.len()];
        let boundary =
            vec![low[k].forward(), next.forward(), high[k].backward(), posts[k].backward()];
        faces.push(match piece.about {
            None => {
                let along = (low[k].to.at - low[k].from.at).normalize();
                data.plane_face(FaceRole::Side, &[boundary], low[k].from.at, along.cross(DVec3::Z))
            }
            Some((centre, radius)) => {
                let cylinder = data.cylinder(centre, radius);
                data.face(FaceRole::Side, &[boundary], cylinder, true)
            }
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
            contour_pieces(half, corner_mm).iter().map(|p| (p.start.x, p.start.y)).collect()
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
