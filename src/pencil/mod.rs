//! Pencils: the bundle of camera rays that makes one pixel, after the mirror.
//!
//! A pixel sees the world through its chief ray; how the direction turns from pixel to pixel gives
//! the solid angle of a pixel ([`Pencil::solid_angle`]). A lens with an aperture collects a bundle of
//! rays about the chief ray, all of which pass through one point of the plane in focus. The
//! curved mirror spreads them over the world: divided by the turn from pixel to pixel that is an
//! ellipse of blur in the picture ([`BlurEllipse`]).
//!
//! Words: the **aperture** radius A of a pinhole camera is half its entrance pupil's diameter, mm; of
//! a telecentric one, whose pupil is far away, the tangent of the cone's half angle. A pupil point
//! is (X, Y) in the pupil's plane, or the tangent of a ray's angle to the axis. The **focus** phi
//! stands for the plane in focus across the axis: its Z is that of the reference plane less phi for
//! a telecentric camera; for a pinhole its distance from the pupil is 1 / (k phi), k the chart's
//! vergence (0 is infinitely far).
//!
//! With J the derivative of what is seen along the image point, the image point shifts by
//! (K - phi) a for the ray through pupil point a, where J K is the derivative of what is seen along a
//! at phi = 0: the Coddington equations, generalized to any mirror and any incidence. K's two
//! eigenvalues are real, as the rays from a point are the normals of a wave front (Malus and Dupin):
//! they are the foci of the two line images (tangential and sagittal of a sphere).
//!
//! Diffraction is counted by [`Sharpness`] alone. What a rim or a ridge cuts off a bundle is not counted,
//! nor the square of the aperture.

mod blur_ellipse;
mod sensor;
mod sharpness;

pub use blur_ellipse::{BlurEllipse, Quantiles, best_focus, quantiles};
pub use sensor::{map_pencils, map_pencils_sparsely, mirror_symmetric_weights};
pub use sharpness::{ApertureSharpness, Sharpness};

use crate::geom::{Chart, DVec2};
use crate::mirror::LocalSurface;
use crate::num::{Dual, Scalar};
use crate::optics::{Camera, ImagingTask, Target, stereographic};
use glam::DMat2;

/// The first derivatives of what a pixel sees, on its image point and on the pupil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pencil {
    /// What the chief ray shows: direction from the target's origin, a stereographic coordinate.
    pub seen: DVec2,
    /// J, the derivative of `seen` along the image point, 1/mm.
    pub turn: DMat2,
    /// K, the shift of the image point (mm, without the lens's distortion) per pupil point.
    pub focus: DMat2,
}

impl Pencil {
    /// The pencil of image point `image` of `camera`, which sees `quadric` there, in a world as far
    /// away as that of `view` (without one, infinitely). None where the mirror has no scale, as a
    /// plane one under parallel rays, or shows nothing.
    #[must_use]
    pub fn new(
        camera: &Camera,
        view: Option<&ImagingTask>,
        image: DVec2,
        quadric: &LocalSurface,
    ) -> Option<Self> {
        let parallel = camera.chart.vergence == 0.0;
        let Bundle { from, top_mm, tangent } = match camera.picture.is_identity() {
            true => Bundle::on_axis(&camera.chart, image),
            false => Bundle::oblique(camera, image),
        };
        let (at, slope) = quadric.meet(from, top_mm, tangent);
        let direction = stereographic::reflect(stereographic::towards_camera(tangent), slope);
        let seen = match view {
            Some(ImagingTask { target, origin_mm, .. }) if *target != Target::Infinity => {
                target.direction_from_origin([at[0], at[1], at[2] - *origin_mm], direction)
            }
            _ => direction,
        };
        let along = |first: usize| {
            let column = |k: usize| DVec2::new(seen[0].slope[k], seen[1].slope[k]);
            DMat2::from_cols(column(first), column(first + 1))
        };
        let (along_place, along_tangent) = (along(0), along(2));
        let (turn, spread) = match parallel {
            true => (along_place, along_tangent),
            false => (along_tangent * camera.vergence(), along_place),
        };
        let seen = DVec2::new(seen[0].mid(), seen[1].mid());
        let focus = turn.inverse() * spread;
        (seen.is_finite() && turn.is_finite() && focus.is_finite()).then_some(Self {
            seen,
            turn,
            focus,
        })
    }

    /// Solid angle of the world per area of the image, sr/mm^2.
    #[must_use]
    pub fn solid_angle(&self) -> f64 {
        // Stereographic coordinates are conformal.
        let scale = 2.0 / (1.0 + self.seen.length_squared());
        self.turn.determinant().abs() * scale * scale
    }
}

/// The rays through an image point and the points of the aperture, as lines that leave (X, Y) = `from` at the height
/// `top_mm` and move by `tangent` for every mm that they fall. The first two variables are the place, the others
/// the tangent of the ray's angle to the camera's axis: the aperture's points are places for a pinhole camera and
/// angles for a telecentric one, the image's the others.
struct Bundle {
    from: [Dual<4>; 2],
    top_mm: f64,
    tangent: [Dual<4>; 2],
}

impl Bundle {
    /// That of a camera on the part's axis.
    fn on_axis(chart: &Chart, image: DVec2) -> Self {
        let k = chart.vergence;
        let parallel = k == 0.0;
        let top_mm = if parallel { chart.plane_mm } else { chart.plane_mm + 1.0 / k };
        let from = if parallel { image } else { DVec2::ZERO };
        let from = [0, 1].map(|axis| Dual::variable(from[axis], axis));
        let tangent = [0, 1].map(|axis| Dual::variable(k * image[axis], 2 + axis));
        Self { from, top_mm, tangent }
    }

