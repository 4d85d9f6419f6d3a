//! The second half of a build, which starts from bytes: read, check, trace, look.

use super::files::sha256;
use super::formats::read_mesh;
use super::observer::{Clock, Stage};
use super::shape::worst_vertex;
use super::sight::{Seen, above};
use crate::design::Design;
use crate::export::{ReadError, Reread};
use crate::geom::{DVec2, DVec3};
use crate::mirror::Point;
use crate::optics::reflect;
use crate::profile::{Format, Profile};
use crate::report::{ErrorFacts, FileFacts, SolidFacts, TraceFacts, VertexFacts};
use crate::solid::check;
use crate::trace::{self, Errors, Fate, Frame, Intent, Outcome, Scene, Witness, fates};

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
    clock.always(Stage::Trace, || {
        let scene = Scene::new(mesh);
        let table = intents(design, &scene);
        let witness =
            Witness::trace(&scene, normals.as_deref(), design.view.as_ref(), camera.pixels, table);
        let frame = design.view.is_some().then(|| {
            let fates = pixel_fates(profile, design, &witness);
            Frame::new(&witness, &fates, camera.pixels, tolerance_px(profile))
        });
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

/// The pixel error up to which a pixel counts as filled: the profile's own limit, or a hundredth of
/// the frame's width.
pub fn tolerance_px(profile: &Profile) -> f64 {
    let usual = 0.01 * f64::from(profile.camera.pixels()[0]);
    profile.accept.pixel_error_max_px.unwrap_or(usual)
}

/// What becomes of every pixel.
pub fn pixel_fates(profile: &Profile, design: &Design, witness: &Witness) -> Vec<Fate> {
    let camera = &design.camera;
    let folded = design.view.as_ref().is_some_and(|view| view.fold.is_some());
    fates(witness, camera.pixels, camera.pixel_mm, tolerance_px(profile), folded)
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
