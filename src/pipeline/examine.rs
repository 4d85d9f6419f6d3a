//! The second half of a build, which starts from bytes: read, check, trace, look.

use super::files::sha256;
use super::observer::{Clock, Stage};
use crate::design::Design;
use crate::export::{ReadError, Reread, read_obj, read_stl};
use crate::geom::{DVec2, DVec3};
use crate::optics::reflect;
use crate::profile::{Format, Profile};
use crate::render::{Canvas, Picture, Seen as Painted, TestWorld};
use crate::report::{ErrorFacts, FileFacts, SolidFacts, TraceFacts};
use crate::solid::check;
use crate::trace::{Errors, Frame, Intent, Outcome, Scene, Seen, Witness, look};

/// What the bytes of one file showed.
pub struct Evidence {
    /// The file.
    pub file: FileFacts,
    /// Why it could not be read, if so; then there is no more.
    pub unreadable: Option<ReadError>,
    /// The witness's figures.
    pub trace: Option<TraceFacts>,
    /// The frame.
    pub frame: Option<Frame>,
    /// The mesh, ready for more rays.
    pub scene: Option<Scene>,
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
            (reread, solid)
        });
        let note = match &reread {
            Ok((reread, _)) => format!("{name}: {} triangles", reread.mesh.triangles.len()),
            Err(error) => format!("{name}: {error}"),
        };
        (reread, note)
    };
    let (reread, sha256) = clock.always(Stage::Read, || {
        let ((reread, note), sha256) = rayon::join(read, || sha256(bytes));
        ((reread, sha256), note)
    });
    let file = FileFacts {
        name: name.clone(),
        format: format.name(),
        bytes: bytes.len() as u64,
        sha256,
    };
    let (Reread { mesh, normals }, solid) = match reread {
        Ok(reread) => reread,
        Err(error) => {
            let unreadable = Some(error);
            return Evidence {
                file,
                unreadable,
                trace: None,
                frame: None,
                scene: None,
            };
        }
    };
    let (scene, witness) = clock.always(Stage::Trace, || {
        let scene = Scene::new(mesh);
        let rows = design.camera.pixels[1] as usize;
        let table = intents(design, &scene);
        let witness = Witness::trace(&scene, normals.as_deref(), &design.image, rows, table);
        let note = format!(
            "{name}: {} rays aimed at the mirror",
            witness.aimed().count()
        );
        ((scene, witness), note)
    });
    let camera = &design.camera;
    // Without a limit of its own a profile counts a pixel as filled while its content lies within
    // a hundredth of the frame's width from where it should.
    let tolerance_px = profile
        .accept
        .pixel_error_max_px
        .unwrap_or(0.01 * f64::from(camera.pixels[0]));
    let frame = Frame::new(&witness, camera.pixels, camera.pixel_mm, tolerance_px);
    let trace = trace_facts(name, &witness, camera.pixel_mm, normals.is_some(), solid);
    Evidence {
        file,
        unreadable: None,
        trace: Some(trace),
        frame: Some(frame),
        scene: Some(scene),
    }
}

/// The table of intended rays, a row of the sensor at a time.
fn intents(design: &Design, scene: &Scene) -> impl Fn(usize) -> Vec<Intent> {
    let Design {
        mirror,
        image,
        camera,
        ..
    } = design;
    let outline = mirror.outline();
    // Camera rays start above everything in the file.
    let top = scene
        .mesh()
        .bounds()
        .map_or(0.0, |(lo, hi)| hi.z + (hi - lo).max_element());
    move |row| {
        let y = camera.image_point(0.0, row as f64 + 0.5).y;
        let line = mirror.row(y);
        let intent = |column: u32| {
            let point = camera.image_point(f64::from(column) + 0.5, row as f64 + 0.5);
            let ray = camera.ray(point, top);
            let aimed = outline.contains(point);
            let (wanted, designed) = if aimed {
                (
                    image.wanted(point),
                    reflect(ray.direction, line.at(point.x).normal()),
                )
            } else {
                (DVec3::Z, DVec3::Z)
            };
            Intent {
                ray,
                point,
                aimed,
                wanted,
                designed,
            }
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
    let facts = |errors: &dyn Fn(&Seen) -> Option<Errors>| {
        let summary = |pick: &dyn Fn(Errors) -> f64, unit: f64| {
            witness
                .summary(|seen| errors(seen).map(pick))
                .map(|s| s.scaled(unit))
        };
        ErrorFacts {
            ray_error_mrad: summary(&|e| e.ray, 1e3),
            pixel_error_px: summary(&|e| e.image_mm, 1.0 / pixel_mm),
            facet_error_px: summary(&|e| e.facet_mm, 1.0 / pixel_mm),
        }
    };
    TraceFacts {
        file,
        rays: witness.aimed().count(),
        hit: witness.count(|o| o == Outcome::Hit),
        missed: witness.count(|o| o == Outcome::Missed),
        shadowed: witness.count(|o| matches!(o, Outcome::Shadowed(_))),
        back_face: witness.count(|o| o == Outcome::BackFace),
        errors: facts(&|seen| Some(seen.errors)),
        interpolated_normals: has_normals.then(|| facts(&|seen| seen.smooth)),
        solid,
    }
}

/// What the camera sees of the test world in the mesh that was read back, as PNG.
pub fn picture(design: &Design, scene: Option<&Scene>) -> Result<Vec<u8>, impl std::fmt::Display> {
    let Design { camera, image, .. } = design;
    let canvas = Canvas {
        width: camera.pixels[0],
        height: camera.pixels[1],
        samples_per_side: 2,
        pixel_rad: camera.pixel_mm / image.strip.scale_mm,
    };
    let top = scene
        .and_then(|s| s.mesh().bounds())
        .map_or(0.0, |(lo, hi)| hi.z + (hi - lo).max_element());
    let see = |x: f64, y: f64| {
        let point: DVec2 = camera.image_point(x, y);
        let Some(scene) = scene else {
            return Painted::Missed;
        };
        match look(scene, &camera.ray(point, top)) {
            (Outcome::Hit, _, direction) => Painted::World(direction),
            (Outcome::Missed, ..) => Painted::Missed,
            (Outcome::Shadowed(_), ..) => Painted::Shadowed,
            (Outcome::BackFace, ..) => Painted::BackFace,
        }
    };
    Picture::paint(&canvas, &TestWorld::new(), see).to_png()
}
