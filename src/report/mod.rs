//! Results -> bytes: JSON, CSV, HTML, pictures and the terminal's summary. It computes nothing.

mod blur;
mod frame;
mod html;
mod machining;
mod maps;
mod measured;
mod outside;
mod plot;
mod prospect;
mod reason;
mod rendering;
mod replay;
mod sharpness;
mod text;
mod tolerance;
mod tolerance_page;
mod tolerance_plots;
mod unwrapped;

pub use crate::profile::Aperture;
pub use blur::{BlurReport, Focus, Images, Spots};
pub use frame::{FrameReport, Resolution, RoundMirror};
pub use html::html;
pub use machining::{
    AsCutFacts, BestFacts, BudgetFacts, GougeFacts, Machining, ReachFacts, StockFacts,
};
pub use maps::{form_picture, gouge_picture};
pub use measured::{AlignmentFacts, UnitFacts};
pub use outside::visible;
pub(crate) use plot::{Failure, svg};
pub use prospect::{BuildForecast, FileForecast, Foreseen, MeshForecast};
pub use reason::{Reason, ReasonKind};
pub use rendering::Rendering;
pub use replay::{ErrorDrawn, PoseFile, ReplayFile, ReplayReport};
pub use sharpness::{Opened, Sharpness};
pub(crate) use text::{digits, pretty, written};
pub use tolerance::{FacetsFrom, ToleranceReport, read_trial, trial_columns, trial_line};
pub use unwrapped::{MapFacts, PanoramaFacts, PhotoFacts, Unwrapped};

use crate::align::FormError;
use crate::design::{DesignFacts, Mounting};
use crate::mirror::Form;
use crate::num::stats::{Summary, or_null, unless_null};
use crate::profile::AcceptanceLimits;
use crate::solid::SolidCheck;
use crate::trace::FrameFill;
use serde::{Deserialize, Serialize};

/// Version of the report's schema: keys may be added, never changed.
pub const SCHEMA: u32 = 1;

/// Results of a build, in the shape of `report.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BuildReport {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Profile that was built.
    pub profile: ProfileId,
    /// Places of camera and target in the part's frame, and the size of the part; absent from reports
    /// of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layout: Option<Mounting>,
    /// Figures of the design.
    pub design: DesignFacts,
    /// The sphere and the plane nearest to the mirror.
    pub form: Form,
    /// Figures of the mesh; absent where none could be made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshFacts>,
    /// The solid that was made; absent where there is no mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid: Option<SolidFacts>,
    /// The files written.
    pub files: Vec<FileFacts>,
    /// Figures of the witness, for each mesh file that could be read.
    pub trace: Vec<TraceFacts>,
    /// Figures of the sag table that was read back; absent when none was written or it is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sag: Option<SagFacts>,
    /// Error of the STEP file's splines; absent when none was written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<StepFacts>,
    /// The frame as the first mesh file shows it; absent when none could be read.
    pub frame: Option<FrameFill>,
    /// Sharpness of the picture through a lens; absent where no pixel has a spot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sharpness: Option<Sharpness>,
    /// The limits that the picture is held to; absent without a projection.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accepted: Option<AcceptanceLimits>,
    /// Pass or fail.
    pub verdict: Verdict,
    /// Reasons of a fail, each with figures; empty for a pass.
    pub reasons: Vec<Reason>,
    /// Nuisances to come, and what to do about them; no part of the verdict.
    pub warnings: Vec<String>,
}

/// Results of the verification of a file of unknown making, in the shape of `report.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VerifyReport {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Profile that the file is held against.
    pub profile: ProfileId,
    /// Places of camera and target in the part's frame, and the size of the part.
    pub layout: Mounting,
    /// Figures of the design.
    pub design: DesignFacts,
    /// The sphere and the plane nearest to the mirror.
    pub form: Form,
    /// The file: the only one.
    pub files: Vec<FileFacts>,
    /// Figures of the witness; empty where the file could not be read.
    pub trace: Vec<TraceFacts>,
    /// The unit of its coordinates; absent where the file could not be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<UnitFacts>,
    /// Pose that brings a measured part into the part frame; absent when that was not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment: Option<AlignmentFacts>,
    /// Distance of a measured part from its design along its normal, um; positive where there is too
    /// much material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form_error_um: Option<FormError>,
    /// The frame as the file shows it; absent where it could not be read.
    pub frame: Option<FrameFill>,
    /// Sharpness of the picture through a lens; absent where no pixel has a spot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sharpness: Option<Sharpness>,
    /// The limits that the picture is held to; absent without a projection, and of measured parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accepted: Option<AcceptanceLimits>,
    /// Pass or fail.
    pub verdict: Verdict,
    /// Reasons of a fail, each with figures; empty for a pass.
    pub reasons: Vec<Reason>,
    /// Nuisances to come, and what to do about them; no part of the verdict.
    pub warnings: Vec<String>,
}

