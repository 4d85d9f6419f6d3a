//! From what a profile asks of its facets to a face, or to the forecast of one: limits or a number
//! of triangles, and the digits of the files that are asked for.

use super::closed::cavity_facets;
use super::formats::{TRACED, cad, codec, meshes};
use crate::design::Design;
use crate::forming::FormingTool;
use crate::geom::{DVec2, Outline, Precision};
use crate::mesh::{
    Budget, ClosureCount, Face, FaceForecast, Limits, MeshError, MeshPlan,
    forecast as forecast_within, mesh,
};
use crate::num::units::{Mm, Px, Um};
use crate::optics::ImagingTask;
use crate::profile::{MeshFormat, MeshGoal, Profile};
use crate::results::{Refusal, RefusalCause};
use crate::solid::{Rim, added, rim};
use thiserror::Error;

/// What is made or foreseen for the files that can have it.
#[derive(Debug)]
pub(crate) struct AtPrecision<T> {
    /// The face or the plan of it.
    pub made: T,
    /// Its digits.
    pub precision: Precision,
    /// The mesh formats of which files are written.
    pub formats: Vec<MeshFormat>,
    /// Why there are no files in single precision although they are asked for.
    pub refused: Option<Refusal>,
}

/// Why there is no face as a profile asks for it.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FaceError {
    /// No mesh keeps the limits.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// No mesh keeps the limits of a mirror that is wider than what the frame shows of it.
    #[error(
        "{source}, or narrow part.width_mm = {width_mm} to {seen_mm:.0}: the frame shows no more of the mirror, and \
         what is beyond it may be steep"
    )]
    BeyondFrame {
        /// Why.
        source: MeshError,
        /// Width of the mirror, mm.
        width_mm: f64,
        /// Width of what the frame shows of its plane, mm.
        seen_mm: f64,
    },
    /// No mesh file but in single precision is asked for, and that cannot carry the limits: where, and what
    /// it carries.
    #[error("{0}")]
    Single(String),
}

/// What a build makes or foresees of a mesh.
pub(crate) enum MeshOutcome<T> {
    /// This.
    Made(T),
    /// Nothing, for a reason, although the build goes on.
    Refused(Refusal),
    /// Nothing: the profile asks for no mesh file, and for a STEP file that is traced.
    Unasked,
}

impl<T> MeshOutcome<T> {
    /// What was made.
    pub(crate) fn made(&self) -> Option<&T> {
        match self {
            Self::Made(made) => Some(made),
            Self::Refused(_) | Self::Unasked => None,
        }
    }

    /// Why nothing was made.
    pub(crate) fn refused(&self) -> Option<&Refusal> {
        match self {
            Self::Refused(refusal) => Some(refusal),
            Self::Made(_) | Self::Unasked => None,
        }
    }
}

/// The face that the profile asks for.
///
/// # Errors
/// [`FaceError`].
pub(crate) fn face(profile: &Profile, design: &Design) -> Result<AtPrecision<Face>, FaceError> {
    let Design { mirror, camera, .. } = design;
    at_precision(profile, design, |precision| match profile.mesh {
        MeshGoal::Budget(triangles) => {
            ClosingCount::new(design).budget(triangles, precision).mesh()
        }
        MeshGoal::Limits { .. } => {
            mesh(mirror, &camera.chart, design.bounded_view(), limits(profile, design, precision))
        }
    })
    .map_err(|error| beyond_frame(design, error))
}

/// What is foreseen of that face.
pub(crate) fn plan(profile: &Profile, design: &Design) -> Result<AtPrecision<MeshPlan>, FaceError> {
    at_precision(profile, design, |precision| match profile.mesh {
        MeshGoal::Budget(triangles) => {
            ClosingCount::new(design).budget(triangles, precision).foresee()
        }
        MeshGoal::Limits { .. } => {
            let limits = limits(profile, design, precision);
            Ok(MeshPlan { limits, forecast: forecast(design, limits)? })
        }
    })
    .map_err(|error| beyond_frame(design, error))
}

