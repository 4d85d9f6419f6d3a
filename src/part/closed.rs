//! The closed body that files hold: the part, or the tool that is made in its place.

use crate::design::Design;
use crate::geom::{FaceMesh, Precision};
use crate::solid::{Solid, SolidError};

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
    match &design.tool {
        Some(tool) => {
            let face = tool.face(&design.mirror, face.clone());
            Solid::from_face(&face, features, precision)
        }
        None => Solid::from_face(face, features, precision),
    }
}
