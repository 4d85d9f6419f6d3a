//! The slope error that a picture bears: what a slope tolerance of the mirror may be.

use super::engine::Engine;

impl Engine {
    /// The largest random slope error with which the picture, that of the design included, stays within `rms_px` in RMS, mrad:
    /// RMS over the mirror of the angle by which its normals are turned, in no preferred direction, by first derivatives at the
    /// samples (docs/theory.md, T110). None where the design leaves nothing of the limit.
    #[must_use]
    pub fn slope_limit(&self, rms_px: f64) -> Option<f64> {
        let count = self.system.samples.len() as f64;
        let designed = self.base.iter().map(|d| d * d).sum::<f64>() / count;
        let places = self.system.samples.iter().zip(self.linear.by_form());
        let per_radian = places.map(|(sample, [_, x, y])| turned_square(sample.slope, [*x, *y]));
        let room = rms_px * rms_px - designed;
        let limit = 1e3 * (room / (per_radian.sum::<f64>() / count)).sqrt();
        (room > 0.0 && limit.is_finite()).then_some(limit)
    }
}

/// Mean square of the displacement, px^2, of a normal that is turned by one radian, in all directions, where the surface has such
/// slopes and its slopes along X and Y displace by `x` and `y`: what turns it up or down the slope changes
/// the slope by the secant's square, what turns it sideways by the secant.
fn turned_square([p, q]: [f64; 2], [x, y]: [[f64; 2]; 2]) -> f64 {
    let square = p * p + q * q;
    let steep = square.sqrt();
    let [along, across] = if steep > 0.0 { [p / steep, q / steep] } else { [1.0, 0.0] };
    let secant = 1.0 + square;
    let moved = |a: f64, b: f64| {
        let d = [0, 1].map(|i| a * x[i] + b * y[i]);
        d[0] * d[0] + d[1] * d[1]
    };
    0.5 * (secant * secant * moved(along, across) + secant * moved(-across, along))
}

#[cfg(test)]
mod tests {
    use crate::design::design;
    use crate::geom::{DVec2, DVec3, Outline};
    use crate::num::{cos, sin};
    use crate::pipeline::load;
    use crate::tolerance::{Engine, ToleranceSpec};

    /// Normals that are turned by the limit in evenly spread directions, and reflect as the law of reflection says, show a
    /// picture that is at the accepted error, design included.
    #[test]
    fn normals_turned_by_the_limit_use_up_what_is_accepted() {
        for name in ["conquistador", "hyperbolic", "driver", "webcam"] {
            let profile = load(name).unwrap();
            let design = design(&profile).unwrap();
            let round = matches!(design.mirror.outline, Outline::Ring { .. });
            let view = design.view.as_ref().unwrap();
            let spec = ToleranceSpec::of_form(&profile, round);
            let engine = Engine::new(&design.mirror, &design.camera, view, spec).unwrap();
            let accepted = profile.acceptance_limits().pixel_error_rms_px.value;
            let limit = engine.slope_limit(accepted).unwrap();
            let (mut sum, mut count) = (0.0, 0.0);
            // (A hundredth of the limit: second derivatives are another matter.)
            let share = 0.01;
            for sample in &engine.system.samples {
                let [p, q] = sample.slope;
                let normal = DVec3::new(-p, -q, 1.0).normalize();
                let sideways = normal.any_orthonormal_vector();
                let towards = (design.camera.chart.pupil().map(|pupil| pupil - sample.hit))
                    .unwrap_or(DVec3::Z)
                    .normalize();
                let shows = |normal: DVec3| {
                    let direction = 2.0 * normal.dot(towards) * normal - towards;
                    view.image_of(sample.hit, direction, sample.point)
                };
                let designed = shows(normal);
                assert!(designed.distance(sample.content) < 1e-6, "{name}");
                for k in 0..8 {
                    let angle = std::f64::consts::TAU * (f64::from(k) + 0.3) / 8.0;
                    let way = cos(angle) * sideways + sin(angle) * normal.cross(sideways);
                    let turn = share * 1e-3 * limit;
                    let off: DVec2 = shows(cos(turn) * normal + sin(turn) * way) - designed;
                    sum += (off / (share * design.camera.pixel_mm)).length_squared();
                    count += 1.0;
                }
            }
            let base = engine.nominal().rms_px;
            let reached = (base * base + sum / count).sqrt();
            assert!((reached / accepted - 1.0).abs() < 1e-3, "{name}: {reached} of {accepted}");
        }
    }
}
