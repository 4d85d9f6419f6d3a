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
mod coverage;
mod digest;
mod fragment;
mod frame_fill;
mod obstacles;
mod obstruction;
mod occlusion;
mod pixel_table;
mod pixel_trace;
mod rasterizer;
mod ray_end;
mod sample_trace;
mod scene;
mod trace_counts;
mod trace_result;
mod trace_summary;
mod traced_part;
mod tracer;

pub use crate::geom::Hit;
pub use body_scene::BodyScene;
pub use camera_trace::CameraTrace;
pub use coverage::{ColumnCoverage, Coverage, CoverageBuilder, MinMeanMax, Seam};
pub use frame_fill::{FrameFill, FrameFillBuilder, LostPixels, PixelClass, classify_pixels};
pub use obstacles::Obstacles;
pub use obstruction::{Obstruction, ObstructionBuilder};
pub use pixel_trace::{PixelTrace, RayErrors};
pub use ray_end::{Outcome, RayEnd};
pub use sample_trace::{SampleRays, SampleTrace};
pub use scene::Scene;
pub use trace_counts::TraceCounts;
pub use trace_result::{ExpectedRay, TraceResult, TraceStrip};
pub use trace_summary::TraceSummary;
pub use traced_part::TracedPart;
