//! A build without its files: how large everything would be.

use super::cad_export::CadExport;
use super::cad_exports::cad_exports;
use super::mesh_files::label;
use super::run::Run;
use super::{Error, Observer, Stage};
use crate::design::Design;
use crate::export::{ByteCounter, Label, MeshCounts};
use crate::geom::{Outline, Precision};
use crate::mesh::{ErrorBound, Limits, MeshPlan, mesh};
use crate::mirror::Form;
use crate::num::units::{Mm, Um};
use crate::part::{
    self, AtPrecision, MeshCodec, MeshOutcome, SizeWarnings, added_to, closed, codec, left_out,
    needs_mesh,
};
use crate::profile::{MeshFormat, Profile};
use crate::results::{BuildForecast, FileForecast, ForecastLimit, MeshForecast, Refusal};

/// Foresees what `build` would make of the profile of `source`. Touches no file.
///
/// # Errors
/// [`enum@Error`] when it can be foreseen that a stage cannot be done.
pub fn dry_run(source: &Profile, observer: &dyn Observer) -> Result<BuildForecast, Error> {
    let run = Run::in_memory(source, observer);
    let design = run.design()?;
    run.stage(Stage::Forecast, || {
        let planned = planned(run.profile, &design)?;
        let form = Form::of(&design.mirror);
        let exports = cad_exports(run.profile, &design, &form)?;
        let forecast = forecast(&run, &design, &exports, &planned);
        let note = forecast
            .mesh
            .map_or("no mesh".to_owned(), |mesh| format!("about {} triangles", mesh.triangles));
        Ok((forecast, note))
    })
}

/// So much room is enough for any build: the most triangles and the longest table there can be.
const ROOMY: u64 = 20_000_000_000;
/// The pages of a build, at the least.
const PAGES: u64 = 20_000;
/// The share of a forecast that is sure to come: it may be off by a fifth.
const SURE: f64 = 0.8;

/// What the files of any build of `profile` take at the least, before anything is known of the
/// mirror.
pub(super) fn least_bytes(profile: &Profile) -> u64 {
    const PER_TRIANGLE: u64 = 9;
    let meshes = part::meshes(profile).count() as u64;
    // Of the number of triangles most is spent, and no format has fewer bytes for each.
    let triangles = profile.mesh.max_triangles().map_or(0.0, |most| SURE * most as f64) as u64;
    PAGES + meshes * triangles * PER_TRIANGLE
}