    /// That of a camera beside it: places lie in the plane across its axis through the pupil, or for parallel rays
    /// through the axis' foot on the reference plane.
    fn oblique(camera: &Camera, image: DVec2) -> Self {
        let image = camera.picture.undistorted(image);
        let ([right, up], axis) = (camera.picture.axes(), camera.axis());
        let foot = camera.picture.foot().extend(camera.chart.plane_mm);
        let (origin, place, k) = match camera.chart.pupil() {
            Some(pupil) => (pupil, DVec2::ZERO, camera.vergence()),
            None => (foot, image, 0.0),
        };
        let [x, y]: [Dual<4>; 2] = [0, 1].map(|axis| Dual::variable(place[axis], axis));
        let [u, v]: [Dual<4>; 2] = [0, 1].map(|axis| Dual::variable(k * image[axis], 2 + axis));
        let at: [Dual<4>; 3] = [0, 1, 2].map(|i| x * right[i] + y * up[i] + origin[i]);
        let along: [Dual<4>; 3] = [0, 1, 2].map(|i| u * right[i] + v * up[i] - axis[i]);
        let tangent = [0, 1].map(|i| -along[i] / along[2]);
        let above = at[2] - origin.z;
        let from = [0, 1].map(|i| at[i] + tangent[i] * above);
        Self { from, top_mm: origin.z, tangent }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::mirror::Hessian;
    use crate::num::{cos, sin};
    use crate::optics::PictureMap;

    fn on_axis(vergence: f64, plane_mm: f64) -> Camera {
        let chart = Chart::on_axis(vergence, plane_mm);
        Camera { pixels: [1; 2], pixel_mm: 1.0, chart, picture: PictureMap::default() }
    }

    /// A bulging sphere of radius `r` about the origin, at `at` on it.
    fn sphere(r: f64, at: DVec2) -> LocalSurface {
        let z = (r * r - at.length_squared()).sqrt();
        let bend =
            |i: usize, j: usize| -(if i == j { 1.0 } else { 0.0 } + at[i] * at[j] / (z * z)) / z;
        let bend = Hessian { xx: bend(0, 0), xy: bend(0, 1), yy: bend(1, 1) };
        LocalSurface { at: DVec3::new(at.x, at.y, z), slope: -at / z, hessian: bend }
    }

    #[test]
    fn a_sphere_has_its_two_foci_where_coddington_has_them() {
        let r = 25.0;
        for incidence in [0.0, 0.2, 0.5, 1.0] {
            for turn in [0.0, 0.7, 2.0] {
                let at = DVec2::new(cos(turn), sin(turn)) * (r * sin(incidence));
                let sphere = sphere(r, at);
                let camera = on_axis(0.0, 30.0);
                let blur_ellipse =
                    BlurEllipse::new(&Pencil::new(&camera, None, at, &sphere).unwrap());
                let [near, far] = blur_ellipse.foci().map(|phi| sphere.at.z - (30.0 - phi));
                let c = cos(incidence);
                let [tangential, sagittal] = [0.5 * r * c, 0.5 * r / c];
                assert!((near - tangential).abs() < 1e-12 * r, "{incidence}: {near} {tangential}");
                assert!((far - sagittal).abs() < 1e-12 * r, "{incidence}: {far} {sagittal}");
            }
        }
    }

    #[test]
    fn a_sphere_under_a_pinhole_keeps_the_mirror_equation() {
        // On the axis 1 / (distance behind) = 2 / R for a far world; at incidence i with the
        // pinhole off the axis of symmetry the two foci lie along the chief ray.
        let (r, height) = (25.0, 90.0);
        let camera = on_axis(1.0 / height, 0.0);
        for x in [0.0, 6.0, 15.0] {
            let sphere = sphere(r, DVec2::new(x, 0.0));
            let image = DVec2::new(x, 0.0) * (height / (height - sphere.at.z));
            let pencil = Pencil::new(&camera, None, image, &sphere).unwrap();
            let chief = sphere.at - DVec3::new(0.0, 0.0, height);
            let c = -chief.normalize().dot(sphere.at / r);
            // Distances along the chief ray, over its fall per length, from the pinhole.
            let along = |behind: f64| (chief.length() + behind) * -chief.normalize().z;
            let [far, near] = BlurEllipse::new(&pencil).foci().map(|phi| height / phi);
            assert!((near - along(0.5 * r * c)).abs() < 1e-11, "{x}: {near}");
            assert!((far - along(0.5 * r / c)).abs() < 1e-11, "{x}: {far}");
        }
    }

    #[test]
    fn a_sphere_far_away_shows_equal_solid_angles() {
        // Under parallel rays a sphere's world area is R^2 / 4 for each unit of solid angle.
        for x in [0.0, 3.0, 11.0, 20.0] {
            let at = DVec2::new(0.6, -0.8) * x;
            let camera = on_axis(0.0, 0.0);
            let pencil = Pencil::new(&camera, None, at, &sphere(25.0, at)).unwrap();
            assert!((pencil.solid_angle() * 25.0 * 25.0 / 4.0 - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn a_plane_mirror_under_parallel_rays_has_no_pencil() {
        let bend = Hessian { xx: 0.0, xy: 0.0, yy: 0.0 };
        let plane = LocalSurface { at: DVec3::ZERO, slope: DVec2::new(0.2, 0.1), hessian: bend };
        let camera = on_axis(0.0, 0.0);
        assert_eq!(Pencil::new(&camera, None, DVec2::ZERO, &plane), None);
        // Under a pinhole it only moves the world.
        let camera = on_axis(0.01, 0.0);
        let pencil = Pencil::new(&camera, None, DVec2::ZERO, &plane).unwrap();
        assert!(BlurEllipse::new(&pencil).foci().iter().all(|phi| phi.abs() < 1e-15));
    }
}
