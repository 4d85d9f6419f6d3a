//! Reading 3MF: `zip` for the package, `quick-xml` for the model.

mod model;
mod package;

pub use package::ThreeMfError;

use super::{ImportedMesh, ReadError, not_empty};
use model::{BuildMesh, DEEPEST, MOST, ThreeMfModel, Transform};

/// Reads 3MF: all objects on the build plate, in millimetres. Coordinates are single-precision
/// numbers, as in lib3mf.
///
/// # Errors
/// [`ReadError`].
pub fn read_3mf(bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
    let mut model = ThreeMfModel::default();
    package::model_elements(bytes, |element| model.add(element))?;
    let Some([vertices, facets]) = model.size(&model.build, 0) else {
        let fault = format!(
            "the build must hold known objects of at most {MOST} vertices and facets, not nested \
             deeper than {DEEPEST}"
        );
        return Err(ThreeMfError::Build(fault).into());
    };
    let Some(mut mesh) = BuildMesh::reserved(vertices, facets) else {
        return Err(ReadError::Memory { vertices, facets });
    };
    let to_mm = Transform([
        [model.unit_mm, 0.0, 0.0],
        [0.0, model.unit_mm, 0.0],
        [0.0, 0.0, model.unit_mm],
        [0.0; 3],
    ]);
    for item in &model.build {
        mesh.add(&model, item, &to_mm)?;
    }
    Ok(ImportedMesh { mesh: not_empty(mesh.finish())?, normals: None })
}
