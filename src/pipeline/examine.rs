//! The second half of a build, which starts from bytes: read, check, trace, look.

use super::files::sha256;
use super::formats::read_mesh;
use super::observer::{Clock, Stage};
use super::shape::worst_vertex;
use crate::design::Design;
use crate::export::{ReadError, Reread};
use crate::geom::{DVec2, DVec3, Outline};
use crate::mirror::Point;
use crate::optics::reflect;
use crate::profile::{Format, Profile};
use crate::render::{Canvas, EncodingError, Picture, Seen as Painted, TestWorld};
use crate::report::{ErrorFacts, FileFacts, SolidFacts, TraceFacts, VertexFacts};
use crate::solid::check;
use crate::trace::{self, Errors, Frame, Intent, Outcome, Scene, Witness, glance};

/// A mesh, ready for more rays, and what became of those sent so far.
pub type Seen = (Scene, Witness);

/// What the bytes of one file showed.
pub struct Evidence {
    /// The file.
    pub file: FileFacts,
    /// Whether the bytes are others than were written.
    pub altered: bool,
    /// Why it could not be read, if so; then there is no more.
    pub unreadable: Option<ReadError>,
    /// The witness's figures.
    pub trace: Option<TraceFacts>,
    /// How many rays what is around the mirror shadows.
    pub by_rim: usize,
    /// The frame.
    pub frame: Option<Frame>,
    /// The mesh and its rays, until the picture is painted.
    pub seen: Option<Seen>,
}

impl Evidence {
    /// Calls the file `name`.
    pub fn rename(&mut self, name: String) {
        if let Some(trace) = &mut self.trace {
            trace.file.clone_from(&name);
        }
        self.file.name = name;
    }
}

/// Reads, checks and traces the bytes of a mesh file against `design`.
pub fn examine(
    clock: &Clock,
    profile: &Profile,
    design: &Design,
    format: Format,
    bytes: Vec<u8>,
) -> Evidence {
    let name = format.file_name().to_owned();
    let length = bytes.len() as u64;
    let read = || {
        let reread = read_mesh(format, &bytes).map(|reread| {
            let check = check(&reread.mesh).through(design.holes());
            let solid = SolidFacts::new(&check, design.volume());
            let vertex = worst_vertex(design, &reread.mesh.vertices);
            let vertex = vertex.map(|(vertex, off)| {
                let at = reread.mesh.vertices[vertex].to_array();
                VertexFacts { at_mm: at, off_mm: off }
            });
            (reread, solid, vertex)
        });
        let note = match &reread {
            Ok((reread, ..)) => format!("{name}: {} triangles", reread.mesh.triangles.len()),
            Err(error) => format!("{name}: {error}"),
        };
        (reread, note)
    };
    let (reread, sha256) = clock.always(Stage::Read, || {
        let ((reread, note), sha256) = rayon::join(read, || sha256(&bytes));
        ((reread, sha256), note)
    });
    // The rays need the mesh alone.
    drop(bytes);
    let file = FileFacts { name: name.clone(), format: format.name(), bytes: length, sha256 };
    let (Reread { mesh, normals }, solid, vertex) = match reread {
        Ok(reread) => reread,
        Err(error) => {
            let unreadable = Some(error);
            return Evidence {
                file,
                altered: false,
                unreadable,
                trace: None,
                by_rim: 0,
                frame: None,
                seen: None,
            };
        }
    };
    let camera = &design.camera;
    // Without a limit of its own a profile counts a pixel as filled while its content lies within
    // a hundredth of the frame's width from where it should.
    let tolerance_px =
        profile.accept.pixel_error_max_px.unwrap_or(0.01 * f64::from(camera.pixels[0]));
    clock.always(Stage::Trace, || {
        let scene = Scene::new(mesh);
        let table = intents(design, &scene);
        let witness =
            Witness::trace(&scene, normals.as_deref(), design.view.as_ref(), camera.pixels, table);
        let frame = design
            .view
            .is_some()
            .then(|| Frame::new(&witness, camera.pixels, camera.pixel_mm, tolerance_px));
        let has_normals = normals.is_some();
        let mut trace = trace_facts(name.clone(), &witness, camera.pixel_mm, has_normals, solid);
        trace.worst_vertex = vertex;
        let note = format!("{name}: {} rays aimed at the mirror", trace.rays);
        let evidence = Evidence {
            file,
            altered: false,
            unreadable: None,
            trace: Some(trace),
            by_rim: by_rim(design, &scene, &witness),
            frame,
            seen: Some((scene, witness)),
        };
        (evidence, note)
    })
}

fn by_rim(design: &Design, scene: &Scene, witness: &Witness) -> usize {
    let Some(stock) = &design.stock else { return 0 };
    let top = stock.top_mm * (1.0 + 1e-6);
    let around = |facet: u32| scene.mesh().corners(facet as usize).iter().all(|v| v.z <= top);
    witness.count(|outcome| matches!(outcome, Outcome::Shadowed(facet) if around(facet)))
}

