//! The solid stage: optical face -> closed body, and the check that a body is one.

mod border_facets;
mod cavity;
mod check;
mod defect;
mod skirt;

pub use cavity::HollowSpace;
pub(crate) use check::likely_open_edges;
pub use check::{check, open_edges};
pub use defect::{Defect, OpenBoundary, SolidCheck};
pub use skirt::Rim;

use crate::geom::{DVec2, DVec3, FaceMesh, PartFeatures, Precision, Rect, TriMesh};
use crate::num::sort_by_number;
use crate::parallel;
use skirt::Feet;
use thiserror::Error;

/// A closed, oriented 2-manifold of one piece with positive volume, whose facets all have an area.
/// There is no way to make one that does not pass `check`.
#[derive(Debug, Clone)]
pub struct Solid {
    mesh: TriMesh,
    check: SolidCheck,
    optical: usize,
}

/// Why a solid could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SolidError {
    /// The rim of the face is not one closed loop, or one around another.
    #[error("the rim of the optical face is not one closed loop, or one around another: {reason}")]
    BoundaryLoops {
        /// What was found instead.
        reason: String,
    },
    /// The face reaches the base plane or lies below it.
    #[error(
        "the optical face reaches down to Z = {lowest_mm} mm, to or below the base plane Z = 0"
    )]
    BelowBasePlane {
        /// Least Z of the face, mm.
        lowest_mm: f64,
    },
    /// The face reaches the flat rim around it or lies below it.
    #[error(
        "the optical face reaches down to Z = {lowest_mm} mm, to or below the flat rim at Z = \
         {top_mm} mm"
    )]
    BelowBorder {
        /// Least Z of the face, mm.
        lowest_mm: f64,
        /// Z of the flat rim, mm.
        top_mm: f64,
    },
    /// Loops in the flat rim or the base touch each other in the digits of the file.
    #[error(
        "the flat rim or the base cannot be cut into facets near X {} mm, Y {} mm: {reason}; take \
         holes and marks further apart, or export obj alone",
        near.x, near.y
    )]
    BorderTriangulation {
        /// Where.
        near: DVec2,
        /// What was found.
        reason: String,
    },
    /// The roof of a cavity cannot be meshed.
    #[error("the roof of the part's cavity cannot be meshed: {reason}")]
    Roof {
        /// Why.
        reason: String,
    },
    /// The closed surface is not a solid.
    #[error("not a solid: {}", .0.reasons().join("; "))]
    Check(SolidCheck),
}

impl Solid {
    /// Closes `face` (facets counter-clockwise from above, over an outline that is star-shaped
    /// about the axis and may have one hole around it) by a skirt along the face's rays down to the base plane
    /// Z = 0 and the base; a hole by a land, a fan of facets to a vertex on the axis at the mean
    /// height of its rim. Every ray of the rim has its own base vertex, so nothing meets in the middle
    /// of an edge. With a border the skirt ends on its flat top, which has holes and
    /// marks, and its side leads to the base. Blind holes open in the base. Facets come in the order face, walls between
    /// panels, land, skirt, flat top, marks, holes, side, base. The check sees the coordinates as `precision` leaves them.
    ///
    /// # Errors
    /// [`SolidError`] when the rim is not of one loop or two, the face touches the base or the
    /// flat top, what is in the flat top touches each other or the result fails `check`.
    pub fn from_face(
        face: &FaceMesh,
        features: PartFeatures,
        precision: Precision,
    ) -> Result<Self, SolidError> {
        Self::hollow(face, PartFeatures { floor: None, ..features }, None, precision)
    }

