//! Axisymmetric projections: polar angle by a law of the image radius, azimuth kept.
//!
//! psi is the angle between the direction seen and the axis towards the camera, r the image radius
//! on the reference plane, theta = atan(k r) the camera's angle for vergence k, t = tan(psi / 2)
//! the length of the stereographic coordinate. Laws are written as t / r against r^2 and back as
//! r / t against t^2: smooth at the centre wherever the mirror is.

use crate::geom::DVec2;
use crate::num::{Scalar, atan};

/// The law of the radii (docs/theory.md, T19). Lengths are mm on the reference plane, angles
/// radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RadialLaw {
    /// Nayar: t = r * rate. The paraboloid, single viewpoint, orthographic.
    Parabolic {
        /// t per mm.
        rate: f64,
    },
    /// Rees; Yamazawa: tan(theta / 2) = t * rate. The hyperboloid, single viewpoint, pinhole.
    Hyperbolic {
        /// tan(theta / 2) per t.
        rate: f64,
        /// k, 1/mm.
        vergence: f64,
    },
    /// Yagi: psi = 2 alpha + theta. The cone of slope tan(alpha), pinhole.
    Conical {
        /// tan(alpha).
        slope: f64,
        /// k, 1/mm.
        vergence: f64,
    },
    /// Chahl and Srinivasan: psi = psi0 + rate (theta - theta0) / k. With k = 0, where theta / k
    /// is r: Ollis' psi = psi0 + rate (r - r0), proportional to tan(theta) for every camera.
    Equiangular {
        /// psi at the inner rim.
        psi: f64,
        /// theta / k at the inner rim, mm.
        inner: f64,
        /// d psi / d (theta / k), 1/mm.
        rate: f64,
        /// k, 1/mm.
        vergence: f64,
    },
    /// Conroy and Moore: psi = psi0 + rate (r^2 - r0^2).
    AreaProportional {
        /// psi at the inner rim.
        psi: f64,
        /// r0^2, mm^2.
        inner: f64,
        /// 1/mm^2.
        rate: f64,
    },
    /// Hicks and Bajcsy: tan psi = r * rate.
    Plane {
        /// 1/mm.
        rate: f64,
    },
    /// Hicks and Perline: 1 - cos psi = (1 - cos psi0) + rate (r^2 - r0^2).
    EquiAreal {
        /// 1 - cos psi at the inner rim.
        versine: f64,
        /// r0^2, mm^2.
        inner: f64,
        /// 1/mm^2.
        rate: f64,
    },
    /// Gaechter and Pajdla: cot psi = cot psi0 - rate (r - r0).
    Cylinder {
        /// cot psi at the inner rim.
        cot: f64,
        /// r0, mm.
        inner: f64,
        /// 1/mm.
        rate: f64,
    },
}

impl RadialLaw {
    /// t / r against v = r^2.
    #[inline]
    fn stereographic_scale<S: Scalar>(&self, v: S) -> S {
        match *self {
            Self::Parabolic { rate } => S::constant(rate),
            Self::Hyperbolic { rate, vergence: k } => {
                S::constant(k / rate) / (((v * (k * k)) + 1.0).sqrt() + 1.0)
            }
            Self::Conical { slope, vergence: k } => {
                let r = v.sqrt();
                let half = r * k / (((v * (k * k)) + 1.0).sqrt() + 1.0);
                (half + slope) / (-half * slope + 1.0) / r
            }
            Self::Equiangular { psi, inner, rate, vergence: k } => {
                let over = (v * (k * k)).atan_over_root();
                if psi == 0.0 && inner == 0.0 {
                    let x = over * (0.5 * rate);
                    x * (v * x.square()).tan_over_root()
                } else {
                    let r = v.sqrt();
                    ((r * over - inner) * (0.5 * rate) + 0.5 * psi).tan() / r
                }
            }
            Self::AreaProportional { psi, inner, rate } => {
                ((v - inner) * (0.5 * rate) + 0.5 * psi).tan() / v.sqrt()
            }
            Self::Plane { rate } => S::constant(rate) / (((v * (rate * rate)) + 1.0).sqrt() + 1.0),
            Self::EquiAreal { versine, inner, rate } => {
                let u = (v - inner) * rate + versine;
                let per_area =
                    if inner == 0.0 && versine == 0.0 { S::constant(rate) } else { u / v };
                (per_area / (-u + 2.0)).sqrt()
            }
            Self::Cylinder { cot, inner, rate } => {
                let r = v.sqrt();
                let c = -(r - inner) * rate + cot;
                half_tangent(c) / r
            }
        }
    }

    /// r / t against w = t^2.
    #[inline]
    fn image_scale<S: Scalar>(&self, w: S) -> S {
        let psi_of = |w: S| w.sqrt().atan() * 2.0;
        match *self {
            Self::Parabolic { rate } => S::constant(1.0 / rate),
            Self::Hyperbolic { rate, vergence: k } => {
                S::constant(2.0 * rate / k) / (-w * (rate * rate) + 1.0)
            }
            Self::Conical { slope, vergence: k } => {
                let t = w.sqrt();
                let half = (t - slope) / (t * slope + 1.0);
                half * (2.0 / k) / (-half.square() + 1.0) / t
            }
            Self::Equiangular { psi, inner, rate, vergence: k } => {
                if psi == 0.0 && inner == 0.0 {
                    let x = w.atan_over_root() * (2.0 / rate);
                    x * (w * x.square() * (k * k)).tan_over_root()
                } else {
                    let angle = (psi_of(w) - psi) / rate + inner;
                    angle * (angle.square() * (k * k)).tan_over_root() / w.sqrt()
                }
            }
            Self::AreaProportional { psi, inner, rate } => {
                (((psi_of(w) - psi) / rate + inner) / w).sqrt()
            }
            Self::Plane { rate } => S::constant(2.0 / rate) / (-w + 1.0),
            Self::EquiAreal { versine, inner, rate } => {
                if inner == 0.0 && versine == 0.0 {
                    (S::constant(2.0 / rate) / (w + 1.0)).sqrt()
                } else {
                    let u = w * 2.0 / (w + 1.0);
                    (((u - versine) / rate + inner) / w).sqrt()
                }
            }
            Self::Cylinder { cot, inner, rate } => {
                let t = w.sqrt();
                let c = (-w + 1.0) / (t * 2.0);
                ((-c + cot) / rate + inner) / t
            }
        }
    }

