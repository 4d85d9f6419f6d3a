//! Sight: where the camera's rays go, by a mesh that was read back or by the designed mirror, and the
//! picture of a world that they give.

use super::picture::StripPainter;
use super::samples::{EdgePixels, LineByLine, OneByOne, SampleGrid, SampleSight, Sight};
#[cfg(feature = "studio")]
use super::smooth_sight::SmoothCentres;
use super::smooth_sight::SmoothSight;
use super::{Picture, PictureRay, World};
use crate::design::Design;
use crate::geom::{DVec2, DVec3, Outline, Ray};
use crate::optics::Camera;
use crate::parallel::{self, ScratchPool};
use crate::raster::png;
use crate::trace::{
    CameraTrace, Obstacles, Outcome, PixelTrace, RayEnd, SampleRays, SampleTrace, Scene, TraceStrip,
};
use std::convert::Infallible;
use std::io::{self, Write};
use std::ops::Range;

/// A mesh, ready for more rays.
pub(crate) struct TracedMesh {
    /// The mesh.
    pub scene: Scene,
    /// The rays that the pixels' centres have reflected, row by row.
    pub centres: ReflectedCentres,
}

/// The rays that the pixels' centres of a frame reflect, as long as they are few enough to be kept.
#[derive(Default)]
pub(crate) struct ReflectedCentres(Vec<PictureRay>);

impl ReflectedCentres {
    /// Adds those of the next strip.
    pub(crate) fn add(&mut self, strip: &TraceStrip) {
        let [columns, rows] = strip.frame;
        if columns * rows > CameraTrace::STRIP_PIXELS {
            return;
        }
        let (first, pixels) = (self.0.len(), &strip.pixels);
        self.0.reserve_exact(columns * rows - first);
        self.0.resize(first + pixels.len(), MISSED);
        parallel::for_each_mut(&mut self.0[first..], 4096, |k, ray| {
            let PixelTrace { outcome, hit_point, direction, .. } = pixels[k];
            *ray = PictureRay { outcome, leaving: Ray { origin: hit_point, direction } };
        });
    }
}

/// What reflects the camera's rays.
#[derive(Clone, Copy)]
pub(crate) enum CameraView<'a> {
    /// A mesh that was read back. Whether a place between the pixels' centres lies in shadow is taken from
    /// its pixel's centre.
    Mesh(&'a TracedMesh),
    /// The designed mirror.
    Smooth(&'a SmoothSight<'a>),
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

/// A picture that a camera takes of a world in a mirror; it is painted strip by strip, so that its memory does
/// not grow with the frame.
pub(crate) struct CameraPicture<'a> {
    design: &'a Design,
    view: CameraView<'a>,
    distance: Distance,
    camera: Camera,
    samples_per_side: u32,
    turned: bool,
    /// The rays that the designed mirror reflects at the pixels' centres, row by row, where they are known.
    centres: Option<&'a [Option<Ray>]>,
    /// What hides the designed mirror and what it shows; a mesh has its own.
    obstacles: Option<Obstacles>,
}

impl<'a> CameraPicture<'a> {
    /// The picture of a world at `distance` that `view` gives the camera of `design`, with
    /// `samples_per_side` squared samples at edges.
    pub(crate) fn new(
        design: &'a Design,
        view: CameraView<'a>,
        distance: Distance,
        samples_per_side: u32,
    ) -> Self {
        let camera = design.camera;
        let obstacles = match view {
            CameraView::Smooth(_) => Obstacles::new(&design.obstacles, design.view.as_ref()),
            CameraView::Mesh(_) | CameraView::Shut => None,
        };
        let (turned, centres) = (false, None);
        Self { design, view, distance, camera, samples_per_side, turned, centres, obstacles }
    }

    /// The same of a camera with fewer pixels, if it has more than `columns` of them in a row.
    pub(crate) fn at_most(mut self, columns: u32) -> Self {
        self.camera = self.camera.at_most(columns);
        self.centres = None;
        self
    }

