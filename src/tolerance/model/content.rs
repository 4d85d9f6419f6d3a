//! Tracing a pixel's ray through a perturbed system to the image point of what it sees.

use super::super::form_field::add_scaled;
use super::super::local_polynomial::values;
use super::super::work_counts::{WorkCounts, WorkKind};
use super::sample::PixelSample;
use super::state::{PartPose, PerturbedState};
use super::system::{OpticalSystem, is_plain};
use crate::geom::{Chart, DVec2};
use crate::num::{Arithmetic, Dual, Scalar};
use crate::optics::stereographic;
use crate::tolerance_terms::Misalignment;
use glam::DMat2;

/// Steps of Newton's method at most.
pub(super) const MOST_STEPS: usize = 40;
/// Step, mm, after which the place is known to rounding.
pub(super) const LAST_STEP: f64 = 1e-8;

impl OpticalSystem {
    /// The image point, mm, where the content belongs that the pixel of `sample` sees. Not finite
    /// where the ray is lost: it does not meet the surface, which goes on beyond the rim, within the
    /// mirror's size of where it does as designed, or terraces reflect most of the light.
    pub(crate) fn content<S: Scalar>(
        &self,
        sample: &PixelSample,
        pose: &PartPose<S>,
        state: &PerturbedState<S>,
        work: &mut WorkCounts,
    ) -> [S; 2] {
        work.count(WorkKind::Rays, [1, 0]);
        let zeros = state.form.iter().filter(|a| **a == 0.0).count();
        work.count(WorkKind::Forms, [state.form.len() - zeros, zeros]);
        self.trace_content(sample, pose, state, work, |at| {
            self.form_errors(&state.form, &sample.site.footprint, at)
        })
    }

    /// Displacement of content, mm, by a height of 1 mm and a slope of 1 along X and along Y added to
    /// the designed surface where `sample` sees it: x and y of each.
    pub(crate) fn by_form(&self, sample: &PixelSample, work: &mut WorkCounts) -> [[f64; 2]; 3] {
        let state = PerturbedState::<Dual<3>>::perfect(self.fields.len());
        let pose = PartPose::new(&state.misalignment);
        let plane = [0, 1, 2].map(|k| Dual::<3>::variable(0.0, k));
        work.count(WorkKind::Rays, [1, 0]);
        let [x, y] = self.trace_content(sample, &pose, &state, work, |at| {
            let [dx, dy] = [at[0] - sample.hit.x, at[1] - sample.hit.y];
            [plane[0] + plane[1] * dx + plane[2] * dy, plane[1], plane[2]]
        });
        [0, 1, 2].map(|k| [x.slope[k], y.slope[k]])
    }

    /// Image point, mm, of the content, with the form errors `form`.
    fn trace_content<S: Scalar>(
        &self,
        sample: &PixelSample,
        pose: &PartPose<S>,
        state: &PerturbedState<S>,
        work: &mut WorkCounts,
        form: impl Fn([S; 2]) -> [S; 3],
    ) -> [S; 2] {
        match self.trace_ray(sample, pose, state, work, form) {
            Some((at, leaving)) => self.image_of_reflected(sample.point, at, leaving),
            None => [S::constant(f64::NAN); 2],
        }
    }

    /// Place on the made part, mm, and direction from there, of any length, of the ray that the pixel of `sample` sees, both in the world;
    /// none where the ray is lost.
    pub(crate) fn leaving_ray<S: Scalar>(
        &self,
        sample: &PixelSample,
        pose: &PartPose<S>,
        state: &PerturbedState<S>,
        work: &mut WorkCounts,
    ) -> Option<([S; 3], [S; 3])> {
        work.count(WorkKind::Rays, [1, 0]);
        self.trace_ray(sample, pose, state, work, |at| {
            self.form_errors(&state.form, &sample.site.footprint, at)
        })
    }

