//! How few triangles can do: the lower bounds that a mesh's size is compared with.

use crate::geom::DVec2;
use crate::mirror::Mirror;
use crate::num::quadrature::gauss_legendre;

/// Integrals over the mirror from which the least numbers of triangles follow, for vertices on
/// the surface and tolerances that go to zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optimum {
    /// Integral of c sqrt |det H| dA, mm: c = 0.3849 on bowls (equilateral triangles), 0.2236 on
    /// saddles.
    curved: f64,
    /// Integral of dA / A, mm^2: A = 1.299 on bowls, 1 on saddles.
    weighted_area: f64,
}

impl Optimum {
    /// Integrates over all panels of `mirror`.
    #[must_use]
    pub fn new(mirror: &Mirror) -> Self {
        const BOWL: [f64; 2] = [0.3849, 1.0 / 1.299];
        const SADDLE: [f64; 2] = [0.2236, 1.0];
        let (nodes, weights) = gauss_legendre(24);
        let (centre, half) = (mirror.panel.centre(), 0.5 * mirror.panel.size());
        let mut total = [0.0; 2];
        for (u, wu) in nodes.iter().zip(&weights) {
            for (v, wv) in nodes.iter().zip(&weights) {
                let det = mirror.sheet.curvature(centre + half * DVec2::new(*u, *v)).det();
                let [chord, facet] = if det > 0.0 { BOWL } else { SADDLE };
                let area = wu * wv * half.x * half.y;
                total[0] += area * chord * det.abs().sqrt();
                total[1] += area * facet;
            }
        }
        let panels = if mirror.folded { 2.0 } else { 1.0 };
        Self { curved: panels * total[0], weighted_area: panels * total[1] }
    }

    /// Least number of triangles for a chord error of `limit` mm.
    #[must_use]
    pub fn chord(&self, limit: f64) -> f64 {
        self.curved / limit
    }

    /// Least number of triangles for a facet error of `limit` mm on the mirror: each triangle
    /// sees one point of the image, and serves the circle around it.
    #[must_use]
    pub fn facet(&self, limit: f64) -> f64 {
        self.weighted_area / (limit * limit)
    }
}
