//! Scallops: what a ball leaves between neighbouring lines of a raster.
//!
//! The ball of radius R touches the mirror along straight lines of the plan (X, Y), `stepover_mm`
//! apart. Its sweep along one line is a pipe that touches the mirror along that line, so both
//! graphs have the same slope there, and their Hessians differ in one direction alone, square to
//! the line in the plan (unit vector b): H_pipe = H + s b b^T. A pipe is bent by 1/R about its axis; with
//! M = H / g - I / R for the first fundamental form I and g = sqrt(1 + |p|^2) that is
//! det(M + (s / g) b b^T) = 0, hence
//!
//! ```text
//! s = g det M / -(a . M a)          a: along the line, unit length, in the plan
//! ```
//!
//! The slope's error at distance u from the line is s u b: uniform over +-s w / 2. Square to the mirror the
//! lines are W = w g / sqrt(1 + (p . a)^2) apart (w / cos of the slope across the feed, where there is
//! none along it), and the scallop is that of a ball of radius r over a plane, 1/r = 1/R + k - R t^2 / (1 + R m),
//! where k and m are the mirror's normal curvatures across and along the line, positive where it bulges
//! towards the tool, and t its torsion along it (docs/theory.md, T75): 1/(1/R + k) where the line
//! follows a line of curvature.

use crate::geom::DVec2;
use crate::mirror::LocalSurface;
use crate::num::{cos, sin};

/// A raster of straight lines in the plan, cut with a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BallRaster {
    /// Radius of the ball, mm.
    pub ball_mm: f64,
    /// Distance of the lines in the plan (X, Y), mm.
    pub stepover_mm: f64,
    /// Direction of the lines, radians from X towards Y.
    pub angle: f64,
}

impl BallRaster {
    /// Unit vector along the lines.
    #[must_use]
    pub fn along(&self) -> DVec2 {
        let turn = DVec2::new(cos(self.angle), sin(self.angle));
        // A quarter turn is exact.
        let zero = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
        DVec2::new(zero(turn.x), zero(turn.y))
    }
}

/// The scallops near one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scallop {
    /// s, 1/mm: change of the slope's error for each mm across the lines, in the plan.
    pub slope_rate: f64,
    /// W / w: distance of the lines on the mirror for each mm in the plan.
    pub apart: f64,
    /// r, mm: the ball that would leave the same over a plane.
    pub radius_mm: f64,
}

impl Scallop {
    /// Of a ball that touches along `along`; none where it does not fit.
    #[must_use]
    pub fn new(place: &LocalSurface, ball_mm: f64, along: DVec2) -> Option<Self> {
        let m = place.relative_curvature(ball_mm);
        let sunk = -along.dot(m.times(along));
        let det = m.det();
        if !(sunk > 0.0 && det > 0.0) {
            return None;
        }
        let g = place.stretch();
        let lean = place.slope.dot(along);
        let line = 1.0 + lean * lean;
        let slope_rate = g * det / sunk;
        Some(Self {
            slope_rate,
            apart: g / line.sqrt(),
            radius_mm: g * g * g / (slope_rate * line),
        })
    }

    /// Height of the cusps over the mirror, square to it, mm; none where neighbouring cuts do not meet.
    #[must_use]
    pub fn height_mm(&self, stepover_mm: f64) -> Option<f64> {
        let half = 0.5 * self.apart * stepover_mm;
        let square = self.radius_mm * self.radius_mm - half * half;
        // r - sqrt(r^2 - W^2 / 4) without its cancellation.
        (square >= 0.0).then(|| half * half / (self.radius_mm + square.sqrt()))
    }

    /// The stepover that leaves cusps of this height, mm.
    #[must_use]
    pub fn stepover_mm(&self, height_mm: f64) -> f64 {
        let height = height_mm.min(self.radius_mm);
        2.0 * (height * (2.0 * self.radius_mm - height)).sqrt() / self.apart
    }

