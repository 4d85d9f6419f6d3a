//! The witness: camera rays traced against the triangles that were read from a file.
//!
//! It knows the triangles, the camera and a table of expected rays that it is handed, but neither
//! mirror nor mesh generator, so it cannot repeat an error of theirs.
//!
//! [`Scene`] answers for any ray through a hierarchical grid. [`CameraTrace`] takes all rays of a
//! camera at once: it rasterizes the facets and proves reflected rays unoccluded in packets, with the
//! same result to the bit. [`TraceResult`] compares them with the table; [`FrameFill`] and [`Coverage`]
//! evaluate it.

mod band_depths;
mod body_scene;
mod camera_rays;
mod camera_trace;
mod closed_mesh;
mod comparison;
mod coverage;
mod digest;
mod expected_ray;
mod face_slopes;
mod filled_range;
mod fragment;
mod frame_fill;
mod obstacles;
mod obstruction;
mod occlusion;
mod outcome_counts;
mod pixel_class;
mod pixel_table;
mod pixel_trace;
mod rasterizer;
mod ray_end;
mod sample_trace;
mod scene;
mod trace_counts;
mod trace_result;
mod trace_strip;
mod trace_summary;
mod traced_part;
mod tracer;

pub use crate::geom::Hit;
pub use body_scene::BodyScene;
pub use camera_rays::PixelRay;
pub use camera_trace::CameraTrace;
pub use coverage::{ColumnCoverage, Coverage, CoverageBuilder, MinMeanMax, Seam};
pub use expected_ray::ExpectedRay;
pub use face_slopes::FaceSlopes;
pub use frame_fill::{FrameFill, FrameFillBuilder, LostPixels};
pub use obstacles::Obstacles;
pub use obstruction::{Obstruction, ObstructionBuilder};
pub use outcome_counts::OutcomeCounts;
pub use pixel_class::PixelClass;
pub use pixel_trace::{PixelTrace, RayErrors};
pub use ray_end::{Outcome, RayEnd};
pub use sample_trace::{SampleRays, SampleTrace};
pub use scene::Scene;
pub use trace_counts::TraceCounts;
pub use trace_result::TraceResult;
pub use trace_strip::{TraceStrip, WantedPicture};
pub use trace_summary::TraceSummary;
pub use traced_part::TracedPart;