    /// The same with the form errors `form`: height and slopes over (X, Y).
    fn trace_ray<S: Scalar>(
        &self,
        sample: &PixelSample,
        pose: &PartPose<S>,
        state: &PerturbedState<S>,
        work: &mut WorkCounts,
        form: impl Fn([S; 2]) -> [S; 3],
    ) -> Option<([S; 3], [S; 3])> {
        let surface = |[x, y, z]: [S; 3]| {
            let at = [x, y];
            let designed = match &sample.base {
                Some((degree, c)) if sample.square.holds(at) => {
                    work.count(WorkKind::Surface, [0, 1]);
                    values(*degree, c, &sample.square, at)
                }
                _ => {
                    work.count(WorkKind::Surface, [1, 0]);
                    self.designed(&self.panels[sample.panel], at, z.mid())
                }
            };
            self.add_textures(add_scaled(designed, 1.0, form(at)), state, at, &sample.site)
        };
        // Most of the light goes where flat tops send it: there is no picture.
        if state.terraced > 0.5 {
            return None;
        }
        let (from, along) = self.ray_in_part(sample, &state.misalignment, pose);
        let (at, slope) = meet(sample, self.farthest, (from, along), surface)?;
        // Of terraces the flat tops reflect.
        let slope = slope.map(|p| p * (1.0 - state.terraced));
        Some(reflected(pose, at, along, slope))
    }

    /// The camera's ray through the pixel in the frame of the part, before that is grown.
    #[inline]
    pub(super) fn ray_in_part<S: Arithmetic>(
        &self,
        sample: &PixelSample,
        misalignment: &Misalignment<S>,
        pose: &PartPose<S>,
    ) -> ([S; 3], [S; 3]) {
        let (origin, along) = self.ray(sample, misalignment);
        let from: [S; 3] = std::array::from_fn(|k| origin[k] - pose.shift[k]);
        (pose.to_part(from).map(|x| x / pose.scale), pose.to_part(along))
    }

    /// The camera's ray through the pixel: a point of it and its direction, of any length.
    #[inline]
    pub(crate) fn ray<S: Arithmetic>(
        &self,
        sample: &PixelSample,
        misalignment: &Misalignment<S>,
    ) -> ([S; 3], [S; 3]) {
        let (m, q) = (misalignment, sample.point);
        let far = q.length_squared() / (self.half_width * self.half_width);
        let grown = m.magnification + m.distortion * far + 1.0;
        let [coma_x, coma_y] = coma_shift(q, self.half_width).map(|shift| m.coma * shift);
        let seen =
            [grown * q.x + m.principal_x_mm + coma_x, grown * q.y + m.principal_y_mm + coma_y];
        let Chart { vergence: k, plane_mm, lean: b } = self.camera.chart;
        let on_chart = self.on_chart(sample, seen);
        let down = S::constant(-1.0);
        let leaning = |along: [S; 2]| match b {
            DVec2::ZERO => along,
            b => [along[0] - b.x, along[1] - b.y],
        };
        if k == 0.0 {
            let lean = m.telecentricity_rad / self.half_width;
            let [x, y] = leaning([lean * q.x, lean * q.y]);
            ([on_chart[0], on_chart[1], S::constant(plane_mm)], [x, y, down])
        } else {
            let [x, y] = leaning(on_chart.map(|q| q * k));
            ([b.x / k, b.y / k, plane_mm + 1.0 / k].map(S::constant), [x, y, down])
        }
    }

    /// The chart coordinates of an image point near that of `sample`: to the first order, which is exact but for a
    /// camera off the axis or with distortion, and there to a share of a pixel.
    #[inline]
    fn on_chart<S: Arithmetic>(&self, sample: &PixelSample, seen: [S; 2]) -> [S; 2] {
        if self.camera.picture.is_identity() {
            return seen;
        }
        let [dx, dy] = [seen[0] - sample.point.x, seen[1] - sample.point.y];
        let (DMat2 { x_axis: a, y_axis: b }, q) = (sample.sight.along, sample.sight.on_chart);
        [dx * a.x + dy * b.x + q.x, dx * a.y + dy * b.y + q.y]
    }

    /// [`ImagingTask::locate`] for all kinds of numbers.
    pub(crate) fn image_of_reflected<S: Scalar>(
        &self,
        near: DVec2,
        at: [S; 3],
        leaving: [S; 3],
    ) -> [S; 2] {
        let flip = if self.view.reflects(near) { -1.0 } else { 1.0 };
        let from = [at[0], at[1] * flip, at[2] - self.view.origin_mm];
        let sigma = stereographic::sigma([leaving[0], leaving[1] * flip, leaving[2]]);
        let seen = self.view.target.direction_from_origin(from, sigma);
        let [x, y] = self.view.projection.image_of(seen, DVec2::new(near.x, near.y * flip));
        [x, y * flip]
    }
}

