//! Tracks of a ball cutter.

use super::super::form_field::cusp;
use super::sample::TextureSite;
use crate::mirror::Hessian;
use crate::num::Scalar;

/// The tool.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BallCutter {
    /// Radius of the ball, mm.
    pub ball: f64,
    /// The direction in which tracks follow each other.
    pub way: [f64; 2],
}

impl BallCutter {
    /// Curvature of tracks over the mirror, of Z by the distance from the track in the plan, 1/mm, where
    /// the mirror has slope p and second derivatives H. A ball of radius R that touches it there is over
    /// it by half the form M = sqrt(1 + p^2) (I + p p^T) / R - H; a track is the least of all balls along
    /// it. Zero where the ball does not fit.
    pub(crate) fn curvature(&self, [p, q]: [f64; 2], hessian: &Hessian) -> f64 {
        let long = (1.0 + p * p + q * q).sqrt() / self.ball;
        let [xx, xy, yy] = [
            long * (1.0 + p * p) - hessian.xx,
            long * p * q - hessian.xy,
            long * (1.0 + q * q) - hessian.yy,
        ];
        let [a, b] = self.way;
        // Of the track's direction (-b, a); the least over it leaves the determinant over this.
        let along = xx * b * b - 2.0 * xy * a * b + yy * a * a;
        let across = (xx * yy - xy * xy) / along;
        if along > 0.0 && across > 0.0 { across } else { 0.0 }
    }

    /// Height over the mirror of tracks at a site, and the mean of their slope over the footprint
    /// there (of parabolas, which cusps are up to the square of their slope).
    pub(crate) fn cusp<S: Scalar>(
        &self,
        [stepover, phase]: [f64; 2],
        site: &TextureSite,
        at: [S; 2],
    ) -> [S; 3] {
        let across = at[0] * self.way[0] + at[1] * self.way[1];
        let track = (across.mid() / stepover + phase).round() - phase;
        let from_track = across - track * stepover;
        let [height, slope] = cusp(site.groove, from_track);
        let mean = site.footprint.sawtooth(self.way, stepover, from_track);
        let slope = slope + mean * site.groove;
        [height, slope * self.way[0], slope * self.way[1]]
    }
}
