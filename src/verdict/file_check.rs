//! What the bytes of one file showed: as a solid, at its vertices, and to the camera's rays.

use super::as_cut_face::AsCutFace;
use super::expected_rays::{RimShift, expected_rays};
use super::vertex_check::worst_vertex;
use crate::brep::{Body, BodyFacts};
use crate::design::Design;
use crate::export::ImportedMesh;
use crate::forming::FormedFace;
use crate::geom::DVec3;
use crate::num::stats::Summary;
use crate::part::Promise;
use crate::profile::{CadFormat, FileFormat, MeshFormat, Profile};
use crate::results::{ErrorFacts, FileFacts, SolidFacts, TraceFacts, VertexFacts};
use crate::solid::{SolidCheck, check};
use crate::trace::{
    BodyScene, CameraTrace, FaceSlopes, FrameFill, FrameFillBuilder, Obstacles, OutcomeCounts,
    Scene, TraceCounts, TraceStrip, TraceSummary, WantedPicture,
};
use std::error::Error;
use std::sync::Arc;

/// What a file is held to beside what the profile accepts of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HeldTo {
    /// The design: the shape of its facets, and as much of the picture as is usual.
    Design,
    /// As much of the picture as is usual: a face as cut, which is rougher than any mesh.
    Picture,
    /// Nothing but what the profile names, or else its form: a measured part.
    Form,
}

/// What the bytes of one file showed.
pub(crate) struct FileCheck {
    /// The file.
    pub file: FileFacts,
    /// Its format.
    pub format: FileFormat,
    /// Whether the bytes are others than were written.
    pub altered: bool,
    /// What it is held to.
    pub held_to: HeldTo,
    /// The errors that it may have.
    pub promise: Promise,
    /// Why it could not be read, if so; then there is no more.
    pub unreadable: Option<String>,
    /// The witness's figures.
    pub trace: Option<TraceFacts>,
    /// How many rays what is around the mirror shadows.
    pub by_rim: usize,
    /// The frame.
    pub frame: Option<FrameFill>,
    /// The mesh, until the picture is painted; none of curved faces.
    pub scene: Option<Scene>,
}

impl FileCheck {
    /// Of a file that could not be read.
    pub(crate) fn unreadable(
        file: FileFacts,
        format: impl Into<FileFormat>,
        promise: Promise,
        error: &dyn Error,
    ) -> Self {
        Self {
            file,
            format: format.into(),
            altered: false,
            held_to: HeldTo::Design,
            promise,
            unreadable: Some(error.to_string()),
            trace: None,
            by_rim: 0,
            frame: None,
            scene: None,
        }
    }

    /// Of a file that was read, and shows nothing to trace.
    pub(crate) fn untraced(file: FileFacts, promise: Promise) -> Self {
        Self {
            file,
            format: MeshFormat::Obj.into(),
            altered: false,
            held_to: HeldTo::Picture,
            promise,
            unreadable: None,
            trace: None,
            by_rim: 0,
            frame: None,
            scene: None,
        }
    }

    /// Of a mesh whose facets keep to `design` as promised, by the camera's rays; and what those took. With
    /// `shortcuts` rays of which the outcome is proven are not followed. `each` is called with every strip of
    /// the frame, which is forgotten thereafter: where there is no projection without classes.
    pub(crate) fn traced(
        (profile, design): (&Profile, &Design),
        (file, format): (FileFacts, MeshFormat),
        checked: CheckedMesh,
        (promise, shortcuts): (Promise, bool),
        each: EachStrip,
    ) -> (Self, TraceCounts) {
        let CheckedMesh { reread: ImportedMesh { mesh, normals }, solid, vertex, closed, cut } =
            checked;
        let obstacles = Obstacles::new(&design.obstacles, design.view.as_ref());
        let scene = Scene::for_cameras(mesh, closed).among(obstacles.map(Arc::new));
        let slopes = cut.as_ref().and_then(|cut| cut.slopes.as_ref());
        let slopes = slopes.map(|slopes| slopes as &dyn FaceSlopes);
        let rim_mm = cut.as_ref().map(|cut| cut.rim_mm);
        let trace = CameraTrace::new(&scene, &design.camera, scene.above_mm()).with_slopes(slopes);
        let tracing = FileTrace { profile, design, promise, shortcuts, rim_mm };
        let height = |facet: u32| {
            let corners = scene.mesh().corners(facet as usize);
            corners.iter().fold(f64::NEG_INFINITY, |top, v| top.max(v.z))
        };
        let seen = tracing.run(trace, normals.as_deref(), &height, each);
        let (mut check, counts) = tracing.check(seen, (file, format.into()), solid);
        if let Some(trace) = &mut check.trace {
            trace.worst_vertex = vertex;
        }
        check.scene = Some(scene);
        (check, counts)
    }

