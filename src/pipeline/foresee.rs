//! A build without its files: how large everything would be.

use super::advice::Advice;
use super::facets::{self, Facets, added_to};
use super::observer::Clock;
use super::{Error, Observer, Source, Stage, designed};
use crate::design::Design;
use crate::export::{Label, Size, obj_bytes, stl_bytes};
use crate::geom::Outline;
use crate::mesh::{Limits, Plan, mesh};
use crate::profile::{Format, Profile};
use crate::report::{Foreseen, ProfileId, Prospect, ProspectFile, ProspectMesh};

/// Foresees what [`super::build`] would make of the profile of `source`. Touches no file.
///
/// # Errors
/// [`enum@Error`] when it can be foreseen that a stage cannot be done.
pub fn foresee(source: &Source, observer: &dyn Observer) -> Result<Prospect, Error> {
    let profile = &source.profile;
    let clock = Clock::new(observer);
    let design = clock.stage(Stage::Design, || designed(source))?;
    clock.stage(Stage::Forecast, || {
        let facets = facets::plan(profile, &design)?;
        let prospect = prospect(profile, &design, &facets);
        let note = format!("about {} triangles", prospect.mesh.triangles);
        Ok((prospect, note))
    })
}

fn prospect(profile: &Profile, design: &Design, facets: &Facets<Plan>) -> Prospect {
    let Plan { limits, forecast } = facets.made;
    let size = size(design, forecast.facets.round() as usize, &facets.made);
    let triangles = size.optical + size.more;
    let tolerances = profile.mesh.max_triangles.map(|_| reached(design, &facets.made));
    let pixel = design.camera.pixel_mm;
    let mesh = ProspectMesh {
        optical_triangles: size.optical,
        triangles,
        max_triangles: profile.mesh.max_triangles,
        chord_um: Foreseen {
            limit: profile.mesh.chord_um,
            foreseen: tolerances.and_then(|[chord, _]| chord).map(|mm| mm * 1e3),
        },
        facet_px: Foreseen {
            limit: profile.mesh.facet_px,
            foreseen: tolerances.and_then(|[_, facet]| facet).map(|mm| mm / pixel),
        },
    };
    let digits = |limit: Option<f64>| limit.map_or("-".into(), |limit| limit.to_string());
    let label = Label {
        profile: profile.name.clone(),
        sha256: profile.sha256.clone(),
        tolerances: format!(
            "chord um {}:0.000 facet px {}:0.000",
            digits(profile.mesh.chord_um),
            digits(profile.mesh.facet_px)
        ),
    };
    let file = |&format: &Format| ProspectFile {
        name: format!("mirror.{format}"),
        format: format.name(),
        bytes: match format {
            Format::Stl => stl_bytes(triangles),
            Format::Obj => obj_bytes(&size, &design.mirror, limits.precision, &label),
        },
    };
    let files: Vec<ProspectFile> = facets.formats.iter().map(file).collect();
    let id = ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() };
    let mut prospect = Prospect::new(id, mesh, files);
    let refused = facets.refused.iter();
    prospect.reasons = refused.map(|reason| reason.replace("was not", "would not be")).collect();
    let advice = Advice { profile, design, precision: facets.precision };
    let files: Vec<(&str, u64)> = prospect.files.iter().map(|f| (&*f.name, f.bytes)).collect();
    prospect.warnings = advice.on(triangles, &files);
    prospect
}

/// The solid that is foreseen, by Euler's formula.
fn size(design: &Design, optical: usize, plan: &Plan) -> Size {
    let ring = matches!(design.mirror.outline, Outline::Ring { inner, .. } if inner > 0.0);
    let rim = plan.forecast.rim.round() as usize;
    let more = added_to(&plan.forecast, design);
    let face_vertices = (optical + rim) / 2 + if ring { 0 } else { 1 };
    let vertices = ((optical + more) / 2 + 2).saturating_sub(2 * design.holes());
    Size { optical, more, face_vertices, more_vertices: vertices.saturating_sub(face_vertices) }
}

/// The chord and the facet error that a number of triangles is good for: the one it is spent on,
/// and the other by the errors of a coarse mesh, as the chord is of second order in a facet's size
/// and the facet error of first.
fn reached(design: &Design, plan: &Plan) -> [Option<f64>; 2] {
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
