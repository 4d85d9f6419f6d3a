//! The material around and below a face: flat top, side and base, with marks and holes.

use super::{SolidError, add_polygon, rounded, sides, wall};
use crate::geom::{
    BlindHole, Border, CavityFloor, DVec2, Hole, HoleMeridian, Land, PartFeatures, Precision,
    TriMesh, TriangulationFault, triangulate_loops,
};

/// A hole's surface as loops, each counter-clockwise from above, from the upper one to that in the base; a blind hole
/// has a point above them.
pub(super) struct HoleLoops {
    point: Option<u32>,
    loops: Vec<Vec<u32>>,
}

impl HoleLoops {
    /// New vertices on the circles of a hole.
    fn new(mesh: &mut TriMesh, hole: &HoleMeridian) -> Self {
        let mut found = Self { point: None, loops: Vec::new() };
        for ring in hole.points().iter().rev() {
            if ring.x == 0.0 {
                found.point = add_polygon(mesh, &[hole.axis], ring.y).pop();
            } else {
                found.loops.push(add_polygon(mesh, &hole.polygon(ring.x), ring.y));
            }
        }
        found
    }

    /// The loop in the plane above.
    pub(super) fn upper(&self) -> &[u32] {
        &self.loops[0]
    }

    /// The loop in the base.
    fn lower(&self) -> &[u32] {
        &self.loops[self.loops.len() - 1]
    }

    /// Adds the facets between the loops and up to the point.
    fn close(&self, mesh: &mut TriMesh) {
        if let Some(point) = self.point {
            mesh.triangles.extend(sides(self.upper()).map(|[v, next]| [next, v, point]));
        }
        let turned = |rim: &[u32]| rim.iter().rev().copied().collect::<Vec<_>>();
        for pair in self.loops.windows(2) {
            wall(mesh, &turned(&pair[0]), &turned(&pair[1]));
        }
    }
}

/// How many facets [`HoleLoops::close`] adds.
fn hole_facets(hole: &HoleMeridian) -> usize {
    let (pieces, corners) = (hole.points().len() - 1, hole.corners());
    if hole.is_blind() { (2 * pieces - 1) * corners } else { 2 * pieces * corners }
}

/// The flat land within the loop `hole`, around its own holes, which are open below.
///
/// # Errors
/// [`SolidError::BorderTriangulation`] when loops touch each other.
pub(super) fn land(
    mesh: &mut TriMesh,
    hole: &[u32],
    land: &Land,
    precision: Precision,
) -> Result<Vec<HoleLoops>, SolidError> {
    let bores = through(mesh, &land.holes, land.z_mm);
    let inner: Vec<&[u32]> = bores.iter().map(HoleLoops::upper).collect();
    let flat = triangulate_between(mesh, hole, &inner, precision)?;
    mesh.triangles.extend(flat);
    Ok(bores)
}

/// The loops of the drains through the floor of a cavity.
pub(super) fn drains(mesh: &mut TriMesh, floor: Option<&CavityFloor>) -> Vec<HoleLoops> {
    let meridians = floor.into_iter().flat_map(CavityFloor::meridians);
    meridians.map(|drain| HoleLoops::new(mesh, &drain)).collect()
}

/// Closes what is open at `feet`, the loop of the face's skirt on the flat top of `border`, and at the
/// `bores` of land and cavity; blind holes open in the base. Circles become polygons with their corners on them, of chords
/// within [`crate::geom::CHORD_MM`].
///
/// # Errors
/// [`SolidError::BorderTriangulation`] when loops touch each other.
pub(super) fn close(
    mesh: &mut TriMesh,
    feet: &[u32],
    border: &Border,
    (bores, blind): (Vec<HoleLoops>, &[BlindHole]),
    precision: Precision,
) -> Result<(), SolidError> {
    let top = border.top_mm;
    let edges = border.side_edges();
    let side: Vec<Vec<u32>> = edges
        .iter()
        .map(|edge| add_polygon(mesh, &border.contour.shrunk_polygon(edge.x), edge.y))
        .collect();
    let lowest = &side[side.len() - 1];
    let mut holes = through(mesh, &border.holes, top);
    let marks: Vec<Vec<u32>> =
        border.marks.iter().map(|mark| add_polygon(mesh, &mark.polygon(mark.at), top)).collect();

    let upper = holes.iter().map(HoleLoops::upper);
    let inner: Vec<&[u32]> =
        std::iter::once(feet).chain(upper).chain(marks.iter().map(Vec::as_slice)).collect();
    let flat = triangulate_between(mesh, &side[0], &inner, precision)?;
    mesh.triangles.extend(flat);
    for (mark, rim) in border.marks.iter().zip(&marks) {
        let tip = add_polygon(mesh, &[mark.at], top - mark.radius())[0];
        mesh.triangles.extend(sides(rim).map(|[v, next]| [v, next, tip]));
    }
    holes.extend(bores);
    holes.extend(blind.iter().map(|blind| HoleLoops::new(mesh, &blind.meridian())));
    holes.iter().for_each(|hole| hole.close(mesh));
    side.windows(2).for_each(|pair| wall(mesh, &pair[0], &pair[1]));
    base(mesh, lowest, &holes, precision)
}

