//! From what a profile asks of its facets to a face, or to the forecast of one: limits or a number
//! of triangles, and the digits of the files that are asked for.

use super::Error;
use super::formats::{TRACED, drawings, meshes, precision};
use crate::design::Design;
use crate::geom::{DVec2, Outline, Precision};
use crate::mesh::{
    Budget, ClosureCount, Face, FaceForecast, Limits, MeshError, MeshPlan,
    forecast as forecast_within, mesh,
};
use crate::profile::{Format, Profile};
use crate::report::{Reason, ReasonKind};
use crate::solid::{added, rim};

/// What is made or foreseen for the files that can have it.
#[derive(Debug)]
pub struct AtPrecision<T> {
    /// The face or the plan of it.
    pub made: T,
    /// Its digits.
    pub precision: Precision,
    /// The mesh formats of which files are written.
    pub formats: Vec<Format>,
    /// Why there are no files in single precision although they are asked for.
    pub refused: Option<Reason>,
}

/// The face that the profile asks for.
pub fn face(profile: &Profile, design: &Design) -> Result<AtPrecision<Face>, Error> {
    let Design { mirror, camera, view, .. } = design;
    at_precision(profile, design, |precision| match profile.mesh.max_triangles {
        Some(triangles) => ClosingCount::new(design).budget(triangles, precision).mesh(),
        None => mesh(mirror, &camera.chart, view.as_ref(), limits(profile, design, precision)),
    })
}

/// What is foreseen of that face.
pub fn plan(profile: &Profile, design: &Design) -> Result<AtPrecision<MeshPlan>, Error> {
    at_precision(profile, design, |precision| match profile.mesh.max_triangles {
        Some(triangles) => ClosingCount::new(design).budget(triangles, precision).foresee(),
        None => {
            let limits = limits(profile, design, precision);
            Ok(MeshPlan { limits, forecast: forecast(design, limits)? })
        }
    })
}

/// What is foreseen of the face that keeps `limits`.
pub fn forecast(design: &Design, limits: Limits) -> Result<FaceForecast, MeshError> {
    forecast_within(&design.mirror, &design.camera.chart, design.view.as_ref(), limits)
}

/// The profile's limits on the mirror of `design`.
pub fn limits(profile: &Profile, design: &Design, precision: Precision) -> Limits {
    Limits {
        chord_mm: profile.mesh.chord_um.map(|um| um * 1e-3),
        facet_mm: profile.mesh.facet_px.map(|px| px * design.camera.pixel_mm),
        precision,
    }
}

/// How many facets close the face that is foreseen.
pub fn added_to(forecast: &FaceForecast, design: &Design) -> usize {
    let hole = match design.mirror.outline {
        // As if neighbours on both rims were equally far apart.
        Outline::Ring { inner, outer } => forecast.rim * inner / (inner + outer),
        Outline::Rect(_) => 0.0,
    };
    let outer = (forecast.rim - hole).round() as usize;
    added(outer, hole.round() as usize, design.border.as_ref())
}

/// What closing adds to faces of a mirror.
struct ClosingCount<'a>(&'a Design);

impl<'a> ClosingCount<'a> {
    fn new(design: &'a Design) -> Self {
        Self(design)
    }

    fn budget(&self, triangles: usize, precision: Precision) -> Budget<'_> {
        let Design { mirror, camera, view, .. } = self.0;
        let (camera, view) = (&camera.chart, view.as_ref());
        Budget { mirror, camera, view, precision, triangles, closing: self }
    }
}

impl ClosureCount for ClosingCount<'_> {
    fn foreseen(&self, forecast: &FaceForecast) -> f64 {
        added_to(forecast, self.0) as f64
    }

    fn counted(&self, face: &Face) -> usize {
        // A rim that cannot be closed is the next stage's to refuse.
        let stock = self.0.border.as_ref();
        rim(&face.mesh).map_or(0, |[outer, hole]| added(outer, hole, stock))
    }
}

/// What becomes of a refused mesh: where a drawing or a table is asked for the build goes on without one,
/// for this reason; or else it ends with the error.
pub fn left_out(profile: &Profile, error: Error) -> Result<Reason, Error> {
    let Error::Mesh { source, .. } = &error else { return Err(error) };
    if drawings(profile).next().is_none() {
        return Err(error);
    }
    let meshes = profile.formats.iter().filter(|format| format.is_mesh());
    let names: Vec<&str> = meshes.map(|format| format.file_name()).collect();
    let sentence = match names[..] {
        [] => format!("no mesh could be made to trace: {source}"),
        [name] => format!("{name} was not written: {source}"),
        _ => format!("{} were not written: {source}", names.join(" and ")),
    };
    Ok(Reason::new(ReasonKind::NoMesh, sentence))
}

