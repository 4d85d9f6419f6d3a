//! The second half of a build, which starts from bytes: read, check, trace, look.

use super::files::sha256;
use super::observer::{Clock, Stage};
use super::shape::worst_vertex;
use crate::design::Design;
use crate::export::{ReadError, Reread, read_obj, read_stl};
use crate::geom::DVec3;
use crate::optics::reflect;
use crate::profile::{Format, Profile};
use crate::render::{Canvas, EncodingError, Picture, Seen as Painted, TestWorld};
use crate::report::{ErrorFacts, FileFacts, SolidFacts, TraceFacts, VertexFacts};
use crate::solid::check;
use crate::trace::{Errors, Frame, Intent, Outcome, Scene, Seen, Witness, glance};

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
    /// The frame.
    pub frame: Option<Frame>,
    /// The mesh, ready for more rays, and what became of those sent so far.
    pub seen: Option<(Scene, Witness)>,
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
    bytes: &[u8],
) -> Evidence {
    let name = format!("mirror.{format}");
    let read = || {
        let reread = match format {
            Format::Stl => read_stl(bytes),
            Format::Obj => read_obj(bytes),
        };
        let reread = reread.map(|reread| {
            let solid = SolidFacts::new(&check(&reread.mesh), design.mirror.volume());
            let vertex = worst_vertex(&design.mirror, &reread.mesh.vertices);
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
        let ((reread, note), sha256) = rayon::join(read, || sha256(bytes));
        ((reread, sha256), note)
    });
    let file =
        FileFacts { name: name.clone(), format: format.name(), bytes: bytes.len() as u64, sha256 };
    let (Reread { mesh, normals }, solid, vertex) = match reread {
        Ok(reread) => reread,
        Err(error) => {
            let unreadable = Some(error);
            return Evidence {
                file,
                altered: false,
                unreadable,
                trace: None,
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
            Witness::trace(&scene, normals.as_deref(), &design.image, camera.pixels, table);
        let frame = Frame::new(&witness, camera.pixels, camera.pixel_mm, tolerance_px);
        let has_normals = normals.is_some();
        let mut trace = trace_facts(name.clone(), &witness, camera.pixel_mm, has_normals, solid);
        trace.worst_vertex = vertex;
        let note = format!("{name}: {} rays aimed at the mirror", trace.rays);
        let evidence = Evidence {
            file,
            altered: false,
            unreadable: None,
            trace: Some(trace),
            frame: Some(frame),
            seen: Some((scene, witness)),
        };
        (evidence, note)
    })
}

/// The table of intended rays, a row of the sensor at a time.
fn intents(design: &Design, scene: &Scene) -> impl Fn(u32) -> Vec<Intent> {
    let Design { mirror, image, camera, .. } = design;
    let outline = mirror.outline();
    let top = above(scene);
    move |row| {
        let y = camera.image_point(0.0, f64::from(row) + 0.5).y;
        let line = mirror.row(y);
        let intent = |column: u32| {
            let point = camera.image_point(f64::from(column) + 0.5, f64::from(row) + 0.5);
            let ray = camera.ray(point, top);
            let aimed = outline.contains(point);
            let (wanted, designed) = if aimed {
                (image.wanted(point), reflect(ray.direction, line.at(point.x).normal()))
            } else {
                (DVec3::Z, DVec3::Z)
            };
            Intent { ray, point, aimed, wanted, designed }
        };
        (0..camera.pixels[0]).map(intent).collect()
    }
}

fn trace_facts(
    file: String,
    witness: &Witness,
    pixel_mm: f64,
    has_normals: bool,
    solid: SolidFacts,
) -> TraceFacts {
    let facts = |errors: fn(&Seen) -> Option<Errors>| {
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
        errors: facts(|seen| Some(seen.errors)),
        interpolated_normals: has_normals.then(|| facts(|seen| seen.smooth)),
        worst_vertex: None,
        solid,
    }
}

/// What the camera sees of the test world in the mesh that was read back, as PNG. The witness's own
/// rays are the pixel centres.
pub fn picture(design: &Design, seen: Option<&(Scene, Witness)>) -> Result<Vec<u8>, EncodingError> {
    let Design { camera, image, .. } = design;
    let [width, height] = camera.pixels;
    let canvas = Canvas {
        width,
        height,
        samples_per_side: 2,
        pixel_rad: camera.pixel_mm / image.strip.scale_mm,
    };
    let painted = |outcome: Outcome, direction: DVec3| match outcome {
        Outcome::Hit => Painted::World(direction),
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
        witness.seen.iter().map(|seen| painted(seen.outcome, seen.direction)).collect();
    let top = above(scene);
    // Between the centres: whether a place lies in shadow is taken from its pixel's centre.
    let see = |x: f64, y: f64| {
        let centre = &witness.seen[y as usize * width as usize + x as usize];
        if let Outcome::Shadowed(_) = centre.outcome {
            return Painted::Shadowed;
        }
        let (outcome, _, direction) = glance(scene, &camera.ray(camera.image_point(x, y), top));
        painted(outcome, direction)
    };
    Picture::paint(&canvas, &world, &centres, see).to_png()
}

/// A height above everything in the file, mm, for camera rays to start from.
fn above(scene: &Scene) -> f64 {
    scene.mesh().bounds().map_or(0.0, |(lo, hi)| hi.z + (hi - lo).max_element())
}