/// Closes what is open at `feet`, the loop of the face's skirt on the base, around drains and blind holes; at least one.
///
/// # Errors
/// [`SolidError::BorderTriangulation`] when loops touch each other.
pub(super) fn drill(
    mesh: &mut TriMesh,
    feet: &[u32],
    (drains, blind): (Vec<HoleLoops>, &[BlindHole]),
    precision: Precision,
) -> Result<(), SolidError> {
    let mut holes = drains;
    holes.extend(blind.iter().map(|blind| HoleLoops::new(mesh, &blind.meridian())));
    holes.iter().for_each(|hole| hole.close(mesh));
    base(mesh, feet, &holes, precision)
}

/// Adds the base within the loop `outer`, around the mouths of holes.
fn base(
    mesh: &mut TriMesh,
    outer: &[u32],
    holes: &[HoleLoops],
    precision: Precision,
) -> Result<(), SolidError> {
    let lower: Vec<&[u32]> = holes.iter().map(HoleLoops::lower).collect();
    let base = triangulate_between(mesh, outer, &lower, precision)?;
    mesh.triangles.extend(base.into_iter().map(|[a, b, c]| [a, c, b]));
    Ok(())
}

/// How many facets [`close`], [`land`] and [`drill`] add, but for the one at each of the feet and at each edge
/// of the land.
pub(super) fn added_facets(features: PartFeatures) -> usize {
    // A polygon of n corners in all and h holes takes n + 2 h - 2 triangles, a fan about its middle n.
    let mouths =
        |holes: &[HoleMeridian]| -> usize { holes.iter().map(|hole| hole.corners() + 2).sum() };
    let walls = |holes: &[HoleMeridian]| -> usize { holes.iter().map(hole_facets).sum() };
    let blind = features.from_below();
    let Some(border) = features.border else {
        return if blind.is_empty() { 0 } else { mouths(&blind) + walls(&blind) - 2 };
    };
    let meridians = |holes: &[Hole], top: f64| -> Vec<HoleMeridian> {
        holes.iter().map(|hole| hole.meridian(top)).collect()
    };
    let holes = meridians(&border.holes, border.top_mm);
    let (side, edges) = (border.contour.polygon().len(), border.side_edges().len());
    let marks: usize = border.marks.iter().map(|mark| mark.polygon(DVec2::ZERO).len()).sum();
    let flat = side + mouths(&holes) + marks + 2 * border.marks.len();
    let base = side + mouths(&holes) + mouths(&blind) - 2;
    let land = border.land.as_ref().map_or(0, |land| {
        let holes = meridians(&land.holes, land.z_mm);
        // In the land, in the base and the walls between them.
        2 * mouths(&holes) - 2 + walls(&holes)
    });
    flat + base + marks + walls(&holes) + walls(&blind) + 2 * (edges - 1) * side + land
}

fn through(mesh: &mut TriMesh, holes: &[Hole], top: f64) -> Vec<HoleLoops> {
    holes.iter().map(|hole| HoleLoops::new(mesh, &hole.meridian(top))).collect()
}

/// The triangles between the loop `outer` and those inside it, counter-clockwise from above.
pub(super) fn triangulate_between(
    mesh: &TriMesh,
    outer: &[u32],
    inner: &[&[u32]],
    precision: Precision,
) -> Result<Vec<[u32; 3]>, SolidError> {
    let numbers: Vec<u32> = [&[outer], inner].concat().concat();
    let at = |v: u32| rounded(mesh.vertices[v as usize], precision).truncate();
    let points: Vec<DVec2> = numbers.iter().map(|&v| at(v)).collect();
    let sizes: Vec<usize> =
        std::iter::once(&outer).chain(inner).map(|corners| corners.len()).collect();
    let triangles =
        triangulate_loops(&points, &sizes).map_err(|TriangulationFault { near, reason }| {
            SolidError::BorderTriangulation { near: points[near], reason }
        })?;
    Ok(triangles.into_iter().map(|t| t.map(|k| numbers[k as usize])).collect())
}

