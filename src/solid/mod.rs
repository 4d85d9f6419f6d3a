//! The solid stage: optical face -> closed body, and the check that a body is one.

mod check;
mod defect;

pub use check::check;
pub use defect::{Check, Defect};

use crate::geom::{DVec3, TriMesh};
use thiserror::Error;

/// A closed, oriented 2-manifold of one piece with positive volume, whose facets all have an area.
/// There is no way to make one that does not pass [`check`].
#[derive(Debug, Clone)]
pub struct Solid {
    mesh: TriMesh,
    check: Check,
    optical: usize,
}

/// How many digits a solid's coordinates carry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// 24 bits: every coordinate is rounded to `f32`.
    Single,
    /// 53 bits: coordinates as designed.
    Double,
}

/// Why a solid could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SolidError {
    /// The rim of the face is not one closed loop.
    #[error("the rim of the optical face is not a single closed loop: {reason}")]
    Rim {
        /// What was found instead.
        reason: String,
    },
    /// The face reaches the base plane or lies below it.
    #[error(
        "the optical face reaches down to Z = {lowest_mm} mm, to or below the base plane Z = 0"
    )]
    Base {
        /// Least Z of the face, mm.
        lowest_mm: f64,
    },
    /// The closed surface is not a solid.
    #[error("not a solid: {}", .0.reasons().join("; "))]
    Check(Check),
}

impl Solid {
    /// Closes `face` (facets counter-clockwise from above, over a convex outline around the
    /// origin) by a vertical skirt down to the base plane Z = 0 and the base. Every rim vertex has
    /// its own base vertex, so nothing meets in the middle of an edge. Facets come in the order
    /// face, skirt, base. The check sees the coordinates as `precision` leaves them.
    ///
    /// # Errors
    /// [`SolidError`] when the rim is no loop, the face touches the base or the result fails
    /// [`check`].
    pub fn from_face(face: &TriMesh, precision: Precision) -> Result<Self, SolidError> {
        let lowest_mm = face.vertices.iter().map(|v| v.z).fold(f64::INFINITY, f64::min);
        if !(lowest_mm > 0.0) {
            return Err(SolidError::Base { lowest_mm });
        }
        let rim = rim(face)?;
        let mut mesh = face.clone();
        let foot = mesh.vertices.len() as u32;
        mesh.vertices.extend(rim.iter().map(|&v| face.vertices[v as usize].truncate().extend(0.0)));
        let centre = mesh.vertices.len() as u32;
        mesh.vertices.push(DVec3::ZERO);
        let count = rim.len();
        for k in 0..count {
            let next = (k + 1) % count;
            let (top, top_next) = (rim[k], rim[next]);
            let (low, low_next) = (foot + k as u32, foot + next as u32);
            mesh.triangles.push([top_next, top, low]);
            mesh.triangles.push([top_next, low, low_next]);
        }
        for k in 0..count {
            let next = (k + 1) % count;
            mesh.triangles.push([centre, foot + next as u32, foot + k as u32]);
        }
        if precision == Precision::Single {
            mesh.vertices.iter_mut().for_each(|v| *v = v.as_vec3().as_dvec3());
        }
        // Only +0.0: a file must not hold one place in two spellings.
        mesh.vertices.iter_mut().for_each(|v| *v += DVec3::ZERO);
        let check = check(&mesh);
        if check.is_solid() {
            Ok(Self { mesh, check, optical: face.triangles.len() })
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
    pub fn check(&self) -> &Check {
        &self.check
    }

    /// The first this many facets are the optical face; the rest are skirt and base.
    #[must_use]
    pub fn optical(&self) -> usize {
        self.optical
    }
}

/// The rim's vertices in order, the face on the left.
fn rim(face: &TriMesh) -> Result<Vec<u32>, SolidError> {
    let broken = |reason: String| SolidError::Rim { reason };
    const NONE: u32 = u32::MAX;
    let mut next = vec![NONE; face.vertices.len()];
    let (mut start, mut length) = (NONE, 0);
    for (from, to) in check::open_edges(face) {
        let known = std::mem::replace(&mut next[from as usize], to);
        if known != NONE {
            return Err(broken(format!("vertex {from} begins two rim edges")));
        }
        start = start.min(from);
        length += 1;
    }
    if start == NONE {
        return Err(broken("it has no rim".into()));
    }
    let mut loop_ = vec![start];
    while loop_.len() <= length {
        let to = next[loop_[loop_.len() - 1] as usize];
        if to == start && loop_.len() == length {
            return Ok(loop_);
        }
        if to == start || to == NONE {
            break;
        }
        loop_.push(to);
    }
    Err(broken(format!("{} of {length} rim edges follow each other", loop_.len())))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square face of two facets at height 2.
    pub(super) fn face() -> TriMesh {
        let vertices = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| DVec3::new(x, y, 2.0));
        TriMesh { vertices: vertices.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] }
    }

    #[test]
    fn a_face_becomes_a_box() {
        let solid = Solid::from_face(&face(), Precision::Double).unwrap();
        assert_eq!(solid.check().volume_mm3, 8.0);
        assert_eq!((solid.check().euler, solid.check().components), (2, 1));
        assert_eq!((solid.mesh().triangles.len(), solid.optical()), (2 + 8 + 4, 2));
    }

    #[test]
    fn a_face_on_the_base_plane_is_refused() {
        let mut low = face();
        low.vertices[2].z = 0.0;
        assert_eq!(
            Solid::from_face(&low, Precision::Double).unwrap_err(),
            SolidError::Base { lowest_mm: 0.0 }
        );
    }

    #[test]
    fn a_face_with_a_hole_is_refused() {
        let ring: Vec<DVec3> = (0..8)
            .map(|k| {
                let corner = face().vertices[k % 4];
                if k < 4 { corner } else { corner * DVec3::new(0.5, 0.5, 1.0) }
            })
            .collect();
        let quad = |k: u32| {
            let n = (k + 1) % 4;
            [[k, n, 4 + n], [k, 4 + n, 4 + k]]
        };
        let holed = TriMesh { vertices: ring, triangles: (0..4).flat_map(quad).collect() };
        assert!(matches!(Solid::from_face(&holed, Precision::Single), Err(SolidError::Rim { .. })));
    }

    #[test]
    fn facets_that_rounding_flattens_are_refused() {
        let mut fine = face();
        fine.vertices.push(DVec3::new(1.0 + 1e-12, 0.0, 2.0));
        fine.triangles.push([1, 4, 2]);
        assert!(Solid::from_face(&fine, Precision::Double).is_ok());
        let Err(SolidError::Check(check)) = Solid::from_face(&fine, Precision::Single) else {
            panic!("not refused")
        };
        assert!(check.reasons()[0].contains("facet 2 "), "{:?}", check.reasons());
    }
}
