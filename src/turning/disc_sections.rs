//! The sections of a mirror that is not round with half-planes through the axis, at each azimuth another.

use super::TurningError;
use super::meridian::MeridianPlace;
use crate::geom::{DVec2, Outline};
use crate::mirror::{LocalSurface, Mirror, Surface};
use crate::num::{atan2, cos, sin};
use crate::parallel;
use std::f64::consts::{PI, TAU};

/// Azimuths and places along the radius at which a mirror is looked at for what is steepest, most hollow and most bent.
const AZIMUTHS: usize = 180;
const RADII: usize = 48;
/// Steps, at most, to a place of the rim: every second at least halves what is left of its azimuth, or of an interval around it.
const STEPS: usize = 100;
/// What is left of the azimuth, radians, at which they end.
const EXACT: f64 = 1e-14;
/// Steps, at most, to the place that a circle touches: from a place near it one or two suffice.
const TOUCHING_STEPS: usize = 40;
/// What is left of its distance from the axis and from the half-plane, mm, at which they end: the centre is as high as circles through any place come, and
/// off by the square of what is left over twice the circle's radius; beside the half-plane the surface is known by its slope.
const LEFT_MM: f64 = 1e-7;
/// Distance from the axis, mm, within which places are taken for those so far from it: a nanometre, where all directions are told apart.
const NEAR_AXIS_MM: f64 = 1e-6;

/// A disc that a tool goes around, on whose face the axis is.
///
/// A rectangle is cut as the disc around it: beside the rectangle the tool follows the mirror's extension.
#[derive(Debug, Clone)]
pub struct DiscSections<'a> {
    mirror: &'a Mirror,
    /// Azimuths of the corners of the rim, radians; none of a disc.
    corners: Vec<f64>,
    /// Radius of the disc around a rectangle, mm; none of a disc.
    around_mm: Option<f64>,
    /// Places all over the disc.
    places: Vec<DiscPlace>,
}

/// A circle in the half-plane of an azimuth.
#[derive(Debug, Clone, Copy)]
pub(super) struct Circle {
    /// Its radius, mm.
    pub reach_mm: f64,
    /// Distance of its centre from the axis, mm.
    pub x_mm: f64,
    /// The largest distance from the axis of a place that it may touch, mm.
    pub most_mm: f64,
}

/// A place of a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiscPlace {
    /// Its azimuth, radians.
    pub azimuth: f64,
    /// The place of the section at that azimuth.
    pub section: MeridianPlace,
    /// Slope along the direction in which the tool cuts, towards larger azimuths.
    pub along: f64,
    /// Derivative by the azimuth of the slope along the circle about the axis: of a round mirror the slope along the radius.
    pub bend: f64,
    /// Derivative of the section's slope by the azimuth; 0 of a round mirror.
    pub twist: f64,
}

impl DiscPlace {
    /// Second derivative of Z by the azimuth on the circle about the axis, mm.
    #[must_use]
    pub fn around_mm(&self) -> f64 {
        self.section.at.x * (self.bend - self.section.slope)
    }
}

impl<'a> DiscSections<'a> {
    /// Those of a mirror.
    ///
    /// # Errors
    /// [`TurningError::NoDisc`].
    pub fn new(mirror: &'a Mirror) -> Result<Self, TurningError> {
        let refused = |what| Err(TurningError::NoDisc { what });
        let mut sections =
            Self { mirror, corners: Vec::new(), around_mm: None, places: Vec::new() };
        match mirror.outline {
            Outline::Ring { inner, .. } if inner > 0.0 => {
                return refused("the mirror has a flat land in its middle");
            }
            Outline::Ring { .. } => {}
            Outline::Rect(rect) => {
                if mirror.folded || matches!(mirror.surface, Surface::Panels(_)) {
                    return refused("the mirror is of several panels");
                }
                let [min, max] = [rect.min, rect.max];
                let corners = [max, DVec2::new(min.x, max.y), min, DVec2::new(max.x, min.y)];
                let corners = corners.map(|q| mirror.local_surface(q).at.truncate());
                sections.corners = corners.map(|xy| atan2(xy.y, xy.x).rem_euclid(TAU)).into();
            }
        }
        let rims: Vec<Option<MeridianPlace>> =
            parallel::map(AZIMUTHS, 1, |k| sections.rim(azimuth(k)));
        let Some(mut rims) = rims.into_iter().collect::<Option<Vec<_>>>() else {
            return refused("the mirror does not go all around the axis");
        };
        if !sections.corners.is_empty() {
            rims.extend(sections.corners.iter().filter_map(|&corner| sections.rim(corner)));
            sections.around_mm = rims.iter().map(|rim| rim.at.x).reduce(f64::max);
        }
        let spokes = parallel::map(AZIMUTHS, 1, |k| {
            let end = sections.around_mm.unwrap_or(rims[k].at.x);
            let radius = |j: usize| end * (j as f64 + 1.0) / RADII as f64;
            (0..RADII).map(|j| sections.place(azimuth(k), radius(j))).collect::<Option<Vec<_>>>()
        });
        match spokes.into_iter().collect::<Option<Vec<_>>>() {
            Some(spokes) => sections.places = spokes.concat(),
            None if sections.around_mm.is_some() => {
                return refused(
                    "beside the mirror, within the disc around it, its extension folds over",
                );
            }
            None => return refused("the mirror hides parts of itself from above"),
        }
        Ok(sections)
    }

