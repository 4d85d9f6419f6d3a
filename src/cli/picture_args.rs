//! Arguments of the commands that make pictures and tables.

use super::number_args::{finite, frame_size, positive, share, view_angles};
use crate::pipeline::{TableOptions, ViewAngles};
use clap::{Args, ValueEnum};
use std::num::NonZeroUsize;
use std::path::PathBuf;

// Arguments of `morion render`.
#[derive(Debug, Args)]
pub(super) struct RenderArgs {
    /// Profile file, or name of a shipped profile
    pub profile: String,
    /// grid, chessboard, errors, views or cylinder; a panorama as PNG, JPEG or EXR; a model as OBJ
    #[arg(long, value_name = "NAME|FILE")]
    pub scene: String,
    /// By the designed mirror instead of the mesh that is written and read back
    #[arg(long)]
    pub smooth: bool,
    /// Side of the chessboard's squares [default: the mirror's largest width]
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub square_mm: Option<f64>,
    /// Millimetres that a unit of the OBJ model measures [default: 1]
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub unit_mm: Option<f64>,
    /// Let the OBJ model name material libraries and pictures outside its folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

// Arguments of `morion frame`.
#[derive(Debug, Args)]
pub(super) struct FrameArgs {
    /// Profile file, or name of a shipped profile
    pub profile: String,
    /// Least share of the pixels that must see their part of the world [default: the profile's
    /// accept.frame_filled, else 0.995 with fill_frame = true and 0.1 without]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub min: Option<f64>,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

// Arguments of `morion unwrap`.
#[derive(Debug, Args)]
pub(super) struct UnwrapArgs {
    /// The photo, PNG, JPEG or EXR: all that the sensor saw, at any resolution. Or a folder of such photos, all of one size; or - for the
    /// frames of a Y4M stream on standard input, which go to standard output
    pub photo: PathBuf,
    /// Profile file, or name of a shipped profile
    #[arg(long)]
    pub profile: String,
    /// Folder for results, but of a stream [default: out]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Only cut out the panels, turn them upright and lay them side by side
    #[arg(long, conflicts_with_all = ["map", "projection", "width", "view", "ground", "pose"])]
    pub cuts: bool,
    /// A perspective view in the place of the panorama: azimuth and elevation of its middle and the field across it, degrees; Z of the
    /// part's frame is upright in it
    #[arg(
        long,
        value_name = "AZ,EL,FOV",
        value_parser = view_angles,
        allow_hyphen_values = true,
        conflicts_with_all = ["projection", "ground"]
    )]
    pub view: Option<ViewAngles>,
    /// A plan of a floor in the place of the panorama, as seen from the mirror, X to the right: Z of the floor in the part's frame,
    /// its distance from the plane of the mirror's base, past the camera; negative where it is behind the mirror
    #[arg(
        long,
        value_name = "HEIGHT_MM",
        value_parser = finite,
        allow_negative_numbers = true,
        conflicts_with_all = ["projection", "width"]
    )]
    pub ground: Option<f64>,
    /// Millimetres to a pixel of the plan [default: 500 pixels across]
    #[arg(long, value_name = "MM", value_parser = positive, requires = "ground")]
    pub mm_per_px: Option<f64>,
    /// Farthest place of the plan from the axis [default: five times the floor's distance]
    #[arg(long, value_name = "MM", value_parser = positive, requires = "ground")]
    pub range_mm: Option<f64>,
    /// How the part is mounted, and the camera's errors: a pose.json as `tolerance --replay` writes it
    #[arg(long, value_name = "FILE")]
    pub pose: Option<PathBuf>,
    /// Write the map too, for OpenCV's remap: column and row of the photo for each pixel
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub map: Option<MapFormatArg>,
    /// Projection of the panorama [default: the profile's; equirectangular for round mirrors]
    #[arg(long, value_enum, value_name = "LAW")]
    pub projection: Option<RowsArg>,
    /// Pixels across the panorama or the view [default: the scale of the photo, at the rim of round mirrors, in the mean for a view]
    #[arg(long, value_name = "N")]
    pub width: Option<NonZeroUsize>,
    /// Pixels down the view [default: three quarters of those across]
    #[arg(long, value_name = "N", requires = "view")]
    pub height: Option<NonZeroUsize>,
    /// The stream is one of frames without headers, of such pixels
    #[arg(long, value_enum, value_name = "FORMAT", conflicts_with = "cuts")]
    pub raw: Option<RawFormatArg>,
    /// Pixels across and down of frames without headers [default: the camera's in the profile]
    #[arg(long, value_name = "WxH", value_parser = frame_size, requires = "raw")]
    pub pixels: Option<[usize; 2]>,
}

impl UnwrapArgs {
    /// Whether frames of standard input go to standard output.
    pub(super) fn is_stream(&self) -> bool {
        self.photo.as_os_str() == "-"
    }
}

// Arguments of `morion table`.
#[derive(Debug, Args)]
pub(super) struct TableArgs {
    /// Profile file, or name of a shipped profile
    pub profile: String,
    /// Z of a floor in the part's frame: its distance from the plane of the mirror's base, past the camera; negative
    /// where it is behind the mirror [default: no floor]
    #[arg(long, value_name = "MM", value_parser = finite, allow_negative_numbers = true)]
    pub floor_mm: Option<f64>,
    /// Farthest place of the floor from the axis [default: five times the floor's distance]
    #[arg(long, value_name = "MM", value_parser = positive, requires = "floor_mm")]
    pub range_mm: Option<f64>,
    /// Millimetres to a pixel of the floor's plan [default: 500 pixels across]
    #[arg(long, value_name = "MM", value_parser = positive, requires = "floor_mm")]
    pub mm_per_px: Option<f64>,
    /// Pixels along each side of the block that has one entry
    #[arg(long, value_name = "N", default_value_t = TableOptions::EVERY)]
    pub every: usize,
    /// Degrees to a pixel of the panorama's map, to a whole number in a turn
    #[arg(long, value_name = "DEG", default_value_t = TableOptions::DEG_PER_PX)]
    pub deg_per_px: f64,
    /// How the part is mounted, and the camera's errors: a pose.json as `tolerance --replay` writes it
    #[arg(long, value_name = "FILE")]
    pub pose: Option<PathBuf>,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

/// Pixels of frames without headers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum RawFormatArg {
    /// Red, green and blue, a byte each
    Rgb24,
    /// A byte of grey
    Gray8,
}

/// Formats of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MapFormatArg {
    /// NumPy array of shape (rows, columns, 2)
    Npy,
    /// OpenEXR with the columns in channel R, the rows in G
    Exr,
}

/// Laws of a panorama's rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum RowsArg {
    /// The tangent of the elevation in equal steps
    Cylindrical,
    /// The elevation in equal steps
    Equirectangular,
    /// Conformal
    Mercator,
}
