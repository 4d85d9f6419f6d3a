//! The slope field of a camera and a target, whatever the projection.

use super::{Target, stereographic};
use crate::geom::Chart;
use crate::num::Scalar;

/// Slope field: turns a wanted direction into the slope, in camera coordinates, of a mirror that shows it.
#[derive(Debug, Clone, Copy)]
pub struct SlopeField<'a> {
    /// The camera.
    pub chart: &'a Chart,
    /// Surface that the picture shows.
    pub target: &'a Target,
    /// Z of the target's origin, mm.
    pub origin_mm: f64,
}

impl SlopeField<'_> {
    /// The field s (docs/theory.md, T12) at height `f` mm over image point `q` where direction
    /// `wanted` from the target's origin is to be seen. For targets at infinity it does not depend
    /// on f.
    #[inline]
    pub fn slope_for<S: Scalar>(&self, q: [S; 2], f: S, wanted: [S; 2]) -> [S; 2] {
        let seen = match self.target {
            Target::Infinity => wanted,
            target => {
                let [x, y, z] = self.chart.position(q, f);
                target.direction_at([x, y, z - self.origin_mm], wanted)
            }
        };
        let camera = stereographic::towards_camera(self.chart.tangent(q));
        self.chart.chart_slope(q, stereographic::slope_between(camera, seen))
    }

    /// W . curl W / |W|^2, 1/mm, at height `f` over image point `q` where the field is `s` and its
    /// derivatives along X, Y and the height are `along`.
    ///
    /// In chart coordinates W is the form df - s . dq; its exterior product with its own derivative
    /// is the integrand, and the chart's map gives the volume and the length of W.
    #[inline]
    pub fn curl<S: Scalar>(&self, q: [S; 2], f: S, s: [S; 2], along: [[S; 2]; 3]) -> S {
        Self::twist(s, along) / self.curl_denominator(q, f, s)
    }

    /// Numerator of the curl, 1/mm, of a field `s` whose derivatives along X, Y and the height are `along`.
    #[inline]
    pub fn twist<S: Scalar>(s: [S; 2], along: [[S; 2]; 3]) -> S {
        let [x, y, h] = along;
        y[0] - x[1] + s[1] * h[0] - s[0] * h[1]
    }

    /// Denominator of the curl, by which a twist of the field is divided.
    #[inline]
    pub fn curl_denominator<S: Scalar>(&self, q: [S; 2], f: S, s: [S; 2]) -> S {
        let upwards = self.chart.normal_scale(q, s);
        let size = s[0].square() + s[1].square() + upwards.square();
        (f * -self.chart.vergence).exp() * size
    }
}
