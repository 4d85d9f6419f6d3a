//! The material around a mirror: outer walls, flat top, holes, marks and base plane.

use super::part21::{Data, Edge, Id, Part, Vertex, Way, real, reversed};
use crate::geom::{Border, Contour, DVec2, DVec3, Drilled};
use std::f64::consts::FRAC_PI_4;

/// Writes the faces of `stock` around the mirror's walls, whose feet run counterclockwise from
/// above, with the lower ends of other holes in its base.
pub fn border(data: &mut Data, stock: &Border, feet: &[Way], lows: &[Edge], faces: &mut Vec<Id>) {
    let top_mm = stock.top_mm;
    let [low, high] = match stock.contour {
        Contour::Circle { radius_mm } => {
            let low = data.round(DVec3::ZERO, radius_mm);
            let high = data.round(DVec3::Z * top_mm, radius_mm);
            let around = (DVec2::ZERO, radius_mm);
            faces.push(data.upright(Part::Side, [low, high], around, true));
            [vec![low.forward()], vec![high.forward()]]
        }
        Contour::Rect { half, corner_mm } => {
            let pieces = pieces(half, corner_mm);
            let low = outline(data, &pieces, 0.0);
            let high = outline(data, &pieces, top_mm);
            walls(data, &pieces, [&low, &high], faces);
            [low, high].map(|edges| edges.into_iter().map(Edge::forward).collect())
        }
    };
    let (mut base, mut top) = (vec![reversed(&low)], vec![high, reversed(feet)]);
    for hole in &stock.holes {
        let [low, high] = drill(data, hole, top_mm, faces);
        base.push(vec![low.forward()]);
        top.push(vec![high.backward()]);
    }
    base.extend(lows.iter().map(|low| vec![low.forward()]));
    for (k, mark) in stock.marks.iter().enumerate() {
        let radius = 0.5 * mark.diameter_mm;
        let centre = mark.at.extend(top_mm);
        let rim = data.round(centre, radius);
        let place = data.placement(centre, DVec3::Z, DVec3::X);
        let (radius_mm, angle) = (real(radius), FRAC_PI_4);
        let cone = data.add(format_args!("CONICAL_SURFACE('',{place},{radius_mm},{angle})"));
        let apex = data.vertex(centre - DVec3::Z * radius);
        faces.push(data.fan(Part::Mark(k + 1), apex, rim, cone, false));
        top.push(vec![rim.backward()]);
    }
    faces.push(data.flat_face(Part::Rim, &top, DVec3::Z * top_mm, DVec3::Z));
    faces.push(data.flat_face(Part::Base, &base, DVec3::ZERO, DVec3::NEG_Z));
}

/// Writes the wall of a through hole from the base to `top_mm`; its lower and its upper end.
pub fn drill(data: &mut Data, hole: &Drilled, top_mm: f64, faces: &mut Vec<Id>) -> [Edge; 2] {
    let low = data.round(hole.at.extend(0.0), hole.radius());
    let high = data.round(hole.at.extend(top_mm), hole.radius());
    let part = data.next_hole();
    faces.push(data.upright(part, [low, high], (hole.at, hole.radius()), false));
    [low, high]
}

/// A piece of a rectangle's outline, counterclockwise: where it starts, and what it turns about.
#[derive(Debug, Clone, Copy)]
struct Piece {
    start: DVec2,
    about: Option<(DVec2, f64)>,
}

/// Sides and, if `corner_mm` is more than 0, round corners. Sides without length are left out.
fn pieces(half: DVec2, corner_mm: f64) -> Vec<Piece> {
    let inner = half - corner_mm;
    let ways = [DVec2::NEG_Y, DVec2::X, DVec2::Y, DVec2::NEG_X];
    let mut pieces = Vec::new();
    for (k, &out) in ways.iter().enumerate() {
        let next = ways[(k + 1) % 4];
        // From one corner of the rectangle within the round corners to the next.
        let [from, to] = [(out - next) * inner, (out + next) * inner];
        if corner_mm == 0.0 || (to - from).length() > 1e-7 {
            pieces.push(Piece { start: from + out * corner_mm, about: None });
        }
        if corner_mm > 0.0 {
            pieces.push(Piece { start: to + out * corner_mm, about: Some((to, corner_mm)) });
        }
    }
    pieces
}

/// The edges of an outline at height `z`.
fn outline(data: &mut Data, pieces: &[Piece], z: f64) -> Vec<Edge> {
    let vertices: Vec<Vertex> =
        pieces.iter().map(|piece| data.vertex(piece.start.extend(z))).collect();
    let mut edges = Vec::new();
    for (k, piece) in pieces.iter().enumerate() {
        let (from, to) = (vertices[k], vertices[(k + 1) % pieces.len()]);
        edges.push(match piece.about {
            None => data.straight(from, to),
            Some((centre, radius)) => {
                let circle = data.circle(centre.extend(z), radius);
                data.edge(from, to, circle)
            }
        });
    }
    edges
}

/// The faces between two outlines, one above the other.
fn walls(data: &mut Data, pieces: &[Piece], [low, high]: [&[Edge]; 2], faces: &mut Vec<Id>) {
    let posts: Vec<Edge> =
        low.iter().zip(high).map(|(low, high)| data.straight(low.from, high.from)).collect();
    for (k, piece) in pieces.iter().enumerate() {
        let next = posts[(k + 1) % posts.len()];
        let ways = vec![low[k].forward(), next.forward(), high[k].backward(), posts[k].backward()];
        faces.push(match piece.about {
            None => {
                let along = (low[k].to.at - low[k].from.at).normalize();
                data.flat_face(Part::Side, &[ways], low[k].from.at, along.cross(DVec3::Z))
            }
            Some((centre, radius)) => {
                let cylinder = data.cylinder(centre, radius);
                data.face(Part::Side, &[ways], cylinder, true)
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
            pieces(half, corner_mm).iter().map(|p| (p.start.x, p.start.y)).collect()
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
