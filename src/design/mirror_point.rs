//! The mirror over given places of the part's plan: height, normal and second derivatives.

use super::Design;
use crate::geom::DVec2;
use crate::parallel;

/// A point of a mirror as the graph Z(X, Y) of the part frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MirrorPoint {
    /// Z, mm over the plane of the part's base.
    pub sag_mm: f64,
    /// Unit normal towards +Z.
    pub normal: [f64; 3],
    /// Second derivatives Z_XX, Z_XY and Z_YY, 1/mm: positive where the surface is hollow, seen from above.
    pub hessian: [f64; 3],
}

/// Places that a thread looks at in turn.
const PLACES: usize = 64;

impl Design {
    /// The mirror's points over places (X, Y), mm of the part frame; none where the mirror is not. Where panels meet
    /// it is a point of one of them.
    ///
    /// ```
    /// # let profile = morion::Profile::parse("part", "part.toml", include_bytes!("../../examples/small.toml"))?;
    /// let points = profile.design()?.points_over(&[[0.0, 0.0], [1e3, 0.0]]);
    /// assert!(points[0].is_some_and(|point| point.sag_mm > 0.0 && point.normal[2] > 0.0));
    /// assert_eq!(points[1], None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn points_over(&self, places: &[[f64; 2]]) -> Vec<Option<MirrorPoint>> {
        parallel::map_slice(places, PLACES, |place| self.point_over(DVec2::from_array(*place)))
    }

    fn point_over(&self, place: DVec2) -> Option<MirrorPoint> {
        let mirror = &self.mirror;
        let chart = mirror.chart.parallel();
        let at = mirror.intersect_camera_ray(&chart, place)?;
        if !mirror.full_outline().contains(at) {
            return None;
        }
        let found = mirror.local_surface(at);
        let hessian = [found.hessian.xx, found.hessian.xy, found.hessian.yy];
        Some(MirrorPoint { sag_mm: found.at.z, normal: found.normal().to_array(), hessian })
    }
}

#[cfg(test)]
mod tests {
    use crate::profile::Profile;

    /// A parabola of revolution Z = top - r^2 / 2 R, seen by parallel rays and by a pinhole.
    #[test]
    fn a_paraboloid_has_the_closed_form_s_sag_normals_and_second_derivatives() {
        let radius_mm = 40.0;
        for camera in ["orthographic.pixels = [640, 480]", PINHOLE] {
            let text = format!(
                "camera.{camera}\npart = {{ width_mm = 30, height_mm = 20, base_mm = 5 }}\n\
                 mirror.polynomial = {{ radius_mm = -{radius_mm}, conic = -1 }}\n\
                 mesh.chord_um = 2\nexport.formats = [\"stl\"]\n"
            );
            let profile = Profile::parse("p", "p.toml", text.as_bytes());
            let design = profile.unwrap_or_else(|e| panic!("{e}")).design().unwrap();
            let places = [[0.0, 0.0], [7.0, -3.5], [-14.9, 9.9], [15.1, 0.0], [f64::NAN, 0.0]];
            let found = design.points_over(&places);
            assert_eq!(found[3..], [None, None]);
            let top_mm = found[0].unwrap().sag_mm;
            for ([x, y], point) in places.into_iter().zip(found).take(3) {
                let point = point.unwrap();
                let sag = top_mm - (x * x + y * y) / (2.0 * radius_mm);
                assert!((point.sag_mm - sag).abs() < 1e-12 * radius_mm, "{x} {y}: {point:?}");
                let slope = [-x / radius_mm, -y / radius_mm];
                let long = (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
                let normal = [-slope[0] / long, -slope[1] / long, 1.0 / long];
                let off = (0..3).map(|k| (point.normal[k] - normal[k]).abs());
                assert!(off.fold(0.0, f64::max) < 1e-12, "{point:?} {normal:?}");
                let bend = [-1.0 / radius_mm, 0.0, -1.0 / radius_mm];
                let off = (0..3).map(|k| (point.hessian[k] - bend[k]).abs());
                assert!(off.fold(0.0, f64::max) < 1e-12, "{point:?}");
            }
        }
    }

    const PINHOLE: &str = "pinhole = { pixels = [640, 480], focal_px = 1200, distance_mm = 200 }";
}
