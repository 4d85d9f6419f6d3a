//! Why a stream of frames cannot be read, and what to do about it.

use super::pixel_format::LEAST_SIDE;
use crate::raster::{MOST_PIXELS, MOST_SIDE};
use std::io;
use thiserror::Error;

/// A stream without frames that can be read.
#[derive(Debug, Error)]
pub enum VideoError {
    /// There is not a byte.
    #[error(
        "nothing comes in; pipe frames into it, as `ffmpeg -i FILE -f yuv4mpegpipe -` writes them"
    )]
    Empty,
    /// The first bytes are not those of a Y4M stream.
    #[error(
        "byte 0: {found:?} is not the YUV4MPEG2 that a Y4M stream begins with; pipe in what `ffmpeg -i FILE -f yuv4mpegpipe -` \
         writes, or say --raw rgb24 or --raw gray8 of frames without a header"
    )]
    NotY4m {
        /// What stands there.
        found: String,
    },
    /// A line of the stream is too long.
    #[error(
        "{place}: its line does not end within {most} bytes; the stream is no Y4M or is damaged: write it again"
    )]
    LongLine {
        /// Which header.
        place: String,
        /// Most bytes of a line.
        most: usize,
    },
    /// A parameter of the header cannot be understood.
    #[error("header: {parameter:?} {must}")]
    Parameter {
        /// The parameter.
        parameter: String,
        /// What it has to be, and what to do.
        must: &'static str,
    },
    /// A parameter of the header is missing.
    #[error(
        "header: {0}, is missing; write the stream again, as with `ffmpeg -i FILE -f yuv4mpegpipe -`"
    )]
    Missing(&'static str),
    /// Lines of a frame belong to two moments.
    #[error(
        "header: {parameter:?} says that the frames are {kind}; deinterlace them first, as `ffmpeg -i FILE -vf bwdif -f yuv4mpegpipe -` does"
    )]
    Interlaced {
        /// The parameter.
        parameter: String,
        /// What it stands for.
        kind: &'static str,
    },
    /// Colours that are not read.
    #[error(
        "header: the colour tag {parameter:?} {why}; convert it, as `ffmpeg -i FILE -pix_fmt yuv420p -f yuv4mpegpipe -` does (tags that are read: \
         {known})"
    )]
    Colour {
        /// The parameter.
        parameter: String,
        /// Why not.
        why: &'static str,
        /// The tags that are read.
        known: String,
    },
    /// Frames that are too small or too large.
    #[error(
        "frames of {} x {} pixels cannot be taken: there must be at least {LEAST_SIDE} and at most {MOST_SIDE} a side, and {MOST_PIXELS} in all",
        size[0], size[1]
    )]
    Size {
        /// Pixels across and down.
        size: [usize; 2],
    },
    /// Something else stands in the place of a frame.
    #[error(
        "frame {frame}: {found:?} stands in the place of its line FRAME; the stream is damaged there: write it again (frames before it are written)"
    )]
    NoFrame {
        /// Number of the frame, the first is 1.
        frame: u64,
        /// What stands there.
        found: String,
    },
    /// The stream ends within a frame.
    #[error(
        "frame {frame} ends after {found} of its {wanted} bytes; look what cut the stream off{hint} (frames before it are written)"
    )]
    CutOff {
        /// Number of the frame, the first is 1.
        frame: u64,
        /// Bytes that there are.
        found: usize,
        /// Bytes of a frame.
        wanted: usize,
        /// What else it may be.
        hint: &'static str,
    },
    /// The system does not read on.
    #[error("frame {frame}: {source}")]
    Read {
        /// Number of the frame, the first is 1; 0 in the header.
        frame: u64,
        /// Its account.
        source: io::Error,
    },
}
