//! Morion designs freeform catadioptric mirrors, meshes them, writes solids that a machine shop can cut, reads
//! the written file back and proves by ray tracing that it still does its job.
//!
//! A camera looks at a curved mirror, and the mirror's shape decides what the picture shows. A [`Profile`], a
//! text file, names camera, picture and size; everything else follows from it.
//!
//! # A part by one call
//!
//! [`build`] does it all, into a folder, and says *pass* or *fail* with reasons; its siblings are [`verify`] (a
//! mesh file of any making), [`frame`] (how well the sensor is filled), [`blur`], [`render`] (what the camera
//! sees), [`unwrap`] (a photo to a panorama), [`tolerance`] and [`replay`] (errors of making and mounting),
//! [`machining`] (a ball cutter), [`program`] (programs that mill or turn it), [`inspect`] (a measuring machine), [`drawing`] (the sheet that a shop signs), [`sweep`](sweep()) (a trade study) and
//! [`forecast`].
//!
//! ```
//! # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
//! # let out = tempfile::tempdir()?;
//! // let profile = morion::Profile::load("conquistador")?;
//! let report = morion::build(&profile, &out)?;
//! for reason in &report.reasons {
//!     println!("{reason}");
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Stage by stage, in memory
//!
//! **Design** is the smooth mirror, **face** the triangles that reflect, with bounds proven over each of them,
//! **solid** the closed part: there is no way to make one that is open.
//!
//! ```
//! use morion::{MeshFormat, Profile};
//! # let profile = Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
//! let design = profile.design()?;
//! let face = design.mesh()?;
//! let solid = face.close(&design)?;
//! let mut stl = Vec::new();
//! solid.write(MeshFormat::Stl, &design.label(&face), &mut stl)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Options, progress, and files in memory
//!
//! Every command is a struct of options with usual values, and a [`Command`]. It runs with an [`Observer`] of its
//! stages, into a folder that changes only when all of its files are made and checked, or into memory.
//!
//! ```
//! use morion::{Command, FrameOptions, Silent};
//! # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
//! let (report, files) = FrameOptions { min: Some(0.2) }.in_memory(&profile, &Silent)?;
//! assert!(files.iter().any(|file| file.name == "frame.json"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Frames and units
//!
//! The part frame has X to the right in the picture, Y up in it and Z towards the camera; lengths
//! are millimetres and angles radians unless a name says otherwise.
//!
//! # What is not promised
//!
//! Bounds and checks are about the file's triangles and the designed surface. Nothing is said about what a
//! machine makes of the file, but for the geometry of an ideal ball ([`machining()`]). The words are explained in
//! `docs/glossary.md`, the modules in `docs/architecture.md`, the mathematics in `docs/theory.md`.

#![cfg_attr(not(test), deny(unreachable_pub))]

mod align;
mod bench;
mod brep;
#[cfg(feature = "cli")]
mod cli;
mod design;
mod drawing;
mod export;
mod forming;
mod front;
mod geom;
mod inspection;
#[doc(hidden)]
pub mod internals;
mod lookup;
mod machining;
mod mesh;
mod milling;
mod mirror;
mod num;
mod optics;
mod packed_text;
mod parallel;
mod part;
mod pencil;
mod pipeline;
mod profile;
mod program;
mod publish;
mod raster;
mod render;
mod report;
mod results;
mod sheet;
mod solid;
#[cfg(feature = "studio")]
mod studio;
mod sweep;
mod tolerance;
mod tolerance_terms;
mod trace;
mod turning;
mod unwrap;
mod verdict;
mod video;

pub use design::{Design, DesignError, MirrorPoint};
pub use export::Label;
pub use front::{
    blur, build, drawing, forecast, frame, inspect, machining, program, render, replay, sweep,
    table, tolerance, unwrap, verify,
};
pub use mesh::{Face, MeshError};
pub use pipeline::{
    BlurOptions, BuildOptions, Command, DrawingOptions, Effort, Error, FrameOptions,
    InspectOptions, MachiningOptions, MapFormat, MountedCamera, Observer, OutputFile,
    ProgramOptions, RenderOptions, ReplayOptions, Rows, Silent, SourceError, Stage, TableOptions,
    ToleranceOptions, Unwrap, UnwrapOptions, UnwrapPicture, Verify, VerifyOptions, ViewAngles,
};
pub use profile::{Complaints, MeshFormat, Profile, Shipped, shipped};
pub use report::{Answer, TextLayout};
pub use results::{
    BlurReport, BuildForecast, BuildReport, DrawingFacts, DrawingReport, FrameReport,
    InspectionReport, MachiningReport, ProgramReport, Reason, ReasonSubject, RenderReport,
    ReplayReport, SweepReport, TableReport, ToleranceReport, UnwrapReport, Verdict, VerifyReport,
};
pub use solid::{Solid, SolidError};
pub use unwrap::RemapTable;

/// The README's examples, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