    /// The same of a closed body of curved faces, whose mirror is off that of `design` as promised.
    pub(crate) fn traced_body(
        (profile, design): (&Profile, &Design),
        file: FileFacts,
        body: Body,
        (promise, shortcuts): (Promise, bool),
        each: EachStrip,
    ) -> (Self, TraceCounts) {
        let (features, volume_mm3) = design.made_body();
        let solid = solid_check(body.facts()).through(features.through());
        let solid = SolidFacts::new(&solid, volume_mm3);
        let obstacles = Obstacles::new(&design.obstacles, design.view.as_ref());
        let scene = BodyScene::new(body, obstacles.map(Arc::new));
        let trace = CameraTrace::new(&scene, &design.camera, scene.above_mm());
        let tracing = FileTrace { profile, design, promise, shortcuts, rim_mm: None };
        let height = |face: u32| scene.body().top_of(face);
        let seen = tracing.run(trace, None, &height, each);
        tracing.check(seen, (file, CadFormat::Step.into()), solid)
    }

    /// Calls the file `name`.
    pub(crate) fn rename(&mut self, name: String) {
        if let Some(trace) = &mut self.trace {
            trace.file.clone_from(&name);
        }
        self.file.name = name;
    }
}

/// What is called with every strip of a traced frame.
pub(crate) type EachStrip<'a> = &'a mut dyn FnMut(&TraceStrip);

/// How a file is traced.
struct FileTrace<'a> {
    profile: &'a Profile,
    design: &'a Design,
    promise: Promise,
    shortcuts: bool,
    /// The largest height of its rim over the mirror or below it, mm, of a part as cut.
    rim_mm: Option<f64>,
}

/// What the camera's rays show of a file.
struct SeenFile {
    summary: TraceSummary,
    /// How many rays what is around the mirror shadows.
    by_rim: usize,
    frame: Option<FrameFill>,
    has_normals: bool,
    counts: TraceCounts,
}

impl FileTrace<'_> {
    /// Traces the frame. `height` is Z of the highest place of a facet or a face, mm.
    fn run(
        &self,
        trace: CameraTrace,
        normals: Option<&[[DVec3; 3]]>,
        height: &dyn Fn(u32) -> f64,
        each: EachStrip,
    ) -> SeenFile {
        let Self { profile, design, promise, shortcuts, rim_mm } = self;
        let trace = if *shortcuts { trace } else { trace.without_shortcuts() };
        let rim = match rim_mm {
            Some(mm) => RimShift::Cut(*mm),
            // The mirror's own camera sees the rim of its facets where the mirror's is.
            None if design.camera.chart == design.mirror.chart => RimShift::None,
            None => RimShift::Facets(promise.chord_mm),
        };
        let table = expected_rays(design, rim);
        let (picture, has_normals) = (wanted_picture(profile, design), normals.is_some());
        let (mut summary, mut by_rim) = (TraceSummary::default(), 0);
        let mut frame = picture.map(|_| FrameFillBuilder::default());
        let counts = TraceStrip::each(&trace, normals, picture, table, |strip| {
            summary.add(strip);
            by_rim += shadowed_by_rim(design, height, strip);
            if let Some(frame) = &mut frame {
                frame.add(strip);
            }
            each(strip);
        });
        let frame = frame.map(|frame| frame.finish(design.camera.pixels, tolerance_px(profile)));
        SeenFile { summary, by_rim, frame, has_normals, counts }
    }

    /// The check of a file of which that was seen.
    fn check(
        &self,
        seen: SeenFile,
        (file, format): (FileFacts, FileFormat),
        solid: SolidFacts,
    ) -> (FileCheck, TraceCounts) {
        let SeenFile { summary, by_rim, frame, has_normals, counts } = seen;
        let pixel_mm = self.design.camera.pixel_mm;
        let trace = trace_facts(file.name.clone(), summary, pixel_mm, has_normals, solid);
        let check = FileCheck {
            file,
            format,
            altered: false,
            held_to: HeldTo::Design,
            promise: self.promise,
            unreadable: None,
            trace: Some(trace),
            by_rim,
            frame,
            scene: None,
        };
        (check, counts)
    }
}

