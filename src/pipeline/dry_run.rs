//! A build without its files: how large everything would be.

use super::cad_exports::{CadExports, check_table, fitted};
use super::face::{self, AtPrecision, added_to, left_out};
use super::files::Folder;
use super::formats::{TRACED, drawings, mesh_bytes, precision};
use super::observer::StageTimer;
use super::size_warnings::SizeWarnings;
use super::{Error, Observer, Source, Stage, designed, label};
use crate::design::Design;
use crate::export::step::FittedMirror;
use crate::export::{ByteCounter, Label, MeshCounts, threemf_bytes, write_3mf};
use crate::geom::{Outline, Precision};
use crate::mesh::{ErrorBound, Limits, MeshPlan, mesh};
use crate::mirror::Form;
use crate::profile::{Format, Profile};
use crate::report::{BuildForecast, FileForecast, ForecastLimit, MeshForecast, ProfileId, Reason};
use crate::solid::Solid;

/// Foresees what [`super::build`] would make of the profile of `source`. Touches no file.
///
/// # Errors
/// [`enum@Error`] when it can be foreseen that a stage cannot be done.
pub fn dry_run(source: &Source, observer: &dyn Observer) -> Result<BuildForecast, Error> {
    let profile = &source.profile;
    let clock = StageTimer::new(observer);
    let design = clock.stage(Stage::Design, || designed(source))?;
    clock.stage(Stage::Forecast, || {
        let facets = planned(profile, &design)?;
        check_table(profile, &design)?;
        let fit = fitted(profile, &design)?;
        let prospect = prospect(profile, &design, fit.as_ref(), &facets);
        let note = prospect
            .mesh
            .map_or("no mesh".to_owned(), |mesh| format!("about {} triangles", mesh.triangles));
        Ok((prospect, note))
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
pub fn least_bytes(profile: &Profile) -> u64 {
    const PER_TRIANGLE: u64 = 9;
    let meshes = profile.formats.iter().filter(|format| format.is_mesh()).count() as u64;
    // Of the number of triangles most is spent, and no format has fewer bytes for each.
    let triangles = profile.mesh.max_triangles.map_or(0.0, |most| SURE * most as f64) as u64;
    PAGES + meshes * triangles * PER_TRIANGLE
}

/// Whether `folder` has room for the files that are foreseen. Where there is room for any, nothing
/// is foreseen.
///
/// # Errors
/// [`enum@Error`] when there is none, or a stage cannot be done.
pub fn check_room(
    folder: &Folder,
    profile: &Profile,
    design: &Design,
    fit: Option<&FittedMirror>,
) -> Result<(), Error> {
    if folder.free().is_none_or(|free| free >= ROOMY) {
        return Ok(());
    }
    // Where no mesh is asked for, one is written all the same until it is traced.
    let mut written = profile.clone();
    if !written.formats.iter().any(|format| format.is_mesh()) {
        written.formats.push(TRACED);
    }
    let prospect = prospect(&written, design, fit, &planned(&written, design)?);
    let bytes: u64 = prospect.files.iter().map(|file| file.bytes).sum();
    Ok(folder.ensure_space((SURE * bytes as f64) as u64)?)
}

/// The mesh that is foreseen, or why there will be none although the build goes on.
fn planned(
    profile: &Profile,
    design: &Design,
) -> Result<Result<AtPrecision<MeshPlan>, Reason>, Error> {
    match face::plan(profile, design) {
        Ok(facets) => Ok(Ok(facets)),
        Err(error) => left_out(profile, error).map(Err),
    }
}

fn prospect(
    profile: &Profile,
    design: &Design,
    fit: Option<&FittedMirror>,
    facets: &Result<AtPrecision<MeshPlan>, Reason>,
) -> BuildForecast {
    // As long as that of the build, whose bounds are not known yet.
    let label = label(profile, design, Some(&ErrorBound::default()));
    let form = Form::of(&design.mirror);
    let drawing = CadExports { profile, design, form: &form, fit, label: &label };
    let drawn = drawings(profile).map(|format| foreseen(format, drawing.bytes(format)));
    let (mesh, mut files, refused, precision) = match facets {
        Ok(facets) => {
            let (mesh, files) = meshes(profile, design, facets, &label);
            (Some(mesh), files, facets.refused.as_ref(), facets.precision)
        }
        Err(refused) => (None, Vec::new(), Some(refused), Precision::Double),
    };
    files.extend(drawn);
    let id = ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() };
    let mut prospect = BuildForecast::new(id, mesh, files);
    prospect.reasons = refused
        .into_iter()
        .map(|reason| reason.replace("was not", "would not be").replace("were not", "would not be"))
        .collect();
    let advice = SizeWarnings { profile, design, precision };
    let files: Vec<(&str, u64)> = prospect.files.iter().map(|f| (&*f.name, f.bytes)).collect();
    prospect.warnings = advice.on(mesh.map_or(0, |mesh| mesh.triangles), &files);
    prospect
}

fn foreseen(format: Format, bytes: u64) -> FileForecast {
    FileForecast { name: format.file_name().to_owned(), format: format.name(), bytes }
}

/// The mesh that is foreseen, and its files.
fn meshes(
    profile: &Profile,
    design: &Design,
    facets: &AtPrecision<MeshPlan>,
    label: &Label,
) -> (MeshForecast, Vec<FileForecast>) {
    let MeshPlan { limits, forecast } = facets.made;
    let size = size(design, forecast.facets.round() as usize, &facets.made);
    let tolerances = profile.mesh.max_triangles.map(|_| reached(design, &facets.made));
    let pixel = design.camera.pixel_mm;
    let mesh = MeshForecast {
        optical_triangles: size.optical,
        triangles: size.optical + size.more,
        max_triangles: profile.mesh.max_triangles,
        chord_um: ForecastLimit {
            limit: profile.mesh.chord_um,
            foreseen: tolerances.and_then(|[chord, _]| chord).map(|mm| mm * 1e3),
        },
        facet_px: ForecastLimit {
            limit: profile.mesh.facet_px,
            foreseen: tolerances.and_then(|[_, facet]| facet).map(|mm| mm / pixel),
        },
    };
    let bytes = |format: Format| {
        if format == Format::ThreeMf && size.optical < SMALL {
            packed(design, limits, label).unwrap_or_else(|| threemf_bytes(&size))
        } else {
            mesh_bytes(format, &size, design, limits.precision, label)
        }
    };
    let asked = facets.formats.iter().copied().filter(|format| profile.formats.contains(format));
    (mesh, asked.map(|format| foreseen(format, bytes(format))).collect())
}

/// AtPrecision of a face that is soon made.
const SMALL: usize = 30_000;

/// The length of a 3MF, by making it: how well few facets can be packed depends on their order.
fn packed(design: &Design, limits: Limits, label: &Label) -> Option<u64> {
    let (camera, view) = (&design.camera.chart, design.view.as_ref());
    let face = mesh(&design.mirror, camera, view, limits).ok()?;
    let solid =
        Solid::from_face(&face.mesh, design.border.as_ref(), precision(Format::ThreeMf)).ok()?;
    let mut bytes = ByteCounter::default();
    write_3mf(&mut bytes, &solid, label).ok()?;
    Some(bytes.count())
}

/// The solid that is foreseen, by Euler's formula.
fn size(design: &Design, optical: usize, plan: &MeshPlan) -> MeshCounts {
    let ring = matches!(design.mirror.outline, Outline::Ring { inner, .. } if inner > 0.0);
    let rim = plan.forecast.rim.round() as usize;
    let more = added_to(&plan.forecast, design);
    let face_vertices = (optical + rim) / 2 + if ring { 0 } else { 1 };
    let vertices = ((optical + more) / 2 + 2).saturating_sub(2 * design.holes());
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
    let (camera, view) = (&design.camera.chart, design.view.as_ref());
    let chord = mesh(&design.mirror, camera, view, limits);
    [chord.ok().map(|face| face.bound.chord_mm / coarser), Some(facet)]
}
