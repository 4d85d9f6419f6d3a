//! The designed mirror as its camera sees it.

use crate::design::Design;
use crate::geom::{DVec2, Ray};
use crate::mirror::HeightAndSlope;
#[cfg(feature = "studio")]
use crate::optics::Camera;
use crate::optics::{ChartedFrame, reflect};
#[cfg(feature = "studio")]
use crate::parallel;

/// The rays that the designed mirror reflects at the centres of a camera's pixels.
#[cfg(feature = "studio")]
pub(crate) struct SmoothCentres {
    /// The camera.
    pub camera: Camera,
    /// A ray a pixel, row by row: none off the mirror.
    pub rays: Vec<Option<Ray>>,
}

/// The designed mirror, for many rays of its camera: as if no part of it were in another's way.
pub(crate) struct SmoothSight<'a> {
    design: &'a Design,
    frame: ChartedFrame,
}

impl<'a> SmoothSight<'a> {
    /// That of `design`.
    pub(crate) fn new(design: &'a Design) -> Self {
        Self { design, frame: ChartedFrame::new(&design.camera) }
    }

    /// The rays that leave the mirror where the camera sees it at `points` of its frame, mm of the picture (best in lines of equal y):
    /// none off the mirror.
    pub(crate) fn reflected(&self, points: &[DVec2]) -> Vec<Option<Ray>> {
        let on_chart: Vec<DVec2> = points.iter().map(|&q| self.frame.chart_point(q)).collect();
        reflected_on_chart(self.design, &on_chart)
    }

    /// The same at the centres of the pixels of `camera`, which has the design's frame in other pixels.
    #[cfg(feature = "studio")]
    pub(crate) fn centres(&self, camera: Camera) -> SmoothCentres {
        let [columns, rows] = camera.pixels;
        let rays = parallel::gather(rows as usize, 1, |rows| {
            let row = |row: usize| {
                let point = |x: u32| camera.image_point(f64::from(x) + 0.5, row as f64 + 0.5);
                self.reflected(&(0..columns).map(point).collect::<Vec<_>>())
            };
            rows.flat_map(row).collect()
        });
        SmoothCentres { camera, rays }
    }
}

/// The rays that leave the designed mirror where the camera sees it at a few `points`, mm of the picture (best in lines of equal y):
/// none off the mirror.
pub(crate) fn reflected(design: &Design, points: &[DVec2]) -> Vec<Option<Ray>> {
    let picture = &design.camera.picture;
    reflected_on_chart(design, &points.iter().map(|&q| picture.chart_point(q)).collect::<Vec<_>>())
}

/// The rays that leave the designed mirror on the camera's rays through the points `on_chart` of its chart, mm (best in lines of equal y):
/// none off the mirror.
pub(crate) fn reflected_on_chart(design: &Design, on_chart: &[DVec2]) -> Vec<Option<Ray>> {
    let Design { mirror, camera, .. } = design;
    let chart = &camera.chart;
    let outline = mirror.full_outline();
    let under = |&q: &DVec2| mirror.intersect_camera_ray(chart, q).unwrap_or(DVec2::INFINITY);
    let places: Vec<DVec2> = on_chart.iter().map(under).collect();
    let leave = |((&q, place), point): ((&DVec2, &DVec2), HeightAndSlope)| {
        outline.contains(*place).then(|| {
            let arriving = chart.ray(q, 0.0).direction;
            let direction = reflect(arriving, mirror.normal(*place, &point));
            Ray { origin: mirror.position(*place, &point), direction }
        })
    };
    on_chart.iter().zip(&places).zip(mirror.eval_many(&places)).map(leave).collect()
}