    /// Azimuths of the corners of the rim, radians, 0 to a turn; none of a disc.
    #[must_use]
    pub fn corners(&self) -> &[f64] {
        &self.corners
    }

    /// Places all over the disc, rim included.
    #[must_use]
    pub fn places(&self) -> &[DiscPlace] {
        &self.places
    }

    /// The places of the sections alone.
    pub fn sections(&self) -> impl Iterator<Item = MeridianPlace> + Clone + '_ {
        self.places.iter().map(|place| place.section)
    }

    /// The most of a measure of all places.
    #[must_use]
    pub fn most(&self, measure: impl Fn(&DiscPlace) -> f64) -> f64 {
        self.places.iter().map(measure).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The place at an azimuth, radians, and a distance from the axis, mm, which is negative on the other side of it; none where a line
    /// along Z misses the surface.
    #[must_use]
    pub fn place(&self, azimuth: f64, radius_mm: f64) -> Option<DiscPlace> {
        let out = DVec2::new(cos(azimuth), sin(azimuth));
        let radius_mm = if radius_mm.abs() < NEAR_AXIS_MM { NEAR_AXIS_MM } else { radius_mm };
        let local = self.mirror.extended_surface_over(radius_mm * out)?;
        Some(turned(&local, azimuth, out, radius_mm))
    }

    /// The place of the section at an azimuth.
    #[must_use]
    pub fn at(&self, azimuth: f64, radius_mm: f64) -> Option<MeridianPlace> {
        self.place(azimuth, radius_mm).map(|place| place.section)
    }

    /// The place of the section at an azimuth, radians, that a circle touches, and coordinates on the chart a step of Newton's method nearer to it: by Newton's method for both its distance from
    /// the axis and these coordinates, from coordinates near them on; without them from those that the circle's centre has. None where it finds none.
    #[must_use]
    pub(super) fn touched(
        &self,
        azimuth: f64,
        circle: &Circle,
        start: Option<DVec2>,
    ) -> Option<(MeridianPlace, DVec2)> {
        let &Circle { reach_mm, x_mm, most_mm } = circle;
        let out = DVec2::new(cos(azimuth), sin(azimuth));
        let mut q = start.unwrap_or(x_mm.min(most_mm) * out);
        for _ in 0..TOUCHING_STEPS {
            let (local, jacobian) = self.mirror.extended_surface_and_jacobian(q);
            let at = local.at.truncate();
            let mut place = turned(&local, azimuth, out, at.dot(out)).section;
            let off = place.at.x - reach_mm * place.slope / place.stretch() - x_mm;
            // Where the circle fits, its centre goes outwards with the place that it touches.
            let rate = (1.0 - reach_mm * place.curvature).max(0.1);
            let radius_mm = (place.at.x - off / rate).min(most_mm);
            let beside = place.at.x * out - at;
            if (radius_mm - place.at.x).abs().max(beside.length()) < LEFT_MM {
                place.at.y += local.slope.dot(beside);
                return Some((place, q + jacobian.step(radius_mm * out - at)));
            }
            q += jacobian.step(radius_mm * out - at);
        }
        None
    }

    /// Where the tool leaves the section at an azimuth, radians: on the rim, or on the circle around a rectangle; none where there is no
    /// such place.
    #[must_use]
    pub fn edge(&self, azimuth: f64) -> Option<MeridianPlace> {
        match self.around_mm {
            Some(around_mm) => self.at(azimuth, around_mm),
            None => self.rim(azimuth),
        }
    }

    /// The rim at an azimuth, radians; none where it is on the wrong side of the axis.
    #[must_use]
    pub fn rim(&self, azimuth: f64) -> Option<MeridianPlace> {
        // Where the chart's middle is in the axis, its azimuths are those of the plan.
        let (mut chart, mut before) = (azimuth, f64::INFINITY);
        // Azimuths of the chart on both sides of the one that is looked for.
        let mut sides = [None, None];
        let mut local = self.on_rim(chart);
        for _ in 0..STEPS {
            let plan = atan2(local.at.y, local.at.x);
            let off = (azimuth - plan + PI).rem_euclid(TAU) - PI;
            if off.abs() < EXACT {
                break;
            }
            sides[usize::from(off < 0.0)] = Some(chart);
            chart = match sides {
                [Some(low), Some(high)] if off.abs() > 0.5 * before => 0.5 * (low + high),
                _ => chart + off,
            };
            before = off.abs();
            local = self.on_rim(chart);
        }
        let out = DVec2::new(cos(azimuth), sin(azimuth));
        let radius_mm = local.at.truncate().dot(out);
        let beside = local.at.truncate().perp_dot(out).abs();
        (radius_mm > 0.0 && beside < 1e-9 * radius_mm)
            .then(|| turned(&local, azimuth, out, radius_mm).section)
    }

    /// The place of the rim towards an azimuth of the chart from the outline's middle, radians.
    fn on_rim(&self, chart: f64) -> LocalSurface {
        let way = DVec2::new(cos(chart), sin(chart));
        let q = match self.mirror.outline {
            Outline::Ring { outer, .. } => outer * way,
            Outline::Rect(rect) => {
                let half = 0.5 * rect.size();
                let [x, y] = [half.x / way.x.abs(), half.y / way.y.abs()];
                let corner = half.copysign(way);
                // On the side that the way meets one coordinate is the side's, to the last bit.
                rect.centre()
                    + if x < y {
                        DVec2::new(corner.x, x * way.y)
                    } else {
                        DVec2::new(y * way.x, corner.y)
                    }
            }
        };
        self.mirror.local_surface(q)
    }
}

