//! `morion build`: every stage, every file, and back from the bytes on the disk.

use super::build_cache::{self, BuildRecord, Output};
use super::cad_export::{CadExport, CadFigures, CadFindings};
use super::cad_exports::{CadCheck, cad_exports, check_export};
use super::check_file::{MeshSource, check_file, witness_body};
use super::dry_run::{check_room, least_bytes};
use super::mesh_files::{MeshFiles, label, meshed, write_meshes};
use super::page_figures::{
    ErrorMap, ErrorMapBuilder, MAP_COLUMNS, curl, design_errors, part_figures, sharpness_map,
};
use super::run::{Command, Run};
use super::{Error, Observer, Stage};
use crate::design::Design;
use crate::export::Label;
use crate::geom::Precision;
use crate::mesh::Face;
use crate::mirror::{Form, Surface};
use crate::parallel;
use crate::part::{self, AtPrecision, MeshOutcome, SizeWarnings, left_out, needs_mesh};
use crate::profile::{FileFormat, Profile};
use crate::publish::StagedFile;
use crate::raster::FalseColourMap;
use crate::render::{
    CameraPicture, CameraView, Distance, ReflectedCentres, SmoothSight, TestWorld, TracedMesh,
    UnwantedViews,
};
use crate::report::BuildFigures;
use crate::results::{
    BuildReport, CavityFacts, HoleFacts, Reason, SCHEMA, SharpnessFacts, ToolFacts,
};
use crate::verdict::sharpness::sharpness;
use crate::verdict::{self, FileCheck, Findings};
use std::path::Path;
use std::sync::OnceLock;

/// How much of a build's work is done: it writes every file that the profile asks for into NAME, with
/// `preview.png`, `report.html`, `report.json` and `timings.json`, and with a projection `design_error.png` and
/// `curl.png`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BuildOptions {
    /// Work that changes no result.
    pub effort: Effort,
}

/// How much of the work that changes no result is done all the same.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Effort {
    /// None: where the files of the last build are still there and would come out the same, nothing.
    #[default]
    Least,
    /// What the last build in the folder has done already.
    Afresh,
    /// All of it: every copy of a symmetric mirror is meshed by itself and compared, and every ray is
    /// searched for and followed.
    Most,
}

/// Builds the profile of `source` into `out`/NAME.
///
/// # Errors
/// [`enum@Error`] when a stage cannot be done; then nothing under `out` has changed.
pub fn build(source: &Profile, out: &Path, observer: &dyn Observer) -> Result<BuildReport, Error> {
    BuildOptions::default().publish(source, out, observer)
}

impl Command for BuildOptions {
    type Report = BuildReport;

    fn run(&self, run: &mut Run) -> Result<BuildReport, Error> {
        let inputs = build_cache::inputs(run.profile);
        if self.effort == Effort::Least
            && let Some(report) = repeated(run, &inputs)?
        {
            return Ok(report);
        }
        if self.effort == Effort::Most {
            run.timer.forbid_shortcuts();
        }
        run.files.ensure_space(least_bytes(run.profile))?;
        let design = run.design()?;
        count_unknowns(run, &design);
        let form = OnceLock::new();
        let form = || form.get_or_init(|| Form::of(&design.mirror));
        let exports = match part::cad(run.profile).next() {
            Some(_) => cad_exports(run.profile, &design, form())?,
            None => Vec::new(),
        };
        check_room(run, &design, &exports)?;
        let (profile, sharp) = (run.profile, OnceLock::new());
        let sharp = || sharp.get_or_init(|| sharpness(profile, &design));
        let about_design = || {
            form();
            sharp();
        };
        let mut made = Made::written(run, &design, &exports, &about_design)?;
        let checked = made.checked(run, &design, &exports)?;
        // What the disk made of the bytes may be otherwise the next time.
        let altered = checked.traced.iter().any(|check| check.altered);
        let inputs = if altered { String::new() } else { inputs };
        drop(exports);
        let about = (*form(), *sharp());
        let (report, seen) = report(profile, &design, about, &made, checked);
        publish(run, (&made, &design), (&report, &seen), inputs)?;
        Ok(report)
    }
}

