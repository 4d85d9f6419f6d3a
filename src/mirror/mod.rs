//! Mirrors as functions: height, slope, second derivatives, bounds of them, and where rays meet them.
//!
//! A mirror is one [`Surface`] over an outline of a chart's image coordinates, and, when it is
//! folded, the surface's reflection in the plane Y = 0. The chart is that of the camera the mirror
//! was designed for; a mirror given as sag over X and Y has the chart of parallel rays. What a surface
//! has to offer is the contract [`HeightField`]; over X and Y of the part, whatever the chart, the mirror
//! is a [`LocalSurface`] at each point.

mod bicubic_spline;
mod bounds;
mod extended;
#[cfg(test)]
pub(crate) mod fixtures;
mod form;
mod height_field;
mod local_surface;
mod panelled;
mod radial_legendre;
mod radial_tensor_sum;
mod surface;
mod surface_samples;
mod tensor_legendre;
mod volume;
mod walls;

pub use bounds::{BoundCells, BoundGrid, UnionBound};
pub use form::{BestFitPlane, BestFitSphere, Departure, Form};
pub use height_field::{HeightAndSlope, HeightField, HeightRow, Hessian};
pub use local_surface::{LocalSurface, PlanJacobian};
pub use panelled::PanelledSurface;
pub use radial_legendre::{RadialLegendre, RadialLegendreRow, Rings};
pub use radial_tensor_sum::{RadialTensorSum, RadialTensorSumRow};
pub use surface::{Surface, SurfaceRow};
pub use surface_samples::SurfaceSamples;
pub use tensor_legendre::{TensorLegendre, TensorLegendreRow};
pub use walls::WallFault;

use crate::geom::{Chart, DVec2, DVec3, Outline, Rect};

/// How far beyond the line between two panels rounding takes a vertex, as a share of the mirror's size.
const ROUNDED: f64 = 1e-6;

/// A designed or given mirror in the part frame.
#[derive(Debug, Clone)]
pub struct Mirror {
    /// The designed panel's surface.
    pub surface: Surface,
    /// The chart in whose coordinates the surface is a height.
    pub chart: Chart,
    /// The designed panel's outline, mm of the chart. A rectangle's corners are single-precision
    /// numbers where the chart is that of parallel rays.
    pub outline: Outline,
    /// Whether the panel's reflection in the plane Y = 0, along which it then has an edge, is part
    /// of the mirror.
    pub folded: bool,
    /// Whether the surface is even in x and in y and the outline symmetric, to the last bit.
    pub mirror_symmetric: [bool; 2],
}

impl Mirror {
    /// The mirror reflected in X = 0, in Y = 0 and in both planes, as far as it is then the same mirror
    /// ([`Mirror::mirror_symmetric`]). Each has the coefficients of the reflected surface, so that a mesh of it shows
    /// whether reflecting the mesh of one half was right.
    #[must_use]
    pub fn reflections(&self) -> Vec<Self> {
        let mut all = vec![self.clone()];
        for axis in (0..2).filter(|&axis| self.mirror_symmetric[axis]) {
            let reflected =
                |mirror: &Self| Self { surface: mirror.surface.reflected(axis), ..mirror.clone() };
            all.extend(all.iter().map(reflected).collect::<Vec<_>>());
        }
        all.split_off(1)
    }

    /// The outline of all panels.
    #[must_use]
    pub fn full_outline(&self) -> Outline {
        match self.outline {
            Outline::Rect(panel) if self.folded => {
                let reach = panel.min.y.abs().max(panel.max.y.abs());
                Outline::Rect(Rect {
                    min: DVec2::new(panel.min.x, -reach),
                    max: DVec2::new(panel.max.x, reach),
                })
            }
            outline => outline,
        }
    }

    /// Whether there are steps between panels.
    #[must_use]
    pub fn has_steps(&self) -> bool {
        matches!(self.surface, Surface::Panels(_))
    }

    /// The share of the panels' circumferences that lies between panels.
    #[must_use]
    pub fn inner_share(&self) -> f64 {
        let Surface::Panels(PanelledSurface { parts, .. }) = &self.surface else { return 0.0 };
        let around = |rect: &Rect| 2.0 * rect.size().element_sum();
        let all: f64 = parts.0.iter().map(around).sum();
        1.0 - around(&self.outline.bounds()) / all
    }

    /// The index in [`Mirror::panels`] of the panel of `q`.
    #[must_use]
    pub fn panel_of(&self, q: DVec2) -> usize {
        match &self.surface {
            Surface::Panels(panelled) => panelled.parts.index_of(q),
            _ => usize::from(self.reflects(q)),
        }
    }

    /// The index in [`Mirror::panels`] of the panel of a point of space on the mirror, mm: where panels meet, of the one
    /// that is the nearest.
    #[must_use]
    pub fn panel_at(&self, point: DVec3) -> usize {
        let (q, f) = self.chart.coordinates(point);
        match &self.surface {
            Surface::Panels(panelled) => {
                panelled.nearest(q, f, ROUNDED * self.outline.bounds().size().max_element())
            }
            _ => usize::from(self.reflects(q)),
        }
    }

