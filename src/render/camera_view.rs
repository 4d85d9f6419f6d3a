//! Sight: where the camera's rays go, by a mesh that was read back or by the designed mirror, and the
//! picture of a world that they give.

use super::{Picture, PictureRay, SampleGrid, World};
use crate::design::Design;
use crate::geom::{DVec2, DVec3, Outline, Ray};
use crate::mirror::HeightAndSlope;
use crate::optics::reflect;
use crate::parallel;
use crate::trace::{Outcome, PixelTrace, Scene, TraceResult};

/// A mesh, ready for more rays, and what became of those sent so far.
pub(crate) type TracedMesh = (Scene, TraceResult);

/// What reflects the camera's rays.
#[derive(Clone, Copy)]
pub(crate) enum CameraView<'a> {
    /// A mesh that was read back. The witness's own rays are the pixels' centres; whether a place
    /// between them lies in shadow is taken from its pixel's centre.
    Mesh(&'a TracedMesh),
    /// The designed mirror, as if no part of it were in another's way.
    Smooth,
    /// Nothing.
    Shut,
}

/// How far away a world is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Distance {
    /// On the profile's target surface: a direction from its origin says what is seen. Targets far
    /// away have the ray's own direction.
    Target,
    /// Around the mirror, as far as it is: the ray from the mirror says what is seen.
    Around,
}

/// The picture of `world` that `view` gives the camera of `design`, with `samples_per_side` squared
/// samples at edges.
pub(crate) fn camera_picture(
    design: &Design,
    view: CameraView,
    (world, distance): (&dyn World, Distance),
    samples_per_side: u32,
) -> Picture {
    let camera = &design.camera;
    let [width, height] = camera.pixels;
    // Without a projection: as if the width showed half a turn.
    let half_turn = std::f64::consts::PI / (camera.pixel_mm * f64::from(width));
    let scale = design.view.as_ref().map_or(half_turn, |view| view.projection.radians_per_mm());
    let pixel_rad = camera.pixel_mm * scale;
    let grid = SampleGrid { width, height, samples_per_side, pixel_rad };
    let scene = Photographed { design, distance };
    match view {
        CameraView::Shut => {
            let nothing = vec![MISSED; width as usize * height as usize];
            Picture::paint(&grid, world, &nothing, |_, _| MISSED)
        }
        CameraView::Mesh(mesh) => {
            let centre =
                |pixel: &PixelTrace| scene.on_mesh(pixel.outcome, pixel.hit_point, pixel.direction);
            let centres: Vec<PictureRay> = mesh.1.pixels.iter().map(centre).collect();
            let top = mesh.0.above_mm();
            Picture::paint(&grid, world, &centres, |x, y| scene.by_mesh(mesh, top, [x, y]))
        }
        CameraView::Smooth => {
            let columns: Vec<f64> = (0..width).map(|x| f64::from(x) + 0.5).collect();
            let centres = parallel::gather(height as usize, 1, |rows| {
                rows.flat_map(|y| scene.by_mirror(&columns, y as f64 + 0.5)).collect()
            });
            Picture::paint(&grid, world, &centres, |x, y| scene.by_mirror(&[x], y)[0])
        }
    }
}

const MISSED: PictureRay = PictureRay::lost(Outcome::Missed);

/// A mirror, and how far away the world in it is.
struct Photographed<'a> {
    design: &'a Design,
    distance: Distance,
}

impl Photographed<'_> {
    fn leaving(&self, at: DVec3, direction: DVec3) -> PictureRay {
        let shown = match (self.distance, &self.design.view) {
            (Distance::Target, Some(view)) => view.direction_from_origin(at, direction),
            _ => direction,
        };
        PictureRay::reflected(Ray { origin: at, direction: shown })
    }

    fn on_mesh(&self, outcome: Outcome, at: DVec3, direction: DVec3) -> PictureRay {
        match outcome {
            Outcome::Hit if is_dull(self.design, at) => MISSED,
            Outcome::Hit => self.leaving(at, direction),
            lost => PictureRay::lost(lost),
        }
    }

    /// The ray of a place of the picture, by the mesh whose camera rays start at `top` mm.
    fn by_mesh(&self, (scene, traced): &TracedMesh, top: f64, [x, y]: [f64; 2]) -> PictureRay {
        let camera = &self.design.camera;
        let centre = &traced.pixels[y as usize * camera.pixels[0] as usize + x as usize];
        if let Outcome::Shadowed(_) = centre.outcome {
            return PictureRay::lost(centre.outcome);
        }
        let ray = camera.ray(camera.image_point(x, y), top);
        let end = scene.trace_primary(&ray);
        self.on_mesh(end.outcome, end.hit_point(&ray), end.direction)
    }

    /// The rays of a row of the picture, by the designed mirror.
    fn by_mirror(&self, columns: &[f64], y: f64) -> Vec<PictureRay> {
        let point = |&x: &f64| self.design.camera.image_point(x, y);
        let points: Vec<DVec2> = columns.iter().map(point).collect();
        let painted =
            |end: Option<Ray>| end.map_or(MISSED, |ray| self.leaving(ray.origin, ray.direction));
        reflected(self.design, &points).into_iter().map(painted).collect()
    }
}

/// The rays that leave the designed mirror where the camera sees it at `points` (best in lines of
/// equal y): none off the mirror.
pub(crate) fn reflected(design: &Design, points: &[DVec2]) -> Vec<Option<Ray>> {
    let Design { mirror, camera, .. } = design;
    let outline = mirror.full_outline();
    let under =
        |&q: &DVec2| mirror.intersect_camera_ray(&camera.chart, q).unwrap_or(DVec2::INFINITY);
    let places: Vec<DVec2> = points.iter().map(under).collect();
    let leave = |((&q, place), point): ((&DVec2, &DVec2), HeightAndSlope)| {
        outline.contains(*place).then(|| {
            let arriving = camera.ray(q, 0.0).direction;
            let direction = reflect(arriving, mirror.normal(*place, &point));
            Ray { origin: mirror.position(*place, &point), direction }
        })
    };
    points.iter().zip(&places).zip(mirror.eval_many(&places)).map(leave).collect()
}

/// Whether a place of the part is not polished: the land inside a ring, and what is below the mirror.
fn is_dull(design: &Design, at: DVec3) -> bool {
    let land = match design.mirror.outline {
        Outline::Ring { inner, .. } => design.mirror.chart.coordinates(at).0.length() < inner,
        Outline::Rect(_) => false,
    };
    land || design.border.as_ref().is_some_and(|s| at.z <= s.top_mm * (1.0 + 1e-6))
}
