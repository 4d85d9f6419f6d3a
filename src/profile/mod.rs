//! What is wanted of a mirror: the TOML profile, read and checked.
//!
//! A [`Profile`] that exists is a valid one: every number is finite and within its limits, and
//! the layout fits the projection. [`Profile::parse`] either returns one or returns all the
//! [`Complaints`] at once, each with its place in the file.

mod check;
mod complaint;
mod lines;
mod reader;
mod schema;
mod shipped;
mod source;
mod values;
mod words;

use std::fmt;

pub use complaint::{Complaint, Complaints};
pub use shipped::{Shipped, shipped};

/// A checked profile: camera, projection, layout, method, part, mesh, files and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// The name that output goes under, usually the file's name without `.toml`.
    pub name: String,
    /// SHA-256 of the profile's bytes, in lower-case hexadecimal.
    pub sha256: String,
    /// What the mirror is for, in the author's words; empty if not given.
    pub summary: String,
    /// The camera that looks into the mirror.
    pub camera: Camera,
    /// Which part of the world the picture must show, and how it is laid out.
    pub projection: Projection,
    /// How the mirror's panels tile the image.
    pub layout: Layout,
    /// How the mirror's shape is computed.
    pub method: Method,
    /// The size of the solid.
    pub part: Part,
    /// How closely facets must follow the mirror.
    pub mesh: MeshLimits,
    /// The files to write, without repetition, in the profile's order; at least one.
    pub formats: Vec<Format>,
    /// The limits a finished mirror must keep to pass.
    pub accept: Accept,
}

/// The camera that looks into the mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// A telecentric camera: all its rays are parallel to the optical axis.
    Orthographic {
        /// Width and height of the frame in pixels, each 1 to 16384.
        pixels: [u32; 2],
    },
}

/// Which direction of the world an image point must see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// How an image row maps to elevation.
    pub law: Law,
    /// First and last azimuth in degrees: increasing, within ±360, at most 360 apart.
    pub azimuth_deg: [f64; 2],
    /// Lowest and highest elevation in degrees: increasing, strictly inside ±90.
    pub elevation_deg: [f64; 2],
}

/// How an image row maps to elevation; `z` is the row's height in units of the strip's scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// `tan(elevation) = z`, the picture on a cylinder about the axis. No mirror is exact.
    Cylindrical,
    /// `tan(elevation) = sinh(z)`, the conformal picture. An exact mirror exists.
    Mercator,
}

/// How the mirror's panels tile the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layout {
    /// One panel, the whole panorama in one strip.
    Strip {
        /// Change the elevation range so that the mirror fills the camera's frame exactly.
        fill_frame: bool,
    },
    /// Two panels that share a ridge, each with half of a full turn.
    Conquistador {
        /// Where the panel's shape comes from.
        panel: PanelSource,
        /// Which way the ridge between the panels faces.
        ridge: Ridge,
        /// Change the elevation range so that the mirror fills the camera's frame exactly.
        fill_frame: bool,
    },
}

/// Where the shape of a conquistador's panel comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelSource {
    /// Cut out of the mirror for the full turn.
    Section,
    /// Solved on the half turn alone, which leaves a smaller error.
    Refit,
}

/// Which way the ridge between a conquistador's panels faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ridge {
    /// Standing out of the part, where a cutter reaches and no panel shadows the other.
    Crest,
    /// Sunk into the part.
    Valley,
}

/// How the mirror's shape is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Least squares between the mirror's gradient and the wanted slope field.
    VectorField {
        /// Degree of the polynomial in each image coordinate, 1 to 40.
        degree: usize,
    },
}

/// The size of the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Width of the mirror across the picture, in millimetres.
    pub width_mm: f64,
    /// Material under the mirror's lowest point, in millimetres.
    pub base_mm: f64,
}

/// How closely facets must follow the mirror. At least one of the two is given; with both, the
/// stricter rules at each place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshLimits {
    /// Largest height between a facet and the mirror, in micrometres.
    pub chord_um: Option<f64>,
    /// Largest pixel error that the flatness of a facet may cause, in pixels.
    pub facet_px: Option<f64>,
}

/// A kind of file to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Format {
    /// Binary STL, single precision.
    Stl,
    /// Wavefront OBJ, decimal text.
    Obj,
}

impl Format {
    /// All formats that can be written.
    pub const ALL: [Self; 2] = [Self::Stl, Self::Obj];

    /// The format's name in a profile, which is also the file's extension.
    pub fn name(self) -> &'static str {
        match self {
            Format::Stl => "stl",
            Format::Obj => "obj",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The limits a finished mirror must keep to pass; an absent one is not checked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Accept {
    /// Largest root-mean-square pixel error, in pixels.
    pub pixel_error_rms_px: Option<f64>,
    /// Largest pixel error anywhere, in pixels.
    pub pixel_error_max_px: Option<f64>,
    /// Smallest share of the frame's pixels that see their part of the world, 0 to 1.
    pub frame_filled: Option<f64>,
}

impl Profile {
    /// Reads and checks a profile.
    ///
    /// `name` is what output goes under and `file` what complaints call the file. On failure every
    /// complaint that can be made is made, in the order of the file.
    pub fn parse(name: &str, file: &str, bytes: &[u8]) -> Result<Profile, Complaints> {
        let text = source::text(file, bytes)?;
        let (tree, errors) = toml::de::DeTable::parse_recoverable(text);
        let mut reader = reader::Reader::new(file, text);
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