    /// Each panel as a mirror of its own, of a folded mirror the designed one first, whose surface goes on beyond the
    /// ridge.
    #[must_use]
    pub fn panels(&self) -> Vec<Self> {
        if let Surface::Panels(PanelledSurface { parts, sheets }) = &self.surface {
            let panel = |(part, sheet): (&Rect, &TensorLegendre)| Self {
                surface: Surface::Tensor(sheet.clone()),
                outline: Outline::Rect(*part),
                folded: false,
                mirror_symmetric: [false; 2],
                chart: self.chart,
            };
            return parts.0.iter().zip(sheets).map(panel).collect();
        }
        let one = Self { folded: false, ..self.clone() };
        let Outline::Rect(Rect { min, max }) = self.outline else { return vec![one] };
        if !self.folded {
            return vec![one];
        }
        let reflected = Rect { min: DVec2::new(min.x, -max.y), max: DVec2::new(max.x, -min.y) };
        let other = Self {
            surface: self.surface.reflected(1),
            outline: Outline::Rect(reflected),
            ..one.clone()
        };
        vec![one, other]
    }

    /// Whether `q` is on the reflected panel's side (the ridge belongs to the designed one). Places
    /// that rounding has put beyond the outline stay with their panel.
    #[inline]
    #[must_use]
    pub fn reflects(&self, q: DVec2) -> bool {
        let Outline::Rect(panel) = self.outline else { return false };
        self.folded && q.y * panel.centre().y < 0.0
    }

