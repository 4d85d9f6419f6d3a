//! The closed body that files hold: the part, hollow or not, or the tool that is made in its place.

use crate::design::{Cavity, Design};
use crate::geom::{FaceMesh, Precision};
use crate::mesh::{Limits, mesh};
use crate::solid::{HollowSpace, Solid, SolidError};

/// The body with the optical face of `face`, a mesh of the mirror of `design`, in the digits of `precision`.
///
/// # Errors
/// [`SolidError`] when the face cannot be closed.
pub(crate) fn closed(
    design: &Design,
    face: &FaceMesh,
    precision: Precision,
) -> Result<Solid, SolidError> {
    let (features, _) = design.made_body();
    match (&design.tool, &design.cavity) {
        (Some(tool), _) => {
            let face = tool.face(&design.mirror, face.clone());
            Solid::from_face(&face, features, precision)
        }
        (None, Some(cavity)) => {
            let roof = roof(cavity)?;
            let room = HollowSpace { roof: &roof, floor: &cavity.floor };
            Solid::hollow(face, features, Some(room), precision)
        }
        (None, None) => Solid::from_face(face, features, precision),
    }
}

/// How many facets the cavity of `design` adds, without its drains; 0 where there is none, or it cannot be meshed.
pub(super) fn cavity_facets(design: &Design) -> usize {
    let facets = |cavity: &Cavity| {
        let roof = roof(cavity).ok()?;
        HollowSpace { roof: &roof, floor: &cavity.floor }.facets().ok()
    };
    design.cavity.as_ref().and_then(facets).unwrap_or(0)
}

/// Facets of a cavity's roof, in the digits of any file.
fn roof(cavity: &Cavity) -> Result<FaceMesh, SolidError> {
    let limits =
        Limits { chord_mm: Some(cavity.chord_mm()), facet_mm: None, precision: Precision::Single };
    let face = mesh(&cavity.roof, &cavity.roof.chart, None, limits);
    Ok(face.map_err(|error| SolidError::Roof { reason: error.to_string() })?.mesh)
}