    /// The same with the cavity `room`, of which `features` have the floor: its facets come before the base.
    ///
    /// # Errors
    /// As [`Solid::from_face`], of the cavity too.
    pub fn hollow(
        face: &FaceMesh,
        features: PartFeatures,
        room: Option<HollowSpace>,
        precision: Precision,
    ) -> Result<Self, SolidError> {
        let lowest_mm = face.vertices.iter().map(|v| v.z).fold(f64::INFINITY, f64::min);
        if !(lowest_mm > 0.0) {
            return Err(SolidError::BelowBasePlane { lowest_mm });
        }
        let top_mm = features.foot_mm();
        if !(lowest_mm > top_mm) && !face.may_be_sunk() {
            return Err(SolidError::BelowBorder { lowest_mm, top_mm });
        }
        // A solid shows that no edge of the rim is missing.
        let on_rim = |edges| Self::on_rim(edges, face, (features, room), precision);
        on_rim(likely_open_edges(face)).or_else(|_| on_rim(check::open_edges(face)))
    }

    /// The same with a rim of these edges.
    fn on_rim(
        rim_edges: Vec<(u32, u32)>,
        face: &FaceMesh,
        (features, room): (PartFeatures, Option<HollowSpace>),
        precision: Precision,
    ) -> Result<Self, SolidError> {
        let BoundaryLoops { outer, hole } = boundary_loops(face, rim_edges)?;
        let hole_edges = hole.as_ref().map_or(0, Vec::len);
        let rim = Rim { edges: outer.len(), steps: 0, hole_edges };
        let mut mesh = with_room(face, added(rim, features));
        let land = features.border.and_then(|border| border.land.as_ref());
        let mut bores = Vec::new();
        if let (Some(hole), Some(land)) = (&hole, land) {
            bores = border_facets::land(&mut mesh, hole, land, precision)?;
        } else if let Some(hole) = hole {
            fan(&mut mesh, &hole);
        }
        let feet = Feet::of(face, &outer, features.foot_mm()).skirt(&mut mesh, &outer);
        let drains = border_facets::drains(&mut mesh, features.floor);
        if let Some(room) = room {
            room.add(&mut mesh, &drains, precision)?;
        }
        let blind = features.blind_holes;
        match features.border {
            None if blind.is_empty() && drains.is_empty() => {
                let centre = mesh.vertices.len() as u32;
                mesh.vertices.push(base_centre(&mesh, &feet));
                mesh.triangles.extend(sides(&feet).map(|[low, next]| [centre, next, low]));
            }
            None => border_facets::drill(&mut mesh, &feet, (drains, blind), precision)?,
            Some(border) => {
                bores.extend(drains);
                let holes = (bores, blind);
                border_facets::close(&mut mesh, &feet, border, holes, precision)?;
            }
        }
        parallel::for_each_mut(&mut mesh.vertices, 1 << 14, |_, v| *v = rounded(*v, precision));
        let check = check(&mesh).through(features.through());
        if check.is_solid() {
            Ok(Self { mesh, check, optical: face.optical() })
        } else {
            Err(SolidError::Check(check))
        }
    }

    /// The same body, larger by `factor` about the origin, with the digits of `precision`.
    ///
    /// # Errors
    /// [`SolidError::Check`] when rounding makes it no solid.
    pub fn grown(&self, factor: f64, precision: Precision) -> Result<Self, SolidError> {
        let mut mesh = self.mesh.clone();
        mesh.vertices.iter_mut().for_each(|v| *v = rounded(*v * factor, precision));
        let check = check(&mesh).through(self.check.holes);
        if check.is_solid() {
            Ok(Self { mesh, check, optical: self.optical })
        } else {
            Err(SolidError::Check(check))
        }
    }

    /// Vertices and facets.
    #[must_use]
    pub fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    /// What the check found.
    #[must_use]
    pub fn check(&self) -> &SolidCheck {
        &self.check
    }

    /// The first this many facets are the optical face; the rest are land, skirt, stock and base.
    #[must_use]
    pub fn optical(&self) -> usize {
        self.optical
    }
}

/// How many facets [`Solid::from_face`] adds to a face with such a rim.
#[must_use]
pub fn added(Rim { edges, steps, hole_edges }: Rim, features: PartFeatures) -> usize {
    // With a border, what ends on the rim's feet is the flat top in the place of the base. A step stands on one foot.
    3 * edges - 2 * steps + hole_edges + border_facets::added_facets(features)
}

