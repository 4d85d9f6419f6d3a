//! Profiles: TOML texts that say what is wanted of a mirror, read and checked.
//!
//! A [`Profile`] that exists is a valid one: every number is finite and within its limits, and
//! camera, projection, layout and part fit each other. [`Profile::parse`] either returns one or returns all the
//! [`Complaints`] at once, each with its place in the file.

mod accept;
mod border;
mod calibration;
mod check;
mod complaint;
mod drawing;
mod edit;
mod format;
mod forming;
mod hole;
mod lines;
mod mesh_goal;
mod obstacle;
mod profile_file;
mod program;
mod program_words;
mod projection;
mod reader;
mod sag;
mod schema;
mod servo;
mod shape;
mod shell;
mod shipped;
mod source;
mod sweep;
pub mod tolerance;
mod turning;
mod values;
mod vector_map;
mod words;

use crate::geom::{ScanPattern, TriMesh};
use crate::optics::{CameraModel, Mount};
use serde::{Deserialize, Serialize};

pub use accept::{AcceptanceLimit, AcceptanceLimits, AcceptanceSpec};
pub use border::{BorderConflict, BorderFeature, BorderSpec, is_in_land};
pub use calibration::{CalibrationError, CalibrationFile, CoefficientFault, LensModel};
pub use complaint::{Complaint, Complaints};
pub use drawing::{DrawingSpec, PaperSize, TitleBlock, ViewArrangement};
pub use edit::KeyStep;
pub(crate) use edit::put;
#[cfg(feature = "studio")]
pub(crate) use edit::set_value;
pub use format::{CadFormat, DrawingFormat, FileFormat, MeshFormat, StepProtocol};
pub use forming::{FormingSpec, MirrorSide, ToolForm, Vents};
pub use hole::{HoleSpec, under_rim};
pub use mesh_goal::MeshGoal;
pub use obstacle::{CameraBody, ObstacleSpec};
pub use profile_file::{ProfileFile, hex, sha256};
pub use program::{
    CutterLengths, FinishingSpec, MachineSpec, MillSpec, ProgramSpec, RoughingSpec, SpeedsSpec,
};
pub use program_words::{FinishingPath, MillControl, ProgramControl, StockMaterial, WorkOffset};
pub use projection::{
    AzimuthalSpec, MapSpec, PanelSpec, PanelViewSpec, ProjectionSpec, RadialLawSpec, RadialSpec,
    StripLawSpec, StripSpec,
};
pub use sag::{GridError, SagGrid};
#[cfg(feature = "studio")]
pub(crate) use schema::{LISTS, TABLES};
pub use servo::{ServoControl, ServoSpec};
pub use shape::{Conic, Method, MethodKind, Monomial, Polynomial, ShapeSpec};
pub use shell::ShellSpec;
pub use shipped::{Shipped, shipped};
#[cfg(feature = "studio")]
pub(crate) use source::text as text_of_profile;
pub use sweep::{
    AxisSpec, CheckColumn, ColumnGoal, ColumnSpec, FindText, MOST_POINTS, StudyContext,
    SweepCommand, SweepSpec,
};
pub use tolerance::Tolerance;
pub use turning::{LatheControl, LatheSpec, NoseSpec, TurnSpec, TurnedFinishSpec, TurnedRoughSpec};
pub use vector_map::{VectorMap, VectorMapError};

/// What has the bytes of a file that a profile names, if they are not more than so many, or why they cannot be had.
pub type ReadFile<'f> = dyn Fn(&str, u64) -> Result<Vec<u8>, String> + 'f;

/// What has the triangles of an STL or OBJ that a profile names, or why they cannot be had.
pub type ReadMesh<'f> = dyn Fn(&str) -> Result<TriMesh, String> + 'f;

/// What has the files that a profile names.
#[derive(Clone, Copy)]
pub struct NamedFiles<'f> {
    /// Bytes of calibrations and maps.
    pub bytes: &'f ReadFile<'f>,
    /// Triangles of obstacles (mm) and of a target.
    pub mesh: &'f ReadMesh<'f>,
}

