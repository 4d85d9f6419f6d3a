//! The second half of a build, which starts from bytes: read, check, trace, look.

use super::camera_view::{TracedMesh, above};
use super::face::Promise;
use super::formats::codec;
use super::observer::Stage;
use super::run::Run;
use super::vertex_check::worst_vertex;
use crate::design::Design;
use crate::export::{ImportedMesh, ReadError};
use crate::geom::{DVec2, DVec3};
use crate::mirror::HeightAndSlope;
use crate::optics::reflect;
use crate::parallel;
use crate::profile::{MeshFormat, Profile};
use crate::publish::sha256;
use crate::report::{ErrorFacts, FileFacts, SolidFacts, TraceFacts, VertexFacts};
use crate::solid::check;
use crate::trace::{
    CameraTrace, ExpectedRay, FrameFill, Outcome, PixelClass, PixelTrace, RayErrors, Scene,
    TraceResult, classify_pixels,
};

/// What the bytes of one file showed.
pub(super) struct FileCheck {
    /// The file.
    pub file: FileFacts,
    /// Its format.
    pub format: MeshFormat,
    /// Whether the bytes are others than were written.
    pub altered: bool,
    /// Whether it is a measured part, which is judged by what it does and not by its facets.
    pub measured: bool,
    /// The errors that it may have.
    pub promise: Promise,
    /// Why it could not be read, if so; then there is no more.
    pub unreadable: Option<ReadError>,
    /// The witness's figures.
    pub trace: Option<TraceFacts>,
    /// How many rays what is around the mirror shadows.
    pub by_rim: usize,
    /// The frame.
    pub frame: Option<FrameFill>,
    /// The mesh and its rays, until the picture is painted.
    pub seen: Option<TracedMesh>,
}

impl FileCheck {
    /// Of a file that could not be read.
    pub(super) fn unreadable(
        file: FileFacts,
        format: MeshFormat,
        promise: Promise,
        error: ReadError,
    ) -> Self {
        Self {
            file,
            format,
            altered: false,
            measured: false,
            promise,
            unreadable: Some(error),
            trace: None,
            by_rim: 0,
            frame: None,
            seen: None,
        }
    }

    /// Calls the file `name`.
    pub(super) fn rename(&mut self, name: String) {
        if let Some(trace) = &mut self.trace {
            trace.file.clone_from(&name);
        }
        self.file.name = name;
    }
}

/// Reads, checks and traces the bytes of a mesh file against `design`, to which its facets keep as
/// promised.
pub(super) fn check_file(
    run: &Run,
    design: &Design,
    format: MeshFormat,
    bytes: Vec<u8>,
    promise: Promise,
) -> FileCheck {
    let (file, read) = open(run, format, bytes, |reread| checked(design, reread));
    match read {
        Ok(checked) => witness(run, design, (file, format), checked, promise),
        Err(error) => FileCheck::unreadable(file, format, promise, error),
    }
}

/// Reads the bytes of a mesh file, and does something with what is in it.
pub(super) fn open<T: Send>(
    run: &Run,
    format: MeshFormat,
    bytes: Vec<u8>,
    then: impl FnOnce(ImportedMesh) -> T + Send,
) -> (FileFacts, Result<T, ReadError>) {
    let name = format.file_name().to_owned();
    let length = bytes.len() as u64;
    let read = || {
        let reread = codec(format).read(&bytes);
        let note = match &reread {
            Ok(reread) => format!("{name}: {} triangles", reread.mesh.triangles.len()),
            Err(error) => format!("{name}: {error}"),
        };
        (reread.map(then), note)
    };
    let (reread, sha256) = run.timer.always(Stage::Read, || {
        let ((reread, note), sha256) = parallel::join(read, || sha256(&bytes));
        ((reread, sha256), note)
    });
    // The rays need the mesh alone.
    drop(bytes);
    (FileFacts { name, format: format.name().into(), bytes: length, sha256 }, reread)
}

/// A mesh, and what it is as a solid.
pub(super) struct CheckedMesh {
    reread: ImportedMesh,
    solid: SolidFacts,
    vertex: Option<VertexFacts>,
}

/// Checks a mesh as a solid, and its vertices against `design`.
pub(super) fn checked(design: &Design, reread: ImportedMesh) -> CheckedMesh {
    let check = check(&reread.mesh).through(design.holes());
    let solid = SolidFacts::new(&check, design.volume());
    let vertex = worst_vertex(design, &reread.mesh.vertices);
    let vertex = vertex.map(|(vertex, off)| {
        let at = reread.mesh.vertices[vertex].to_array();
        VertexFacts { at_mm: at, off_mm: off }
    });
    CheckedMesh { reread, solid, vertex }
}

