//! What a build and a verification found, in the shape of `report.json`.

use super::Reason;
use super::SharpnessFacts;
use super::{AlignmentFacts, UnitFacts};
use super::{
    CavityFacts, DrawingFacts, FileFacts, HoleFacts, MeasuredForm, MeshFacts, ProfileId,
    ProgramFacts, SagFacts, SolidFacts, StepFacts, ToolFacts, TraceFacts, Verdict,
};
use crate::align::FormError;
use crate::design::{DesignFacts, Mounting};
use crate::mirror::Form;
use crate::profile::AcceptanceLimits;
use crate::render::UnwantedViews;
use crate::trace::FrameFill;
use serde::{Deserialize, Serialize};

/// Results of a build, in the shape of `report.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BuildReport {
    /// Version of these keys.
    pub schema: u32,
    /// Profile that was built.
    pub profile: ProfileId,
    /// Places of camera and target in the part's frame, and the size of the part; absent from reports
    /// of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layout: Option<Mounting>,
    /// Figures of the design.
    pub design: DesignFacts,
    /// What the designed mirror shows that nobody asks for; absent without a projection.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unwanted: Option<UnwantedViews>,
    /// The sphere and the plane nearest to the mirror.
    pub form: Form,
    /// Figures of the mesh; absent where none could be made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshFacts>,
    /// The solid that was made; absent where there is no mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid: Option<SolidFacts>,
    /// The forming tool that is made in the part's place; absent of the part itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<ToolFacts>,
    /// The cavity of a hollow part; absent of a solid one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cavity: Option<CavityFacts>,
    /// Holes of the part, or of the tool; absent where it has none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holes: Vec<HoleFacts>,
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
    /// Every figure of the drawing; absent when none was written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawing: Option<DrawingFacts>,
    /// The frame as the first mesh file shows it; absent when none could be read.
    pub frame: Option<FrameFill>,
    /// Sharpness of the picture through a lens; absent where no pixel has a spot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sharpness: Option<SharpnessFacts>,
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
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct VerifyReport {
    /// Version of these keys.
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
    /// What a list of points says of the form; absent of meshes and solids.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured_form: Option<MeasuredForm>,
    /// What a program cuts; absent of other files, and where it could not be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub program: Option<ProgramFacts>,
    /// The frame as the file shows it; absent where it could not be read.
    pub frame: Option<FrameFill>,
    /// Sharpness of the picture through a lens; absent where no pixel has a spot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sharpness: Option<SharpnessFacts>,
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
