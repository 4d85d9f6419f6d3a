//! Bounds of derivatives over a region of the chart, as the proof of a facet uses them.

use crate::geom::DVec2;
use crate::mirror::UnionBound;
use crate::num::{Interval, Scalar};

/// Bounds of derivatives of mirror and content that hold all over a region.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RegionBounds {
    /// Third derivatives of h (xxx, xxy, xyy, yyy), 1/mm^2.
    pub h_third: [Interval; 4],
    /// mm along the camera's ray per mm of h, at most.
    pub ray_per_h: f64,
    /// |c''| + |c_T''| (xx, xy, yy), 1/mm.
    pub content_second: [f64; 3],
    /// |c''| alone (xx, xy, yy), 1/mm.
    pub mirror_second: [f64; 3],
    /// |c'|.
    pub content_first: f64,
    /// Parallax: distance in the chart between the points where one ray of a camera that is not the chart's meets
    /// mirror and facet, per mm between these.
    pub parallax_rate: f64,
    /// Opposite corners of the box of facet gradients for which `content_second` holds.
    pub gradient_box: [DVec2; 2],
    /// Whether the mirror may show a direction that the image does not have, as the one along the axis.
    pub may_be_on_axis: bool,
}

impl RegionBounds {
    /// The bounds over a region without a mirror.
    pub(crate) const EMPTY: Self = Self {
        h_third: [Interval { lo: f64::INFINITY, hi: f64::NEG_INFINITY }; 4],
        ray_per_h: 0.0,
        content_second: [0.0; 3],
        mirror_second: [0.0; 3],
        content_first: 0.0,
        parallax_rate: 0.0,
        gradient_box: [DVec2::NEG_INFINITY, DVec2::INFINITY],
        may_be_on_axis: false,
    };

    /// The bounds of a round mirror when a region of the X axis, where these hold, is turned about the axis by any
    /// angle whose cosine is at least `cos` and whose sine is at most `sin` in size.
    #[must_use]
    pub(crate) fn turned(&self, [cos, sin]: [f64; 2]) -> Self {
        let (c, s) = (Interval::new(cos, 1.0), Interval::new(-sin, sin));
        let (cc, ss) = (c.square(), s.square());
        // On the axis the other two vanish, as h is even in y.
        let [a, _, b, _] = self.h_third;
        let rest = a - b * 2.0;
        let h_third = [
            c * (cc * a + ss * b * 3.0),
            s * (cc * rest + ss * b),
            c * (ss * rest + cc * b),
            s * (ss * a + cc * b * 3.0),
        ];
        let both = |[xx, xy, yy]: [f64; 3]| {
            [
                xx + sin * (2.0 * xy + sin * yy),
                xy + sin * (xx + yy),
                yy + sin * (2.0 * xy + sin * xx),
            ]
        };
        let content_second = both(self.content_second);
        Self { h_third, content_second, mirror_second: both(self.mirror_second), ..*self }
    }
}

impl UnionBound for RegionBounds {
    fn union(self, other: Self) -> Self {
        let ([lo, hi], [other_lo, other_hi]) = (self.gradient_box, other.gradient_box);
        let larger = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| a[k].max(b[k]));
        Self {
            h_third: std::array::from_fn(|k| self.h_third[k].hull(other.h_third[k])),
            ray_per_h: self.ray_per_h.max(other.ray_per_h),
            content_second: larger(self.content_second, other.content_second),
            mirror_second: larger(self.mirror_second, other.mirror_second),
            content_first: self.content_first.max(other.content_first),
            parallax_rate: self.parallax_rate.max(other.parallax_rate),
            gradient_box: [lo.max(other_lo), hi.min(other_hi)],
            may_be_on_axis: self.may_be_on_axis || other.may_be_on_axis,
        }
    }
}