    /// The same of the camera whose rays are known.
    #[cfg(feature = "studio")]
    pub(crate) fn of_centres(self, centres: &'a SmoothCentres) -> Self {
        Self { camera: centres.camera, centres: Some(&centres.rays), ..self }
    }

    /// The same of a camera that is held upside down.
    pub(crate) fn turned(self) -> Self {
        Self { turned: true, ..self }
    }

    /// Columns and rows.
    pub(crate) fn pixels(&self) -> [u32; 2] {
        self.camera.pixels
    }

    /// The picture of `world`.
    pub(crate) fn picture(&self, world: &dyn World) -> Picture {
        let [width, height] = self.pixels();
        let mut rgb = Vec::with_capacity(3 * width as usize * height as usize);
        let Ok(samples) = self.paint::<Infallible>(world, |rows| {
            rgb.extend_from_slice(rows);
            Ok(())
        });
        Picture { width, height, rgb, samples }
    }

    /// Writes the picture of `world` as PNG, and returns the number of its samples.
    ///
    /// # Errors
    /// That of `out`.
    pub(crate) fn write_png(&self, world: &dyn World, out: &mut dyn Write) -> io::Result<u64> {
        png::write_rows(out, self.pixels(), |out| self.paint(world, |rows| out.write_all(rows)))
    }

