//! One trial of a tolerance run as a part: its imperfect surface as files, its pose, and what the
//! files show through its camera.

use super::check_file::open;
use super::mesh_files::labelled;
use super::run::{Command, Run};
use super::tolerance_spec::{PreparedStudy, prepared};
use super::{Error, Stage};
use crate::design::Design;
use crate::export::ImportedMesh;
use crate::geom::{DVec3, FaceMesh, Precision, TriMesh};
use crate::num::sort_by_number;
use crate::num::stats::Summary;
use crate::parallel;
use crate::part::{self, AtPrecision, codec};
use crate::profile::{MeshFormat, Profile};
use crate::report::Answer;
use crate::results::{
    DrawnError, FileFault, PoseFile, ProfileId, Reason, ReplayFault, ReplayFile, ReplayReport,
    SCHEMA, ShapeFault,
};
use crate::solid::{Solid, check};
use crate::tolerance::{Displacement, Engine, PerturbedSystem};
use crate::tolerance_terms::{ActsOn, Criterion, ErrorSourceRow, Perturbation};
use crate::trace::Scene;
use crate::verdict;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Trial that is made a part: the mesh files that the profile asks for, `pose.json` and `replay.json` in
/// NAME/replay-K.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ReplayOptions<'a> {
    /// Its number.
    pub trial: u64,
    /// Seed of the trials.
    pub seed: u64,
    /// Keys of errors that the part is made without.
    pub without: &'a [String],
}

/// Edges of facets in the shortest swing of a surface.
const PER_SWING: f64 = 12.0;
/// Largest number of facets of the optical face.
const MOST_FACETS: usize = 6_000_000;
/// Facets with edges of a unit and less, halved from longer ones, on a unit of area.
const PER_AREA: f64 = 5.0;
/// Rounding along Z of a vertex, in units of a coordinate's last digit: where the mirror is steep
/// that of X and Y shows too.
const ROUNDING: f64 = 16.0;

impl Command for ReplayOptions<'_> {
    type Report = ReplayReport;

    fn folder(&self, profile: &Profile) -> PathBuf {
        Path::new(&profile.name).join(format!("replay-{}", self.trial))
    }

    fn run(&self, run: &mut Run) -> Result<ReplayReport, Error> {
        let PreparedStudy { design, engine, .. } = prepared(run)?;
        let part = ImperfectPart::new(run.profile, &design, &engine, self)?;
        let AtPrecision { made: face, formats, refused, .. } =
            run.stage(Stage::Mesh, || part.face())?;
        let ReplayOptions { trial, seed, .. } = *self;
        let label = labelled(&design, format!("imperfect: trial {trial} of seed {seed}"));
        let (mut files, mut reasons) = (Vec::new(), Vec::from_iter(refused.map(Reason::from)));
        // Single rays see points of textures.
        let rays = engine.pointwise();
        let smooth = rays.displacement_of(&part.made);
        for &format in &formats {
            let solid = run.stage(Stage::Solid, || part.solid(&face, format))?;
            let optical = solid.optical();
            let write = |out: &mut dyn Write| codec(format).write(out, &solid, None, &label);
            run.write(format.file_name(), write)?;
            drop(solid);
            let subject = (&rays, &part.made, &design);
            let (found, faults) = witnessed(run, subject, format, optical, &smooth)?;
            reasons.extend(faults);
            files.extend(found);
        }
        let report = part.report(smooth, files, reasons);
        let pose = part.pose(report.profile.clone());
        run.publish(Stage::Report, |files, _| {
            files.add_bytes("pose.json", pose.json().as_bytes())?;
            files.add_report("replay.json", &report.json())?;
            for format in MeshFormat::ALL.iter().filter(|format| !formats.contains(format)) {
                files.remove(format.file_name());
            }
            Ok(())
        })?;
        Ok(report)
    }
}

/// The part of a trial, without the errors that its files do not have.
struct ImperfectPart<'a> {
    profile: &'a Profile,
    design: &'a Design,
    engine: &'a Engine,
    seed: u64,
    trial: u64,
    /// Errors that the part is made without.
    without: Vec<Perturbation>,
    made: PerturbedSystem,
    /// Longest edge of a facet, mm; none where the surface is as designed.
    longest_edge_mm: Option<f64>,
}