/// Name and fingerprint of a profile.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProfileId {
    /// Its name.
    pub name: String,
    /// SHA-256 of its text, hexadecimal.
    pub sha256: String,
}

/// Pass or fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The part does what the profile asks.
    Pass,
    /// It does not.
    Fail,
}

/// A limit asked for and the bound proven.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limited {
    /// Asked for; none when the profile sets none.
    pub limit: Option<f64>,
    /// Proven over every facet.
    pub bound: f64,
}

/// Numbers of triangles over the least possible, for the limits that are set; none where the mirror
/// bends in one direction alone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OverOptimum {
    /// Against the chord limit.
    pub chord: Option<f64>,
    /// Against the facet limit.
    pub facet: Option<f64>,
}

/// What the mesh reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeshFacts {
    /// Facets of the optical face.
    pub optical_triangles: usize,
    /// Facets of the solid.
    pub triangles: usize,
    /// Most of them, where the profile sets that in the place of limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_triangles: Option<usize>,
    /// Vertices of the solid.
    pub vertices: usize,
    /// Height between facet and mirror, um.
    pub chord_um: Limited,
    /// Image displacement by flat facets, pixels.
    pub facet_px: Limited,
    /// The part of it that rounding to single precision causes, pixels.
    pub rounding_px: f64,
    /// Triangles over the theoretical least.
    pub over_optimum: OverOptimum,
}

/// The check of a solid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SolidFacts {
    /// What was found.
    #[serde(flatten)]
    pub check: SolidCheck,
    /// Integral of the design, mm^3.
    pub volume_expected_mm3: f64,
    /// What is wrong, facet by facet.
    pub reasons: Vec<String>,
}

impl SolidFacts {
    /// The facts of `check`, beside the volume expected.
    #[must_use]
    pub fn new(check: &SolidCheck, volume_expected_mm3: f64) -> Self {
        Self { check: check.clone(), volume_expected_mm3, reasons: check.reasons() }
    }
}

/// A file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileFacts {
    /// Name in the output folder.
    pub name: String,
    /// Its format's name.
    pub format: String,
    /// Length.
    pub bytes: u64,
    /// SHA-256, hexadecimal.
    pub sha256: String,
}

/// What a sag table holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SagFacts {
    /// Rows of X, Y, Z and normal.
    pub rows: usize,
    /// Largest difference of Z from the design, mm.
    pub height_error_mm: f64,
    /// Largest angle to the design's normal, radians.
    pub normal_error_rad: f64,
}

/// The splines of a STEP file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepFacts {
    /// Largest distance from the design, nm.
    pub fit_error_nm: f64,
    /// Control points of a panel along each axis; one along the second for a surface of revolution.
    pub control_points: [usize; 2],
}

/// What the witness saw in one file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TraceFacts {
    /// Name in the output folder.
    pub file: String,
    /// Camera rays aimed at the mirror.
    pub rays: usize,
    /// Of these, reflected into the world.
    pub hit: usize,
    /// Meeting nothing.
    pub missed: usize,
    /// Reflected against the part itself.
    pub shadowed: usize,
    /// Meeting the back of a facet.
    pub back_face: usize,
    /// Against the projection and the designed mirror, by facet normals.
    #[serde(flatten)]
    pub errors: ErrorFacts,
    /// The same by the file's interpolated normals, where it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interpolated_normals: Option<ErrorFacts>,
    /// The vertex farthest from the designed part's surface.
    pub worst_vertex: Option<VertexFacts>,
    /// The check of the file's mesh.
    pub solid: SolidFacts,
}

/// A vertex and how far it is from where the part has its surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct VertexFacts {
    /// X, Y, Z, mm.
    pub at_mm: [f64; 3],
    /// Distance, mm: along Z from the mirror or the base, or across from the outline.
    pub off_mm: f64,
}

/// Errors over the rays that hit; absent when none did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorFacts {
    /// Angle between the direction seen and the projection's, mrad.
    #[serde(serialize_with = "or_null", deserialize_with = "unless_null")]
    pub ray_error_mrad: Option<Summary>,
    /// The same carried back to the image, pixels.
    #[serde(serialize_with = "or_null", deserialize_with = "unless_null")]
    pub pixel_error_px: Option<Summary>,
    /// Image displacement against the designed mirror, pixels.
    #[serde(serialize_with = "or_null", deserialize_with = "unless_null")]
    pub facet_error_px: Option<Summary>,
}

impl BuildReport {
    /// `report.json`.
    #[must_use]
    pub fn json(&self) -> String {
        text::pretty(self)
    }
}

impl VerifyReport {
    /// `report.json`.
    #[must_use]
    pub fn json(&self) -> String {
        text::pretty(self)
    }
}
