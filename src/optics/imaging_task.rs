//! Imaging tasks: the direction that each image point must see from the mirror, and the image point where that
//! belongs which a mirror shows.
//!
//! Image points are mm in the picture, and chart coordinates mm on the camera's reference plane
//! ([`PictureMap`] joins both); directions are stereographic coordinates ([`stereographic`]) of the part frame (X to the right of the picture, Y up in it, Z along
//! the axis towards the camera).

use super::slope_field::SlopeField;
use super::{PictureMap, Projection, Target, stereographic};
use crate::geom::{Chart, DVec2, DVec3};
use crate::num::{Dual, Interval, Jet2, Scalar};

/// On which side of the line Y = 0 the designed panel of a folded mirror lies; the other panel is
/// its reflection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fold {
    /// The designed panel has Y >= 0.
    Above,
    /// The designed panel has Y <= 0.
    Below,
}

impl Fold {
    /// Whether `q` lies on the reflected panel. The ridge itself belongs to the designed panel.
    #[inline]
    #[must_use]
    pub fn reflects(self, q: DVec2) -> bool {
        match self {
            Self::Above => q.y < 0.0,
            Self::Below => q.y > 0.0,
        }
    }
}

/// Bounds of [`ImagingTask::curl`] at a place, 1/mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurlBounds {
    /// Surely holds the exact one: bounds of every rounding.
    pub range: Interval,
    /// The sum of the magnitudes of the field's derivatives, of which the curl is what is left where
    /// they cancel: their relative errors are multiplied with it.
    pub condition: f64,
}

/// Everything that the picture is meant to show: a projection of a target surface, on one panel or
/// on a panel and its reflection in the plane Y = 0 (a mirror reflected in a plane sees the
/// reflected world).
#[derive(Debug, Clone, PartialEq)]
pub struct ImagingTask {
    /// The designed panel's projection.
    pub projection: Projection,
    /// Surface that the picture shows.
    pub target: Target,
    /// Z of the target's origin, mm.
    pub origin_mm: f64,
    /// Fold of the image, if there is one.
    pub fold: Option<Fold>,
    /// From the chart coordinates of the camera to its image points.
    pub picture: PictureMap,
}

impl ImagingTask {
    /// The direction that must be seen at the chart coordinates `q` of the designed panel from the mirror point
    /// `at`, as a stereographic coordinate.
    #[inline]
    pub fn direction_at<S: Scalar>(&self, q: [S; 2], at: [S; 3]) -> [S; 2] {
        self.target.direction_at(self.relative(at), self.wanted_at(q))
    }

