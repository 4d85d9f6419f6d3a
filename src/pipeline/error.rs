//! Why the stages could not be gone through.

use super::files::FileError;
use super::scenery::SceneError;
use super::unwrap::PhotoError;
use crate::align::AlignError;
use crate::design::DesignError;
use crate::export::step::FitError;
use crate::mesh::MeshError;
use crate::profile::Format;
use crate::solid::SolidError;
use thiserror::Error;

/// Why something could not be done. (A part that turns out bad is no error: that is a verdict.)
#[derive(Debug, Error)]
pub enum Error {
    /// The design has no answer.
    #[error("cannot design {profile}: {source}")]
    Design {
        /// Profile name.
        profile: String,
        /// Why.
        source: DesignError,
    },
    /// No mesh keeps the limits.
    #[error("cannot mesh {profile}: {source}")]
    Mesh {
        /// Profile name.
        profile: String,
        /// Why.
        source: MeshError,
    },
    /// No mesh file but in single precision is asked for, and that cannot carry the limits.
    #[error("cannot mesh {profile}: {reason}")]
    Single {
        /// Profile name.
        profile: String,
        /// Where, and what it carries.
        reason: String,
    },
    /// STEP is asked for, and no splines suit the mirror.
    #[error("cannot write {profile} as STEP: {source}")]
    Step {
        /// Profile name.
        profile: String,
        /// Why.
        source: FitError,
    },
    /// A sag table of too many places.
    #[error(
        "cannot write the sag table of {profile}: it would sample {points:.1e} places, over {most:.0e}; \
         raise export.sag.pitch_mm or step_mm"
    )]
    Table {
        /// Profile name.
        profile: String,
        /// Places along its path.
        points: f64,
        /// Most that there may be.
        most: f64,
    },
    /// The body is not a solid.
    #[error("cannot close {profile} for {format}: {source}")]
    Solid {
        /// Profile name.
        profile: String,
        /// For which format.
        format: Format,
        /// Why.
        source: SolidError,
    },
    /// The disk refuses.
    #[error(transparent)]
    File(#[from] FileError),
    /// The picture cannot be made.
    #[error("cannot make the picture: {0}")]
    Picture(String),
    /// There is no such scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A frame is to be filled, but with nothing in particular.
    #[error(
        "cannot check the frame of {profile}: it has no projection, so nothing that a pixel should \
         see; give it a [projection] and a [layout]"
    )]
    NoProjection {
        /// Profile name.
        profile: String,
    },
    /// A lens that the camera cannot have, or nothing to see through it.
    #[error("cannot work out the blur of {profile}: {reason}")]
    Lens {
        /// Profile name.
        profile: String,
        /// Why, and what to do about it.
        reason: &'static str,
    },
    /// A mesh cannot be written in memory, or not be read from there.
    #[error("cannot write and read back the mesh of {profile}: {reason}")]
    Reread {
        /// Profile name.
        profile: String,
        /// Why.
        reason: String,
    },
    /// The benchmark cannot run or be drawn.
    #[error("cannot benchmark: {0}")]
    Bench(String),
    /// A photo cannot be unwrapped.
    #[error(transparent)]
    Photo(#[from] PhotoError),
    /// A file to be verified does not let itself be aligned.
    #[error("cannot align {path}: {source}")]
    Align {
        /// The file.
        path: String,
        /// Why.
        source: AlignError,
    },
    /// A file that names its own unit is given another.
    #[error("{path}: a 3MF says what its unit is; leave --units out")]
    Declared {
        /// The file.
        path: String,
    },
    /// A file to be verified is of no known format.
    #[error("{path}: the name must end in .stl, .obj or .3mf")]
    Format {
        /// The file.
        path: String,
    },
}