/// What is foreseen of the face that keeps `limits`.
pub(crate) fn forecast(design: &Design, limits: Limits) -> Result<FaceForecast, MeshError> {
    forecast_within(&design.mirror, &design.camera.chart, design.bounded_view(), limits)
}

/// The profile's limits on the mirror of `design`, less what a tool's facets need of them.
pub(crate) fn limits(profile: &Profile, design: &Design, precision: Precision) -> Limits {
    let share = design.tool.as_ref().map_or(1.0, FormingTool::mesh_share);
    Limits {
        chord_mm: profile.mesh.chord_um().map(|um| share * Mm::from(Um(um)).0),
        facet_mm: profile.mesh.facet_px().map(|px| share * design.camera.to_mm(Px(px)).0),
        precision,
    }
}

/// How many facets close the face that is foreseen.
pub(crate) fn added_to(forecast: &FaceForecast, design: &Design) -> usize {
    body_facets(forecast, design) + cavity_facets(design)
}

/// The same without those of a cavity.
fn body_facets(forecast: &FaceForecast, design: &Design) -> usize {
    let hole = match design.mirror.outline {
        // As if neighbours on both rims were equally far apart.
        Outline::Ring { inner, outer } => forecast.rim * inner / (inner + outer),
        Outline::Rect(_) => 0.0,
    };
    let edges = (forecast.rim - hole).round() as usize;
    // (Steps are few.)
    let rim = Rim { edges, steps: 0, hole_edges: hole.round() as usize };
    added(rim, design.made_body().0)
}

/// What closing adds to faces of a mirror.
struct ClosingCount<'a> {
    design: &'a Design,
    /// Facets of its cavity.
    within: usize,
}

impl<'a> ClosingCount<'a> {
    fn new(design: &'a Design) -> Self {
        Self { design, within: cavity_facets(design) }
    }

    fn budget(&self, triangles: usize, precision: Precision) -> Budget<'_> {
        let Design { mirror, camera, .. } = self.design;
        let (camera, view) = (&camera.chart, self.design.bounded_view());
        Budget { mirror, camera, view, precision, triangles, closing: self }
    }
}

impl ClosureCount for ClosingCount<'_> {
    fn foreseen(&self, forecast: &FaceForecast) -> f64 {
        (body_facets(forecast, self.design) + self.within) as f64
    }

    fn counted(&self, face: &Face) -> usize {
        // A rim that cannot be closed is the next stage's to refuse.
        let (features, _) = self.design.made_body();
        rim(&face.mesh).map_or(0, |rim| added(rim, features) + self.within)
    }
}

/// What becomes of a refused mesh: where the designed mirror is asked for the build goes on without one,
/// for this reason; or else it ends with the error.
///
/// # Errors
/// `error`, where it ends the build.
pub(crate) fn left_out(profile: &Profile, error: FaceError) -> Result<Refusal, FaceError> {
    if matches!(error, FaceError::Single(_)) || cad(profile).next().is_none() {
        return Err(error);
    }
    let files = meshes(profile).map(MeshFormat::file_name).collect();
    Ok(Refusal { cause: RefusalCause::NoMesh, files, why: error.to_string() })
}