#[cfg(test)]
mod tests {
    use super::super::{Solid, added, rim, tests};
    use super::*;
    use crate::geom::{Contour, Counterbore, Drilled, HoleBottom, HoleKind};
    use std::f64::consts::PI;

    /// A plate 6 by 6 by 1 around the square face 2 by 2 at height 2.
    fn plate(holes: &[[f64; 3]], marks: &[[f64; 3]]) -> Border {
        let drilled = |list: &[[f64; 3]]| {
            let one = |&[x, y, d]: &[f64; 3]| Drilled { at: DVec2::new(x, y), diameter_mm: d };
            list.iter().map(one).collect()
        };
        let contour = Contour::Rect { half: DVec2::splat(3.0), corner_mm: 0.0 };
        let holes = holes.iter().map(|&[x, y, d]| Hole::plain(DVec2::new(x, y), d)).collect();
        Border {
            contour,
            top_mm: 1.0,
            edge_chamfer_mm: 0.0,
            holes,
            marks: drilled(marks),
            land: None,
        }
    }

    fn closed(stock: &Border, precision: Precision) -> Result<Solid, SolidError> {
        Solid::from_face(&tests::face(), PartFeatures::bordered(Some(stock)), precision)
    }

    #[test]
    fn a_face_stands_on_a_plate() {
        let solid = closed(&plate(&[], &[]), Precision::Double).unwrap();
        assert_eq!((solid.check().volume_mm3, solid.check().euler), (36.0 + 4.0, 2));
        // Face, skirt, flat top, side, base.
        assert_eq!(solid.mesh().triangles.len(), 2 + 8 + 8 + 8 + 2);
        for (holes, marks) in [
            (&[[2.0, 0.0, 1.0]][..], &[][..]),
            (&[[2.0, 0.0, 1.0], [-2.0, 2.0, 0.3]], &[[0.0, -2.0, 0.5], [1.0, -2.0, 0.4]]),
        ] {
            let stock = plate(holes, marks);
            let solid = closed(&stock, Precision::Single).unwrap();
            assert_eq!(solid.check().euler, 2 - 2 * holes.len() as i64);
            let around = rim(&tests::face()).unwrap();
            assert_eq!(
                solid.mesh().triangles.len(),
                2 + added(around, PartFeatures::bordered(Some(&stock)))
            );
            let off = solid.check().volume_mm3 - (stock.volume(4.0) + 8.0);
            assert!(off.abs() <= stock.chords_mm3() + 1e-6 && off.abs() > 1e-5, "{off}");
        }
    }

    /// Of every contour, with mitres at sharp corners.
    #[test]
    fn plates_with_chamfered_edges_are_closed_and_as_large_as_their_closed_forms() {
        let rect = |x: f64, y: f64, corner_mm| Contour::Rect { half: DVec2::new(x, y), corner_mm };
        // Corners, and what two chamfers take off the edges: prisms less pyramids at mitres, rings by Pappus' theorem.
        let c: f64 = 0.25;
        let ring = |radius: f64| 2.0 * PI * (radius - c / 3.0) * 0.5 * c * c;
        for (contour, straight, corners) in [
            (rect(3.0, 2.5, 0.0), 22.0, -4.0 / 3.0 * c * c * c),
            (rect(3.0, 2.5, 0.5), 18.0, ring(0.5)),
            (rect(3.0, 2.5, 2.5), 2.0, ring(2.5)),
            (Contour::Circle { radius_mm: 3.0 }, 0.0, ring(3.0)),
        ] {
            let stock = Border { contour, edge_chamfer_mm: c, ..plate(&[], &[]) };
            let exact = contour.area() + 4.0 - 2.0 * (0.5 * c * c * straight + corners);
            let around = rim(&tests::face()).unwrap();
            for (precision, digits) in [(Precision::Single, 1e-6), (Precision::Double, 1e-13)] {
                let solid = closed(&stock, precision).unwrap();
                let facets = solid.mesh().triangles.len();
                assert_eq!(facets, 2 + added(around, PartFeatures::bordered(Some(&stock))));
                // Face, skirt, flat top and base, and three walls of two facets at each corner of the contour.
                let side = contour.polygon().len();
                assert_eq!(facets, 2 + 8 + (side + 4) + (side - 2) + 6 * side, "{contour:?}");
                let lost = exact - solid.check().volume_mm3;
                let off = lost - stock.chords_mm3();
                assert!(off.abs() < digits * exact, "{contour:?}: {lost} {off:e}");
            }
        }
    }

