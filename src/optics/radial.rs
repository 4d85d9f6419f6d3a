//! Axisymmetric projections: polar angle by a law of the image radius, azimuth kept.
//!
//! psi is the angle between the direction seen and the axis towards the camera, r the image radius
//! on the reference plane, theta = atan(k r) the camera's angle for vergence k, t = tan(psi / 2)
//! the length of the stereographic coordinate. Laws are written as t / r against r^2 and back as
//! r / t against t^2: smooth at the centre wherever the mirror is.

use crate::geom::DVec2;
use crate::num::{RadialCubic, Scalar, atan};
use std::sync::Arc;

/// The law of the radii (docs/theory.md, T19). Lengths are mm on the reference plane, angles
/// radians.
#[derive(Debug, Clone, PartialEq)]
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
    /// psi as a curve through given points, against r in mm.
    Tabulated(Arc<RadialCubic>),
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
            Self::Tabulated(ref curve) => {
                let half = v.map(&curve.quotient()) * 0.5;
                half * (v * half.square()).tan_over_root()
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
            Self::Tabulated(ref curve) => {
                let per_t = w.atan_over_root() * 2.0;
                (w * per_t.square()).map(&curve.inverse_quotient()) * per_t
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
    use crate::num::sample::Draws;
    use crate::num::{Interval, Jet2, cos, degrees, radians, tan};
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

    /// The table of `n` + 1 even samples of a law.
    fn sampled(law: &RadialLaw, radius: [f64; 2], n: u32) -> RadialLaw {
        let at = |k: u32| radius[0] + (radius[1] - radius[0]) * f64::from(k) / f64::from(n);
        let radii: Vec<f64> = (0..=n).map(at).collect();
        let polar = |r: &f64| if *r == 0.0 { 0.0 } else { law.polar(*r) };
        let polar: Vec<f64> = radii.iter().map(polar).collect();
        RadialLaw::Tabulated(Arc::new(RadialCubic::new(&radii, &polar).unwrap()))
    }

    /// The largest third derivative of the polar angle between the rims, rad/mm^3, by central differences.
    fn third_derivative(law: &RadialLaw, [inner, outer]: [f64; 2]) -> f64 {
        let e = 1e-3 * outer;
        let polar = |r: f64| law.polar(r.abs()).copysign(r);
        let at = |k: u32| {
            let r = inner + (outer - inner) * f64::from(k) / 200.0;
            let ends = polar(r + 2.0 * e) - polar(r - 2.0 * e);
            (ends - 2.0 * (polar(r + e) - polar(r - e))).abs() / (2.0 * e * e * e)
        };
        (1..=200).map(at).fold(0.0, f64::max)
    }

    /// Interpolation by cubics whose slopes are those of parabolas, over steps h: the slope of the longest parabola,
    /// from -h over h to 2 h, is off by h^2 / 3 times the third derivative, and the cubic beside it by h / 2 times that.
    #[test]
    fn a_table_of_a_law_has_its_polar_angles_to_third_order() {
        for rims in rims() {
            let [inner, outer] = rims.radius;
            // The cone has no polar angle of 0 at the centre.
            let smooth = |name: &str| name != "conical" || inner > 0.0;
            for (name, law) in laws(&rims).into_iter().filter(|(name, _)| smooth(name)) {
                let steepest = third_derivative(&law, rims.radius);
                for n in [32, 64, 128] {
                    let table = sampled(&law, rims.radius, n);
                    let apart = |k: u32| {
                        let r = inner + (outer - inner) * f64::from(k) / 997.0;
                        (table.polar(r) - law.polar(r)).abs()
                    };
                    let found = (1..=997).map(apart).fold(0.0, f64::max);
                    let h = (outer - inner) / f64::from(n);
                    // The fourth derivative's part is less by a step's share of the law's own length.
                    let bound = h * h * h / 6.0 * steepest * (1.0 + 8.0 / f64::from(n)) + 1e-14;
                    assert!(found < bound, "{name} {rims:?} {n}: {found:e} {bound:e}");
                }
            }
        }
    }

    fn tables() -> [RadialLaw; 2] {
        let radii = [0.0, 4.0, 13.0, 15.0, 26.0, 30.0];
        let polar = [0.0, 24.0, 61.0, 80.0, 88.0, 110.0].map(radians);
        [(radii, polar), (radii.map(|r| r + 9.0), polar.map(|psi| psi + 0.3))]
            .map(|(r, psi)| RadialLaw::Tabulated(Arc::new(RadialCubic::new(&r, &psi).unwrap())))
    }

    #[test]
    fn image_points_of_a_table_are_found_again() {
        for (law, first) in tables().iter().zip([1e-9, 9.0]) {
            for k in 0..=60 {
                let r = first + 0.5 * f64::from(k);
                let q = DVec2::new(-0.8 * r, 0.6 * r);
                let back = DVec2::from_array(law.image_of(law.direction_of(q.to_array())));
                assert!((back - q).length() < 1e-13 * r, "{q} {back}");
            }
        }
        // At the centre itself, where the angle is proportional to the radius.
        let [disc, _] = tables();
        assert_eq!(disc.direction_of([0.0, 0.0]), [0.0, 0.0]);
        let slope = |r: f64| disc.polar(r) / r;
        assert!((slope(1e-7) / slope(1e-9) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn bounds_of_a_table_hold_values_and_derivatives_both_ways() {
        let parts = |j: Jet2<f64>| [j.value].into_iter().chain(j.gradient).chain(j.hessian);
        let mut r = Draws::new(11);
        // About the centre, and clear of what lies within the inner rim.
        for (law, [lo, hi]) in tables().iter().zip([[-22.0, 22.0], [7.0, 28.0]]) {
            for _ in 0..400 {
                let [x, y] = [r.range([lo, hi]), r.range([lo, hi])];
                let box_of = |[lo, hi]: [f64; 2]| Interval::new(lo, hi);
                let over =
                    law.direction_of([Jet2::variable_x(box_of(x)), Jet2::variable_y(box_of(y))]);
                let [sx, sy] = over.map(|sigma| sigma.value);
                let back = law.image_of([Jet2::variable_x(sx), Jet2::variable_y(sy)]);
                for _ in 0..4 {
                    let at = [Jet2::variable_x(r.inside(x)), Jet2::variable_y(r.inside(y))];
                    let found = law.direction_of(at);
                    let sigma = found.map(|sigma| sigma.value);
                    let undone =
                        law.image_of([Jet2::variable_x(sigma[0]), Jet2::variable_y(sigma[1])]);
                    for (over, at) in
                        over.into_iter().chain(back).zip(found.into_iter().chain(undone))
                    {
                        let over: Vec<Interval> = [over.value]
                            .into_iter()
                            .chain(over.gradient)
                            .chain(over.hessian)
                            .collect();
                        for (over, at) in over.into_iter().zip(parts(at)) {
                            assert!(over.contains(at), "{at} {over:?} at {x:?} {y:?}");
                        }
                    }
                }
            }
        }
    }
}
