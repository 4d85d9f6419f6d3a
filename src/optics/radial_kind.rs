//! Radial laws by their names, and the one of a kind that the rims of a mirror fix.

use super::RadialLaw;
use crate::num::{Scalar, atan, sin, tan};

/// Relation of polar angle and image radius, but for its constants. The polar angle of a direction is the one
/// between it and the axis towards the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
    /// Every kind.
    pub const ALL: [Self; 9] = [
        Self::Parabolic,
        Self::Hyperbolic,
        Self::Conical,
        Self::Equiangular,
        Self::TangentProportional,
        Self::AreaProportional,
        Self::Plane,
        Self::EquiAreal,
        Self::Cylinder,
    ];

    /// Name of the law, as in a profile.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Parabolic => "parabolic",
            Self::Hyperbolic => "hyperbolic",
            Self::Conical => "conical",
            Self::Equiangular => "equiangular",
            Self::TangentProportional => "tangent-proportional",
            Self::AreaProportional => "area-proportional",
            Self::Plane => "plane",
            Self::EquiAreal => "equi-areal",
            Self::Cylinder => "cylinder",
        }
    }

    /// Whether the polar angle at an annulus' inner rim is free to choose.
    #[must_use]
    pub fn has_two_parameters(self) -> bool {
        match self {
            Self::Parabolic | Self::Hyperbolic | Self::Conical | Self::Plane => false,
            Self::Equiangular
            | Self::TangentProportional
            | Self::AreaProportional
            | Self::EquiAreal
            | Self::Cylinder => true,
        }
    }

    /// Whether the law's mirror is not smooth at the centre, so that it must be an annulus.
    #[must_use]
    pub fn needs_annulus(self) -> bool {
        matches!(self, Self::Conical | Self::AreaProportional | Self::Cylinder)
    }
}

/// Boundary conditions of an axisymmetric mirror at its rims, from which a law's constants follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RimConditions {
    /// Image radii of the inner and the outer rim, mm; the inner one is 0 for a disc.
    pub radius: [f64; 2],
    /// Polar angles psi there, radians. One-parameter laws look at the outer one alone.
    pub psi: [f64; 2],
    /// k of the camera, 1/mm.
    pub vergence: f64,
}

impl RimConditions {
    /// The law of a kind that meets the conditions (docs/theory.md, T19).
    #[must_use]
    pub fn law(&self, kind: RadialLawKind) -> RadialLaw {
        let (Self { radius: [_, outer], psi: [psi, outer_psi], vergence }, areas) =
            (*self, self.radius.map(|r| r * r));
        // t and tan(theta / 2) at the outer rim.
        let outer_t = || tan(0.5 * outer_psi);
        let outer_half = || tan(0.5 * atan(vergence * outer));
        match kind {
            RadialLawKind::Parabolic => RadialLaw::Parabolic { rate: outer_t() / outer },
            RadialLawKind::Hyperbolic => {
                RadialLaw::Hyperbolic { rate: outer_half() / outer_t(), vergence }
            }
            RadialLawKind::Conical => {
                let alpha = 0.5 * (outer_psi - atan(vergence * outer));
                RadialLaw::Conical { slope: tan(alpha), vergence }
            }
            RadialLawKind::Equiangular => self.equiangular(),
            // Ollis' law is Chahl's for parallel rays.
            RadialLawKind::TangentProportional => Self { vergence: 0.0, ..*self }.equiangular(),
            RadialLawKind::AreaProportional => {
                let rate = (outer_psi - psi) / (areas[1] - areas[0]);
                RadialLaw::AreaProportional { psi, inner: areas[0], rate }
            }
            RadialLawKind::Plane => RadialLaw::Plane { rate: tan(outer_psi) / outer },
            RadialLawKind::EquiAreal => {
                let [versine, last] = self.psi.map(versine);
                let rate = (last - versine) / (areas[1] - areas[0]);
                RadialLaw::EquiAreal { versine, inner: areas[0], rate }
            }
            RadialLawKind::Cylinder => {
                let [cot, outer_cot] = self.psi.map(|psi| 1.0 / tan(psi));
                let inner = self.radius[0];
                RadialLaw::Cylinder { cot, inner, rate: (cot - outer_cot) / (outer - inner) }
            }
        }
    }

    /// [`RadialLaw::Equiangular`] through both rims.
    fn equiangular(&self) -> RadialLaw {
        // theta / k: the radius itself for parallel rays.
        let [inner, outer] = self.radius.map(|r| r * (self.vergence * r).square().atan_over_root());
        let [psi, outer_psi] = self.psi;
        let rate = (outer_psi - psi) / (outer - inner);
        RadialLaw::Equiangular { psi, inner, rate, vergence: self.vergence }
    }
}

/// 1 - cos psi without cancellation.
fn versine(psi: f64) -> f64 {
    let half = sin(0.5 * psi);
    2.0 * half * half
}
