//! A vertex of the mesh with the mirror's derivatives and its content.

use crate::geom::{Chart, DVec2, DVec3};

/// A vertex of a facet, with position, height, gradient and content of the mirror there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceVertex {
    /// Coordinates in the mirror's chart, mm.
    pub q: DVec2,
    /// Position in the part frame, mm.
    pub at: DVec3,
    /// Projective height h of the mirror in its chart, mm.
    pub h: f64,
    /// Change of h, on the vertex's own ray, when the mirror is moved to the vertex as single precision rounds it, mm;
    /// 0 in double precision.
    pub rounding: f64,
    /// Gradient of h over q.
    pub gradient: DVec2,
    /// Image point at which the camera sees the vertex, mm.
    pub image: DVec2,
    /// Content: the image point (mm) whose wanted direction the mirror shows here; 0 without an imaging task.
    pub content: DVec2,
}

impl SurfaceVertex {
    /// The mirror's slope (Z_X, Z_Y) at the vertex.
    pub(crate) fn slope(&self, chart: &Chart) -> DVec2 {
        let along = self.gradient / (1.0 + chart.vergence * self.h);
        DVec2::from_array(chart.slope(self.q.to_array(), along.to_array()))
    }

    /// The vertex with [`Self::rounding`] filled in.
    pub(crate) fn with_rounding(self, chart: &Chart) -> Self {
        let slope = self.slope(chart);
        let off = self.at.as_vec3().as_dvec3() - self.at;
        let up =
            (off.z - slope.dot(off.truncate())) / chart.fall(self.q.to_array(), slope.to_array());
        let grow = 1.0 + chart.vergence * self.h;
        Self { rounding: up * grow * grow, ..self }
    }
}