    /// Height and slope on the line of constant `y`, for many values of x. The line through the
    /// ridge takes the designed panel's slope.
    #[must_use]
    pub fn row(&self, y: f64) -> MirrorRow<'_> {
        let reflected = self.reflects(DVec2::new(0.0, y));
        MirrorRow { row: self.surface.row(if reflected { -y } else { y }), reflected }
    }

    /// Height and slope over one place, with the bits of [`MirrorRow::at`].
    #[must_use]
    pub fn at(&self, q: DVec2) -> HeightAndSlope {
        if !self.reflects(q) {
            return self.surface.at(q);
        }
        let mut point = self.surface.at(DVec2::new(q.x, -q.y));
        point.slope.y = -point.slope.y;
        point
    }

    /// Height (mm) over `q`, with the bits of [`MirrorRow::at`].
    #[must_use]
    pub fn height(&self, q: DVec2) -> f64 {
        self.surface.height(if self.reflects(q) { q * DVec2::new(1.0, -1.0) } else { q })
    }

    /// Height and slope over each of a few places, with the bits of [`Mirror::at`].
    #[inline]
    fn at_each<const N: usize>(&self, places: [DVec2; N]) -> [HeightAndSlope; N] {
        let reflected = places.map(|q| self.reflects(q));
        let side = |k: usize| if reflected[k] { DVec2::new(1.0, -1.0) } else { DVec2::ONE };
        let points: [_; N] = self.surface.at_each(std::array::from_fn(|k| places[k] * side(k)));
        std::array::from_fn(|k| {
            let HeightAndSlope { f, slope } = points[k];
            HeightAndSlope { f, slope: slope * side(k) }
        })
    }

    /// Height and slope over each of `places`, best listed in lines of equal y.
    #[must_use]
    pub fn eval_many(&self, places: &[DVec2]) -> Vec<HeightAndSlope> {
        let on_line = |a: &DVec2, b: &DVec2| a.y == b.y;
        let mut points = Vec::with_capacity(places.len());
        let (mut xs, mut rest) = (Vec::new(), places);
        while let Some(line) = rest.chunk_by(on_line).next() {
            let few = rest.first_chunk::<SCATTERED>();
            let scattered = few.filter(|few| few.windows(2).all(|two| !on_line(&two[0], &two[1])));
            let taken = if let Some(few) = scattered {
                points.extend(self.at_each(*few));
                few.len()
            } else if let [place] = line {
                // (A row takes longer than a place.)
                points.push(self.at(*place));
                1
            } else {
                xs.clear();
                xs.extend(line.iter().map(|q| q.x));
                self.row(line[0].y).extend_at(&xs, &mut points);
                line.len()
            };
            rest = &rest[taken..];
        }
        points
    }

    /// Position (mm) of a panel's point over `q`, by the panel's number of those with steps between them.
    #[must_use]
    pub fn position_on(&self, panel: usize, q: DVec2) -> DVec3 {
        let point = match &self.surface {
            Surface::Panels(panelled) => panelled.sheets[panel].at(q),
            _ => self.row(q.y).at(q.x),
        };
        self.position(q, &point)
    }

    /// Position (mm) of the mirror's point over `q`.
    #[inline]
    #[must_use]
    pub fn position(&self, q: DVec2, point: &HeightAndSlope) -> DVec3 {
        self.chart.point(q, point.f)
    }

    /// The slope (Z_X, Z_Y) of the mirror's point over `q`.
    #[inline]
    #[must_use]
    pub fn slope(&self, q: DVec2, point: &HeightAndSlope) -> DVec2 {
        DVec2::from_array(self.chart.slope(q.to_array(), point.slope.to_array()))
    }

    /// A normal towards the camera, not of unit length: (-Z_X, -Z_Y, 1).
    #[inline]
    #[must_use]
    pub fn normal(&self, q: DVec2, point: &HeightAndSlope) -> DVec3 {
        (-self.slope(q, point)).extend(1.0)
    }

    /// The mirror's point over `q`, on any panel, with its derivatives over X and Y.
    #[must_use]
    pub fn local_surface(&self, q: DVec2) -> LocalSurface {
        if self.reflects(q) {
            return self.panel_local_surface(q * DVec2::new(1.0, -1.0)).reflected();
        }
        self.panel_local_surface(q)
    }

    /// The mirror's point over (X, Y) = `xy`, with its derivatives: where the vertical through `xy` meets the
    /// mirror more than once, the one near the height `z_mm`. None where Newton's method finds none.
    #[must_use]
    pub fn local_surface_over(&self, xy: DVec2, z_mm: f64) -> Option<LocalSurface> {
        let q = self.intersect_camera_ray_near(&self.chart.parallel(), xy, z_mm)?;
        Some(self.local_surface(q))
    }

    /// The same on the designed panel.
    fn panel_local_surface(&self, q: DVec2) -> LocalSurface {
        let (point, hessian) = self.surface.at_with_hessian(q);
        LocalSurface::new(&self.chart, q, &point, &hessian)
    }

    /// The chart's coordinates of the mirror's point that a camera sees at its image point `q`:
    /// `q` itself for the camera the mirror was designed for; by Newton's method along the ray for
    /// another, and none where that does not converge.
    #[must_use]
    pub fn intersect_camera_ray(&self, camera: &Chart, q: DVec2) -> Option<DVec2> {
        self.intersect_camera_ray_near(camera, q, camera.plane_mm)
    }

    /// The same, where the ray meets the mirror more than once the place near the height `z_mm`: a panel
    /// that goes on beyond the ridge may come to lie over itself.
    #[must_use]
    pub fn intersect_camera_ray_near(&self, camera: &Chart, q: DVec2, z_mm: f64) -> Option<DVec2> {
        if *camera == self.chart {
            return Some(q);
        }
        self.point_on_camera_ray(camera, q, z_mm).map(|(at, _)| at)
    }

    /// The same with the mirror's height and slope there.
    #[must_use]
    pub fn point_on_camera_ray(
        &self,
        camera: &Chart,
        q: DVec2,
        z_mm: f64,
    ) -> Option<(DVec2, HeightAndSlope)> {
        if *camera == self.chart {
            return Some((q, self.at(q)));
        }
        let size = self.outline.bounds().size().max_element();
        let (_, mut height) = camera.coordinates(DVec3::new(0.0, 0.0, z_mm));
        for _ in 0..32 {
            let on_ray = camera.point(q, height);
            let (at, f) = self.chart.coordinates(on_ray);
            let point = self.at(at);
            // Along the ray the image point drifts by the view's tangent for each mm of height, and
            // heights of the two charts grow as views shrink towards their pinholes.
            let drift = camera.tangent_at(q) - self.chart.tangent_at(at);
            let growth = self.chart.view_scale(on_ray.z) / camera.view_scale(on_ray.z);
            let step = growth * (point.f - f) / (1.0 + point.slope.dot(drift));
            height += step;
            if step.abs() <= 1e-13 * size {
                return Some((at, point));
            }
        }
        None
    }
}

/// Places on lines of their own that are evaluated at once: half as many as on one line, since the sums of each take twice
/// the registers.
const SCATTERED: usize = 4;

/// A mirror on one line of constant y.
#[derive(Debug, Clone)]
pub struct MirrorRow<'a> {
    row: SurfaceRow<'a>,
    reflected: bool,
}

impl MirrorRow<'_> {
    /// Height and slope at `x`.
    #[inline]
    #[must_use]
    pub fn at(&self, x: f64) -> HeightAndSlope {
        let mut point = self.row.at(x);
        if self.reflected {
            point.slope.y = -point.slope.y;
        }
        point
    }

    /// Adds height and slope at each of `xs`, with the bits of [`MirrorRow::at`].
    fn extend_at(&self, xs: &[f64], points: &mut Vec<HeightAndSlope>) {
        let first = points.len();
        self.row.extend_at(xs, points);
        if self.reflected {
            points[first..].iter_mut().for_each(|point| point.slope.y = -point.slope.y);
        }
    }
}