    #[test]
    fn features_that_touch_are_refused_with_their_place() {
        let refused = |holes: &[[f64; 3]], marks: &[[f64; 3]]| match closed(
            &plate(holes, marks),
            Precision::Single,
        ) {
            Err(SolidError::BorderTriangulation { near, reason }) => {
                (near.round().to_array(), reason)
            }
            other => panic!("{other:?}"),
        };
        // Into each other, the skirt, the side; one on the other; too small for the digits.
        for (holes, marks, reason) in [
            (&[[2.0, 0.0, 1.0]][..], &[[2.0, 0.6, 1.0]][..], "two edges cross"),
            (&[[1.1, 0.0, 1.0]], &[], "two edges cross"),
            (&[[2.0, 0.0, 1.0]], &[[2.0, 0.0, 1.0]], "two corners fall together"),
            (&[[2.0, 0.0, 1e-7]], &[], "two corners fall together"),
        ] {
            let (near, found) = refused(holes, marks);
            assert_eq!(found, reason, "{holes:?} {marks:?}");
            assert!((1.0..=3.0).contains(&near[0]) && near[1].abs() <= 1.0, "{near:?}");
        }
        // Beyond the side.
        assert_eq!(refused(&[[2.9, 0.0, 1.0]], &[]).1, "two edges cross");
        assert!(closed(&plate(&[[9.0, 0.0, 1.0]], &[]), Precision::Double).is_err());
        let high = Border { top_mm: 2.0, ..plate(&[], &[]) };
        let sunk = SolidError::BelowBorder { lowest_mm: 2.0, top_mm: 2.0 };
        assert_eq!(closed(&high, Precision::Double).unwrap_err(), sunk);
    }
    /// Every kind of hole, in a plate and below a bare face, by the closed forms of its cylinders and cones.
    #[test]
    fn holes_of_every_kind_are_closed_and_as_large_as_their_closed_forms() {
        let hole = |x: f64, y: f64, counterbore, chamfer_mm| Hole {
            at: DVec2::new(x, y),
            diameter_mm: 0.5,
            kind: HoleKind::Plain,
            counterbore,
            chamfer_mm,
        };
        let wide = Some(Counterbore { diameter_mm: 0.8, depth_mm: 0.3 });
        let blind = |hole, bottom| BlindHole { hole, depth_mm: 0.6, bottom };
        let blind_holes = [
            blind(hole(0.0, 0.0, None, 0.0), HoleBottom::DrillPoint),
            blind(hole(0.5, -0.5, wide, 0.05), HoleBottom::DrillPoint),
            blind(hole(-0.55, 0.55, None, 0.1), HoleBottom::Flat),
        ];
        let mut plate = plate(&[], &[[-2.0, 0.0, 0.3]]);
        plate.holes = vec![hole(2.0, 0.0, wide, 0.1), hole(2.0, 2.0, None, 0.0)];
        for (border, body) in [(None, 8.0), (Some(&plate), 40.0 - PI * 0.15 * 0.15 * 0.05)] {
            let features = PartFeatures { border, blind_holes: &blind_holes, floor: None };
            for precision in [Precision::Single, Precision::Double] {
                let solid = Solid::from_face(&tests::face(), features, precision).unwrap();
                let through = features.through();
                assert_eq!(
                    (through, solid.check().euler),
                    match border {
                        None => (0, 2),
                        Some(_) => (2, -2),
                    }
                );
                let around = rim(&tests::face()).unwrap();
                assert_eq!(solid.mesh().triangles.len(), 2 + added(around, features));
                let cut: f64 = features.holes().map(|hole| hole.meridian.volume()).sum();
                let off = solid.check().volume_mm3 - (body - cut);
                assert!(off > 1e-5 && off <= features.chords_mm3() + 1e-6, "{off}");
            }
        }
    }

    #[test]
    fn blind_holes_that_touch_are_refused() {
        let hole = |x: f64| BlindHole {
            hole: Hole::plain(DVec2::new(x, 0.0), 0.5),
            depth_mm: 0.6,
            bottom: HoleBottom::DrillPoint,
        };
        for blind in [[hole(0.0), hole(0.4)], [hole(0.9), hole(0.0)]] {
            let features = PartFeatures { blind_holes: &blind, ..PartFeatures::NONE };
            let found = Solid::from_face(&tests::face(), features, Precision::Double);
            assert!(matches!(found, Err(SolidError::BorderTriangulation { .. })), "{found:?}");
        }
    }
}
