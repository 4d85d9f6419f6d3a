//! Scenes by name or file.

use super::files::{self, FileError};
use crate::raster::{Raster, RasterError};
use crate::render::{Model, ModelError, PanoramaWorld};
use std::path::Path;
use thiserror::Error;

/// What is to be rendered, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderOptions<'a> {
    /// The name of a scene, or a file.
    pub scene: &'a str,
    /// By the designed mirror instead of the mesh.
    pub smooth: bool,
    /// Side of the chessboard's squares, mm; absent: the mirror's largest width.
    pub square_mm: Option<f64>,
    /// Millimetres that a unit of a model measures; absent: 1.
    pub unit_mm: Option<f64>,
    /// Whether a model may name files outside its folder.
    pub allow_outside: bool,
}

/// Why there is no scene.
#[derive(Debug, Error)]
pub enum SceneError {
    /// Neither a scene nor a file.
    #[error(
        "{named}: no such file, and no scene of that name; the scenes are grid, chessboard, views \
         and cylinder, and files may be PNG, JPEG, EXR or OBJ{hint}"
    )]
    Unknown {
        /// As typed.
        named: String,
        /// What could be meant.
        hint: String,
    },
    /// An option of another scene.
    #[error("{option} is for {of}, and the scene is {named}; leave it out")]
    Misplaced {
        /// The option.
        option: &'static str,
        /// The scenes that have it.
        of: &'static str,
        /// The scene, as typed.
        named: String,
    },
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is no picture.
    #[error("{file}: {source}; a model's name ends in .obj")]
    Picture {
        /// The file.
        file: String,
        /// Why.
        source: RasterError,
    },
    /// The picture is no panorama.
    #[error(
        "{file}: a panorama is a full turn wide and at most half as high, and this has {width} x {height} \
         pixels; crop it, or take an equirectangular one"
    )]
    Shape {
        /// The file.
        file: String,
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// The file is no model.
    #[error("{file}: {source}")]
    Model {
        /// The file.
        file: String,
        /// Why.
        source: ModelError,
    },
}

/// A scene, ready to be seen.
pub enum Scenery {
    /// The test world far away.
    Grid,
    /// The chessboard around the mirror.
    Chessboard,
    /// The part itself.
    Views,
    /// The image, the part and the cylinder around it.
    Cylinder,
    /// A picture far away.
    Panorama(Box<PanoramaWorld>),
    /// Triangles around the mirror.
    Model(Box<Model>),
}

const NAMES: [&str; 4] = ["grid", "chessboard", "views", "cylinder"];

impl Scenery {
    /// Whether it shows the part itself.
    pub fn shows_part(&self) -> bool {
        matches!(self, Self::Views | Self::Cylinder)
    }

    /// Finds and reads the scene that is wanted.
    pub fn read(wanted: &RenderOptions) -> Result<Self, SceneError> {
        let scenery = Self::find(wanted)?;
        let misplaced =
            |option, of| Err(SceneError::Misplaced { option, of, named: wanted.scene.to_owned() });
        if wanted.square_mm.is_some() && !matches!(scenery, Self::Chessboard) {
            return misplaced("--square-mm", "the chessboard");
        }
        if wanted.smooth && matches!(scenery, Self::Cylinder) {
            return misplaced("--smooth", "what the camera sees, and views");
        }
        if wanted.unit_mm.is_some() && !matches!(scenery, Self::Model(_)) {
            return misplaced("--unit-mm", "OBJ models");
        }
        Ok(scenery)
    }

    fn find(wanted: &RenderOptions) -> Result<Self, SceneError> {
        let named = wanted.scene;
        match named {
            "grid" => return Ok(Self::Grid),
            "chessboard" => return Ok(Self::Chessboard),
            "views" => return Ok(Self::Views),
            "cylinder" => return Ok(Self::Cylinder),
            _ => {}
        }
        let path = Path::new(named);
        if !path.exists() {
            let likeness = |name: &&&str| strsim::jaro_winkler(named, name);
            let closest = NAMES.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
            let hint = closest
                .filter(|name| likeness(name) > 0.8)
                .map_or(String::new(), |name| format!("; did you mean {name}?"));
            return Err(SceneError::Unknown { named: named.into(), hint });
        }
        let bytes = files::read(path)?;
        let file = || path.display().to_string();
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        if ending.as_deref() == Some("obj") {
            let folder = path.parent().unwrap_or(Path::new(""));
            let beside = |name: &Path| {
                let bytes = files::read_below(folder, name, wanted.allow_outside);
                bytes.map_err(|error| error.to_string())
            };
            let model = Model::read(&bytes, wanted.unit_mm.unwrap_or(1.0), beside);
            let fault = |source| SceneError::Model { file: file(), source };
            return Ok(Self::Model(Box::new(model.map_err(fault)?)));
        }
        let picture = Raster::decode(&bytes)
            .map_err(|source| SceneError::Picture { file: file(), source })?;
        let (width, height) = (picture.width, picture.height);
        let panorama = PanoramaWorld::new(picture).ok_or_else(|| SceneError::Shape {
            file: file(),
            width,
            height,
        })?;
        Ok(Self::Panorama(Box::new(panorama)))
    }
}

/// What the picture's file is called after: a scene's name, or the file's with a hyphen before its
/// ending, so that no file's picture takes the place of another's or of a scene's.
pub fn stem(scene: &str) -> String {
    let name = Path::new(scene).file_name().unwrap_or_default();
    name.to_string_lossy().replace('.', "-")
}
