//! Why the stages could not be gone through.

use super::scenery::SceneError;
use super::source::SourceError;
use crate::align::AlignError;
use crate::design::DesignError;
use crate::export::step::FitError;
use crate::machining::MachiningError;
use crate::milling::MillingError;
use crate::part::FaceError;
use crate::profile::{MeshFormat, Profile};
use crate::publish::FileError;
use crate::raster::RasterError;
use crate::solid::SolidError;
use crate::tolerance::TracksError;
use crate::turning::TurningError;
use crate::unwrap::{MapEncodingError, UnwrapError};
use crate::video::VideoError;
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Why something could not be done. (A part that turns out bad is no error: that is a verdict.)
#[derive(Debug, Error)]
pub enum Error {
    /// The observer wanted the run to end.
    #[error("stopped")]
    Stopped,
    /// The design has no answer.
    #[error("cannot design {profile}: {source}")]
    Design {
        /// Profile name.
        profile: String,
        /// Why.
        source: DesignError,
    },
    /// There is no face as the profile asks for it.
    #[error("cannot mesh {profile}: {source}")]
    Mesh {
        /// Profile name.
        profile: String,
        /// Why.
        source: FaceError,
    },
    /// STEP is asked for, and no splines suit the mirror.
    #[error("cannot write {profile} as STEP: {source}")]
    Step {
        /// Profile name.
        profile: String,
        /// Why.
        source: FitError,
    },
    /// A drawing is asked for, and there is no part to draw.
    #[error("cannot draw {profile}: {reason}")]
    Drawing {
        /// Profile name.
        profile: String,
        /// Why.
        reason: String,
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
    /// The mirror cannot be cut so.
    #[error("cannot machine {profile}: {source}")]
    Machining {
        /// Profile name.
        profile: String,
        /// Why.
        source: MachiningError,
    },
    /// The mirror cannot be milled so.
    #[error("cannot program {profile}: {source}")]
    Milling {
        /// Profile name.
        profile: String,
        /// Why.
        source: MillingError,
    },
    /// The mirror cannot be turned so.
    #[error("cannot program {profile}: {source}")]
    Turning {
        /// Profile name.
        profile: String,
        /// Why.
        source: TurningError,
    },
    /// A program that cuts what the mirror is formed on.
    #[error(
        "cannot judge a program for {profile}: its file is a {form}, whose face is not the mirror's; leave part.form out for a \
         program that cuts the mirror itself"
    )]
    FormedProgram {
        /// Profile name.
        profile: String,
        /// Name of the tool.
        form: &'static str,
    },
    /// Symmetry is no shortcut for this mirror: a fault of the program.
    #[error(
        "the reflection of {profile} does not have the mesh that its symmetry gives it; this is a fault \
         of morion: please report it"
    )]
    Uneven {
        /// Profile name.
        profile: String,
    },
    /// The body is not a solid.
    #[error("cannot close {profile} for {format}: {source}")]
    Solid {
        /// Profile name.
        profile: String,
        /// For which format.
        format: MeshFormat,
        /// Why.
        source: SolidError,
    },
    /// The disk refuses.
    #[error(transparent)]
    File(#[from] FileError),
    /// The picture cannot be made.
    #[error("cannot make the picture: {0}")]
    Picture(String),
    /// There is no profile, or no file that it names.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// There is no such scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Pixels are to be judged, but nothing says what they should see.
    #[error(
        "cannot {work} {profile}: it has no projection, so nothing that a pixel should see; give it \
         a [projection] and a [layout]"
    )]
    NoProjection {
        /// What is to be done.
        work: &'static str,
        /// Profile name.
        profile: String,
    },
    /// No pixel sees the mirror.
    #[error(
        "cannot tolerance {profile}: no pixel sees the target in the mirror; `morion frame` tells what they see"
    )]
    Unseen {
        /// Profile name.
        profile: String,
    },
    /// A cutter does not reach from track to track.
    #[error("cannot tolerance {profile}: {source}")]
    Tracks {
        /// Profile name.
        profile: String,
        /// Of which radius, and how far.
        source: TracksError,
    },
    /// A measured form error that is none of this mirror.
    #[error("cannot take tolerance.map_file {file}: {reason}")]
    Map {
        /// The file, as the profile names it.
        file: String,
        /// Why, and what to do about it.
        reason: String,
    },
    /// A trial that cannot be made into a file.
    #[error("cannot replay a trial of {profile}: {reason}")]
    Replay {
        /// Profile name.
        profile: String,
        /// Why, and what to do about it.
        reason: String,
    },
    /// A part of a run that cannot be merged.
    #[error("cannot merge {}: {reason}", path.display())]
    Part {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
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
    #[error("{path}: a file of this format says what its unit is; leave --units out")]
    Declared {
        /// The file.
        path: String,
    },
    /// A list of points without a pose.
    #[error("{path}: a list of points is of a part that was measured; add --align")]
    Points {
        /// The file.
        path: String,
    },
    /// A program without its cutter.
    #[error(
        "{path}: a program does not tell the cutter; give --ball-mm, the radius of the ball whose tip it moves, or --cutter-mm of a flat \
         or bull-nosed cutter, or on a lathe --nose-mm, that of the tool's nose"
    )]
    Ball {
        /// The file.
        path: String,
    },
    /// A probe of a file that holds no points.
    #[error(
        "{path}: only lists of points (.csv, .xyz, .txt, .asc, .ply) are of centres of a ball; leave --probe-mm out"
    )]
    Probe {
        /// The file.
        path: String,
    },
    /// A pose is none.
    #[error("the pose {file}: {reason}")]
    Pose {
        /// Its file.
        file: String,
        /// Why.
        reason: String,
    },
    /// An option has a value that means nothing.
    #[error("{option} must be {must}, found {found}")]
    Option {
        /// The option.
        option: &'static str,
        /// What it must be.
        must: String,
        /// What it is.
        found: String,
    },
    /// A STEP file of a forming tool is to be verified.
    #[error(
        "{path}: what is formed on a {form} is traced at facets alone; verify a mesh of it, or, with --align, what was formed"
    )]
    ToolStep {
        /// The file.
        path: String,
        /// The tool.
        form: &'static str,
    },
    /// A file to be verified is of no known format.
    #[error(
        "{path}: the name must end in .step, .stp, .csv, .xyz, .txt, .asc, .ply, {}",
        MeshFormat::endings()
    )]
    Format {
        /// The file.
        path: String,
    },
}

