//! Cross-sections of a part through its axis.

use crate::geom::{DVec2, DVec3, TriMesh};

/// A plane through the part's axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxialPlane {
    /// X = 0: from the picture's foot to its top.
    X0,
    /// Y = 0: across the picture.
    Y0,
}

impl AxialPlane {
    /// Place of a point along the plane's horizontal and vertical axes, mm, and its distance from the plane.
    #[must_use]
    pub fn split(self, at: DVec3) -> (DVec2, f64) {
        match self {
            Self::X0 => (DVec2::new(at.y, at.z), at.x),
            Self::Y0 => (DVec2::new(at.x, at.z), at.y),
        }
    }

    /// Its equation.
    #[must_use]
    pub fn equation(self) -> &'static str {
        match self {
            Self::X0 => "X = 0",
            Self::Y0 => "Y = 0",
        }
    }

    /// Name of its horizontal axis.
    #[must_use]
    pub fn along(self) -> &'static str {
        match self {
            Self::X0 => "Y",
            Self::Y0 => "X",
        }
    }
}

/// Cross-section of a part: edges in no order, by the plane's horizontal axis and Z, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct PartSection {
    /// The plane.
    pub plane: AxialPlane,
    /// The edges.
    pub edges: Vec<[DVec2; 2]>,
}

/// Share of the part's size by which the plane is moved: vertices of symmetric meshes lie on it.
const ASIDE: f64 = 1e-6;

impl PartSection {
    /// The cross-section of `mesh`.
    #[must_use]
    pub fn new(mesh: &TriMesh, plane: AxialPlane) -> Self {
        let size = mesh.bounds().map_or(0.0, |(low, high)| (high - low).max_element());
        let aside = ASIDE * size;
        let cut = |t: usize| {
            let corners = mesh.corners(t).map(|corner| {
                let (at, off) = plane.split(corner);
                (at, off - aside)
            });
            let crossing = |k: usize| {
                let ((a, from), (b, to)) = (corners[k], corners[(k + 1) % 3]);
                ((from < 0.0) != (to < 0.0)).then(|| a.lerp(b, from / (from - to)))
            };
            let mut ends = (0..3).filter_map(crossing);
            Some([ends.next()?, ends.next()?])
        };
        Self { plane, edges: (0..mesh.triangles.len()).filter_map(cut).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_cut_in_a_closed_outline_of_its_size() {
        let corners = [[-3.0, 0.0, 0.0], [3.0, -2.0, 0.0], [3.0, 2.0, 0.0], [0.0, 0.0, 5.0]];
        let mesh = TriMesh {
            vertices: corners.map(DVec3::from_array).to_vec(),
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        };
        for (plane, ends) in [(AxialPlane::X0, [-1.0, 1.0]), (AxialPlane::Y0, [-3.0, 3.0])] {
            let section = PartSection::new(&mesh, plane);
            let points: Vec<DVec2> = section.edges.iter().flatten().copied().collect();
            let range = |f: fn(f64, f64) -> f64, axis: usize| {
                points.iter().map(|at| at[axis]).reduce(f).unwrap()
            };
            assert!((range(f64::min, 0) - ends[0]).abs() < 1e-4);
            assert!((range(f64::max, 0) - ends[1]).abs() < 1e-4);
            assert!((range(f64::max, 1) - 5.0).abs() < 1e-4 && range(f64::min, 1).abs() < 1e-4);
            // Every corner of the outline is the end of two edges.
            for at in &points {
                let near = points.iter().filter(|other| at.distance(**other) < 1e-9).count();
                assert_eq!(near, 2, "{at}");
            }
        }
    }
}