    /// The direction from the target's origin that must be seen at the chart coordinates `q`.
    #[inline]
    fn wanted_at<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        self.projection.direction_of(self.picture.image_of(q))
    }

    /// The task of one of several views side by side alone; of others the task itself.
    #[must_use]
    pub fn of_panel(&self, panel: usize) -> Self {
        let projection = match &self.projection {
            Projection::Panels(views) => Projection::Framed(views.views[panel].clone()),
            other => other.clone(),
        };
        Self { projection, ..self.clone() }
    }

    /// Whether what is seen has derivatives that can be bounded over boxes: not across the edges of a target's facets.
    #[must_use]
    pub fn has_bounds(&self) -> bool {
        !self.target.is_faceted()
    }

    /// Whether the picture ends with the frame: a view or a map has no other end, and what a mirror has beyond a frame with
    /// bent sides is nobody's.
    #[must_use]
    pub fn is_framed(&self) -> bool {
        matches!(self.projection, Projection::Framed(_) | Projection::Panels(_))
            || !self.picture.is_identity()
    }

    /// The image point at which the camera of `chart` sees a point of space.
    #[inline]
    #[must_use]
    pub fn image_at(&self, chart: &Chart, at: DVec3) -> DVec2 {
        self.picture.image_point(chart.coordinates(at).0)
    }

    /// The field s(q, f) over chart coordinates that the chart slope of an exact mirror equals (docs/theory.md,
    /// T12). For targets at infinity it does not depend on f.
    #[inline]
    pub fn field<S: Scalar>(&self, chart: &Chart, q: [S; 2], f: S) -> [S; 2] {
        self.slope_field(chart).slope_for(q, f, self.wanted_at(q))
    }

    /// The image point of the designed panel where that belongs which the camera of `chart` sees in
    /// a mirror through `at` of slope `p`; `near` chooses among several.
    #[inline]
    pub fn image_of_seen<S: Scalar>(
        &self,
        chart: &Chart,
        at: [S; 3],
        p: [S; 2],
        near: DVec2,
    ) -> [S; 2] {
        self.image_of_seen_along(chart.view(at), || at, p, near)
    }

    /// [`ImagingTask::image_of_seen`] for a ray whose angle to the axis has the tangent `view`. Targets at
    /// infinity do not ask for `at`, where the ray meets the mirror.
    #[inline]
    pub fn image_of_seen_along<S: Scalar>(
        &self,
        view: [S; 2],
        at: impl FnOnce() -> [S; 3],
        p: [S; 2],
        near: DVec2,
    ) -> [S; 2] {
        self.projection.image_of(self.seen_along(view, at, p), near)
    }

    /// The direction from the target's origin, as a stereographic coordinate, of what the camera of `chart` sees in a mirror through `at`
    /// of slope `p`; the direction itself for targets at infinity.
    #[must_use]
    pub fn seen_from_origin(&self, chart: &Chart, at: [f64; 3], p: [f64; 2]) -> [f64; 2] {
        self.seen_along(chart.view(at), || at, p)
    }

    /// The same for a ray whose angle to the axis has the tangent `view`.
    #[inline]
    fn seen_along<S: Scalar>(
        &self,
        view: [S; 2],
        at: impl FnOnce() -> [S; 3],
        p: [S; 2],
    ) -> [S; 2] {
        let seen = stereographic::reflect(stereographic::towards_camera(view), p);
        match &self.target {
            Target::Infinity => seen,
            target => target.direction_from_origin(self.relative(at()), seen),
        }
    }

    /// W . curl W / |W|^2 at height `f` over chart coordinates `q`, 1/mm: zero everywhere exactly when an
    /// exact mirror exists (paper, section 3.2), and the same for every length of W.
    #[must_use]
    pub fn curl(&self, chart: &Chart, q: DVec2, f: f64) -> f64 {
        let (s, along) = self.field_and_derivatives(chart, q, f);
        self.slope_field(chart).curl(q.to_array(), f, s, along)
    }

    /// The twist at height `f` over chart coordinates `q`, 1/mm: the curl of the slope field over the chart along a
    /// mirror that has its slopes.
    #[must_use]
    pub fn twist(&self, chart: &Chart, q: DVec2, f: f64) -> f64 {
        let (s, along) = self.field_and_derivatives(chart, q, f);
        SlopeField::twist(s, along)
    }

    /// The field, and its derivatives along X, Y and the height.
    fn field_and_derivatives(&self, chart: &Chart, q: DVec2, f: f64) -> ([f64; 2], [[f64; 2]; 3]) {
        let [x, y, h] = [q.x, q.y, f];
        let [x, y, h] = [Dual::variable(x, 0), Dual::variable(y, 1), Dual::variable(h, 2)];
        let s: [Dual<3>; 2] = self.field(chart, [x, y], h);
        (s.map(|s| s.value), std::array::from_fn(|k| s.map(|s| s.slope[k])))
    }

    /// Bounds of the curl at a place, and its condition.
    #[must_use]
    pub fn curl_bounds(&self, chart: &Chart, q: DVec2, f: f64) -> CurlBounds {
        let [x, y, h] = [q.x, q.y, f].map(Interval::point);
        let flat = Jet2::flat;
        let (in_x, in_y) = (Jet2::variable_x(x), Jet2::variable_y(y));
        let s = self.field(chart, [in_x, in_y], flat(h));
        let by_h = match &self.target {
            Target::Infinity => [flat(Interval::point(0.0)); 2],
            _ => self.field(chart, [flat(x), flat(y)], Jet2::variable_x(h)),
        };
        let along =
            [s.map(|s| s.gradient[0]), s.map(|s| s.gradient[1]), by_h.map(|s| s.gradient[0])];
        let (under, s) = (self.slope_field(chart), s.map(|s| s.value));
        let [in_x, in_y, [f, g]] = along;
        let all = [in_x[0], in_x[1], in_y[0], in_y[1], s[1] * f, s[0] * g];
        let size: f64 = all.iter().map(|derivative| derivative.magnitude()).sum();
        let unit = under.curl_denominator([x, y], h, s).mignitude();
        CurlBounds { range: under.curl([x, y], h, s, along), condition: size / unit }
    }

    /// The slope field's camera and target.
    fn slope_field<'a>(&'a self, chart: &'a Chart) -> SlopeField<'a> {
        SlopeField { chart, target: &self.target, origin_mm: self.origin_mm }
    }

    /// `at` relative to the target's origin.
    pub(super) fn relative<S: Scalar>(&self, at: [S; 3]) -> [S; 3] {
        [at[0], at[1], at[2] - self.origin_mm]
    }

    /// Distance from the mirror point `at` in the unit direction `direction` to the target, mm; infinite where it is
    /// not met.
    #[must_use]
    pub fn distance_to_target(&self, at: DVec3, direction: DVec3) -> f64 {
        self.target.distance_mm(at - DVec3::Z * self.origin_mm, direction)
    }

    /// Whether image point `q` belongs to a reflected panel.
    #[inline]
    #[must_use]
    pub fn reflects(&self, q: DVec2) -> bool {
        self.fold.is_some_and(|fold| fold.reflects(q))
    }

    /// The number of the panel that image point `q` belongs to: of a folded mirror 0 the designed one.
    #[inline]
    #[must_use]
    pub fn panel_of(&self, q: DVec2) -> usize {
        match &self.projection {
            Projection::Panels(views) => views.panel_of(q),
            _ => usize::from(self.reflects(q)),
        }
    }

    /// What image points at X share: of a strip sine and cosine of their azimuth.
    #[inline]
    #[must_use]
    pub fn turn(&self, x: f64) -> [f64; 2] {
        match &self.projection {
            Projection::Strip(strip) => strip.turn(x),
            Projection::Radial { .. } | Projection::Framed(_) | Projection::Panels(_) => [0.0, 1.0],
        }
    }

    /// What image points at Y, on any panel, share: of a strip the length of the stereographic coordinate of what they
    /// must see.
    #[inline]
    #[must_use]
    pub fn rise(&self, y: f64) -> f64 {
        match &self.projection {
            Projection::Strip(strip) => strip.rise(y * self.flip(DVec2::new(0.0, y)).y),
            Projection::Radial { .. } | Projection::Framed(_) | Projection::Panels(_) => 1.0,
        }
    }

    /// The direction from the target's origin of what a ray that leaves `at` in the unit direction
    /// `direction` shows; the direction itself for targets at infinity.
    #[must_use]
    pub fn direction_from_origin(&self, at: DVec3, direction: DVec3) -> DVec3 {
        match &self.target {
            Target::Infinity => direction,
            target => {
                let from = self.relative(at.to_array());
                stereographic::direction(
                    target.direction_from_origin(from, stereographic::sigma(direction.to_array())),
                )
            }
        }
    }

    /// Signs of the reflection that carries the panel of `q` to the designed one.
    pub(super) fn flip(&self, q: DVec2) -> DVec3 {
        if self.reflects(q) { DVec3::new(1.0, -1.0, 1.0) } else { DVec3::ONE }
    }
}

#[cfg(test)]
mod tests;