impl<'a> ImperfectPart<'a> {
    fn new(
        profile: &'a Profile,
        design: &'a Design,
        engine: &'a Engine,
        wanted: &ReplayOptions,
    ) -> Result<Self, Error> {
        let ReplayOptions { trial, seed, .. } = *wanted;
        let mut without = left_out(profile, engine, wanted.without)?;
        // The file has facets of its own, and no terraces: these are the printer's.
        let own = [Perturbation::Facets, Perturbation::Layers];
        without.extend(sources(engine).filter(|kind| own.contains(kind)));
        without.sort_unstable();
        without.dedup();
        let made = engine.replayed(seed, trial, &without);
        let longest_edge_mm = engine.shortest(&made).map(|swing| swing / PER_SWING);
        let part = Self { profile, design, engine, seed, trial, without, made, longest_edge_mm };
        let too_fine = |edge| facets_of(design, edge) > MOST_FACETS as f64;
        if longest_edge_mm.is_some_and(too_fine) { Err(part.too_fine()) } else { Ok(part) }
    }

    /// The face with the part's form, and how many facets its mesh has as designed.
    fn face(&self) -> Result<(AtPrecision<FaceMesh>, String), Error> {
        let AtPrecision { made, precision, formats, refused } =
            part::face(self.profile, self.design)
                .map_err(|error| Error::face(self.profile, error))?;
        let note = format!("{} optical triangles", made.mesh.triangles.len());
        let mut mesh = made.mesh;
        if let Some(edge) = self.longest_edge_mm {
            let between = |a: DVec3, b: DVec3| middle(self.design, a, b);
            // Walls follow the edges of the panels, which are split.
            let panels = mesh.into_panels().split(edge, MOST_FACETS, between);
            let panels = panels.ok_or_else(|| self.too_fine())?;
            mesh = self.design.mirror.with_walls(panels).map_err(|fault| Error::Replay {
                profile: self.profile.name.clone(),
                reason: fault.to_string(),
            })?;
        }
        let made = mesh.moved(|mesh| displaced(self.engine, &self.made, mesh));
        Ok((AtPrecision { made, precision, formats, refused }, note))
    }

    /// The closed part in the digits of a format, and how many triangles it has.
    fn solid(&self, face: &FaceMesh, format: MeshFormat) -> Result<(Solid, String), Error> {
        let name = || self.profile.name.clone();
        let solid = Solid::from_face(face, self.design.features(), Precision::Double)
            .and_then(|solid| {
                solid.grown(self.engine.growth(&self.made), codec(format).precision())
            })
            .map_err(|source| Error::Solid { profile: name(), format, source })?;
        let note = format!("{} triangles, closed", solid.mesh().triangles.len());
        Ok((solid, note))
    }

    fn report(
        &self,
        smooth: Displacement,
        files: Vec<ReplayFile>,
        reasons: Vec<Reason>,
    ) -> ReplayReport {
        let Self { profile, engine, seed, trial, .. } = *self;
        let errors = engine.drawn(seed, trial);
        let drawn = |(kind, value): (Perturbation, f64)| DrawnError {
            source: kind.key().to_owned(),
            value,
        };
        ReplayReport {
            schema: SCHEMA,
            profile: profile.into(),
            seed,
            trial,
            samples: engine.samples(),
            criterion: engine.spec.criterion,
            reference: engine.spec.reference,
            errors: errors.into_iter().map(drawn).collect(),
            without: self.without.iter().map(|kind| kind.key().to_owned()).collect(),
            repeated: engine.displacement_of(&engine.replayed(seed, trial, &[])),
            smooth,
            longest_edge_mm: self.longest_edge_mm,
            files,
            verdict: verdict::of(&reasons),
            reasons,
        }
    }