/// Azimuth of number `k` of all that are looked at, radians.
fn azimuth(k: usize) -> f64 {
    TAU * k as f64 / AZIMUTHS as f64
}

/// A place of the surface, as the half-plane towards `out` sees it.
fn turned(local: &LocalSurface, azimuth: f64, out: DVec2, radius_mm: f64) -> DiscPlace {
    let around = out.perp();
    let second = |a: DVec2, b: DVec2| {
        let h = &local.hessian;
        h.xx * a.x * b.x + h.xy * (a.x * b.y + a.y * b.x) + h.yy * a.y * b.y
    };
    let slope = local.slope.dot(out);
    let along = local.slope.dot(around);
    let stretch = f64::sqrt(1.0 + slope * slope);
    let curvature = second(out, out) / (stretch * stretch * stretch);
    let at = DVec2::new(radius_mm, local.at.z);
    DiscPlace {
        azimuth,
        section: MeridianPlace { at, slope, curvature },
        along,
        bend: radius_mm * second(around, around),
        twist: along + radius_mm * second(out, around),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Rect;
    use crate::mirror::fixtures::{quadric, roof};

    /// Of the paraboloid of two curvatures over a disc the derivatives are those of its closed form z = a x^2 / 2 + b y^2 / 2.
    #[test]
    fn places_have_the_derivatives_of_the_closed_form() {
        let (a, b) = (0.02, -0.05);
        let mut mirror = quadric([0.5 * a, 0.0, 0.5 * b], 0.0);
        mirror.outline = Outline::Ring { inner: 0.0, outer: 9.0 };
        let disc = DiscSections::new(&mirror).unwrap();
        assert_eq!(disc.places().len(), AZIMUTHS * RADII);
        let top = disc.at(0.0, 0.0).unwrap().at.y;
        for place in disc.places() {
            let (t, rho) = (place.azimuth, place.section.at.x);
            let [c, s] = [cos(t), sin(t)];
            let k = a * c * c + b * s * s;
            let square = 1.0 + k * k * rho * rho;
            let exact = [
                top + 0.5 * k * rho * rho,
                k * rho,
                k / (square * square.sqrt()),
                (b - a) * s * c * rho,
                rho * (a * s * s + b * c * c),
                2.0 * (b - a) * s * c * rho,
                (b - a) * (c * c - s * s) * rho * rho,
            ];
            let section = place.section;
            let found = [
                section.at.y,
                section.slope,
                section.curvature,
                place.along,
                place.bend,
                place.twist,
                place.around_mm(),
            ];
            for (found, exact) in found.into_iter().zip(exact) {
                assert!((found - exact).abs() < 1e-9, "{t} {rho}: {found} {exact}");
            }
        }
        assert!((disc.rim(1.0).unwrap().at.x - 9.0).abs() < 1e-12);
        // On the other side of the axis slopes have the other sign.
        let [here, there] = [3.0, -3.0].map(|rho| disc.at(0.4, rho).unwrap());
        assert!((here.at.y - there.at.y).abs() < 1e-12 && (here.slope + there.slope).abs() < 1e-12);
    }

    /// The rim of a rectangle is where its sides are, the middle of the chart in the axis or not; beside it the disc around it goes on.
    #[test]
    fn a_rectangle_has_its_sides_and_the_disc_around_it() {
        for middle in [DVec2::ZERO, DVec2::new(1.5, -0.7)] {
            let half = DVec2::new(6.0, 4.0);
            let mut mirror = quadric([0.004, 0.0, -0.004], 0.0);
            mirror.outline = Outline::Rect(Rect { min: middle - half, max: middle + half });
            let disc = DiscSections::new(&mirror).unwrap();
            let side = |out: f64, low: f64, high: f64| {
                if out == 0.0 { f64::INFINITY } else { (high / out).max(low / out) }
            };
            let [min, max] = [middle - half, middle + half];
            for k in 0..720 {
                let t = TAU * k as f64 / 720.0;
                let [c, s] = [cos(t), sin(t)];
                let exact = side(c, min.x, max.x).min(side(s, min.y, max.y));
                let found = disc.rim(t).unwrap().at.x;
                assert!((found - exact).abs() < 1e-11 * exact, "{middle} {t}: {found} {exact}");
            }
            let around = [min, max, DVec2::new(min.x, max.y), DVec2::new(max.x, min.y)];
            let around = around.map(|corner| corner.length()).into_iter().fold(0.0, f64::max);
            assert!((disc.edge(0.4).unwrap().at.x - around).abs() < 1e-9);
            assert!((disc.most(|place| place.section.at.x) - around).abs() < 1e-9);
            let corner = disc.rim(disc.corners()[0]).unwrap().at.x;
            assert!((corner - max.length()).abs() < 1e-11);
        }
    }

    /// The coordinates that come with a touched place lie in its half-plane: a search from there ends with its first step.
    #[test]
    fn coordinates_of_a_touched_place_are_those_where_the_search_ends() {
        let mut mirror = quadric([0.02, 0.01, -0.03], 0.004);
        mirror.outline = Outline::Ring { inner: 0.0, outer: 9.0 };
        let disc = DiscSections::new(&mirror).unwrap();
        for k in 0..60 {
            let t = TAU * f64::from(k) / 60.0;
            let circle = Circle { reach_mm: 0.8, x_mm: 0.1 * f64::from(k), most_mm: 9.0 };
            let (place, q) = disc.touched(t, &circle, None).unwrap();
            let at = mirror.extended_surface(q).at.truncate();
            let out = DVec2::new(cos(t), sin(t));
            assert!(at.perp_dot(out).abs() < 1e-12, "{t}: {}", at.perp_dot(out));
            let (again, _) = disc.touched(t, &circle, Some(q)).unwrap();
            assert!(
                (again.at - place.at).length() < 1e-7 && (again.at.x - at.dot(out)).abs() < 1e-12
            );
        }
    }

    #[test]
    fn two_panels_and_a_rectangle_beside_the_axis_are_refused() {
        let said = |mirror: &Mirror| DiscSections::new(mirror).unwrap_err().to_string();
        assert!(said(&roof(0.1)).contains("of several panels"));
        let mut beside = quadric([0.004, 0.0, -0.004], 0.0);
        beside.outline = Outline::Rect(Rect { min: DVec2::ONE, max: DVec2::splat(3.0) });
        assert!(said(&beside).contains("does not go all around the axis"));
    }
}
