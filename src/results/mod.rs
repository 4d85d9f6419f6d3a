//! Results of commands as plain data, whose fields are the keys of their JSON. Verdicts are found in them, and
//! reports say them in words.

mod answers;
mod blur;
mod build;
mod build_forecast;
mod cavity;
mod drawing;
mod facts;
mod faults;
mod frame;
mod holes;
mod inspection;
mod machining;
mod measured;
mod milling;
mod program;
mod reason;
mod render;
mod replay;
mod sharpness;
mod study_faults;
mod sweep;
mod table;
mod tolerance;
mod tool;
mod unwrap;
mod wording;

pub use crate::profile::Aperture;
pub use answers::{
    ErrorLine, LesserErrorFacts, NamedOutput, PartTrials, ProfileCheck, ShippedProfile, ToldError,
};
pub use blur::{BlurReport, FocusPlane, SpotFacts, VirtualImages};
pub use build::{BuildReport, VerifyReport};
pub use build_forecast::{BuildForecast, FileForecast, ForecastLimit, MeshForecast};
pub use cavity::{CavityFacts, DrainFacts};
pub use drawing::{DrawingFacts, DrawingReport, DrawnFeature};
pub use facts::{
    ErrorFacts, FileFacts, Limited, MeshFacts, OverOptimum, PmiFacts, ProfileId, SCHEMA, SagFacts,
    SolidFacts, StepBodyFacts, StepFacts, TraceFacts, Verdict, VertexFacts,
};
pub use faults::{
    FileFault, LeastFilled, PictureFault, PixelErrorFigure, RayFault, Refusal, RefusalCause,
    ShapeFault,
};
pub use frame::{FrameReport, PixelSolidAngle, RoundMirror};
pub use holes::HoleFacts;
pub use inspection::{FormTermFacts, InspectionReport, MeasuredForm};
pub use machining::{
    AsCutFacts, BestFacts, BudgetFacts, GougeFacts, MachiningReport, ReachFacts, StockFacts,
};
pub use measured::{AlignmentFacts, UnitFacts};
pub use milling::{LeftFacts, LengthFacts, OperationFacts, ProgramReport, ServoFacts};
pub use program::{CutDeparture, ProgramFacts, SlopeOrigin};
pub use reason::{Reason, ReasonKind, ReasonSubject};
pub use render::RenderReport;
pub use replay::{DrawnError, PoseFile, ReplayFile, ReplayReport};
pub use sharpness::{ApertureFacts, SharpnessFacts};
pub use study_faults::{CutterPart, CuttingFault, ReplayFault, StockMeeting, StudyFault};
pub use sweep::{
    AxisFacts, ColumnFacts, PointFacts, PointFailures, PointOutcome, PointStatus, ShardReport,
    SweepReport, SweepRow, SweepTable, words_of_key,
};
pub use table::{FieldFacts, FloorFacts, PlaceMapFacts, TableReport};
pub use tolerance::{FacetsFrom, ToleranceReport};
pub use tool::ToolFacts;
pub use unwrap::{
    FramesFacts, GroundFacts, PanoramaFacts, PhotoFacts, UnwrapMapFacts, UnwrapReport, ViewFacts,
};
pub(crate) use wording::{
    coordinate, digits, displacement, error_px, figures, file_size, of_at_most, percent,
    three_digits,
};