    /// Pose of the part and errors of the camera, of the errors that are not left out.
    fn pose(&self, profile: ProfileId) -> PoseFile {
        let Self { engine, seed, trial, .. } = *self;
        let mut errors = engine.drawn(seed, trial);
        errors.retain(|(kind, _)| !self.without.contains(kind));
        // All keys, so that readers find them.
        let of = |acts: fn(ActsOn) -> bool| {
            let rows = ErrorSourceRow::TABLE.iter().filter(|row| acts(row.acts_on));
            let value = |kind| errors.iter().find(|e| e.0 == kind).map_or(0.0, |e| e.1);
            rows.map(|row| (row.key.to_owned(), value(row.perturbation).into())).collect()
        };
        PoseFile {
            schema: SCHEMA,
            profile,
            seed,
            trial,
            part: of(ActsOn::is_mounting),
            world_from_file: engine.placing(&self.made),
            camera: of(ActsOn::is_camera),
            in_the_files: of(ActsOn::is_size),
            growth: engine.growth(&self.made),
        }
    }

    /// Names the errors that swing too finely.
    fn too_fine(&self) -> Error {
        let finest = |kind: Perturbation| {
            let others: Vec<Perturbation> =
                sources(self.engine).filter(|other| *other != kind).collect();
            let alone = self.engine.replayed(self.seed, self.trial, &others);
            let swing = self.engine.shortest(&alone)?;
            Some((kind, swing, facets_of(self.design, swing / PER_SWING)))
        };
        let mut fine: Vec<(Perturbation, f64, f64)> = sources(self.engine)
            .filter(|kind| !self.without.contains(kind))
            .filter_map(finest)
            .collect();
        sort_by_number(&mut fine, |finest| -finest.2);
        let most = fine.first().map_or(0.0, |finest| finest.2);
        // The worst one in any case.
        let guilty = fine.iter().take_while(|f| f.2 > MOST_FACETS as f64 || f.2 == most);
        let (words, options): (Vec<String>, Vec<String>) = guilty
            .map(|(kind, swing, facets)| {
                let key = kind.key();
                let words = format!(
                    "{key} swings within {swing} mm, which takes about {facets:.1e} facets"
                );
                (words, format!("--without {key}"))
            })
            .unzip();
        let reason = format!(
            "{}, over the {:.0e} that are made; leave it out of the part by {}",
            words.join("; "),
            MOST_FACETS as f64,
            options.join(" "),
        );
        Error::Replay { profile: self.profile.name.clone(), reason }
    }
}

fn sources(engine: &Engine) -> impl Iterator<Item = Perturbation> {
    engine.spec.sources.iter().map(|source| source.kind)
}

/// The error sources that these keys name.
fn left_out(
    profile: &Profile,
    engine: &Engine,
    keys: &[String],
) -> Result<Vec<Perturbation>, Error> {
    let kind = |key: &String| {
        let found = sources(engine).find(|kind| kind.key() == key);
        found.ok_or_else(|| {
            let known: Vec<&str> = sources(engine).map(Perturbation::key).collect();
            let reason = format!("{key} is none of its errors, which are {}", known.join(", "));
            Error::Replay { profile: profile.name.clone(), reason }
        })
    };
    keys.iter().map(kind).collect()
}

/// About how many facets with such edges the mirror takes.
fn facets_of(design: &Design, edge: f64) -> f64 {
    PER_AREA * design.mirror.full_outline().area() / (edge * edge)
}

/// The place of the designed mirror half way between two others.
fn middle(design: &Design, a: DVec3, b: DVec3) -> DVec3 {
    let mirror = &design.mirror;
    let q = 0.5 * (mirror.chart.coordinates(a).0 + mirror.chart.coordinates(b).0);
    mirror.position_on(mirror.panel_at(a), q)
}

/// The designed face with the form of a made one.
fn displaced(engine: &Engine, made: &PerturbedSystem, mut face: TriMesh) -> TriMesh {
    let up = |_, v: &mut DVec3| v.z += engine.departure(made, *v);
    parallel::for_each_mut(&mut face.vertices, 1, up);
    face
}

