//! Cameras, projections, laws and reflection: what the picture should be.

mod azimuthal;
mod bounded_spline;
mod calibration;
mod camera;
mod charted_frame;
mod distortion;
mod framed_view;
mod imaging_task;
mod law;
mod panelled_view;
mod picture_map;
mod posed_target;
mod projection;
mod radial;
mod radial_kind;
mod sampled_map;
mod shown_content;
mod slope_field;
pub mod stereographic;
mod strip;
mod tabulated_law;
mod target;
mod target_mesh;
mod thinned_frame;

pub use azimuthal::{Azimuthal, AzimuthalLaw};
pub use calibration::{Calibration, PixelFault};
pub use camera::{Camera, CameraModel};
pub use charted_frame::ChartedFrame;
pub use distortion::{Distortion, DistortionFault};
pub use framed_view::FramedView;
pub use imaging_task::{CurlBounds, Fold, ImagingTask};
pub use law::StripLaw;
pub use panelled_view::PanelledView;
pub use picture_map::{Mount, PictureMap};
pub use posed_target::{PoseFault, PosedSurface, PosedTarget};
pub use projection::Projection;
pub use radial::RadialLaw;
pub use radial_kind::{RadialLawKind, RimConditions};
pub use sampled_map::{DirectionSamples, MapFault, SampledMap};
pub use shown_content::{ReflectedRay, ShownContent};
pub use slope_field::SlopeField;
pub use strip::Strip;
pub use tabulated_law::TabulatedLaw;
pub use target::Target;
pub use thinned_frame::ThinnedFrame;

use crate::geom::DVec3;

/// The unit direction `d` after reflection at a surface with normal `n` of any length.
#[inline]
#[must_use]
pub fn reflect(d: DVec3, n: DVec3) -> DVec3 {
    d - n * (2.0 * d.dot(n) / n.length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec2;

    #[test]
    fn vertical_reflection_obeys_the_law_of_reflection() {
        for p in [DVec2::new(0.3, -1.7), DVec2::ZERO, DVec2::new(-5.0, 40.0)] {
            let normal = DVec3::new(-p.x, -p.y, 1.0);
            let seen = reflect(DVec3::NEG_Z, normal);
            assert!((seen.length() - 1.0).abs() < 1e-15);
            // Equal angles to the normal, and in one plane with it.
            let incidence = DVec3::Z.dot(normal) - seen.dot(normal);
            assert!(incidence.abs() < 1e-13 * normal.length());
            assert!(DVec3::Z.cross(normal).dot(seen).abs() < 1e-13 * normal.length());
        }
    }

    #[test]
    fn a_slope_error_turns_the_ray_alike_in_every_direction() {
        let (p, step) = (DVec2::new(0.8, -0.4), 1e-7);
        let seen =
            |p: DVec2| stereographic::direction(stereographic::reflect([0.0; 2], p.to_array()));
        let expected = 2.0 * step / (1.0 + p.length_squared());
        for axis in [DVec2::X, DVec2::Y, DVec2::new(0.6, 0.8)] {
            let turned = (seen(p + axis * step) - seen(p)).length();
            assert!((turned / expected - 1.0).abs() < 1e-6);
        }
    }
}