impl Error {
    /// That there is no face as `profile` asks for it.
    pub(super) fn face(profile: &Profile, error: FaceError) -> Self {
        Self::Mesh { profile: profile.name.clone(), source: error }
    }

    /// That the cutter of `profile` does not reach from track to track.
    pub(super) fn tracks(profile: &Profile, source: TracksError) -> Self {
        Self::Tracks { profile: profile.name.clone(), source }
    }
}

/// Why a photo cannot be unwrapped.
#[derive(Debug, Error)]
pub enum PhotoError {
    /// It is no picture.
    #[error("{photo}: {source}")]
    Picture {
        /// The file.
        photo: String,
        /// Why not.
        source: RasterError,
    },
    /// The profile says nothing about directions.
    #[error(
        "{profile} has no [projection], and without one there is no telling what its picture should \
         show; add the projection that the mirror was made for"
    )]
    NoProjection {
        /// Profile name.
        profile: String,
    },
    /// Photo and profile do not go together.
    #[error("cannot unwrap {photo}: {source}")]
    Unfit {
        /// The file.
        photo: String,
        /// Why.
        source: UnwrapError,
    },
    /// There is nothing in the picture that is asked for.
    #[error("{photo} shows nothing of {what}; {remedy}")]
    Unseen {
        /// The file.
        photo: String,
        /// The picture.
        what: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// A folder has no pictures.
    #[error(
        "{folder}: there is no PNG, JPEG or EXR in this folder; convert its pictures to PNG, or name another folder"
    )]
    NoPictures {
        /// The folder.
        folder: String,
    },
    /// Two pictures of a folder would be unwrapped to one file.
    #[error("{folder}: {} and {} would both become {name}; rename one of them", files[0], files[1])]
    SameName {
        /// The folder.
        folder: String,
        /// The file.
        name: String,
        /// The pictures.
        files: [String; 2],
    },
    /// A picture of a folder has not the size of the first one.
    #[error(
        "{photo} has {} x {} pixels, and the folder's first picture has {} x {}; move it to a folder of its own, or scale it to this size",
        pixels[0], pixels[1], first[0], first[1]
    )]
    OtherSize {
        /// The picture.
        photo: String,
        /// Its pixels, across and down.
        pixels: [usize; 2],
        /// Those of the first one.
        first: [usize; 2],
    },
    /// A stream of frames cannot be read.
    #[error("{input}: {source}")]
    Stream {
        /// Name of the stream.
        input: &'static str,
        /// Why not.
        source: VideoError,
    },
    /// Frames cannot be written.
    #[error("cannot write to standard output: {0}")]
    Output(#[source] io::Error),
    /// The map cannot be encoded.
    #[error(transparent)]
    Table(#[from] MapEncodingError),
}