    /// The largest error of the slope, in the plan.
    #[must_use]
    pub fn slope(&self, stepover_mm: f64) -> f64 {
        0.5 * self.slope_rate * stepover_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::mirror::Hessian;
    use crate::num::{atan, tan};

    fn place(slope: [f64; 2], [xx, xy, yy]: [f64; 3]) -> LocalSurface {
        let (at, hessian) = (DVec3::ZERO, Hessian { xx, xy, yy });
        LocalSurface { at, slope: DVec2::from_array(slope), hessian }
    }

    #[test]
    fn a_plane_has_the_shop_formula_on_the_slope_too() {
        let (ball, w) = (3.0, 0.4);
        let flat = Scallop::new(&place([0.0; 2], [0.0; 3]), ball, DVec2::X).unwrap();
        let exact = ball - f64::sqrt(ball * ball - w * w / 4.0);
        assert!((flat.height_mm(w).unwrap() - exact).abs() < 1e-15);
        assert!((flat.slope(w) - w / (2.0 * ball)).abs() < 1e-15);
        assert!((flat.stepover_mm(exact) - w).abs() < 1e-12);
        // Sloping across the feed, lines are w / cos apart; along it, w.
        let tilt = 0.7;
        for (along, apart) in [(DVec2::X, 1.0), (DVec2::Y, 1.0 / crate::num::cos(tilt))] {
            let found = Scallop::new(&place([tan(tilt), 0.0], [0.0; 3]), ball, along).unwrap();
            assert!((found.apart - apart).abs() < 1e-14 && (found.radius_mm - ball).abs() < 1e-13);
        }
    }

    #[test]
    fn a_cylinder_counts_across_its_rulings_alone_and_with_its_sign() {
        let ball = 3.0;
        for (bulge, sign) in [(-1.0 / 20.0, 1.0), (1.0 / 20.0, -1.0)] {
            // Bent along Y.
            let place = place([0.0; 2], [0.0, 0.0, bulge]);
            let radius = |along| Scallop::new(&place, ball, along).unwrap().radius_mm;
            assert!((radius(DVec2::X) - 1.0 / (1.0 / ball + sign / 20.0)).abs() < 1e-14);
            assert!((radius(DVec2::Y) - ball).abs() < 1e-14);
        }
        assert_eq!(Scallop::new(&place([0.0; 2], [0.0, 0.0, 0.4]), ball, DVec2::X), None);
    }

    /// Neighbouring balls on a sphere, a plane section through its centre: the cusp's distance from
    /// the centre is (rho + R) cos t - sqrt(R^2 - (rho + R)^2 sin^2 t) for half the angle t between them.
    #[test]
    fn a_sphere_meets_its_closed_form_to_fourth_order() {
        let ball: f64 = 3.0;
        for rho in [20.0f64, -20.0] {
            let place = place([0.0; 2], [-1.0 / rho, 0.0, -1.0 / rho]);
            let scallop = Scallop::new(&place, ball, DVec2::X).unwrap();
            let off = |w: f64| {
                let t = atan(0.5 * w / rho.abs());
                let far = (rho + ball).abs();
                let root = (ball * ball - far * far * sin(t) * sin(t)).sqrt();
                let height = if rho > 0.0 {
                    far * cos(t) - root - rho
                } else {
                    -rho - (far * cos(t) + root)
                };
                (scallop.height_mm(w).unwrap() - height).abs()
            };
            assert!(off(0.4) < 1e-5 && (off(0.4) / off(0.2) / 16.0 - 1.0).abs() < 0.05, "{rho}");
        }
    }

    #[test]
    fn torsion_lets_the_pipe_turn_with_the_ground() {
        // Z = c X Y at the origin, cut along X: k = m = 0, t = c.
        let (ball, c) = (3.0, 0.1);
        let found = Scallop::new(&place([0.0; 2], [0.0, c, 0.0]), ball, DVec2::X).unwrap();
        assert!((1.0 / found.radius_mm - (1.0 / ball - ball * c * c)).abs() < 1e-14);
    }
}