/// Adds a fan of facets within the loop `hole` around the axis, to a vertex on it at the mean height of the loop.
fn fan(mesh: &mut TriMesh, hole: &[u32]) {
    let centre = mesh.vertices.len() as u32;
    let height: f64 = hole.iter().map(|&v| mesh.vertices[v as usize].z).sum();
    mesh.vertices.push(DVec3::new(0.0, 0.0, height / hole.len() as f64));
    mesh.triangles.extend(sides(hole).map(|[v, next]| [next, v, centre]));
}

/// A copy of `face` with room for so many more facets, and the vertices that they may have.
fn with_room(face: &FaceMesh, more: usize) -> TriMesh {
    let mut mesh = TriMesh {
        vertices: Vec::with_capacity(face.vertices.len() + more),
        triangles: Vec::with_capacity(face.triangles.len() + more),
    };
    mesh.vertices.extend_from_slice(&face.vertices);
    mesh.triangles.extend_from_slice(&face.triangles);
    mesh
}

/// What a file of this precision keeps of a place: only +0.0, for it must not hold one place in two
/// spellings.
fn rounded(v: DVec3, precision: Precision) -> DVec3 {
    let v = if precision == Precision::Single { v.as_vec3().as_dvec3() } else { v };
    v + DVec3::ZERO
}

/// New vertices over `places` at height `z`.
fn add_polygon(mesh: &mut TriMesh, places: &[DVec2], z: f64) -> Vec<u32> {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(places.iter().map(|p| p.extend(z)));
    (first..mesh.vertices.len() as u32).collect()
}

/// A vertical wall from a loop down to one below it; seen from outside it faces those for whom the
/// loop is counter-clockwise from above.
fn wall(mesh: &mut TriMesh, upper: &[u32], lower: &[u32]) {
    for ([top, top_next], [low, low_next]) in sides(upper).zip(sides(lower)) {
        mesh.triangles.push([top_next, top, low]);
        mesh.triangles.push([top_next, low, low_next]);
    }
}

/// The rim of `face` in numbers.
///
/// # Errors
/// [`SolidError::BoundaryLoops`] when it is not of one loop or two.
pub fn rim(face: &FaceMesh) -> Result<Rim, SolidError> {
    let BoundaryLoops { outer, hole } = boundary_loops(face, check::open_edges(face))?;
    let walls = face.wall_edges();
    let steps = sides(&outer).filter(|&[from, to]| walls.contains(&(from, to))).count();
    Ok(Rim { edges: outer.len(), steps, hole_edges: hole.map_or(0, |hole| hole.len()) })
}

/// A place from which the whole base is seen, mm: the axis, or the middle of the rectangle that a camera which leans leaves
/// beside it.
fn base_centre(mesh: &TriMesh, feet: &[u32]) -> DVec3 {
    let feet = feet.iter().map(|&v| mesh.vertices[v as usize].truncate());
    let none = Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
    let bounds = feet.fold(none, |all, p| Rect { min: all.min.min(p), max: all.max.max(p) });
    if bounds.contains(DVec2::ZERO) { DVec3::ZERO } else { bounds.centre().extend(0.0) }
}

/// The sides of a closed loop.
fn sides(vertices: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    let next = vertices.iter().cycle().skip(1);
    vertices.iter().zip(next).map(|(&v, &next)| [v, next])
}

/// The rim's loops: vertices in order, the face on the left.
struct BoundaryLoops {
    outer: Vec<u32>,
    hole: Option<Vec<u32>>,
}