/// Traces a mesh whose facets keep to the design as promised.
pub(super) fn witness(
    run: &Run,
    design: &Design,
    (file, format): (FileFacts, MeshFormat),
    checked: CheckedMesh,
    promise: Promise,
) -> FileCheck {
    let (timer, profile) = (&run.timer, run.profile);
    let CheckedMesh { reread: ImportedMesh { mesh, normals }, solid, vertex } = checked;
    let name = file.name.clone();
    let camera = &design.camera;
    timer.always(Stage::Trace, || {
        let scene = Scene::new(mesh);
        let table = expected_rays(design, promise.chord_mm);
        let trace = CameraTrace::new(&scene, camera, above(&scene));
        let trace = if timer.shortcuts() { trace } else { trace.without_shortcuts() };
        let (witness, counts) =
            TraceResult::new(&trace, normals.as_deref(), design.view.as_ref(), table);
        timer.traced(counts);
        let frame = design.view.is_some().then(|| {
            let classes = pixel_classes(profile, design, &witness);
            FrameFill::new(&witness, &classes, camera.pixels, tolerance_px(profile))
        });
        let has_normals = normals.is_some();
        let mut trace = trace_facts(name.clone(), &witness, camera.pixel_mm, has_normals, solid);
        trace.worst_vertex = vertex;
        let note = format!("{name}: {} rays aimed at the mirror", trace.rays);
        let check = FileCheck {
            file,
            format,
            altered: false,
            measured: false,
            promise,
            unreadable: None,
            trace: Some(trace),
            by_rim: by_rim(design, &scene, &witness),
            frame,
            seen: Some((scene, witness)),
        };
        (check, note)
    })
}

/// The pixel error up to which a pixel counts as filled: the largest that is accepted.
pub(super) fn tolerance_px(profile: &Profile) -> f64 {
    profile.acceptance_limits().pixel_error_max_px.value
}

/// Class of every pixel.
pub(super) fn pixel_classes(
    profile: &Profile,
    design: &Design,
    witness: &TraceResult,
) -> Vec<PixelClass> {
    let camera = &design.camera;
    let folded = design.view.as_ref().is_some_and(|view| view.fold.is_some());
    classify_pixels(witness, camera.pixels, camera.pixel_mm, tolerance_px(profile), folded)
}

fn by_rim(design: &Design, scene: &Scene, witness: &TraceResult) -> usize {
    let Some(stock) = &design.border else { return 0 };
    let top = stock.top_mm * (1.0 + 1e-6);
    let around = |facet: u32| scene.mesh().corners(facet as usize).iter().all(|v| v.z <= top);
    witness.count(|outcome| matches!(outcome, Outcome::Shadowed(facet) if around(facet)))
}

/// The table of expected rays, a row of the sensor at a time. Rays that may pass by the rim of facets
/// `chord_mm` off the mirror are not aimed at it.
pub(crate) fn expected_rays(design: &Design, chord_mm: f64) -> impl Fn(u32) -> Vec<ExpectedRay> {
    let Design { mirror, view, camera, .. } = design;
    let outline = mirror.full_outline();
    // The mirror's own camera sees the rim of the facets where the mirror's is.
    let off_mm = if camera.chart == mirror.chart { 0.0 } else { chord_mm };
    let beside = move |at: DVec3, along: DVec3, normal: DVec3| {
        let step = along * (off_mm * normal.z / along.dot(normal));
        let aims = |at: DVec3| outline.aims(mirror.chart.coordinates(at).0);
        !(aims(at + step) && aims(at - step))
    };
    move |row| {
        let image_point =
            |column: u32| camera.image_point(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let points: Vec<DVec2> = (0..camera.pixels[0]).map(image_point).collect();
        let places: Vec<DVec2> = points
            .iter()
            .map(|&q| mirror.intersect_camera_ray(&camera.chart, q).unwrap_or(DVec2::INFINITY))
            .collect();
        let designed = mirror.eval_many(&places);
        let expected = |((point, place), designed): ((DVec2, DVec2), HeightAndSlope)| {
            let mut expected =
                ExpectedRay { aimed: false, direction: DVec3::Z, designed: DVec2::ZERO };
            if !outline.aims(place) {
                return expected;
            }
            let arriving = camera.ray(point, 0.0).direction;
            let (at, normal) = (mirror.position(place, &designed), mirror.normal(place, &designed));
            expected.aimed = off_mm == 0.0 || !beside(at, arriving, normal);
            if let (true, Some(view)) = (expected.aimed, view) {
                expected.direction = view.direction_of(point, at);
                expected.designed = view.image_of(at, reflect(arriving, normal), point);
            }
            expected
        };
        points.into_iter().zip(places).zip(designed).map(expected).collect()
    }
}

fn trace_facts(
    file: String,
    witness: &TraceResult,
    pixel_mm: f64,
    has_normals: bool,
    solid: SolidFacts,
) -> TraceFacts {
    let facts = |errors: fn(&PixelTrace) -> Option<RayErrors>| {
        let summary = |pick: fn(RayErrors) -> f64, unit: f64| {
            witness.summary(|pixel| errors(pixel).map(pick)).map(|s| s.scaled(unit))
        };
        let (ray_error_mrad, (pixel_error_px, facet_error_px)) = parallel::join(
            || summary(|e| e.angle_rad, 1e3),
            || {
                parallel::join(
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
        errors: facts(|pixel| pixel.errors),
        interpolated_normals: has_normals.then(|| facts(|pixel| pixel.smooth)),
        worst_vertex: None,
        solid,
    }
}
