//! Morion designs freeform catadioptric mirrors, meshes them, writes solids that a machine shop
//! can cut, reads the written file back and proves by ray tracing that it still does its job.
//!
//! # Words
//!
//! - **profile**: the TOML file that says what is wanted (`profile`).
//! - **camera**: which ray each image point sends out; orthographic or pinhole (`optics::Camera`).
//! - **projection**: which world direction, or point of a target surface, an image point must see
//!   (`optics::Projection`; with the target, `optics::ImagingTask`).
//! - **law**: how an image row or radius maps to elevation (`optics::StripLaw`, `optics::RadialLaw`).
//! - **chart**: image coordinates and a height along the camera's rays (`geom::Chart`).
//! - **panel**: one smooth mirror sheet over one image region; a conquistador has two, the second
//!   being the reflection of the first.
//! - **mirror**: the designed panels (`mirror::Mirror`).
//! - **optical face**: the facets that reflect (`mesh::Face`).
//! - **solid**: optical face, skirt and base, closed (`solid::Solid`).
//! - **border**: a flat rim around the mirror, with holes and marks (`geom::Border`).
//! - **scallop**: what a cutter leaves between two lines of its raster (`machining`).
//! - **as cut**: as the cutter leaves it, before polishing.
//! - **ray error**: angle between the direction seen and the direction wanted.
//! - **pixel error**: the same carried back to the image: how many pixels away the content belongs.
//! - **facet error**: the part of it that flat facets cause.
//! - **error source**: what can be off in a made system (`tolerance::Perturbation`); **limit**: by how
//!   much; **compensator**: what is adjusted in return.
//! - **witness**: the ray trace of the file that was written (`trace::TraceResult`).
//! - **panorama**: azimuth across, elevation up; what a photo through the mirror is unwrapped to
//!   (`unwrap::Panorama`, `unwrap::Map`).
//! - **pencil**: the bundle of camera rays that makes one pixel, after the mirror (`pencil`).
//! - **crest / valley**: a ridge where two panels meet, standing out of / sunk into the part.
//!
//! # Frames and units
//!
//! The part frame has X to the right in the picture, Y up in it and Z towards the camera; lengths
//! are millimetres and angles radians unless a name says otherwise. The paper (R. A. Hicks,
//! *Differential Methods in Catadioptric Sensor Design with Applications to Panoramic Imaging*)
//! calls these y, z and x. "The paper's units" have one unit per radian of azimuth.
//!
//! # Stages
//!
//! Data flows one way; each stage is a function from one value to the next.
//!
//! ```text
//! profile -> design -> mesh -> solid -> export -> [file] -> trace -> report
//!               \                                    \        \
//!                machining, pencil          [measured file]   render
//!                tolerance                         align -> trace
//!                unwrap <- [photo]
//! ```
//!
//! Which module may use which; every module after `num` may use `num` and `parallel`, the one
//! door to threads, and from `optics` on `geom` too:
//!
//! ```text
//! parallel
//! num                raster
//! geom
//! tolerance_terms
//! profile            tolerance_terms
//! optics
//! profile            optics
//! mirror
//! design             profile, optics, mirror
//! mesh               optics, mirror
//! solid
//! export             mirror, solid
//! trace              optics
//! align              optics, mirror
//! machining          optics, mirror
//! pencil             optics, mirror
//! unwrap             optics, mirror, raster
//! render             optics, trace, raster
//! tolerance          optics, mirror, trace, tolerance_terms
//! report             results of all of these
//! pipeline           all of these, and the file system
//! bench              all of these, and the file system
//! cli                bench, pipeline, profile, report
//! ```
//!
//! `trace`, the witness, uses nothing of the design: it gets a table of intended rays.
//!
//! # What is not promised
//!
//! Bounds and checks are about the file's triangles and the designed surface. Nothing is said
//! about what a machine makes of the file, but for the geometry of an ideal ball (`machining`).

mod align;
mod bench;
#[cfg(feature = "cli")]
mod cli;
mod design;
mod export;
mod geom;
#[doc(hidden)]
pub mod internals;
mod machining;
mod mesh;
mod mirror;
mod num;
mod optics;
mod parallel;
mod pencil;
mod pipeline;
mod profile;
mod publish;
mod raster;
mod render;
mod report;
mod solid;
mod tolerance;
mod tolerance_terms;
mod trace;
mod unwrap;

pub use pipeline::{Silent, build, load};

/// The README's examples, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