impl NamedFiles<'_> {
    /// No files: each is refused by its name.
    pub const NONE: NamedFiles<'static> =
        NamedFiles { bytes: &|named, _| Err(no_file(named)), mesh: &|named| Err(no_file(named)) };
}

fn no_file(named: &str) -> String {
    format!("{named}: such a file is read for a profile that is a file itself")
}

/// A checked profile: camera, projection, layout, shape, part, mesh, files and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// The name that output goes under, usually the file's name without `.toml`.
    pub name: String,
    /// SHA-256 of the profile's bytes, in lower-case hexadecimal.
    pub sha256: String,
    /// The files that it names, in the order in which they were read: calibration, directions, meshes, heights. A tolerance's map of form
    /// errors, which is read where it is asked for, is not among them.
    pub files: Vec<ProfileFile>,
    /// The name by which it was loaded: the files that it names lie beside that.
    pub named: String,
    /// Purpose of the mirror in the author's words; empty if not given.
    pub summary: String,
    /// The camera that looks into the mirror: each side of its frame has 1 to 32767 pixels; a pinhole's
    /// distance is that to the mirror's mean height, for a disc or an annulus to its outer rim.
    pub camera: CameraModel,
    /// Where it stands over the part: on the axis but for a rectangle.
    pub mount: Mount,
    /// The calibration file that the camera comes from, if it comes from one.
    pub camera_file: Option<String>,
    /// Its lens.
    pub lens: LensSpec,
    /// Its body, if it may be in the way; never of a telecentric camera.
    pub camera_body: Option<CameraBody>,
    /// What else may stand in the way of rays, in the profile's order.
    pub obstacles: Vec<ObstacleSpec>,
    /// Part of the world that the picture must show, and its layout in the picture. A designed mirror
    /// always has one; without one a given mirror has no pixel error to limit.
    pub projection: Option<ProjectionSpec>,
    /// The mirror's outline. It fits the projection: a strip or a conquistador with a strip's law,
    /// a disc or an annulus with a radial law; without a projection any but those two.
    pub layout: Layout,
    /// Source of the mirror's shape.
    pub shape: ShapeSpec,
    /// Heights of a mirror that is given as a grid, once its file is read.
    pub heights: Option<SagGrid>,
    /// The size of the solid.
    pub part: PartSpec,
    /// How closely facets must follow the mirror.
    pub mesh: MeshGoal,
    /// The files to write, without repetition, in the profile's order; at least one.
    pub formats: Vec<FileFormat>,
    /// Sampling of the sag table.
    pub sag: SagTable,
    /// Schema of the STEP file.
    pub step: StepProtocol,
    /// What a drawing says beside its figures.
    pub drawing: DrawingSpec,
    /// How the mirror is milled or turned.
    pub program: ProgramSpec,
    /// The limits a finished mirror must keep to pass.
    pub accept: AcceptanceSpec,
    /// The errors of making and mounting that are expected.
    pub tolerance: Tolerance,
    /// The measured form error that `tolerance` names, where it is in memory; otherwise its file is read when
    /// it is asked for.
    pub form_map: Option<SagGrid>,
}

/// Lens of the camera: its aperture, focal length and light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensSpec {
    /// Its aperture, if that is known.
    pub aperture: Option<Aperture>,
    /// Focal length, mm, where the profile has it: an f-number is that over the entrance pupil.
    pub focal_mm: Option<f64>,
    /// Wavelength, nm.
    pub wavelength_nm: f64,
}

impl LensSpec {
    /// Green, where eyes and most sensors see best.
    pub const USUAL_NM: f64 = 550.0;
}

/// Aperture of a lens.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Aperture {
    /// The diameter of a pinhole camera's entrance pupil.
    Pupil {
        /// Diameter, mm.
        pupil_mm: f64,
    },
    /// The numerical aperture of a telecentric lens on the mirror's side.
    Na {
        /// Sine of the half angle of the cone about a chief ray.
        na: f64,
    },
}