/// Makes what single precision needs if there is to be a file in it; where that is what fails, what
/// the other formats need.
fn at_precision<T>(
    profile: &Profile,
    design: &Design,
    make: impl Fn(Precision) -> Result<T, MeshError>,
) -> Result<AtPrecision<T>, Error> {
    let fail = |source| Error::Mesh { profile: profile.name.clone(), source };
    let formats = meshes(profile);
    let single: Vec<Format> =
        formats.iter().copied().filter(|&f| precision(f) == Precision::Single).collect();
    if single.is_empty() {
        let precision = Precision::Double;
        let made = make(precision).map_err(fail)?;
        return Ok(AtPrecision { made, precision, formats, refused: None });
    }
    let error = match make(Precision::Single) {
        Ok(made) => {
            return Ok(AtPrecision { made, precision: Precision::Single, formats, refused: None });
        }
        Err(error) => error,
    };
    let Some(reason) = refusal(profile, design, &single, &error) else { return Err(fail(error)) };
    let mut others: Vec<Format> = formats.into_iter().filter(|f| !single.contains(f)).collect();
    if others.is_empty() && drawings(profile).next().is_some() {
        others.push(TRACED);
    }
    if others.is_empty() {
        return Err(Error::Single { profile: profile.name.clone(), reason });
    }
    let precision = Precision::Double;
    let made = make(precision).map_err(fail)?;
    let refused = Some(Reason::new(ReasonKind::SinglePrecision, reason));
    Ok(AtPrecision { made, precision, formats: others, refused })
}

/// Why there are no files of the formats in `single`, if `error` is due to that precision.
fn refusal(
    profile: &Profile,
    design: &Design,
    single: &[Format],
    error: &MeshError,
) -> Option<String> {
    let (at, chord_mm, facet_mm) = match *error {
        MeshError::PrecisionLimit { at, chord_mm, facet_mm } => (at, chord_mm, facet_mm),
        MeshError::NotRefinable { at, bound, holds_in_double: true, .. } => {
            let limits = limits(profile, design, Precision::Single);
            let missed = |bound: f64, limit: Option<f64>| {
                limit.is_some_and(|limit| !(bound <= limit)).then_some(bound)
            };
            let chord = missed(bound.chord_mm, limits.chord_mm);
            let facet = missed(bound.facet_mm, limits.facet_mm);
            (at, chord.or(facet.is_none().then_some(bound.chord_mm)), facet)
        }
        _ => return None,
    };
    let chord = chord_mm.map(|mm| ("chord_um", mm * 1e3));
    let facet = facet_mm.map(|mm| ("facet_px", mm / design.camera.pixel_mm));
    let reached: Vec<_> = chord.into_iter().chain(facet).collect();
    Some(unwritten(single, &reached, at))
}

/// That there are no files of the formats in `single`, because at `at` facets `reached` no more: what
/// limits they bring their bounds down to, and what can be done.
fn unwritten(single: &[Format], reached: &[(&str, f64)], at: DVec2) -> String {
    let figure = |&(key, value): &(&str, f64)| {
        if value.is_finite() {
            format!("{key} {}", digits(value))
        } else {
            format!("no {key} at all")
        }
    };
    let figures: Vec<String> = reached.iter().map(figure).collect();
    let finite = reached.iter().filter(|(_, value)| value.is_finite());
    let keys: Vec<&str> = finite.map(|(key, _)| *key).collect();
    let loosen =
        if keys.is_empty() { String::new() } else { format!("loosen {} or ", keys.join(" and ")) };
    let names: Vec<&str> = single.iter().map(|format| format.file_name()).collect();
    let was = if single.len() == 1 { "was" } else { "were" };
    format!(
        "{} {was} not written: single precision reaches {} at X {:.4} mm, Y {:.4} mm; \
         {loosen}export obj alone",
        names.join(" and "),
        figures.join(", "),
        at.x,
        at.y,
    )
}

/// Three digits or so.
fn digits(x: f64) -> String {
    if (1e-2..1e4).contains(&x) { format!("{x:.3}") } else { format!("{x:.2e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_bound_is_not_to_be_loosened() {
        let said = |reached: &[(&str, f64)]| {
            unwritten(&[Format::Stl, Format::ThreeMf], reached, DVec2::new(58.34694, -0.4649))
        };
        assert_eq!(
            said(&[("facet_px", f64::INFINITY)]),
            "mirror.stl and mirror.3mf were not written: single precision reaches no facet_px at all \
             at X 58.3469 mm, Y -0.4649 mm; export obj alone"
        );
        assert_eq!(
            said(&[("chord_um", 0.25), ("facet_px", f64::INFINITY)]),
            "mirror.stl and mirror.3mf were not written: single precision reaches chord_um 0.250, \
             no facet_px at all at X 58.3469 mm, Y -0.4649 mm; loosen chord_um or export obj alone"
        );
    }
}
