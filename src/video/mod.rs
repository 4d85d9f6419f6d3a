//! Video of 8-bit code values: the frames of a Y4M or raw stream, read and written one at a time. Codecs are other programs' work: ffmpeg
//! turns any video into such a stream and back.

mod error;
mod frame;
mod pixel_format;
mod stream;
mod y4m;

pub use error::VideoError;
pub use frame::VideoFrame;
pub use pixel_format::{PixelFormat, PlaneGrid};
pub use stream::{FrameReader, FrameWriter};
pub use y4m::VideoFormat;
