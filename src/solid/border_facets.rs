//! The stock around a face: its flat top, side and base, with marks and through holes.

use super::{SolidError, add_polygon, rounded, sides, wall};
use crate::geom::{
    Border, DVec2, Drilled, Land, Precision, TriMesh, TriangulationFault, triangulate_loops,
};

/// A hole's loops at its upper end and in the base, counter-clockwise from above.
type HoleLoops = [Vec<u32>; 2];

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
    let bores = hole_loops(mesh, &land.holes, land.z_mm);
    let inner: Vec<&[u32]> = bores.iter().map(|bore| &bore[0][..]).collect();
    let flat = triangulate_between(mesh, hole, &inner, precision)?;
    mesh.triangles.extend(flat);
    Ok(bores)
}

/// Closes what is open at `feet`, the loop of the face's skirt on the stock's flat top, and at the
/// holes of the land. Circles become polygons with their corners on them, of chords within
/// [`Border::CHORD_MM`].
///
/// # Errors
/// [`SolidError::BorderTriangulation`] when loops touch each other.
pub(super) fn close(
    mesh: &mut TriMesh,
    feet: &[u32],
    stock: &Border,
    of_land: Vec<HoleLoops>,
    precision: Precision,
) -> Result<(), SolidError> {
    let top = stock.top_mm;
    let side = loop_pair(mesh, &stock.contour.polygon(), top);
    let mut holes = hole_loops(mesh, &stock.holes, top);
    let marks: Vec<Vec<u32>> =
        stock.marks.iter().map(|mark| add_polygon(mesh, &mark.polygon(mark.at), top)).collect();

    let upper = holes.iter().map(|hole| &hole[0][..]);
    let inner: Vec<&[u32]> =
        std::iter::once(feet).chain(upper).chain(marks.iter().map(Vec::as_slice)).collect();
    let flat = triangulate_between(mesh, &side[0], &inner, precision)?;
    mesh.triangles.extend(flat);
    for (mark, rim) in stock.marks.iter().zip(&marks) {
        let tip = add_polygon(mesh, &[mark.at], top - mark.radius())[0];
        mesh.triangles.extend(sides(rim).map(|[v, next]| [v, next, tip]));
    }
    holes.extend(of_land);
    for [upper, lower] in &holes {
        let turned = |rim: &[u32]| rim.iter().rev().copied().collect::<Vec<_>>();
        wall(mesh, &turned(upper), &turned(lower));
    }
    wall(mesh, &side[0], &side[1]);
    let lower: Vec<&[u32]> = holes.iter().map(|hole| &hole[1][..]).collect();
    let base = triangulate_between(mesh, &side[1], &lower, precision)?;
    mesh.triangles.extend(base.into_iter().map(|[a, b, c]| [a, c, b]));
    Ok(())
}

/// How many facets [`close`] and [`land`] add, but for the one at each of the feet and at each edge
/// of the land.
pub(super) fn added_facets(stock: &Border) -> usize {
    let corners = |list: &[Drilled]| -> usize {
        list.iter().map(|round| round.polygon(DVec2::ZERO).len()).sum()
    };
    let (side, holes, marks) =
        (stock.contour.polygon().len(), corners(&stock.holes), corners(&stock.marks));
    // A polygon of n corners in all and h holes takes n + 2 h - 2 triangles.
    let flat = side + holes + marks + 2 * (stock.holes.len() + stock.marks.len());
    let base = side + holes + 2 * stock.holes.len() - 2;
    let land = stock.land.as_ref().map_or(0, |land| {
        let (corners, count) = (corners(&land.holes), land.holes.len());
        // In the land, in the base and the walls between them.
        (corners + 2 * count - 2) + (corners + 2 * count) + 2 * corners
    });
    flat + base + marks + 2 * holes + 2 * side + land
}

fn hole_loops(mesh: &mut TriMesh, holes: &[Drilled], top: f64) -> Vec<HoleLoops> {
    holes.iter().map(|hole| loop_pair(mesh, &hole.polygon(hole.at), top)).collect()
}

/// The polygon at the height of the top and in the base.
fn loop_pair(mesh: &mut TriMesh, polygon: &[DVec2], top: f64) -> HoleLoops {
    [top, 0.0].map(|z| add_polygon(mesh, polygon, z))
}

/// The triangles between the loop `outer` and those inside it, counter-clockwise from above.
fn triangulate_between(
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
    use crate::geom::Contour;

    /// A plate 6 by 6 by 1 around the square face 2 by 2 at height 2.
    fn plate(holes: &[[f64; 3]], marks: &[[f64; 3]]) -> Border {
        let drilled = |list: &[[f64; 3]]| {
            let one = |&[x, y, d]: &[f64; 3]| Drilled { at: DVec2::new(x, y), diameter_mm: d };
            list.iter().map(one).collect()
        };
        let contour = Contour::Rect { half: DVec2::splat(3.0), corner_mm: 0.0 };
        Border { contour, top_mm: 1.0, holes: drilled(holes), marks: drilled(marks), land: None }
    }

    fn closed(stock: &Border, precision: Precision) -> Result<Solid, SolidError> {
        Solid::from_face(&tests::face(), Some(stock), precision)
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
            assert_eq!(solid.mesh().triangles.len(), 2 + added(around, Some(&stock)));
            let off = solid.check().volume_mm3 - (stock.volume(4.0) + 8.0);
            assert!(off.abs() <= stock.chords_mm3() + 1e-6 && off.abs() > 1e-5, "{off}");
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
}
