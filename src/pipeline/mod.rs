//! Stage order, files, progress: the one place where everything meets.
//!
//! A build designs, meshes, closes, writes, and then starts again from the bytes on the disk: what
//! was written is read, checked and traced like a stranger's file, and only then published under
//! its own name, with the report beside it.

mod as_cut;
mod blur;
mod build;
mod build_cache;
mod cad_export;
mod cad_exports;
mod check;
mod check_file;
mod drawing;
mod drawing_export;
mod dry_run;
mod error;
mod file_units;
mod floor_plan;
mod form_study;
mod frame;
mod in_memory_build;
mod inspect;
mod lathe_shop;
mod machining;
mod made_face;
mod mesh_files;
mod mill_program;
mod mounted_camera;
mod mounted_system;
mod observer;
mod obstacles;
mod page_figures;
mod part_drawing;
mod pose;
mod program;
mod program_forecast;
mod program_travel;
mod render;
mod replay;
mod run;
mod sag_export;
mod scenery;
mod servo_program;
mod source;
mod stages;
mod step_export;
mod table;
mod table_files;
mod table_sight;
mod told_error;
mod tolerance;
mod tolerance_spec;
mod turn_program;
mod unwrap;
mod unwrap_facts;
mod unwrap_folder;
mod unwrap_map;
mod unwrap_picture;
mod unwrap_stream;
mod verify;
mod verify_options;
mod verify_points;
mod verify_program;

pub use crate::align::LengthUnit;
pub use crate::publish::{FileError, OutputFile, abandon, journal_under_way};
pub use crate::unwrap::ViewAngles;
pub use crate::verdict::MachiningOptions;
pub use blur::BlurOptions;
pub use build::{BuildOptions, Effort, build};
pub use build_cache::{BuildTimings, Output};
pub use check::check;
pub use drawing::DrawingOptions;
pub use dry_run::dry_run;
pub use error::{Error, PhotoError};
pub use frame::FrameOptions;
pub use inspect::InspectOptions;
pub use mounted_camera::MountedCamera;
pub use observer::{Observer, Silent, Stage, Timings, Work};
pub use program::ProgramOptions;
pub use replay::ReplayOptions;
pub use run::Command;
pub use scenery::{RenderOptions, SceneError};
pub use source::{ProfileText, SourceError, load};
pub use table::TableOptions;
pub use told_error::all_errors;
pub use tolerance::{ToleranceOptions, TrialsFile, TrialsPart, merge};
pub use unwrap::{MapFormat, Unwrap, UnwrapOptions};
pub use unwrap_folder::UnwrapFolder;
pub use unwrap_picture::{Rows, UnwrapPicture};
pub use unwrap_stream::{RawFormat, RawFrames, UnwrapStream};
pub use verify::{Verify, verify};
pub use verify_options::VerifyOptions;

/// What benchmark and sweep run, stage by stage.
pub(crate) use {
    build_cache::inputs,
    in_memory_build::build_in_memory,
    mesh_files::meshed,
    observer::StageTimer,
    program_forecast::ProgramForecast,
    run::{Run, designed, designed_alone, designed_unmeasured},
    tolerance_spec::{PreparedStudy, prepared},
};

/// What the studio shows of a mirror.
#[cfg(feature = "studio")]
pub(crate) use {
    mesh_files::label as mesh_label,
    page_figures::{coarse_part, drawn_spots, glb, shadowed, sharpness_map, still},
};
