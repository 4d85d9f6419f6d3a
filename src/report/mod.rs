//! Results -> bytes: JSON, CSV, HTML, pictures and the terminal's summary. It computes nothing.
//!
//! A command's result is a struct whose fields are its JSON, and an [`Answer`]: rows of facts in words, from
//! which one renderer makes the terminal's text and one the page.

mod answer;
mod blur;
mod build;
mod build_forecast;
mod fact_rows;
mod facts;
mod frame;
mod machining;
mod machining_rows;
mod maps;
mod measured;
mod page;
mod plot;
mod reason;
mod render;
mod replay;
mod sharpness;
mod tolerance;
mod unwrap;
mod visible;
mod wording;

pub use crate::profile::Aperture;
pub use answer::{Answer, AnswerRows, Head, ToRows};
pub use blur::{BlurReport, FocusPlane, SpotFacts, VirtualImages};
pub use build::{BuildReport, VerifyReport};
pub use build_forecast::{BuildForecast, FileForecast, ForecastLimit, MeshForecast};
pub use facts::{
    ErrorFacts, FileFacts, Limited, MeshFacts, OverOptimum, ProfileId, SCHEMA, SagFacts,
    SolidFacts, StepFacts, TraceFacts, Verdict, VertexFacts,
};
pub use frame::{FrameReport, PixelSolidAngle, RoundMirror};
pub use machining::{
    AsCutFacts, BestFacts, BudgetFacts, GougeFacts, MachiningReport, ReachFacts, StockFacts,
};
pub use maps::{form_picture, gouge_picture};
pub use measured::{AlignmentFacts, UnitFacts};
pub(crate) use plot::{Failure, svg};
pub use reason::{Reason, ReasonKind};
pub use render::RenderReport;
pub use replay::{DrawnError, PoseFile, ReplayFile, ReplayReport};
pub use sharpness::{ApertureFacts, SharpnessFacts};
pub use tolerance::{FacetsFrom, ToleranceReport};
pub use unwrap::{PanoramaFacts, PhotoFacts, UnwrapMapFacts, UnwrapReport};
pub use visible::visible;
pub(crate) use wording::digits;