    fn paint<E>(
        &self,
        world: &dyn World,
        done: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<u64, E> {
        let [width, height] = self.camera.pixels;
        let painter = StripPainter::new(self.grid(), world);
        let all = height as usize;
        // The rows of the sensor that are some of the picture's, and their rays in the picture's order.
        let rows_of = |rows: Range<usize>| match self.turned {
            true => all - rows.end..all - rows.start,
            false => rows,
        };
        let ordered = |mut rays: Vec<PictureRay>| {
            if self.turned {
                rays.reverse();
            }
            rays
        };
        let in_order = |strips: Vec<Range<usize>>| match self.turned {
            true => strips.into_iter().rev().map(rows_of).collect(),
            false => strips,
        };
        let trace = match self.view {
            CameraView::Mesh(mesh) => {
                Some(CameraTrace::new(&mesh.scene, &self.camera, mesh.scene.above_mm()))
            }
            _ => None,
        };
        let strips = match &trace {
            Some(trace) => in_order(trace.strips()),
            None => in_order((0..all).step_by(ROWS).map(|y| y..(y + ROWS).min(all)).collect()),
        };
        let centres = |rows: Range<usize>| {
            let rows = rows_of(rows);
            ordered(match (self.view, &trace) {
                (CameraView::Mesh(mesh), Some(trace)) => self.centres_on_mesh(mesh, trace, rows),
                (CameraView::Smooth(sight), _) => self.centres_on_mirror(sight, rows),
                _ => vec![MISSED; width as usize * rows.len()],
            })
        };
        self.paint_samples(&painter, strips, centres, done)
    }

    /// Paints strips of which `centres` gives the rays of the pixels' centres, with the samples that the view sees.
    fn paint_samples<E>(
        &self,
        painter: &StripPainter,
        strips: Vec<Range<usize>>,
        centres: impl FnMut(Range<usize>) -> Vec<PictureRay>,
        done: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<u64, E> {
        let size = self.camera.pixels.map(f64::from);
        // A place of the picture on the sensor.
        let on_sensor = |axis: usize, x: f64| if self.turned { size[axis] - x } else { x };
        match self.view {
            CameraView::Mesh(TracedMesh { scene, .. }) => {
                let one_by_one = OneByOne(|centre: &PictureRay, [x, y]: [f64; 2]| {
                    self.on_mesh_at(scene, centre, [on_sensor(0, x), on_sensor(1, y)])
                });
                if self.turned {
                    scene.prepare_search();
                    return painter.paint(strips, centres, &one_by_one, done);
                }
                let side = self.samples_per_side.max(1);
                let rays = SampleRays::new(&self.camera, scene.above_mm(), side);
                let sight = MeshSight { picture: self, scene, rays, one_by_one };
                painter.paint(strips, centres, &sight, done)
            }
            CameraView::Smooth(sight) => {
                let line_by_line = LineByLine(|columns: &[f64], y: f64| {
                    let columns: Vec<f64> = columns.iter().map(|x| on_sensor(0, *x)).collect();
                    self.on_mirror(sight, &columns, on_sensor(1, y))
                });
                painter.paint(strips, centres, &line_by_line, done)
            }
            CameraView::Shut => {
                let nothing = LineByLine(|columns: &[f64], _: f64| vec![MISSED; columns.len()]);
                painter.paint(strips, centres, &nothing, done)
            }
        }
    }

    /// Its pixels and samples.
    fn grid(&self) -> SampleGrid {
        let Camera { pixels: [width, height], pixel_mm, .. } = self.camera;
        // Without a projection: as if the width showed half a turn.
        let half_turn = std::f64::consts::PI / (pixel_mm * f64::from(width));
        let scale =
            self.design.view.as_ref().map_or(half_turn, |view| view.projection.radians_per_mm());
        let samples_per_side = self.samples_per_side;
        SampleGrid { width, height, samples_per_side, pixel_rad: pixel_mm * scale }
    }

    /// The rays of the pixels' centres of some rows, by a mesh.
    fn centres_on_mesh(
        &self,
        mesh: &TracedMesh,
        trace: &CameraTrace,
        rows: Range<usize>,
    ) -> Vec<PictureRay> {
        let width = self.camera.pixels[0] as usize;
        let centres = &mesh.centres.0;
        let known = centres.len() == width * self.camera.pixels[1] as usize;
        if known && self.camera == self.design.camera {
            let centres = &centres[rows.start * width..rows.end * width];
            return parallel::map_slice(centres, 4096, |end| {
                self.on_mesh(end.outcome, end.leaving.origin, end.leaving.direction)
            });
        }
        let first = rows.start;
        let (ends, _) = trace.run_rows(rows);
        parallel::map(ends.len(), 4096, |k| {
            let (column, row) = ((k % width) as u32, (first + k / width) as u32);
            let ray = trace.ray(column, row);
            self.on_mesh(ends[k].outcome, ends[k].hit_point(&ray), ends[k].direction)
        })
    }

    /// The same by the designed mirror.
    fn centres_on_mirror(&self, sight: &SmoothSight, rows: Range<usize>) -> Vec<PictureRay> {
        let width = self.camera.pixels[0] as usize;
        let columns: Vec<f64> = (0..width).map(|x| x as f64 + 0.5).collect();
        let first = rows.start;
        let row = |row: usize| match self.centres {
            Some(rays) => {
                let points = self.points(&columns, row as f64 + 0.5);
                self.painted(&points, &rays[row * width..(row + 1) * width])
            }
            None => self.on_mirror(sight, &columns, row as f64 + 0.5),
        };
        parallel::gather(rows.len(), 1, |rows| rows.flat_map(|y| row(first + y)).collect())
    }

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

    /// The ray of a place of the pixel whose centre's is `centre`, by a mesh.
    fn on_mesh_at(&self, scene: &Scene, centre: &PictureRay, [x, y]: [f64; 2]) -> PictureRay {
        if let Outcome::Shadowed(_) = centre.outcome {
            return *centre;
        }
        let ray = self.camera.ray(self.camera.image_point(x, y), scene.above_mm());
        let end = scene.trace_primary(&ray);
        self.on_mesh(scene.obstructed(&ray, &end), end.hit_point(&ray), end.direction)
    }

    /// The obstacle that hides what the camera sees at `point`, where the designed mirror reflects its ray as `end`.
    fn hidden(&self, point: DVec2, end: Option<&Ray>) -> Option<u32> {
        let obstacles = self.obstacles.as_ref()?;
        let top_mm = obstacles.above_mm().max(2.0 * self.design.mounting.size_mm[2]);
        obstacles.on_the_way(&self.camera.ray(point, top_mm), end)
    }

    /// The rays of places of a row of the picture, by the designed mirror.
    fn on_mirror(&self, sight: &SmoothSight, columns: &[f64], y: f64) -> Vec<PictureRay> {
        let points = self.points(columns, y);
        self.painted(&points, &sight.reflected(&points))
    }

    /// Image points of places of a row, mm.
    fn points(&self, columns: &[f64], y: f64) -> Vec<DVec2> {
        columns.iter().map(|x| self.camera.image_point(*x, y)).collect()
    }

    /// The picture's rays of image points at which the designed mirror reflects these rays.
    fn painted(&self, points: &[DVec2], reflected: &[Option<Ray>]) -> Vec<PictureRay> {
        let ray = |(&point, end): (&DVec2, &Option<Ray>)| match self.hidden(point, end.as_ref()) {
            Some(number) => PictureRay::lost(Outcome::Obstructed(number)),
            None => end.map_or(MISSED, |ray| self.leaving(ray.origin, ray.direction)),
        };
        points.iter().zip(reflected).map(ray).collect()
    }
}

/// What the camera sees in a mesh at the samples of pixels: their rays are rasterized, and where that cannot be
/// searched for.
struct MeshSight<'a, F> {
    picture: &'a CameraPicture<'a>,
    scene: &'a Scene,
    rays: SampleRays,
    one_by_one: OneByOne<F>,
}

impl<F: Fn(&PictureRay, [f64; 2]) -> PictureRay + Sync> Sight for MeshSight<'_, F> {
    fn samples<'a>(&'a self, pixels: EdgePixels<'a>) -> SampleSight<'a> {
        let EdgePixels { grid, first, centres, edges } = pixels;
        let (width, side) = (grid.width as usize, grid.samples_per_side.max(1) as usize);
        let strip = first..first + centres.len() / width.max(1);
        let wanted = self.rays.wanted(edges);
        let Some(trace) = SampleTrace::new(self.scene, &self.rays, strip, wanted) else {
            self.scene.prepare_search();
            return self.one_by_one.samples(pixels);
        };
        let scratch: ScratchPool<Vec<RayEnd>> = ScratchPool::default();
        let columns = width * side;
        let see =
            move |ends: &[RayEnd], rows: &Range<usize>, (pixel, [x, y]): (usize, [f64; 2])| {
                let centre = &centres[pixel];
                if let Outcome::Shadowed(_) = centre.outcome {
                    return *centre;
                }
                let (column, row) = ((x * side as f64) as usize, (y * side as f64) as usize);
                let end = &ends[(row - rows.start * side) * columns + column];
                let ray = self.rays.at(column, row);
                let outcome = self.scene.obstructed(&ray, end);
                self.picture.on_mesh(outcome, end.hit_point(&ray), end.direction)
            };
        Box::new(move |rows, take| {
            scratch.with(|ends| {
                trace.ends_into(rows.clone(), ends);
                let mut rays = Vec::new();
                for y in rows.clone() {
                    rays.clear();
                    rays.extend(pixels.samples(y..y + 1).map(|sample| see(ends, &rows, sample)));
                    take(&rays);
                }
            });
        })
    }
}

const MISSED: PictureRay = PictureRay::lost(Outcome::Missed);
/// Rows of a strip where nothing is traced.
const ROWS: usize = 128;

/// Whether a place of the part is not polished: the land inside a ring, and what is below the mirror.
fn is_dull(design: &Design, at: DVec3) -> bool {
    let land = match design.mirror.outline {
        Outline::Ring { inner, .. } => design.mirror.chart.coordinates(at).0.length() < inner,
        Outline::Rect(_) => false,
    };
    land || design.border.as_ref().is_some_and(|s| at.z <= s.top_mm * (1.0 + 1e-6))
}
