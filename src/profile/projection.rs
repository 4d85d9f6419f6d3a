//! The projection as a profile asks for it, in degrees and without the scale that the part gives it.

use crate::optics::{AzimuthalLaw, DirectionSamples, RadialLawKind, StripLaw, Target};
use std::sync::Arc;

/// Directions, or points of a target, that the image points must see.
#[derive(Clone, Debug, PartialEq)]
pub enum ProjectionSpec {
    /// Azimuth along the image's rows, elevation along its columns.
    Strip(StripSpec),
    /// Symmetric about the axis: the image's radius gives the angle from the axis.
    Radial(RadialSpec),
    /// A perspective or fisheye view about any direction.
    Azimuthal(AzimuthalSpec),
    /// Directions given as data.
    Map(MapSpec),
    /// Views of one surface side by side, each on a panel of its own: at least two, which tile the frame without gaps or
    /// overlaps.
    Panels(Vec<PanelSpec>),
}

impl ProjectionSpec {
    /// Surface that the picture shows.
    pub fn target(&self) -> &Target {
        match self {
            ProjectionSpec::Strip(strip) => &strip.target,
            ProjectionSpec::Radial(radial) => &radial.target,
            ProjectionSpec::Azimuthal(view) => &view.target,
            ProjectionSpec::Map(map) => &map.target,
            ProjectionSpec::Panels(panels) => panels[0].view.target(),
        }
    }

    /// Sets the surface that the picture shows.
    pub(crate) fn set_target(&mut self, to: Target) {
        match self {
            ProjectionSpec::Strip(strip) => strip.target = to,
            ProjectionSpec::Radial(radial) => radial.target = to,
            ProjectionSpec::Azimuthal(view) => view.target = to,
            ProjectionSpec::Map(map) => map.target = to,
            ProjectionSpec::Panels(panels) => {
                panels.iter_mut().for_each(|panel| panel.view.set_target(to.clone()));
            }
        }
    }
}

/// A projection onto a strip.
#[derive(Clone, Debug, PartialEq)]
pub struct StripSpec {
    /// Relation of image row and elevation.
    pub law: StripLawSpec,
    /// First and last azimuth in degrees: increasing, within ±360, at most 360 apart.
    pub azimuth_deg: [f64; 2],
    /// Lowest and highest elevation in degrees, of a table too: increasing, strictly inside ±90.
    pub elevation_deg: [f64; 2],
    /// Surface that the picture shows. A plane has the sign of every elevation given;
    /// where the frame is filled, the elevations that come of it are not checked here.
    pub target: Target,
}

/// Relation of image row and elevation, as a profile asks for it.
#[derive(Clone, Debug, PartialEq)]
pub enum StripLawSpec {
    /// A law that is known before the mirror is designed.
    Named(StripLaw),
    /// The law between the two elevations whose slope field has the least curl. The strip's height
    /// is an outcome, so the frame is never filled by it. Never of a given mirror.
    LeastCurl,
    /// Rows and their elevations in degrees, 2 to 1000 of them: the rows, in pixels down the
    /// picture, strictly rise and the elevations strictly fall. The strip is as high as the table.
    Table(Vec<[f64; 2]>),
}

/// A projection about the axis. The polar angle of a direction is the one between it and the axis
/// towards the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialSpec {
    /// Relation of image radius and polar angle.
    pub law: RadialLawSpec,
    /// Polar angle in degrees at the inner rim of an annulus, 0 or more and less than the outer
    /// one. Given exactly for an annulus and a table or a law of two parameters; a disc starts at 0.
    pub inner_polar_deg: Option<f64>,
    /// Polar angle in degrees at the mirror's outer rim, of a table too: strictly between 0 and 180, for
    /// [`RadialLawKind::Plane`] 90.
    pub outer_polar_deg: f64,
    /// Surface that the picture shows. A cylinder is there for an annulus only; a
    /// plane is on the side that the given polar angles look to. The polar angle at the inner rim
    /// of a hyperbolic or conical annulus is an outcome and is not checked here.
    pub target: Target,
}

/// Relation of image radius and polar angle, as a profile asks for it.
#[derive(Clone, Debug, PartialEq)]
pub enum RadialLawSpec {
    /// A law that the polar angles at the rims complete.
    Named(RadialLawKind),
    /// Shares of the way from the inner to the outer rim in the picture (of a disc, from the centre), and the polar
    /// angles there in degrees: 2 to 1000 of them, from share 0 to share 1, both strictly rising. A disc's begins
    /// with polar angle 0.
    Table(Vec<[f64; 2]>),
}

