//! Straightness of the picture: how far images of straight lines of the world are from straight.

use super::broyden::Broyden;
use crate::geom::{DVec2, Outline};
use crate::mirror::Mirror;
use crate::optics::{Camera, ImagingTask};
use crate::parallel;
use serde::{Deserialize, Serialize};

/// Lines along the frame's rows, and as many along its columns: its edges and middle are among them.
const LINES: usize = 9;
/// Points of a line. A bow has its sagitta between two of them to 0.1 %.
const POINTS: usize = 33;
/// Steps of the search for a point, which converges in a handful.
const MOST_STEPS: usize = 30;
/// Largest distance of what is found from what is searched for, px: far below what a picture shows, and above
/// rounding in frames of 20 000 pixels.
const FOUND_PX: f64 = 1e-9;

/// Largest departure from straight in the picture of the smooth mirror: over straight lines of the world whose
/// images would be rows, columns and the diagonals of the frame, where the mirror shows them.
///
/// The departure of a line is the largest distance of its image from the chord through the ends of what is seen of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Straightness {
    /// Largest departure, px.
    pub departure_px: f64,
    /// The same in percent of the frame's width.
    pub departure_percent: f64,
}

impl Straightness {
    /// Of the picture of `mirror`: none unless `view` is to keep lines straight, and where no line is seen.
    pub(super) fn of(mirror: &Mirror, camera: &Camera, view: &ImagingTask) -> Option<Self> {
        if !view.projection.keeps_lines() {
            return None;
        }
        let picture = SmoothPicture { mirror, camera, view, outline: mirror.full_outline() };
        let lines = wanted_lines(camera.half_frame());
        let departures = parallel::map_slice(&lines, 1, |line| {
            let seen: Vec<DVec2> = points(*line).filter_map(|at| picture.place_of(at)).collect();
            departure(&seen)
        });
        let largest_mm = departures.into_iter().flatten().reduce(f64::max)?;
        let departure_px = largest_mm / camera.pixel_mm;
        let departure_percent = 100.0 * departure_px / f64::from(camera.pixels[0]);
        Some(Self { departure_px, departure_percent })
    }
}

/// Ends of the lines, image points in mm.
fn wanted_lines(half: DVec2) -> Vec<[DVec2; 2]> {
    let diagonals = [-1.0, 1.0].map(|up| [DVec2::new(-1.0, -up), DVec2::new(1.0, up)]);
    let along = |k: usize| {
        let at = 2.0 * k as f64 / (LINES - 1) as f64 - 1.0;
        [-1.0, 1.0].map(|end| DVec2::new(end, at))
    };
    let rows = (0..LINES).map(along);
    let columns = (0..LINES).map(along).map(|ends| ends.map(|end| DVec2::new(end.y, end.x)));
    rows.chain(columns).chain(diagonals).map(|ends| ends.map(|end| end * half)).collect()
}

/// Points of a line, evenly spaced.
fn points([first, last]: [DVec2; 2]) -> impl Iterator<Item = DVec2> {
    (0..POINTS).map(move |k| first.lerp(last, k as f64 / (POINTS - 1) as f64))
}

/// Largest distance of points from the chord through the first and the last, in their unit: none of fewer than three.
fn departure(points: &[DVec2]) -> Option<f64> {
    let [first, between @ .., last] = points else { return None };
    let chord = (*last - *first).normalize();
    between.iter().map(|at| (*at - *first).perp_dot(chord).abs()).reduce(f64::max)
}

/// The picture that the smooth mirror gives.
struct SmoothPicture<'a> {
    mirror: &'a Mirror,
    camera: &'a Camera,
    view: &'a ImagingTask,
    outline: Outline,
}

impl SmoothPicture<'_> {
    /// Place on the chart of the mirror's point that the camera sees at `image`, and the image point where what it
    /// shows belongs; beyond the rim by the surface as it goes on there.
    fn content_at(&self, image: DVec2) -> Option<(DVec2, DVec2)> {
        let Self { mirror, camera, view, .. } = self;
        let (chart, on_chart) = (&camera.chart, camera.picture.chart_point(image));
        let (place, point) = mirror.point_on_camera_ray(chart, on_chart, chart.plane_mm)?;
        let (at, slope) = (mirror.position(place, &point), mirror.slope(place, &point));
        let content = view.image_of_seen(chart, at.to_array(), slope.to_array(), image);
        Some((place, DVec2::from_array(content)))
    }

    /// The image point at which that is seen which belongs to `wanted`: none where the mirror or the frame does not
    /// have it, and where the search finds none.
    fn place_of(&self, wanted: DVec2) -> Option<DVec2> {
        let width_mm = 2.0 * self.camera.half_frame().x;
        let (mut search, mut image) = (Broyden::new(0.1 * width_mm), wanted);
        for _ in 0..MOST_STEPS {
            let (place, content) = self.content_at(image)?;
            let off = content - wanted;
            if off.length() <= FOUND_PX * self.camera.pixel_mm {
                let is_seen = self.camera.frames(image) && self.outline.contains(place);
                return is_seen.then_some(image);
            }
            image = DVec2::from_array(search.next(image.to_array(), (image - off).to_array()));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three points of a circle of radius r, a chord 2 c apart: the sagitta r - sqrt(r^2 - c^2).
    #[test]
    fn the_departure_of_a_bow_is_its_sagitta() {
        let bow: Vec<DVec2> = points([DVec2::new(-3.0, 0.0), DVec2::new(3.0, 0.0)])
            .map(|at| DVec2::new(at.x, (25.0 - at.x * at.x).sqrt()))
            .map(|at| DVec2::new(0.6, 0.8).rotate(at))
            .collect();
        assert!((departure(&bow).unwrap() - 1.0).abs() < 1e-14);
        assert_eq!(departure(&bow[..2]), None);
    }

    #[test]
    fn lines_are_those_of_the_frame() {
        let lines = wanted_lines(DVec2::new(4.0, 3.0));
        assert_eq!(lines.len(), 2 * LINES + 2);
        let is_edge = |[a, b]: &[DVec2; 2]| a.abs() == DVec2::new(4.0, 3.0) && a.abs() == b.abs();
        // Four sides and two diagonals.
        assert_eq!(lines.iter().filter(|line| is_edge(line)).count(), 6);
        assert!(lines.contains(&[DVec2::new(0.0, -3.0), DVec2::new(0.0, 3.0)]));
        let last = points(lines[0]).last();
        assert_eq!(last, Some(lines[0][1]));
    }
}
