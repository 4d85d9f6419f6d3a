//! Projections: which direction of the world each image point must see, and back.

use super::{FramedView, PanelledView, RadialLaw, Strip};
use crate::geom::DVec2;
use crate::num::Scalar;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Direction of the world, from the target's origin, that an image point of the designed panel must see: G in
/// the paper.
#[derive(Debug, Clone, PartialEq)]
pub enum Projection {
    /// A straight panorama.
    Strip(Strip),
    /// An axisymmetric law over image radii.
    Radial {
        /// The law.
        law: RadialLaw,
        /// Inner and outer image radius, mm.
        radius: [f64; 2],
    },
    /// A view, or directions given as data, that ends with the frame.
    Framed(FramedView),
    /// Views side by side.
    Panels(Arc<PanelledView>),
}

impl Projection {
    /// Direction that image point `q` must see, as a stereographic coordinate.
    #[inline]
    pub fn direction_of<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        match self {
            Self::Strip(strip) => strip.direction_of(q),
            Self::Radial { law, .. } => law.direction_of(q),
            Self::Framed(view) => view.direction_of(q),
            Self::Panels(views) => views.direction_of(q),
        }
    }

    /// The image point, nearest to `near` where there are several, that must see `sigma`.
    #[inline]
    pub fn image_of<S: Scalar>(&self, sigma: [S; 2], near: DVec2) -> [S; 2] {
        match self {
            Self::Strip(strip) => strip.image_of(sigma, near),
            Self::Radial { law, .. } => law.image_of(sigma),
            Self::Framed(view) => view.image_of(sigma, near),
            Self::Panels(views) => views.image_of(sigma, near),
        }
    }

    /// Whether something is wanted of an image point: of gaps in a map nothing is.
    #[inline]
    #[must_use]
    pub fn wants(&self, image: DVec2) -> bool {
        match self {
            Self::Framed(view) => view.wants(image),
            Self::Panels(views) => views.wants(image),
            Self::Strip(_) | Self::Radial { .. } => true,
        }
    }

    /// Whether straight lines of the world are straight in the picture: whether it is in perspective.
    #[must_use]
    pub fn keeps_lines(&self) -> bool {
        match self {
            Self::Strip(_) | Self::Panels(_) => false,
            Self::Radial { law, .. } => matches!(law, RadialLaw::Plane { .. }),
            Self::Framed(view) => view.keeps_lines(),
        }
    }

    /// The length in mm that is 1 in the paper's units: one radian of azimuth of a strip, the rim's
    /// radius of a round image, one radian at the centre of a view.
    #[must_use]
    pub fn scale_mm(&self) -> f64 {
        match self {
            Self::Strip(strip) => strip.scale_mm,
            Self::Radial { radius: [_, outer], .. } => *outer,
            Self::Framed(view) => 1.0 / view.radians_per_mm(),
            Self::Panels(views) => 1.0 / views.radians_per_mm(),
        }
    }

    /// About how many radians of the world a millimetre of the image shows.
    #[must_use]
    pub fn radians_per_mm(&self) -> f64 {
        match self {
            Self::Strip(strip) => 1.0 / strip.scale_mm,
            Self::Radial { law, radius: [inner, outer] } => {
                (law.polar(*outer) - law.polar(*inner)) / (outer - inner)
            }
            Self::Framed(view) => view.radians_per_mm(),
            Self::Panels(views) => views.radians_per_mm(),
        }
    }

    /// Distance of two image points by the directions that they must see, mm: azimuth repeats every turn.
    #[inline]
    #[must_use]
    pub fn image_distance(&self, a: DVec2, b: DVec2) -> f64 {
        let mut way = a - b;
        if let Self::Strip(strip) = self {
            let turn = TAU * strip.scale_mm;
            if way.x.abs() > 0.5 * turn {
                way.x -= turn * (way.x / turn).round();
            }
        }
        way.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::StripLaw;

    #[test]
    fn image_points_a_turn_apart_see_the_same() {
        let law = StripLaw::Mercator;
        let strip = Projection::Strip(Strip { law, scale_mm: 19.0, azimuth: 0.0, z: -0.589 });
        let law = RadialLaw::Parabolic { rate: 0.02 };
        let ring = Projection::Radial { law, radius: [6.0, 31.0] };
        let (turn, way) = (19.0 * TAU, DVec2::new(0.3, -0.4));
        for x in [-2.0, -1.0, 0.0, 1.0] {
            let far = DVec2::new(x * turn, 2.0) + way;
            assert!((strip.image_distance(far, DVec2::new(0.0, 2.0)) - 0.5).abs() < 1e-13);
        }
        assert_eq!(ring.image_distance(DVec2::new(turn, 0.0), DVec2::ZERO), turn);
        assert!(strip.image_distance(DVec2::NAN, DVec2::ZERO).is_nan());
    }
}