/// The report of the last build in the folder, if this one would only repeat it.
fn repeated(run: &mut Run, inputs: &str) -> Result<Option<BuildReport>, Error> {
    let Some(folder) = run.files.folder().map(Path::to_owned) else { return Ok(None) };
    let Some((report, record)) = build_cache::unchanged(&folder, inputs) else { return Ok(None) };
    run.files.add_bytes("timings.json", record.json(&run.timer).as_bytes())?;
    run.files.commit()?;
    run.timer.unchanged(&folder);
    Ok(Some(report))
}

/// Files of the part, written but not published.
struct Made {
    /// The mesh files.
    meshes: MeshOutcome<MeshFiles>,
    /// The words of every file on its mirror.
    label: Label,
}

impl Made {
    /// Meshes the mirror, and writes all its files; `beside` the mesh something else is done.
    fn written(
        run: &mut Run,
        design: &Design,
        exports: &[Box<dyn CadExport + '_>],
        beside: &(dyn Fn() + Sync),
    ) -> Result<Self, Error> {
        let face = Self::face(run, design, beside)?;
        let label = label(design, face.made().map(|face| &face.made.bound));
        let meshes = match face {
            MeshOutcome::Made(face) => MeshOutcome::Made(write_meshes(run, design, face, &label)?),
            MeshOutcome::Refused(refused) => MeshOutcome::Refused(refused),
            MeshOutcome::Unasked => MeshOutcome::Unasked,
        };
        for export in exports {
            run.write(export.format().file_name(), |out| export.write(out, &label))?;
        }
        Ok(Self { meshes, label })
    }

    /// Meshes the mirror, where the build needs that.
    fn face(
        run: &Run,
        design: &Design,
        beside: &(dyn Fn() + Sync),
    ) -> Result<MeshOutcome<AtPrecision<Face>>, Error> {
        if !needs_mesh(run.profile) {
            beside();
            run.timer.worked(Stage::Mesh, "meshes", [0, 1], "no mesh file is asked for");
            return Ok(MeshOutcome::Unasked);
        }
        let mesh = || parallel::join(|| meshed(run, design), beside).0;
        match run.stage(Stage::Mesh, mesh) {
            Ok(face) => Ok(MeshOutcome::Made(face)),
            Err(Error::Mesh { source, .. }) => {
                let left_out = left_out(run.profile, source);
                let refused = left_out.map_err(|error| Error::face(run.profile, error))?;
                Ok(MeshOutcome::Refused(refused))
            }
            Err(error) => Err(error),
        }
    }

    /// Reads, checks and traces the files as they are on the disk: one at a time, so that memory does not
    /// grow with their number.
    fn checked(
        &mut self,
        run: &Run,
        design: &Design,
        exports: &[Box<dyn CadExport + '_>],
    ) -> Result<Checked, Error> {
        let (mut traced, mut picture) = (Vec::new(), None);
        let mut errors = ErrorMapBuilder::new(design, MAP_COLUMNS);
        if let MeshOutcome::Made(made) = &mut self.meshes {
            for format in made.formats.clone() {
                let written = made.take_written(format);
                let staged = run.files.staged(format.file_name())?;
                let mut centres = ReflectedCentres::default();
                let mut check = check_file(
                    run,
                    design,
                    format,
                    MeshSource::Staged(staged, written),
                    made.promise,
                    &mut |strip| {
                        if picture.is_none() {
                            centres.add(strip);
                            errors.add(strip);
                        }
                    },
                )?;
                check.altered = check.file.sha256 != staged.sha256();
                // A mesh that is made for the rays alone is no file.
                if !is_asked(run.profile, FileFormat::Mesh(format)) {
                    check.rename(UNKEPT.to_owned());
                }
                if let (None, Some(scene)) = (&picture, check.scene.take()) {
                    let mesh = TracedMesh { scene, centres };
                    picture = Some(painted(run, design, CameraView::Mesh(&mesh))?);
                }
                traced.push(check);
            }
        }
        // Without a mesh file the designed mirror is what there is to see.
        let smooth = SmoothSight::new(design);
        let view = if traced.is_empty() { CameraView::Smooth(&smooth) } else { CameraView::Shut };
        let mut cad = Vec::new();
        for export in exports {
            let staged = run.files.staged(export.format().file_name())?;
            let mut check = check_export(run, &**export, &staged.read()?, staged.sha256());
            if let Some((body, promise)) = check.findings.body.take() {
                let is_first = traced.is_empty();
                let of = (check.file.clone(), body);
                traced.push(witness_body(run, design, of, promise, &mut |strip| {
                    if is_first {
                        errors.add(strip);
                    }
                }));
            }
            cad.push(check);
        }
        let picture = match picture {
            Some(picture) => picture,
            None => painted(run, design, view)?,
        };
        let errors = errors.finish_or_smooth(design);
        Ok(Checked { traced, cad, seen: Seen { picture, errors } })
    }

    /// Whether a file of this format is published.
    fn keeps(&self, profile: &Profile, format: FileFormat) -> bool {
        is_asked(profile, format)
            && match format {
                FileFormat::Mesh(format) => {
                    self.meshes.made().is_some_and(|meshes| meshes.formats.contains(&format))
                }
                FileFormat::Cad(_) => true,
            }
    }
}

/// How a mesh is called that was made for the rays alone.
const UNKEPT: &str = "a mesh that was not kept";

fn is_asked(profile: &Profile, format: FileFormat) -> bool {
    profile.formats.contains(&format)
}

/// What the bytes on the disk showed.
struct Checked {
    /// The files that were traced: of meshes, then of curved faces.
    traced: Vec<FileCheck>,
    cad: Vec<CadCheck>,
    seen: Seen,
}

/// What the camera sees in the first mesh file that could be read, or else in the designed mirror.
struct Seen {
    /// The test world, as PNG.
    picture: Vec<u8>,
    /// Pixel errors over the frame.
    errors: ErrorMap,
}

/// The map of the designed mirror's pixel errors.
const DESIGN_ERROR: &str = "design_error.png";
/// The map of the curl of the slopes that the picture asks for.
const CURL: &str = "curl.png";

/// Most pixels in a row of `preview.png`.
const PREVIEW_COLUMNS: u32 = 1600;

fn painted(run: &Run, design: &Design, view: CameraView) -> Result<Vec<u8>, Error> {
    let picture = CameraPicture::new(design, view, Distance::Target, 2).at_most(PREVIEW_COLUMNS);
    Ok(run.painted(|| picture.picture(&TestWorld::new()))?.1)
}

/// Counts what the design's symmetry saved.
fn count_unknowns(run: &Run, design: &Design) {
    if let (Surface::Tensor(sheet), unknowns @ 1..) =
        (&design.mirror.surface, design.facts.unknowns)
    {
        let (rows, columns) = sheet.series.shape();
        // The constant is no unknown.
        let odd = (rows * columns - 1).saturating_sub(unknowns);
        run.timer.worked(Stage::Design, "coefficients solved for", [unknowns, odd], "symmetry");
    }
}

/// All figures, the verdict and its reasons.
fn report(
    profile: &Profile,
    design: &Design,
    (form, sharpness): (Form, Option<SharpnessFacts>),
    made: &Made,
    checked: Checked,
) -> (BuildReport, Seen) {
    let findings = Findings::beside(profile, design, checked.traced, sharpness);
    let meshes = made.meshes.made();
    let refused = made.meshes.refused().or(meshes.and_then(|meshes| meshes.refused.as_ref()));
    let mut reasons: Vec<Reason> = refused.cloned().map(Reason::from).into_iter().collect();
    reasons.extend(findings.reasons);
    let (mut files, mut sag, mut step, mut drawing) = (findings.files, None, None, None);
    for CadCheck { file, findings: CadFindings { faults, figures, .. } } in checked.cad {
        reasons.extend(faults.into_iter().map(|fault| Reason::from(fault).of_file(&file.name)));
        // (Of one that was traced it is there.)
        files.retain(|known| known.name != file.name);
        files.push(file);
        match figures {
            Some(CadFigures::Sag(facts)) => sag = Some(facts),
            Some(CadFigures::Step(facts)) => step = Some(facts),
            Some(CadFigures::Drawing(facts)) => drawing = Some(*facts),
            None => {}
        }
    }
    // What was made for the rays alone stays nowhere.
    files.retain(|file| profile.formats.iter().any(|format| format.name() == file.format));
    let (mesh, solid) = meshes.and_then(|meshes| meshes.facts.clone()).unzip();
    let precision = meshes.map_or(Precision::Double, |meshes| meshes.precision);
    let size = SizeWarnings { profile, design, precision };
    let lengths: Vec<(&str, u64)> = files.iter().map(|f| (&*f.name, f.bytes)).collect();
    let mut warnings = size.on(mesh.map_or(0, |mesh| mesh.triangles), &lengths);
    let next_finer = meshes.and_then(|meshes| meshes.next_finer);
    warnings.extend(mesh.as_ref().and_then(|mesh| size.unspent(mesh, next_finer)));
    let blurred = findings.sharpness.as_ref().and_then(SharpnessFacts::warning);
    warnings.extend(blurred.map(|warning| format!("{}: {warning}", profile.name)));
    let tool = design.tool.as_ref().map(ToolFacts::of);
    let unseen = profile.part.forming.as_ref().and_then(ToolFacts::warning);
    warnings.extend(unseen.map(|warning| format!("{}: {warning}", profile.name)));
    let report = BuildReport {
        schema: SCHEMA,
        profile: profile.into(),
        layout: Some(design.mounting),
        design: design.facts.clone(),
        unwanted: UnwantedViews::of(design),
        form,
        mesh,
        solid,
        tool,
        cavity: CavityFacts::of(design),
        holes: HoleFacts::of(design.made_body().0),
        files,
        trace: findings.trace,
        sag,
        step,
        drawing,
        frame: findings.frame,
        sharpness: findings.sharpness,
        accepted: findings.accepted,
        verdict: verdict::of(&reasons),
        reasons,
        warnings,
    };
    (report, checked.seen)
}

/// The page of the report.
fn page(
    design: &Design,
    (label, report, seen): (&Label, &BuildReport, &Seen),
    curl: Option<&FalseColourMap>,
) -> Result<String, Error> {
    let (part, spots) = parallel::join(
        || part_figures(design, label),
        || sharpness_map(design, report.sharpness.as_ref()),
    );
    let errors = seen.errors.drawn(design);
    let figures = BuildFigures { part, preview: &seen.picture, errors, curl, spots };
    let page = report.html(&design.profile, &figures);
    page.map_err(|error| Error::Picture(error.to_string()))
}

/// Adds the pages and the record of the build, and publishes everything.
fn publish(
    run: &mut Run,
    (made, design): (&Made, &Design),
    (report, seen): (&BuildReport, &Seen),
    inputs: String,
) -> Result<(), Error> {
    let profile = run.profile;
    run.publish(Stage::Report, |files, timer| {
        files.add_bytes("preview.png", &seen.picture)?;
        let curl = curl(design);
        let (errors, page) = parallel::join(
            || design_errors(design),
            || page(design, (&made.label, report, seen), curl.as_ref()),
        );
        let page = page?;
        for (name, map) in [(DESIGN_ERROR, errors), (CURL, curl)] {
            let png = map.map(|map| map.png()).transpose();
            match png.map_err(|error| Error::Picture(error.to_string()))? {
                Some(png) => drop(files.add_bytes(name, &png)?),
                // An older one would be another profile's.
                None => files.remove(name),
            }
        }
        files.add_bytes("report.html", page.as_bytes())?;
        files.add_report("report.json", &report.json())?;
        // A file of a format that is not written now would be another profile's.
        for format in FileFormat::all().filter(|format| !made.keeps(profile, *format)) {
            files.withdraw(format.file_name());
            files.remove(format.file_name());
        }
        let unasked = FileFormat::all().count() - profile.formats.len();
        timer.worked(Stage::Write, "files", [files.files().count(), unasked], "not asked for");
        let output = |file: &StagedFile| Output::of(file.path()?, file.name());
        let outputs = files.files().filter_map(output).collect();
        let record = BuildRecord { inputs, outputs, work: timer.work() };
        files.add_bytes("timings.json", record.json(timer).as_bytes())?;
        Ok(())
    })
}
