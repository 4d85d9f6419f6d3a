//! Forming tools: moulds and mandrels whose face lies beside a mirror, and what is formed on them.
//!
//! The face of a tool is the parallel surface S = P + d n of the mirror P with the unit normal n (docs/theory.md,
//! T111): d is 0 where the mirror is the sheet's side on the tool, or else the sheet's thickness. Walls with a draft lead from
//! its edge outwards to their foot in a plane: that of the flat rim, or the base of a mandrel without one. A tool has a frame of its own, in which it stands on its base and its face looks up: a mandrel's is the
//! part's, a mould's is turned by half a turn about X. What is formed shrinks when it leaves the tool, so all of the face and
//! its walls is larger than the mirror by as much.

mod face_limits;
mod formed;
mod parallel_surface;
mod tool;
mod tool_frame;
mod volume;

pub use face_limits::FormingFault;
pub use formed::FormedFace;
pub use parallel_surface::ParallelSurface;
pub use tool::FormingTool;
pub use tool_frame::ToolFrame;