/// The table of intended rays, a row of the sensor at a time.
fn intents(design: &Design, scene: &Scene) -> impl Fn(u32) -> Vec<Intent> {
    let Design { mirror, view, camera, .. } = design;
    let outline = mirror.whole();
    let top = above(scene);
    move |row| {
        let image_point =
            |column: u32| camera.image_point(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let points: Vec<DVec2> = (0..camera.pixels[0]).map(image_point).collect();
        let places: Vec<DVec2> = points
            .iter()
            .map(|&q| mirror.under(&camera.chart, q).unwrap_or(DVec2::INFINITY))
            .collect();
        let designed = mirror.along(&places);
        let intent = |((point, place), designed): ((DVec2, DVec2), Point)| {
            let ray = camera.ray(point, top);
            let aimed = outline.aims(place);
            let mut intent = Intent { ray, point, aimed, wanted: DVec3::Z, designed: DVec2::ZERO };
            if let (true, Some(view)) = (aimed, view) {
                let at = mirror.place(place, &designed);
                intent.wanted = view.wanted(point, at);
                let direction = reflect(ray.direction, mirror.normal(place, &designed));
                intent.designed = view.locate(at, direction, point);
            }
            intent
        };
        points.into_iter().zip(places).zip(designed).map(intent).collect()
    }
}

fn trace_facts(
    file: String,
    witness: &Witness,
    pixel_mm: f64,
    has_normals: bool,
    solid: SolidFacts,
) -> TraceFacts {
    let facts = |errors: fn(&trace::Seen) -> Option<Errors>| {
        let summary = |pick: fn(Errors) -> f64, unit: f64| {
            witness.summary(|seen| errors(seen).map(pick)).map(|s| s.scaled(unit))
        };
        let (ray_error_mrad, (pixel_error_px, facet_error_px)) = rayon::join(
            || summary(|e| e.ray, 1e3),
            || {
                rayon::join(
                    || summary(|e| e.image_mm, 1.0 / pixel_mm),
                    || summary(|e| e.facet_mm, 1.0 / pixel_mm),
                )
            },
        );
        ErrorFacts { ray_error_mrad, pixel_error_px, facet_error_px }
    };
    TraceFacts {
        file,
        rays: witness.aimed().count(),
        hit: witness.count(|o| o == Outcome::Hit),
        missed: witness.count(|o| o == Outcome::Missed),
        shadowed: witness.count(|o| matches!(o, Outcome::Shadowed(_))),
        back_face: witness.count(|o| o == Outcome::BackFace),
        errors: facts(|seen| seen.errors),
        interpolated_normals: has_normals.then(|| facts(|seen| seen.smooth)),
        worst_vertex: None,
        solid,
    }
}

/// What the camera sees of the test world in the mesh that was read back, as PNG. The witness's own
/// rays are the pixel centres.
pub fn picture(design: &Design, seen: Option<&Seen>) -> Result<Vec<u8>, EncodingError> {
    let Design { camera, view, .. } = design;
    let [width, height] = camera.pixels;
    // Without a projection: as if the width showed half a turn.
    let half_turn = std::f64::consts::PI / (camera.pixel_mm * f64::from(width));
    let scale = view.as_ref().map_or(half_turn, |view| view.projection.radians_per_mm());
    let canvas = Canvas { width, height, samples_per_side: 2, pixel_rad: camera.pixel_mm * scale };
    // Neither the land inside a ring is polished nor what is below the mirror.
    let land = |at: DVec3| match design.mirror.outline {
        Outline::Ring { inner, .. } => design.mirror.chart.coordinates(at).0.length() < inner,
        Outline::Rect(_) => false,
    };
    let below = |at: DVec3| design.stock.as_ref().is_some_and(|s| at.z <= s.top_mm * (1.0 + 1e-6));
    let painted = |outcome: Outcome, at: DVec3, direction: DVec3| match outcome {
        Outcome::Hit if land(at) || below(at) => Painted::Missed,
        Outcome::Hit => {
            Painted::World(view.as_ref().map_or(direction, |view| view.shown(at, direction)))
        }
        Outcome::Missed => Painted::Missed,
        Outcome::Shadowed(_) => Painted::Shadowed,
        Outcome::BackFace => Painted::BackFace,
    };
    let world = TestWorld::new();
    let Some((scene, witness)) = seen else {
        let nothing = vec![Painted::Missed; width as usize * height as usize];
        return Picture::paint(&canvas, &world, &nothing, |_, _| Painted::Missed).to_png();
    };
    let centres: Vec<Painted> =
        witness.seen.iter().map(|seen| painted(seen.outcome, seen.at, seen.direction)).collect();
    let top = above(scene);
    // Between the centres: whether a place lies in shadow is taken from its pixel's centre.
    let see = |x: f64, y: f64| {
        let centre = &witness.seen[y as usize * width as usize + x as usize];
        if let Outcome::Shadowed(_) = centre.outcome {
            return Painted::Shadowed;
        }
        let ray = camera.ray(camera.image_point(x, y), top);
        let (outcome, hit, direction) = glance(scene, &ray);
        painted(outcome, hit.map_or(DVec3::ZERO, |hit| ray.at(hit.t)), direction)
    };
    Picture::paint(&canvas, &world, &centres, see).to_png()
}

/// A height above everything in the file, mm, for camera rays to start from.
fn above(scene: &Scene) -> f64 {
    scene.mesh().bounds().map_or(0.0, |(lo, hi)| hi.z + (hi - lo).max_element())
}
