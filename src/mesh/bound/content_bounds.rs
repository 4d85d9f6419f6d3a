//! Interval bounds of the content of mirror and facets over a box of the chart.

use crate::geom::{Chart, DVec2};
use crate::num::{Interval, Jet2};

/// Value, gradient and Hessian of a function over a box, each an interval.
pub(crate) type IntervalJet = Jet2<Interval>;

/// Bounds of the content over a box: c of the mirror, and c_T of facets.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContentBounds {
    /// Content c of the mirror, mm.
    pub mirror: [IntervalJet; 2],
    /// Content c_T of a facet, mm.
    pub facet: [IntervalJet; 2],
}

impl ContentBounds {
    /// |c''| + |c_T''| (xx, xy, yy), 1/mm.
    pub(crate) fn second(&self) -> [f64; 3] {
        let (mirror, facet) = (second_derivatives(&self.mirror), second_derivatives(&self.facet));
        std::array::from_fn(|k| mirror[k] + facet[k])
    }

    /// |c'|.
    pub(crate) fn first(&self) -> f64 {
        norm(self.mirror.iter().flat_map(|jet| jet.gradient).map(Interval::magnitude))
    }

    /// |c_T - c| from the ranges of both, mm.
    pub(crate) fn difference(&self) -> f64 {
        norm((0..2).map(|k| (self.facet[k].value - self.mirror[k].value).magnitude()))
    }

    /// Whether the mirror's content has a finite range.
    pub(crate) fn is_bounded(&self) -> bool {
        self.mirror.iter().all(|jet| jet.value.is_finite())
    }
}

/// Norms of the second derivatives (xx, xy, yy) of a content, 1/mm.
pub(crate) fn second_derivatives(jets: &[IntervalJet; 2]) -> [f64; 3] {
    std::array::from_fn(|k| norm(jets.iter().map(|jet| jet.hessian[k].magnitude())))
}

/// The Euclidean norm of the given components.
pub(crate) fn norm(components: impl Iterator<Item = f64>) -> f64 {
    components.map(|x| x * x).sum::<f64>().sqrt()
}

/// Ranges of the planes of facets over a box of the chart: Z - plane = a + p . (X, Y).
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacetPlanes {
    /// Range of h, mm.
    pub h: Interval,
    /// Ranges of the gradient of h, which is linear in q.
    pub gradient: [Interval; 2],
    /// Ranges of the slope p, which is the same everywhere on a facet.
    pub slope: [Interval; 2],
}

impl FacetPlanes {
    /// The planes whose gradient of h is in `gradient`, in `chart`, over the box `q`.
    pub(crate) fn of_gradient(
        chart: &Chart,
        q: [Interval; 2],
        h: Interval,
        gradient: [Interval; 2],
    ) -> Self {
        let base = h - (q[0] * gradient[0] + q[1] * gradient[1]);
        let upright = base * chart.vergence + 1.0;
        let scale = match chart.lean {
            DVec2::ZERO => upright,
            lean => upright + (gradient[0] * lean.x + gradient[1] * lean.y),
        };
        Self { h, gradient, slope: gradient.map(|g| g / scale) }
    }

    /// The planes whose slope is in `slope`, in `chart`, over the box `q`.
    pub(crate) fn of_slope(
        chart: &Chart,
        q: [Interval; 2],
        h: Interval,
        slope: [Interval; 2],
    ) -> Self {
        let (fall, k) = (chart.fall(q, slope), chart.vergence);
        Self { h, gradient: slope.map(|p| p * (h * k + 1.0) / fall), slope }
    }
}

/// The ranges of x and y in the box from `lo` to `hi`.
pub(crate) fn ranges([lo, hi]: [DVec2; 2]) -> [Interval; 2] {
    [Interval::new(lo.x, hi.x), Interval::new(lo.y, hi.y)]
}