/// What a body that was read is as a solid: its reader refuses what is not closed.
fn solid_check(facts: BodyFacts) -> SolidCheck {
    SolidCheck {
        closed: true,
        oriented: true,
        manifold: true,
        open: None,
        components: facts.components,
        euler: facts.euler,
        holes: 0,
        volume_mm3: facts.volume_mm3,
        defects: Vec::new(),
        defect_count: 0,
    }
}

/// A mesh, and what it is as a solid.
pub(crate) struct CheckedMesh {
    reread: ImportedMesh,
    solid: SolidFacts,
    vertex: Option<VertexFacts>,
    /// Whether the mesh is known to be closed.
    closed: bool,
    /// What it has beside its facets, of a part as cut.
    cut: Option<AsCutFace>,
}

impl CheckedMesh {
    /// The checks of a mesh as a solid, and of its vertices against `design`; what it is as a solid may be
    /// proven already. Of a tool's mesh, the mirror that is formed on it is what rays are traced at.
    pub(crate) fn new(design: &Design, reread: ImportedMesh, proven: Option<SolidCheck>) -> Self {
        let (features, volume_mm3) = design.made_body();
        let check = proven.unwrap_or_else(|| check(&reread.mesh)).through(features.through());
        let solid = SolidFacts::new(&check, volume_mm3);
        let vertices = &reread.mesh.vertices;
        let facts = |(vertex, off_mm): (usize, f64)| VertexFacts {
            at_mm: vertices[vertex].to_array(),
            off_mm,
        };
        if let Some(tool) = &design.tool {
            let FormedFace { mesh, worst_vertex } =
                FormedFace::of(tool, &design.mirror, &reread.mesh);
            let vertex = worst_vertex.map(facts);
            let formed = ImportedMesh { mesh, normals: None };
            return Self { reread: formed, solid, vertex, closed: false, cut: None };
        }
        let vertex = worst_vertex(design, vertices).map(facts);
        let closed = check.closed && check.oriented && check.manifold;
        Self { reread, solid, vertex, closed, cut: None }
    }

    /// The same of a face as cut.
    pub(crate) fn of_cut(self, cut: AsCutFace) -> Self {
        Self { cut: Some(cut), ..self }
    }
}

/// The pixel error up to which a pixel counts as filled: the largest that is accepted.
pub(crate) fn tolerance_px(profile: &Profile) -> f64 {
    profile.acceptance_limits().pixel_error_max_px.value
}

/// The picture that the mirror of a design is to show, if there is one.
pub(crate) fn wanted_picture<'a>(
    profile: &Profile,
    design: &'a Design,
) -> Option<WantedPicture<'a>> {
    let tolerance_mm = tolerance_px(profile) * design.camera.pixel_mm;
    design.view.as_ref().map(|task| WantedPicture { task, tolerance_mm })
}

/// How many aimed rays facets or faces below the top of what is around the mirror shadow. Between panels there are walls below it.
fn shadowed_by_rim(design: &Design, height: &dyn Fn(u32) -> f64, strip: &TraceStrip) -> usize {
    let Some(stock) = design.border.as_ref().filter(|_| !design.mirror.has_steps()) else {
        return 0;
    };
    let top = stock.top_mm * (1.0 + 1e-6);
    strip.shadowing().filter(|facet| height(*facet) <= top).count()
}

fn trace_facts(
    file: String,
    summary: TraceSummary,
    pixel_mm: f64,
    has_normals: bool,
    solid: SolidFacts,
) -> TraceFacts {
    let facts = |[angle, image, facet]: [Option<Summary>; 3]| {
        let scaled = |summary: Option<Summary>, unit: f64| summary.map(|s| s.scaled(unit));
        ErrorFacts {
            ray_error_mrad: scaled(angle, 1e3),
            pixel_error_px: scaled(image, 1.0 / pixel_mm),
            facet_error_px: scaled(facet, 1.0 / pixel_mm),
        }
    };
    let OutcomeCounts { aimed, hit, missed, shadowed, back_face, obstructed } = summary.counts;
    let [by_facets, by_normals] = summary.errors();
    TraceFacts {
        file,
        rays: aimed,
        hit,
        missed,
        shadowed,
        back_face,
        obstructed,
        errors: facts(by_facets),
        interpolated_normals: has_normals.then(|| facts(by_normals)),
        worst_vertex: None,
        solid,
    }
}