/// Where light that comes `along` meets the made part, and its direction from there, both in the world: `at`
/// and `slope` are those of the part before it is grown.
#[inline]
pub(super) fn reflected<S: Arithmetic>(
    pose: &PartPose<S>,
    at: [S; 3],
    along: [S; 3],
    slope: [S; 2],
) -> ([S; 3], [S; 3]) {
    // d - n (2 d . n / n . n) with n = (-slope, 1).
    let across = along[2] - along[0] * slope[0] - along[1] * slope[1];
    let twice = across * 2.0 / (slope[0] * slope[0] + slope[1] * slope[1] + 1.0);
    let leaving = [along[0] + slope[0] * twice, along[1] + slope[1] * twice, along[2] - twice];
    let at = pose.to_world(at.map(|x| x * pose.scale));
    (std::array::from_fn(|k| at[k] + pose.shift[k]), pose.to_world(leaving))
}

/// Parameter at which a line meets the tangent plane of the designed mirror where `sample` sees it.
#[inline]
pub(super) fn meet_tangent<S: Arithmetic>(
    sample: &PixelSample,
    (from, along): ([S; 3], [S; 3]),
) -> S {
    let (hit, p) = (sample.hit, sample.slope);
    let rate = along[2] - along[0] * p[0] - along[1] * p[1];
    let below = from[2] - hit.z - (from[0] - hit.x) * p[0] - (from[1] - hit.y) * p[1];
    -below / rate
}

/// Shift of image point `q`, mm, by a coma of 1 along X: that of a lens whose elements are decentred, which
/// moves the chief ray as p (3 x^2 + y^2, 2 x y) (A. E. Conrady, *Decentred lens-systems*, 1919; D. C. Brown,
/// *Decentering distortion of lenses*, 1966, his p1). It is the derivative of third-order radial distortion
/// by a shift of its centre. With p = 1 / (3 w), it is w at (w, 0), and a third of that at (0, w).
fn coma_shift(q: DVec2, half_width: f64) -> [f64; 2] {
    let p = 1.0 / (3.0 * half_width);
    [p * (3.0 * q.x * q.x + q.y * q.y), p * 2.0 * q.x * q.y]
}

/// Intersection of a line with `surface`, which is told the places of the line, and the slope there: Newton's method from the sample's own hit, no
/// farther from that than `farthest`.
#[inline]
fn meet<S: Scalar>(
    sample: &PixelSample,
    farthest: f64,
    (from, along): ([S; 3], [S; 3]),
    mut surface: impl FnMut([S; 3]) -> [S; 3],
) -> Option<([S; 3], [S; 2])> {
    let hit = sample.hit;
    let mut t = meet_tangent(sample, (from, along));
    // The step before and the slope before it.
    let mut last: Option<(S, [S; 2])> = None;
    for _ in 0..MOST_STEPS {
        let [x, y, z] = [0, 1, 2].map(|k| from[k] + along[k] * t);
        // Nor is what is not a number near.
        let near = |x: S, hit: f64| (x.mid() - hit).abs() <= farthest;
        if !(near(x, hit.x) && near(y, hit.y)) {
            return None;
        }
        let [f, f_x, f_y] = surface([x, y, z]);
        let step = (z - f) / (along[2] - along[0] * f_x - along[1] * f_y);
        t = t - step;
        if step.mid().abs() < LAST_STEP {
            let at = [0, 1, 2].map(|k| from[k] + along[k] * t);
            if let (true, Some((before, [p, q]))) = (is_plain::<S>(), last) {
                // So short a step changes the slope as the one before did.
                let more: S = step / before;
                return Some((at, [f_x + (f_x - p) * more, f_y + (f_y - q) * more]));
            }
            let [_, f_x, f_y] = surface(at);
            return Some((at, [f_x, f_y]));
        }
        last = Some((step, [f_x, f_y]));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coma_is_what_decentring_makes_of_radial_distortion() {
        let w = 30.0;
        assert_eq!(coma_shift(DVec2::new(w, 0.0), w), [w, 0.0]);
        assert_eq!(coma_shift(DVec2::new(0.0, w), w), [w / 3.0, 0.0]);
        let distorted = |q: DVec2| q * q.length_squared();
        for q in [DVec2::new(11.0, -7.0), DVec2::new(-3.0, 20.0)] {
            // A cubic: central differences are exact up to the square of the step.
            let h = 1e-3;
            let moved = (distorted(q + DVec2::X * h) - distorted(q - DVec2::X * h)) / (2.0 * h);
            let off = DVec2::from_array(coma_shift(q, w)) - moved / (3.0 * w);
            assert!(off.length() < 1e-7, "{q}: {off}");
        }
    }
}
