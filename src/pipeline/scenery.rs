//! Scenes by name or file.

use crate::publish::{self, FileError};
use crate::raster::{Raster, RasterError};
use crate::render::{Model, ModelError, PanoramaWorld};
use std::path::Path;
use thiserror::Error;

/// How a scene is rendered: writes `render-SCENE.png` into NAME.
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

impl Default for RenderOptions<'_> {
    /// The test world.
    fn default() -> Self {
        let (square_mm, unit_mm) = (None, None);
        Self { scene: "grid", smooth: false, square_mm, unit_mm, allow_outside: false }
    }
}

/// Why there is no scene.
#[derive(Debug, Error)]
pub enum SceneError {
    /// Neither a scene nor a file.
    #[error(
        "{named}: no such file, and no scene of that name; the scenes are grid, chessboard, errors, \
         views and cylinder, and files may be PNG, JPEG, EXR or OBJ{hint}"
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

/// A scene by its name, not read yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SceneName {
    /// The test world far away.
    Grid,
    /// The chessboard around the mirror.
    Chessboard,
    /// How far the picture is off the projection.
    Errors,
    /// The part itself.
    Part(PartScene),
    /// A file with triangles around the mirror.
    Model,
    /// A file with a picture far away.
    Panorama,
}

/// A picture of the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PartScene {
    /// From several sides.
    Views,
    /// The image, the part and the cylinder around it.
    Cylinder,
}

/// A scene, ready to be seen.
pub(super) enum Scenery {
    /// In the mirror.
    World(WorldScene),
    /// How far the picture is off the projection.
    Errors,
    /// The part itself.
    Part(PartScene),
}

/// A world that is seen in the mirror.
pub(super) enum WorldScene {
    /// The test world far away.
    Grid,
    /// The chessboard around the mirror.
    Chessboard,
    /// A picture far away.
    Panorama(Box<PanoramaWorld>),
    /// Triangles around the mirror.
    Model(Box<Model>),
}

const NAMES: [(&str, SceneName); 5] = [
    ("grid", SceneName::Grid),
    ("chessboard", SceneName::Chessboard),
    ("errors", SceneName::Errors),
    ("views", SceneName::Part(PartScene::Views)),
    ("cylinder", SceneName::Part(PartScene::Cylinder)),
];

impl SceneName {
    /// The scene that is asked for, if there is one to which the options belong.
    ///
    /// # Errors
    /// [`SceneError::Unknown`] and [`SceneError::Misplaced`].
    pub(super) fn of(options: &RenderOptions) -> Result<Self, SceneError> {
        let scene = Self::find(options.scene)?;
        let misplaced =
            |option, of| Err(SceneError::Misplaced { option, of, named: options.scene.to_owned() });
        if options.square_mm.is_some() && scene != Self::Chessboard {
            return misplaced("--square-mm", "the chessboard");
        }
        if options.smooth && scene == Self::Part(PartScene::Cylinder) {
            return misplaced("--smooth", "what the camera sees, and views");
        }
        if options.unit_mm.is_some() && scene != Self::Model {
            return misplaced("--unit-mm", "OBJ models");
        }
        Ok(scene)
    }

    fn find(named: &str) -> Result<Self, SceneError> {
        if let Some((_, scene)) = NAMES.iter().find(|(name, _)| *name == named) {
            return Ok(*scene);
        }
        let path = Path::new(named);
        if !path.exists() {
            let likeness = |name: &str| strsim::jaro_winkler(named, name);
            let closest = NAMES
                .iter()
                .map(|(name, _)| *name)
                .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
            let hint = closest
                .filter(|name| likeness(name) > 0.8)
                .map_or(String::new(), |name| format!("; did you mean {name}?"));
            return Err(SceneError::Unknown { named: named.into(), hint });
        }
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        Ok(if ending.as_deref() == Some("obj") { Self::Model } else { Self::Panorama })
    }
}

impl Scenery {
    /// Finds and reads the scene that is asked for.
    ///
    /// # Errors
    /// [`SceneError`] when there is none, or its file cannot be read.
    pub(super) fn read(options: &RenderOptions) -> Result<Self, SceneError> {
        let world = match SceneName::of(options)? {
            SceneName::Part(scene) => return Ok(Self::Part(scene)),
            SceneName::Errors => return Ok(Self::Errors),
            SceneName::Grid => WorldScene::Grid,
            SceneName::Chessboard => WorldScene::Chessboard,
            SceneName::Model => WorldScene::Model(Box::new(model(options)?)),
            SceneName::Panorama => WorldScene::Panorama(Box::new(panorama(options.scene)?)),
        };
        Ok(Self::World(world))
    }
}

fn model(options: &RenderOptions) -> Result<Model, SceneError> {
    let path = Path::new(options.scene);
    let bytes = publish::read(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let beside = |name: &Path| {
        let bytes = publish::read_below(folder, name, options.allow_outside);
        bytes.map_err(|error| error.to_string())
    };
    Model::read(&bytes, options.unit_mm.unwrap_or(1.0), beside)
        .map_err(|source| SceneError::Model { file: path.display().to_string(), source })
}

fn panorama(named: &str) -> Result<PanoramaWorld, SceneError> {
    let path = Path::new(named);
    let file = || path.display().to_string();
    let picture = Raster::decode(&publish::read(path)?)
        .map_err(|source| SceneError::Picture { file: file(), source })?;
    let (width, height) = (picture.width, picture.height);
    PanoramaWorld::new(picture).ok_or_else(|| SceneError::Shape { file: file(), width, height })
}

/// What the picture's file is called after: a scene's name, or the file's with a hyphen before its
/// ending, so that no file's picture takes the place of another's or of a scene's.
pub(super) fn stem(scene: &str) -> String {
    let name = Path::new(scene).file_name().unwrap_or_default();
    name.to_string_lossy().replace('.', "-")
}
