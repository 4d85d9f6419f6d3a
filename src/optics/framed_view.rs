//! Pictures that end with the frame, or with their part of it.

use super::{Azimuthal, RadialLaw, SampledMap};
use crate::geom::DVec2;
use crate::num::Scalar;
use std::sync::Arc;

/// What a frame, or a panel's part of it, shows.
#[derive(Debug, Clone, PartialEq)]
pub enum FramedView {
    /// A perspective or fisheye view about any direction.
    Azimuthal(Azimuthal),
    /// Directions given as data.
    Map(Arc<SampledMap>),
}

impl FramedView {
    /// Direction that image point `q` must see, as a stereographic coordinate.
    #[inline]
    pub fn direction_of<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        match self {
            Self::Azimuthal(view) => view.direction_of(q),
            Self::Map(map) => map.direction_of(q),
        }
    }

    /// The image point, nearest to `near` where there are several, that must see `sigma`.
    #[inline]
    pub fn image_of<S: Scalar>(&self, sigma: [S; 2], near: DVec2) -> [S; 2] {
        match self {
            Self::Azimuthal(view) => view.image_of(sigma),
            Self::Map(map) => map.image_of(sigma, near),
        }
    }

    /// Whether something is wanted of an image point: of gaps in a map nothing is.
    #[inline]
    #[must_use]
    pub fn wants(&self, image: DVec2) -> bool {
        match self {
            Self::Azimuthal(_) => true,
            Self::Map(map) => map.wants(image),
        }
    }

    /// The view with picture and world reflected in X = 0 (`axis` 0) or Y = 0 (1); none of data.
    #[must_use]
    pub fn reflected(&self, axis: usize) -> Option<Self> {
        match self {
            Self::Azimuthal(view) => Some(Self::Azimuthal(view.reflected(axis))),
            Self::Map(_) => None,
        }
    }

    /// Whether reflecting the picture in X = 0 (`axis` 0) or Y = 0 (1) reflects the world.
    #[must_use]
    pub fn is_symmetric(&self, axis: usize) -> bool {
        match self {
            Self::Azimuthal(view) => view.is_symmetric(axis),
            Self::Map(map) => map.is_symmetric(axis),
        }
    }

    /// Whether it is in perspective.
    #[must_use]
    pub fn keeps_lines(&self) -> bool {
        matches!(self, Self::Azimuthal(Azimuthal { law: RadialLaw::Plane { .. }, .. }))
    }

    /// About how many radians of the world a millimetre of the image shows.
    #[must_use]
    pub fn radians_per_mm(&self) -> f64 {
        match self {
            Self::Azimuthal(view) => view.radians_per_mm(),
            Self::Map(map) => map.radians_per_mm(),
        }
    }

    /// The samples, of a picture that is given as data.
    #[must_use]
    pub fn map(&self) -> Option<&SampledMap> {
        match self {
            Self::Azimuthal(_) => None,
            Self::Map(map) => Some(map),
        }
    }
}
