//! Which direction of the world an image point must see.

/// Which direction, or which point of a target, an image point must see.
#[derive(Clone, Debug, PartialEq)]
pub enum ProjectionSpec {
    /// Azimuth along the image's rows, elevation along its columns.
    Strip(StripSpec),
    /// Symmetric about the axis: the image's radius gives the angle from the axis.
    Radial(RadialSpec),
}

impl ProjectionSpec {
    /// Where the points lie that the picture shows.
    pub fn target(&self) -> Target {
        match self {
            ProjectionSpec::Strip(strip) => strip.target,
            ProjectionSpec::Radial(radial) => radial.target,
        }
    }
}

/// A projection onto a strip.
#[derive(Clone, Debug, PartialEq)]
pub struct StripSpec {
    /// How an image row maps to elevation.
    pub law: StripLawSpec,
    /// First and last azimuth in degrees: increasing, within ±360, at most 360 apart.
    pub azimuth_deg: [f64; 2],
    /// Lowest and highest elevation in degrees, of a table too: increasing, strictly inside ±90.
    pub elevation_deg: [f64; 2],
    /// Where the points lie that the picture shows. A plane has the sign of every elevation given;
    /// where the frame is filled, the elevations that come of it are not checked here.
    pub target: Target,
}

/// How an image row maps to elevation; `z` is the row's height in units of the strip's scale.
#[derive(Clone, Debug, PartialEq)]
pub enum StripLawSpec {
    /// `tan(elevation) = z`, the picture on a cylinder about the axis. No mirror is exact.
    Cylindrical,
    /// `tan(elevation) = sinh(z)`, the conformal picture. An exact mirror exists.
    Mercator,
    /// `elevation = z`.
    Equirectangular,
    /// `sin(elevation) = z`: each pixel sees the same solid angle.
    EqualArea,
    /// The law between the two elevations whose slope field has the least curl. The strip's height
    /// is an outcome, so the frame is never filled by it. Never of a given mirror.
    Best,
    /// Rows and their elevations in degrees, 2 to 1000 of them: the rows, in pixels down the
    /// picture, strictly rise and the elevations strictly fall. The strip is as high as the table.
    Table(Vec<[f64; 2]>),
}

/// A projection about the axis. The polar angle of a direction is the one between it and the axis
/// towards the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadialSpec {
    /// How the image's radius maps to the polar angle.
    pub law: RadialLawKind,
    /// Polar angle in degrees at the inner rim of an annulus, 0 or more and less than the outer
    /// one. Given exactly for an annulus and a law of two parameters; a disc starts at 0.
    pub inner_polar_deg: Option<f64>,
    /// Polar angle in degrees at the mirror's outer rim: strictly between 0 and 180, for
    /// [`RadialLawKind::Plane`] 90.
    pub outer_polar_deg: f64,
    /// Where the points lie that the picture shows. A cylinder is there for an annulus only; a
    /// plane is on the side that the given polar angles look to. The polar angle at the inner rim
    /// of a hyperbolic or conical annulus is an outcome and is not checked here.
    pub target: Target,
}

/// How the image's radius maps to the polar angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RadialLawKind {
    /// A paraboloid under an orthographic camera: single viewpoint (Nayar).
    Parabolic,
    /// A hyperboloid with a pinhole at its focus: single viewpoint (Rees; Yamazawa).
    Hyperbolic,
    /// A cone under a pinhole, on an annulus (Yagi).
    Conical,
    /// The polar angle is linear in the camera's angle (Chahl and Srinivasan). Two parameters.
    Equiangular,
    /// The polar angle is linear in the image's radius (Ollis et al.). Two parameters.
    TangentProportional,
    /// The polar angle is linear in the image's area, on an annulus (Conroy and Moore). Two
    /// parameters.
    AreaProportional,
    /// The tangent of the polar angle is proportional to the image's radius: a plane across the
    /// axis looks undistorted (Hicks and Bajcsy).
    Plane,
    /// Each pixel sees the same solid angle (Hicks and Perline). Two parameters.
    EquiAreal,
    /// The height on a cylinder about the axis is linear in the image's radius, on an annulus
    /// (Gaechter and Pajdla). Two parameters.
    Cylinder,
}

impl RadialLawKind {
    /// Whether the polar angle at an annulus' inner rim is free to choose.
    pub fn has_two_parameters(self) -> bool {
        use RadialLawKind::*;
        match self {
            Parabolic | Hyperbolic | Conical | Plane => false,
            Equiangular | TangentProportional | AreaProportional | EquiAreal | Cylinder => true,
        }
    }

    /// Whether the law's mirror is not smooth at the centre, so that it must be an annulus.
    pub fn needs_annulus(self) -> bool {
        matches!(
            self,
            RadialLawKind::Conical | RadialLawKind::AreaProportional | RadialLawKind::Cylinder
        )
    }
}

/// Where the points lie that the picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// So far away that only directions count.
    Infinity,
    /// On a cylinder about the axis.
    Cylinder {
        /// Its radius in millimetres, more than half the part's width.
        radius_mm: f64,
    },
    /// On a plane across the axis.
    Plane {
        /// Its height over the target's origin in millimetres, positive towards the camera, not 0.
        height_mm: f64,
    },
}
