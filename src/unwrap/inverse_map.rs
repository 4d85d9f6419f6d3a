//! The image point that shows a direction: the inverse of the real mirror's map from image points to the
//! world, by Newton's method from where the projection puts it.

use super::ImagingSystem;
use crate::geom::{DVec2, Outline, Rect};
use crate::num::Dual;
use crate::optics::{Projection, stereographic};
use glam::DMat2;
use std::f64::consts::TAU;

/// Most Newton steps of a search.
const MOST_STEPS: usize = 30;
/// Steps with the Jacobian of the last solution.
const BORROWED: usize = 2;
/// Share of a pixel: a last step of this length leaves an error below a millionth of it.
const CLOSE: f64 = 1e-4;
/// Share of the mirror's size by which places may lie beyond its rim on the way.
const BEYOND: f64 = 0.1;

/// Inverse of the map from image points to directions that mirror and camera give.
#[derive(Debug, Clone, Copy)]
pub struct InverseMap<'a> {
    optics: ImagingSystem<'a>,
    /// The designed panel and what is near it.
    reach: Rect,
    close_mm: f64,
}

/// Image point of a direction, mm on the camera's reference plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageLocation {
    /// Image point where the mirror shows it.
    pub image: DVec2,
    /// Image point that the projection intends.
    pub intended: DVec2,
}

/// A series of searches for neighbouring directions, each started from the last solution.
#[derive(Debug, Clone)]
pub struct InverseSearch<'a> {
    map: InverseMap<'a>,
    /// Of the designed panel and of the reflected one.
    known: [Option<LastSolution>; 2],
}

/// Solution of the last search, from which the next one starts.
#[derive(Debug, Clone, Copy)]
struct LastSolution {
    /// From the chart coordinates of the intended image point to the place on the mirror.
    offset: DVec2,
    /// Derivatives of the place on the mirror by the intended one.
    follows: DMat2,
}

impl<'a> InverseMap<'a> {
    /// In the picture of `optics`.
    #[must_use]
    pub fn new(optics: ImagingSystem<'a>) -> Self {
        let panel = optics.mirror.outline.bounds();
        let slack = BEYOND * panel.size();
        let reach = Rect { min: panel.min - slack, max: panel.max + slack };
        Self { optics, reach, close_mm: CLOSE * optics.camera.pixel_mm }
    }

    /// A new series.
    #[must_use]
    pub fn search(&self) -> InverseSearch<'a> {
        InverseSearch { map: *self, known: [None; 2] }
    }

    /// Where the content of the mirror's place `at` belongs (on the designed panel), nearest to
    /// `near` in azimuth.
    fn content(&self, at: DVec2, near: DVec2) -> DVec2 {
        let ImagingSystem { mirror, camera, view } = self.optics;
        let point = mirror.surface.at(at);
        let place = mirror.position(at, &point).to_array();
        let slope = mirror.slope(at, &point).to_array();
        DVec2::from_array(view.image_of_seen(&camera.chart, place, slope, near))
    }

    /// Whether the direction `wanted`, from the target's origin, is on the side of what the mirror's place `at` shows: a perspective law
    /// has opposite directions at the same image point.
    fn shows(&self, at: DVec2, wanted: [f64; 2]) -> bool {
        let ImagingSystem { mirror, camera, view } = self.optics;
        let point = mirror.surface.at(at);
        let place = mirror.position(at, &point).to_array();
        let slope = mirror.slope(at, &point).to_array();
        let seen = stereographic::direction(view.seen_from_origin(&camera.chart, place, slope));
        seen.dot(stereographic::direction(wanted)) > 0.0
    }

    /// Inverse of the Jacobian of [`InverseMap::content`].
    fn follows(&self, at: DVec2, near: DVec2) -> DMat2 {
        let ImagingSystem { mirror, camera, view } = self.optics;
        let point = mirror.surface.at(at);
        let bend = mirror.surface.hessian(at);
        let (q, slope) = (at.to_array(), point.slope.to_array());
        let q: [Dual<2>; 2] = [0, 1].map(|k| Dual::variable(q[k], k));
        let f = Dual { value: point.f, slope };
        let bends = [[bend.xx, bend.xy], [bend.xy, bend.yy]];
        let p = [0, 1].map(|k| Dual { value: slope[k], slope: bends[k] });
        let place = mirror.chart.position(q, f);
        let content = view.image_of_seen(&camera.chart, place, mirror.chart.slope(q, p), near);
        // Rows are contents, columns variables.
        DMat2::from_cols_array_2d(&content.map(|c| c.slope)).transpose().inverse()
    }

    /// The place of the designed panel (or near it) whose content belongs to `intended`.
    fn solve(&self, intended: DVec2, known: &mut Option<LastSolution>) -> Option<DVec2> {
        let start = self.optics.camera.picture.chart_point(intended);
        let mut at = start + known.map_or(DVec2::ZERO, |known| known.offset);
        let mut borrowed = known.take().map(|known| known.follows);
        for step in 0..MOST_STEPS {
            let fresh = borrowed.filter(|_| step < BORROWED);
            let follows = fresh.unwrap_or_else(|| self.follows(at, intended));
            borrowed = Some(follows);
            let step = follows * (intended - self.content(at, intended));
            at += step;
            // A step that is no number leads nowhere.
            if !self.reach.contains(at) {
                return None;
            }
            if step.length() <= self.close_mm {
                *known = Some(LastSolution { offset: at - start, follows });
                return Some(at);
            }
        }
        None
    }
}

impl InverseSearch<'_> {
    /// Image point of the direction `sigma` (stereographic, from the target's origin); `None` where mirror
    /// or sensor does not show it.
    #[must_use]
    pub fn find(&mut self, sigma: [f64; 2]) -> Option<ImageLocation> {
        let ImagingSystem { mirror, camera, view } = self.map.optics;
        let centre = mirror.outline.bounds().centre();
        let turn = match (&view.projection, mirror.outline) {
            (Projection::Strip(strip), Outline::Rect(_)) => TAU * strip.scale_mm,
            _ => 0.0,
        };
        let panels = if mirror.folded { 2 } else { 1 };
        for panel in 0..panels {
            // A mirror reflected in a plane sees the reflected world.
            let flip = if panel == 0 { DVec2::ONE } else { DVec2::new(1.0, -1.0) };
            let wanted = (DVec2::from_array(sigma) * flip).to_array();
            let place = DVec2::from_array(view.projection.image_of(wanted, centre));
            // Just beyond one end of a full turn is what is just before the other.
            let turns = if turn > 0.0 { &[0.0, -turn, turn][..] } else { &[0.0] };
            for shift in turns {
                let intended = place + DVec2::new(*shift, 0.0);
                if !self.map.reach.contains(camera.picture.chart_point(intended)) {
                    continue;
                }
                let found = self.map.solve(intended, &mut self.known[panel]);
                let is_there =
                    |at: &DVec2| mirror.outline.contains(*at) && self.map.shows(*at, wanted);
                let Some(at) = found.filter(is_there) else { continue };
                let on = mirror.position(at, &mirror.surface.at(at));
                let image = camera.image_at(on) * flip;
                let pixel = self.map.optics.pixel(image);
                let seen = |k: usize| (0.0..=f64::from(camera.pixels[k])).contains(&pixel[k]);
                if seen(0) && seen(1) {
                    return Some(ImageLocation { image, intended: intended * flip });
                }
            }
        }
        None
    }
}