/// The loops of the edges of the rim of `face`.
fn boundary_loops(face: &TriMesh, rim_edges: Vec<(u32, u32)>) -> Result<BoundaryLoops, SolidError> {
    let mut loops = loops(face, rim_edges)?;
    let area = |vertices: &Vec<u32>| -> f64 {
        let at = |v: u32| face.vertices[v as usize].truncate();
        sides(vertices).map(|[v, next]| 0.5 * at(v).perp_dot(at(next))).sum()
    };
    sort_by_number(&mut loops, |vertices| -area(vertices).abs());
    let mut loops = loops.into_iter();
    let (outer, hole, more) = (loops.next(), loops.next(), loops.count());
    let broken = |reason: String| Err(SolidError::BoundaryLoops { reason });
    match outer {
        None => broken("it has no rim".into()),
        Some(_) if more > 0 => broken(format!("it has {} loops", more + 2)),
        Some(outer) if !(area(&outer) > 0.0) || hole.as_ref().is_some_and(|h| area(h) >= 0.0) => {
            broken("its loops do not run around the face".into())
        }
        Some(outer) => Ok(BoundaryLoops { outer, hole }),
    }
}

/// The closed loops of the edges that have a facet on one side only, in the order of their least
/// vertices.
fn loops(face: &TriMesh, rim_edges: Vec<(u32, u32)>) -> Result<Vec<Vec<u32>>, SolidError> {
    let broken = |reason: String| SolidError::BoundaryLoops { reason };
    const NONE: u32 = u32::MAX;
    let mut next = vec![NONE; face.vertices.len()];
    for (from, to) in rim_edges {
        let known = std::mem::replace(&mut next[from as usize], to);
        if known != NONE {
            return Err(broken(format!("vertex {from} begins two rim edges")));
        }
    }
    let mut loops = Vec::new();
    for start in 0..next.len() as u32 {
        let mut at = start;
        let mut vertices = Vec::new();
        while next[at as usize] != NONE {
            vertices.push(at);
            at = std::mem::replace(&mut next[at as usize], NONE);
        }
        if at != start {
            return Err(broken(format!(
                "{} edges lead to vertex {at} and no further",
                vertices.len()
            )));
        }
        if !vertices.is_empty() {
            loops.push(vertices);
        }
    }
    Ok(loops)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square face of two facets at height 2.
    pub(super) fn face() -> FaceMesh {
        square().into()
    }

    fn square() -> TriMesh {
        let vertices = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| DVec3::new(x, y, 2.0));
        TriMesh { vertices: vertices.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] }
    }

    #[test]
    fn a_face_becomes_a_box() {
        let solid = Solid::from_face(&face(), PartFeatures::NONE, Precision::Double).unwrap();
        assert_eq!(solid.check().volume_mm3, 8.0);
        assert_eq!((solid.check().euler, solid.check().components), (2, 1));
        assert_eq!((solid.mesh().triangles.len(), solid.optical()), (2 + 8 + 4, 2));
        let around = Rim { edges: 4, steps: 0, hole_edges: 0 };
        assert_eq!((rim(&face()).unwrap(), added(around, PartFeatures::NONE)), (around, 8 + 4));
    }

    /// A skirt may lead so far to one side that the axis is beside its foot: the base has its facets within the foot all the same.
    #[test]
    fn a_base_beside_the_axis_has_no_facet_turned_over() {
        for away in [0.5, 3.0, -7.0] {
            let feet =
                square().vertices.iter().map(|v| v.truncate() + DVec2::new(away, 0.25)).collect();
            let face = FaceMesh::drafted(square(), feet);
            let solid = Solid::from_face(&face, PartFeatures::NONE, Precision::Double).unwrap();
            let down = solid.mesh().triangles.iter().map(|corners| {
                let [a, b, c] = corners.map(|v| solid.mesh().vertices[v as usize]);
                (a.z == 0.0 && b.z == 0.0 && c.z == 0.0).then(|| (b - a).cross(c - a).z)
            });
            let base: Vec<f64> = down.flatten().collect();
            assert!(base.len() == 4 && base.iter().all(|&area| area < 0.0), "{away}: {base:?}");
        }
    }

    #[test]
    fn a_body_grows_about_the_origin_and_is_checked_again() {
        let solid = Solid::from_face(&face(), PartFeatures::NONE, Precision::Double).unwrap();
        let grown = solid.grown(1.5, Precision::Single).unwrap();
        assert_eq!((grown.check().volume_mm3, grown.optical()), (27.0, 2));
        assert_eq!(grown.mesh().vertices[2], DVec3::new(1.5, 1.5, 3.0));
        let third = solid.grown(1.0 + 1e-4, Precision::Single).unwrap();
        assert_eq!(third.mesh().vertices[2].x, f64::from(1.0001f32));
        assert!(matches!(solid.grown(1e-50, Precision::Single), Err(SolidError::Check(_))));
    }

    #[test]
    fn a_face_on_the_base_plane_is_refused() {
        let mut low = square();
        low.vertices[2].z = 0.0;
        assert_eq!(
            Solid::from_face(&low.into(), PartFeatures::NONE, Precision::Double).unwrap_err(),
            SolidError::BelowBasePlane { lowest_mm: 0.0 }
        );
    }

    /// The face between the square and a smaller one, half as large at `inner` of height 2.5.
    fn holed(inner: DVec3) -> FaceMesh {
        let ring: Vec<DVec3> = (0..8)
            .map(|k| {
                let corner = square().vertices[k % 4];
                if k < 4 { corner } else { corner * DVec3::new(0.5, 0.5, 1.25) + inner }
            })
            .collect();
        let quad = |k: u32| {
            let n = (k + 1) % 4;
            [[k, n, 4 + n], [k, 4 + n, 4 + k]]
        };
        TriMesh { vertices: ring, triangles: (0..4).flat_map(quad).collect() }.into()
    }

    #[test]
    fn a_hole_gets_a_land() {
        for precision in [Precision::Single, Precision::Double] {
            let solid =
                Solid::from_face(&holed(DVec3::ZERO), PartFeatures::NONE, precision).unwrap();
            // A box of height 2 and the frustum of a pyramid of height 1/2.
            let exact = 8.0 + 0.5 / 3.0 * (4.0 + 1.0 + 2.0);
            assert!((solid.check().volume_mm3 - exact).abs() < 1e-12);
            assert_eq!((solid.check().euler, solid.check().components), (2, 1));
            assert_eq!((solid.mesh().triangles.len(), solid.optical()), (8 + 4 + 8 + 4, 8));
            let around = Rim { edges: 4, steps: 0, hole_edges: 4 };
            let found = (rim(&holed(DVec3::ZERO)).unwrap(), added(around, PartFeatures::NONE));
            assert_eq!(found, (around, 4 + 8 + 4));
            for t in 8..12 {
                assert!(solid.mesh().area_vector(t).normalize().z == 1.0);
            }
        }
    }

    #[test]
    fn two_holes_and_open_rims_are_refused() {
        let mut face = holed(DVec3::ZERO).into_panels();
        face.triangles.remove(0);
        let refused = |face: &TriMesh| {
            matches!(
                Solid::from_face(&face.clone().into(), PartFeatures::NONE, Precision::Single),
                Err(SolidError::BoundaryLoops { .. })
            )
        };
        assert!(refused(&face));
        // Apart, two faces have two outer rims.
        let mut two = holed(DVec3::ZERO).into_panels();
        let (count, other) = (two.vertices.len() as u32, holed(DVec3::ZERO));
        two.vertices.extend(other.vertices.iter().map(|&v| v + DVec3::X * 10.0));
        two.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + count)));
        assert!(refused(&two) && refused(&TriMesh::default()));
    }

    #[test]
    fn facets_that_rounding_flattens_are_refused() {
        let mut fine = square();
        fine.vertices.push(DVec3::new(1.0 + 1e-12, 0.0, 2.0));
        fine.triangles.push([1, 4, 2]);
        assert!(
            Solid::from_face(&fine.clone().into(), PartFeatures::NONE, Precision::Double).is_ok()
        );
        let Err(SolidError::Check(check)) =
            Solid::from_face(&fine.clone().into(), PartFeatures::NONE, Precision::Single)
        else {
            panic!("not refused")
        };
        assert!(check.reasons()[0].contains("facet 2 "), "{:?}", check.reasons());
    }
}