/// Makes what single precision needs if there is to be a file in it; where that is what fails, what
/// the other formats need.
fn at_precision<T>(
    profile: &Profile,
    design: &Design,
    make: impl Fn(Precision) -> Result<T, MeshError>,
) -> Result<AtPrecision<T>, FaceError> {
    let in_double = |formats, refused| {
        let precision = Precision::Double;
        Ok(AtPrecision { made: make(precision)?, precision, formats, refused })
    };
    let mut formats: Vec<MeshFormat> = meshes(profile).collect();
    if formats.is_empty() {
        // There is to be something to trace; it is not published.
        formats.push(TRACED);
    }
    let is_single = |format: &MeshFormat| codec(*format).precision() == Precision::Single;
    let (single, mut others): (Vec<_>, Vec<_>) = formats.iter().copied().partition(is_single);
    if single.is_empty() {
        return in_double(formats, None);
    }
    let precision = Precision::Single;
    let error = match make(precision) {
        Ok(made) => return Ok(AtPrecision { made, precision, formats, refused: None }),
        Err(error) => error,
    };
    let Some(why) = beyond_single(profile, design, &error) else { return Err(error.into()) };
    let files = single.into_iter().map(MeshFormat::file_name).collect();
    let refused = Refusal { cause: RefusalCause::SinglePrecision, files, why };
    if others.is_empty() && cad(profile).next().is_some() {
        others.push(TRACED);
    }
    if others.is_empty() {
        return Err(FaceError::Single(refused.to_string()));
    }
    in_double(others, Some(refused))
}

/// The error with the width that the frame shows, where the mirror has more and the picture ends with the frame.
fn beyond_frame(design: &Design, error: FaceError) -> FaceError {
    /// How much wider a mirror may be for the frame to stay in it as the part is mounted.
    const MARGIN: f64 = 1.02;
    let FaceError::Mesh(source) = error else { return error };
    let (width_mm, camera) = (design.profile.part.width_mm, &design.camera);
    let seen_mm = camera.seen_of(camera.frame()).size().x.ceil();
    let is_framed = design.view.as_ref().is_some_and(ImagingTask::is_framed);
    match source {
        MeshError::TooMany { .. } | MeshError::NotRefinable { .. }
            if is_framed && width_mm > MARGIN * seen_mm =>
        {
            FaceError::BeyondFrame { source, width_mm, seen_mm }
        }
        source => FaceError::Mesh(source),
    }
}

/// What single precision reaches, if `error` is due to it.
fn beyond_single(profile: &Profile, design: &Design, error: &MeshError) -> Option<String> {
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
    let chord = chord_mm.map(|mm| ("chord_um", Um::from(Mm(mm)).0));
    let facet = facet_mm.map(|mm| ("facet_px", design.camera.to_px(Mm(mm)).0));
    let reached: Vec<_> = chord.into_iter().chain(facet).collect();
    Some(reaches(&reached, at))
}

/// That facets at `at` reach no more than this in single precision: what limits they bring their bounds
/// down to, and what can be done.
fn reaches(reached: &[(&str, f64)], at: DVec2) -> String {
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
    format!(
        "single precision reaches {} at X {:.4} mm, Y {:.4} mm; {loosen}export obj alone",
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
    use crate::design::design_unmeasured;
    use crate::profile::shipped;

    #[test]
    fn a_mirror_wider_than_its_frame_is_to_be_narrowed() {
        let shipped = shipped().iter().find(|shipped| shipped.name == "driver").unwrap();
        let said = |width: &str| {
            let text = shipped.text.replace("width_mm = 229", &format!("width_mm = {width}"));
            let profile = Profile::parse("driver", "driver", text.as_bytes()).unwrap();
            let design = design_unmeasured(&profile).unwrap();
            let error = MeshError::TooMany { facets: 6.8e9, most: 1e8 };
            beyond_frame(&design, error.into()).to_string()
        };
        let end = ", or narrow part.width_mm = 300 to ";
        let wide = said("300");
        let (_, rest) = wide.split_once(end).unwrap_or_else(|| panic!("{wide}"));
        let value = rest.split(':').next().unwrap();
        let narrowed = said(value);
        assert!(narrowed.ends_with("loosen chord_um or facet_px"), "{narrowed}");
    }

    #[test]
    fn what_has_no_bound_is_not_to_be_loosened() {
        let said = |reached: &[(&str, f64)]| {
            let why = reaches(reached, DVec2::new(58.34694, -0.4649));
            let files = vec!["mirror.stl", "mirror.3mf"];
            Refusal { cause: RefusalCause::SinglePrecision, files, why }.to_string()
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