/// Whether there is room for the files that are foreseen. Where there is room for any, nothing is
/// foreseen.
///
/// # Errors
/// [`enum@Error`] when there is none, or a stage cannot be done.
pub(super) fn check_room(
    run: &Run,
    design: &Design,
    exports: &[Box<dyn CadExport + '_>],
) -> Result<(), Error> {
    if run.files.free().is_none_or(|free| free >= ROOMY) {
        return Ok(());
    }
    let planned = planned(run.profile, design)?;
    // (Where no file is asked for that can be traced, one is written all the same until it is traced.)
    let meshes = planned.made().map_or(Vec::new(), |plan| meshes(run, design, plan).1);
    let label = forecast_label(design);
    let drawn: u64 = exports.iter().map(|export| export.bytes(&label)).sum();
    let bytes = drawn + meshes.iter().map(|file| file.bytes).sum::<u64>();
    Ok(run.files.ensure_space((SURE * bytes as f64) as u64)?)
}

/// The mesh that is foreseen.
fn planned(
    profile: &Profile,
    design: &Design,
) -> Result<MeshOutcome<AtPrecision<MeshPlan>>, Error> {
    if !needs_mesh(profile) {
        return Ok(MeshOutcome::Unasked);
    }
    let found = match part::plan(profile, design) {
        Ok(plan) => Ok(MeshOutcome::Made(plan)),
        Err(error) => left_out(profile, error).map(MeshOutcome::Refused),
    };
    found.map_err(|error| Error::face(profile, error))
}

/// As long as the label of the build, whose bounds are not known yet.
fn forecast_label(design: &Design) -> Label {
    label(design, Some(&ErrorBound::default()))
}

fn forecast(
    run: &Run,
    design: &Design,
    exports: &[Box<dyn CadExport + '_>],
    planned: &MeshOutcome<AtPrecision<MeshPlan>>,
) -> BuildForecast {
    let profile = run.profile;
    let (mesh, mut files, refused, precision) = match planned.made() {
        Some(plan) => {
            let (mesh, files) = meshes(run, design, plan);
            (Some(mesh), files, plan.refused.as_ref(), plan.precision)
        }
        None => (None, Vec::new(), planned.refused(), Precision::Double),
    };
    files.retain(|file| profile.formats.iter().any(|format| format.name() == file.format));
    let label = forecast_label(design);
    files.extend(exports.iter().map(|export| {
        let format = export.format();
        let (name, bytes) = (format.file_name().to_owned(), export.bytes(&label));
        FileForecast { name, format: format.name(), bytes }
    }));
    let mut forecast = BuildForecast::new(profile.into(), mesh, files);
    forecast.reasons = refused.map(Refusal::foreseen).into_iter().collect();
    let size = SizeWarnings { profile, design, precision };
    let files: Vec<(&str, u64)> = forecast.files.iter().map(|f| (&*f.name, f.bytes)).collect();
    forecast.warnings = size.on(mesh.map_or(0, |mesh| mesh.triangles), &files);
    forecast
}

/// The mesh that is foreseen, and its files: one that is made for the rays alone too.
fn meshes(
    run: &Run,
    design: &Design,
    plan: &AtPrecision<MeshPlan>,
) -> (MeshForecast, Vec<FileForecast>) {
    let MeshPlan { limits, forecast } = plan.made;
    let goal = run.profile.mesh;
    let size = size(design, forecast.facets.round() as usize, &plan.made);
    let tolerances = goal.max_triangles().map(|_| reached(design, &plan.made));
    let mesh = MeshForecast {
        optical_triangles: size.optical,
        triangles: size.optical + size.more,
        max_triangles: goal.max_triangles(),
        chord_um: ForecastLimit {
            limit: goal.chord_um(),
            foreseen: tolerances.and_then(|[chord, _]| chord).map(|mm| Um::from(Mm(mm)).0),
        },
        facet_px: ForecastLimit {
            limit: goal.facet_px(),
            foreseen: tolerances
                .and_then(|[_, facet]| facet)
                .map(|mm| design.camera.to_px(Mm(mm)).0),
        },
    };
    let label = forecast_label(design);
    let file = |&format: &MeshFormat| {
        let codec = codec(format);
        let made = (!codec.is_proportional() && size.optical < SMALL)
            .then(|| made_length(codec, design, limits, &label))
            .flatten();
        let bytes = made.unwrap_or_else(|| codec.bytes(&size, design, limits.precision, &label));
        FileForecast { name: format.file_name().to_owned(), format: format.name(), bytes }
    };
    (mesh, plan.formats.iter().map(file).collect())
}

/// Facets of a face that is soon made.
const SMALL: usize = 30_000;

/// The length of a file, by making it: how well few facets can be packed depends on their order.
fn made_length(
    codec: &dyn MeshCodec,
    design: &Design,
    limits: Limits,
    label: &Label,
) -> Option<u64> {
    let (camera, view) = (&design.camera.chart, design.bounded_view());
    let face = mesh(&design.mirror, camera, view, limits).ok()?;
    let solid = closed(design, &face.mesh, codec.precision()).ok()?;
    let mut bytes = ByteCounter::default();
    let made = design.tool.is_none().then_some((&face, design));
    codec.write(&mut bytes, &solid, made, label).ok()?;
    Some(bytes.count())
}

/// The solid that is foreseen, by Euler's formula.
fn size(design: &Design, optical: usize, plan: &MeshPlan) -> MeshCounts {
    let ring = matches!(design.mirror.outline, Outline::Ring { inner, .. } if inner > 0.0);
    let rim = plan.forecast.rim.round() as usize;
    let more = added_to(&plan.forecast, design);
    let face_vertices = (optical + rim) / 2 + if ring { 0 } else { 1 };
    let vertices = ((optical + more) / 2 + 2).saturating_sub(2 * design.made_body().0.through());
    MeshCounts {
        optical,
        more,
        face_vertices,
        more_vertices: vertices.saturating_sub(face_vertices),
    }
}

/// The chord and the facet error that a number of triangles is good for: the one it is spent on,
/// and the other by the errors of a coarse mesh, as the chord is of second order in a facet's size
/// and the facet error of first.
fn reached(design: &Design, plan: &MeshPlan) -> [Option<f64>; 2] {
    const COARSE: f64 = 30_000.0;
    let Limits { chord_mm: None, facet_mm: Some(facet), precision } = plan.limits else {
        return [plan.limits.chord_mm, None];
    };
    let coarser = (plan.forecast.facets / COARSE).max(1.0);
    let limits = Limits { chord_mm: None, facet_mm: Some(facet * coarser.sqrt()), precision };
    let (camera, view) = (&design.camera.chart, design.bounded_view());
    let chord = mesh(&design.mirror, camera, view, limits);
    [chord.ok().map(|face| face.bound.chord_mm / coarser), Some(facet)]
}