/// Reads a file of the made part and traces it, with reasons why it will not do.
fn witnessed(
    run: &Run,
    (engine, made, design): (&Engine, &PerturbedSystem, &Design),
    format: MeshFormat,
    optical: usize,
    smooth: &Displacement,
) -> Result<(Option<ReplayFile>, Vec<Reason>), Error> {
    let read = |reread: ImportedMesh| {
        let solid = check(&reread.mesh).through(design.holes());
        (reread.mesh, solid)
    };
    let staged = run.files.staged(format.file_name())?;
    let (file, read) = open(run, format, staged.read()?, read)?;
    let name = file.name.clone();
    let mut reasons: Vec<Reason> = Vec::new();
    if file.sha256 != staged.sha256() {
        reasons.push(FileFault::Altered.into());
    }
    let found = match read {
        Err(error) => {
            reasons.push(FileFault::Unreadable(error.to_string()).into());
            None
        }
        Ok((mesh, solid)) => Some(run.timer.always(Stage::Trace, || {
            let defects = solid.reasons().into_iter();
            reasons.extend(defects.map(|defect| ShapeFault::NotSolid(defect).into()));
            let rounding_mm = rounding(&mesh, format);
            let mut vertices: Vec<u32> =
                mesh.triangles.iter().take(optical).flatten().copied().collect();
            vertices.sort_unstable();
            vertices.dedup();
            let vertices: Vec<DVec3> =
                vertices.iter().map(|&v| mesh.vertices[v as usize]).collect();
            let off_surface_mm = engine.off_surface(made, &vertices);
            let triangles = mesh.triangles.len();
            let witnessed = engine.witness(made, &Scene::new(mesh), optical);
            let note = format!("{name}: {} of {} rays hit", witnessed.hit, witnessed.rays);
            let found = ReplayFile {
                file,
                triangles,
                optical_triangles: optical,
                solid,
                off_surface_mm,
                rounding_mm,
                witnessed,
            };
            let faults = objections(&found, smooth, engine.spec.criterion);
            reasons.extend(faults.into_iter().map(Reason::from));
            (found, note)
        })),
    };
    Ok((found, reasons.into_iter().map(|reason| reason.of_file(&name)).collect()))
}

/// Displacement of a vertex along Z by rounding to a format's digits, mm.
fn rounding(mesh: &TriMesh, format: MeshFormat) -> f64 {
    let largest = mesh.bounds().map_or(0.0, |(lo, hi)| lo.abs().max(hi.abs()).max_element());
    let digit = match codec(format).precision() {
        Precision::Single => 0.5 * f64::from(f32::EPSILON),
        // The mirror itself is evaluated to some thousand times the last digit.
        Precision::Double => 1e3 * f64::EPSILON,
    };
    ROUNDING * digit * largest
}

/// Why a file does not show the made surface.
fn objections(found: &ReplayFile, smooth: &Displacement, criterion: Criterion) -> Vec<ReplayFault> {
    let ReplayFile { off_surface_mm: off_mm, rounding_mm, ref witnessed, .. } = *found;
    let mut faults = Vec::new();
    if !smooth.as_made.kept() {
        faults.push(ReplayFault::Lost);
        return faults;
    }
    if !(off_mm <= rounding_mm) {
        faults.push(ReplayFault::OffSurface { off_mm, rounding_mm });
    }
    if witnessed.lost > 0 {
        faults.push(ReplayFault::Unreflected { lost: witnessed.lost, rays: witnessed.rays });
    }
    let error = |facets: Summary| match criterion {
        Criterion::Rms => facets.rms,
        Criterion::P95 => facets.max,
    };
    let facets_px = witnessed.facet_error_px.map_or(0.0, error);
    let shown = &witnessed.displacement;
    for (state, shown, smooth) in
        [("as made", shown.as_made, smooth.as_made), ("adjusted", shown.adjusted, smooth.adjusted)]
    {
        let (shown_px, smooth_px) = (shown.by(criterion), smooth.by(criterion));
        // Facets that are all there is would meet their own error to rounding.
        if !((shown_px - smooth_px).abs() <= facets_px * (1.0 + 1e-3)) {
            faults.push(ReplayFault::Displacement { state, shown_px, smooth_px, facets_px });
        }
    }
    faults
}