/// The mirror's outline, and how its panels tile the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layout {
    /// One panel, the whole panorama in one strip.
    Strip {
        /// Change the elevation range so that the mirror fills the camera's frame exactly.
        fill_frame: bool,
    },
    /// Two panels that share a ridge, each with half of a full turn. Never of a given mirror.
    Conquistador {
        /// Source of the panel's shape.
        panel: PanelSource,
        /// Side to which the ridge between the panels faces.
        ridge: Ridge,
        /// Change the elevation range so that the mirror fills the camera's frame exactly.
        fill_frame: bool,
    },
    /// Round, about the axis; the part's width is its diameter.
    Disc,
    /// A disc with a flat land in the middle.
    Annulus {
        /// Diameter of the land in millimetres, less than 0.99 of the part's width.
        inner_width_mm: f64,
    },
    /// A rectangle about the axis: a perspective or fisheye view, or a given mirror without a projection.
    Rectangle {
        /// Height of the mirror across the part's width, in millimetres: without one the mirror has the shape in
        /// which the frame sees the part. A given mirror without a projection has one.
        height_mm: Option<f64>,
    },
}

/// Source of the shape of a conquistador's panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelSource {
    /// Cut out of the mirror for the full turn.
    Section,
    /// Solved on the half turn alone, which leaves a smaller error.
    Refit,
}

/// Side to which the ridge between a conquistador's panels faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ridge {
    /// Standing out of the part, where a cutter reaches and no panel shadows the other.
    Crest,
    /// Sunk into the part.
    Valley,
}

/// The size of the solid.
#[derive(Clone, Debug, PartialEq)]
pub struct PartSpec {
    /// Width of the mirror across the picture, in millimetres; of a round one its diameter.
    pub width_mm: f64,
    /// Material under the mirror's lowest point, in millimetres.
    pub base_mm: f64,
    /// A flat rim around the mirror.
    pub border: Option<BorderSpec>,
    /// Holes with a table of their own, in the profile's order.
    pub holes: Vec<HoleSpec>,
    /// The tool that is made in the part's place; none for the part itself.
    pub forming: Option<FormingSpec>,
    /// The cavity of a hollow part.
    pub shell: Option<ShellSpec>,
}

/// Sampling of the mirror by the sag table; without a pitch or a step that one is 1/200 of the part's
/// width.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SagTable {
    /// Along which lines.
    pub path: ScanPattern,
    /// From line to line or turn to turn, in millimetres.
    pub pitch_mm: Option<f64>,
    /// From point to point along them, in millimetres.
    pub step_mm: Option<f64>,
}

impl Profile {
    /// Reads and checks a profile that names no file.
    ///
    /// `name` is what output goes under and `file` what complaints call the file. On failure every
    /// complaint that can be made is made, in the order of the file.
    ///
    /// # Errors
    /// [`Complaints`], each with its place and a hint.
    pub fn parse(name: &str, file: &str, bytes: &[u8]) -> Result<Profile, Complaints> {
        Self::parse_with(name, file, bytes, NamedFiles::NONE)
    }

    /// Whether the mirror is without walls between panels: beside a wall a ball cutter leaves material that is not
    /// foreseen.
    #[must_use]
    pub fn is_one_surface(&self) -> bool {
        !matches!(self.projection, Some(ProjectionSpec::Panels(_)))
    }

    /// Reads and checks a profile as [`Self::parse`] does; `files` has the calibration, the map and the
    /// meshes that it may name, or why there are none.
    ///
    /// # Errors
    /// [`Complaints`], each with its place and a hint.
    pub fn parse_with(
        name: &str,
        file: &str,
        bytes: &[u8],
        files: NamedFiles,
    ) -> Result<Profile, Complaints> {
        let text = source::text(file, bytes)?;
        let (tree, errors) = toml::de::DeTable::parse_recoverable(text);
        let mut reader = reader::ProfileReader::new(file, text, files);
        for error in &errors {
            reader.broken(error);
        }
        let mended = reader.mended();
        let tree = match &mended {
            Some(text) => toml::de::DeTable::parse_recoverable(text).0,
            None => tree,
        };
        check::profile(&mut reader, tree.get_ref(), name, bytes)
            .ok_or_else(|| reader.into_complaints())
    }
}