    /// Direction that image point `q` must see, as a stereographic coordinate.
    #[inline]
    pub fn direction_of<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        let scale = self.stereographic_scale(q[0].square() + q[1].square());
        q.map(|x| x * scale)
    }

    /// The image point that must see `sigma`.
    #[inline]
    pub fn image_of<S: Scalar>(&self, sigma: [S; 2]) -> [S; 2] {
        let scale = self.image_scale(sigma[0].square() + sigma[1].square());
        sigma.map(|x| x * scale)
    }

    /// Polar angle psi at image radius `r`, radians.
    #[must_use]
    pub fn polar(&self, r: f64) -> f64 {
        2.0 * atan(DVec2::from_array(self.direction_of([r, 0.0])).length())
    }
}

/// tan(psi / 2) from cot psi, without cancellation on either side of the horizon.
#[inline]
fn half_tangent<S: Scalar>(cot: S) -> S {
    let long = (cot.square() + 1.0).sqrt();
    if cot.mid() > 0.0 { S::constant(1.0) / (cot + long) } else { long - cot }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{cos, degrees, radians, tan};
    use crate::optics::{RadialLawKind, RimConditions};

    fn laws(rims: &RimConditions) -> Vec<(&'static str, RadialLaw)> {
        let possible = |kind: &RadialLawKind| match kind {
            RadialLawKind::Parabolic => rims.vergence == 0.0,
            RadialLawKind::Hyperbolic | RadialLawKind::Conical => rims.vergence != 0.0,
            RadialLawKind::AreaProportional | RadialLawKind::Cylinder => rims.radius[0] > 0.0,
            RadialLawKind::Plane => rims.psi[1] < radians(90.0),
            _ => true,
        };
        let kinds = RadialLawKind::ALL.into_iter().filter(possible);
        kinds.map(|kind| (kind.name(), rims.law(kind))).collect()
    }

    fn rims() -> impl Iterator<Item = RimConditions> {
        let radii = [[0.0, 30.0], [8.0, 30.0]];
        let psi = [[40.0, 80.0], [55.0, 125.0]];
        radii.into_iter().flat_map(move |radius| {
            psi.into_iter().flat_map(move |[inner, outer]| {
                [0.0, 0.01].map(|vergence| {
                    let inner = if radius[0] == 0.0 { 0.0 } else { inner };
                    RimConditions { radius, psi: [inner, outer].map(radians), vergence }
                })
            })
        })
    }

    #[test]
    fn locate_inverts_wanted() {
        for rims in rims() {
            for (name, law) in laws(&rims) {
                for k in 0..=40 {
                    let r =
                        rims.radius[0] + (rims.radius[1] - rims.radius[0]) * f64::from(k) / 40.0;
                    let q = DVec2::new(0.6 * r, -0.8 * r);
                    let back = DVec2::from_array(law.image_of(law.direction_of(q.to_array())));
                    if name == "conical" && !back.is_finite() {
                        assert!(r == 0.0);
                        continue;
                    }
                    assert!((back - q).length() < 4e-14 * 30.0, "{name} {rims:?} {q} {back}");
                }
            }
        }
    }

    #[test]
    fn every_law_is_its_definition() {
        for rims in rims() {
            let RimConditions { radius: [r0, r1], psi: [psi0, psi1], vergence: k } = rims;
            for (name, law) in laws(&rims) {
                let r = 0.3 * r0 + 0.7 * r1;
                let theta = |r: f64| if k == 0.0 { r } else { atan(k * r) };
                let psi = law.polar(r);
                let share = (psi - psi0) / (psi1 - psi0);
                let part =
                    |f: &dyn Fn(f64) -> f64, x: f64, a: f64, b: f64| (f(x) - f(a)) / (f(b) - f(a));
                let cot = |psi: f64| 1.0 / tan(psi);
                let (found, exact) = match name {
                    "parabolic" => (tan(psi / 2.0) / tan(psi1 / 2.0), r / r1),
                    "hyperbolic" => (
                        tan(psi / 2.0) / tan(psi1 / 2.0),
                        tan(theta(r) / 2.0) / tan(theta(r1) / 2.0),
                    ),
                    "conical" => (psi - psi1, theta(r) - theta(r1)),
                    "equiangular" => (share, part(&theta, r, r0, r1)),
                    "tangent-proportional" => (share, part(&|r| r, r, r0, r1)),
                    "area-proportional" => (share, part(&|r| r * r, r, r0, r1)),
                    "plane" => (tan(psi) / tan(psi1), r / r1),
                    "equi-areal" => (part(&cos, psi, psi0, psi1), part(&|r| r * r, r, r0, r1)),
                    _ => (part(&cot, psi, psi0, psi1), part(&|r| r, r, r0, r1)),
                };
                assert!((found - exact).abs() < 1e-14, "{name} {rims:?}: {found} {exact}");
                let outer = degrees(law.polar(r1) - psi1).abs();
                assert!(outer < 1e-12, "{name} {rims:?}: {outer}");
            }
        }
    }
}