/// A perspective or fisheye view.
#[derive(Clone, Debug, PartialEq)]
pub struct AzimuthalSpec {
    /// Relation of the distance from the picture's centre and the angle from the centre direction.
    pub law: AzimuthalLaw,
    /// Azimuth and elevation of the centre about the camera's axis in degrees: within ±360, and from -89 to 90, which
    /// is the direction back to the camera. Without them it is what a flat part would show.
    pub centre_deg: Option<[f64; 2]>,
    /// Angle of view in degrees across the frame's width, positive: less than 180 of a perspective view, than 360
    /// of another.
    pub hfov_deg: f64,
    /// Turn of the world in the picture in degrees, clockwise, within ±360.
    pub roll_deg: f64,
    /// Whether left and right are exchanged as in a flat mirror.
    pub mirrored: bool,
    /// Surface that the picture shows.
    pub target: Target,
}

/// A view in a part of the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelSpec {
    /// Columns of the frame from the first edge to the last, pixels: rising, within the frame.
    pub columns: [u32; 2],
    /// Rows of the frame from the upper edge to the lower one, pixels: rising, within the frame.
    pub rows: [u32; 2],
    /// What it shows.
    pub view: PanelViewSpec,
}

/// What a panel shows.
#[derive(Clone, Debug, PartialEq)]
pub enum PanelViewSpec {
    /// A view, whose angle is the one across the panel's width and whose centre, which is always given, is in the panel's middle.
    Azimuthal(AzimuthalSpec),
    /// Directions over the panel's part of the frame.
    Map(MapSpec),
}

impl PanelViewSpec {
    /// Surface that the panel shows.
    pub(crate) fn target(&self) -> &Target {
        match self {
            Self::Azimuthal(view) => &view.target,
            Self::Map(map) => &map.target,
        }
    }

    /// Sets the surface that the panel shows.
    fn set_target(&mut self, to: Target) {
        match self {
            Self::Azimuthal(view) => view.target = to,
            Self::Map(map) => map.target = to,
        }
    }
}

/// A picture given as data.
#[derive(Clone, Debug, PartialEq)]
pub struct MapSpec {
    /// The file, as the profile names it.
    pub file: String,
    /// SHA-256 of its bytes, in lower-case hexadecimal, by which a build knows another one.
    pub sha256: String,
    /// The directions that the frame must show, from the target's origin.
    pub samples: Arc<DirectionSamples>,
    /// Surface that the picture shows.
    pub target: Target,
}

/// A law by its name in a profile.
pub(super) enum LawName {
    /// Of a view: perspective where the law is known by the table's name.
    Azimuthal(Option<AzimuthalLaw>),
    /// Of a strip.
    Strip(StripLawSpec),
    /// Of a disc or an annulus.
    Radial(RadialLawKind),
    /// Given as data.
    Map,
    /// Of a strip, or of a disc or an annulus, as its keys tell.
    Table,
}

impl LawName {
    /// The law that `[projection.NAME]` asks for; none where there is no such name.
    pub(super) fn find(name: &str) -> Option<Self> {
        let named = |law| Some(Self::Strip(StripLawSpec::Named(law)));
        match name {
            "cylindrical" => named(StripLaw::Cylindrical),
            "mercator" => named(StripLaw::Mercator),
            "equirectangular" => named(StripLaw::Equirectangular),
            "equal-area" => named(StripLaw::EqualArea),
            "best" => Some(Self::Strip(StripLawSpec::LeastCurl)),
            "perspective" => Some(Self::Azimuthal(Some(AzimuthalLaw::Perspective))),
            "fisheye" => Some(Self::Azimuthal(None)),
            "map" => Some(Self::Map),
            "table" => Some(Self::Table),
            name => {
                let kind = RadialLawKind::ALL.into_iter().find(|kind| kind.name() == name);
                kind.map(Self::Radial)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::schema;

    #[test]
    fn every_name_of_the_schema_is_a_law() {
        for name in schema::PROFILE.keys("projection") {
            assert!(LawName::find(name).is_some(), "{name}");
        }
        let kinds = RadialLawKind::ALL
            .iter()
            .all(|k| schema::PROFILE.keys("projection").contains(&k.name()));
        assert!(kinds && LawName::find("photograph").is_none());
    }
}
