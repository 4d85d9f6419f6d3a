//! A stream of frames through the mirror -> the stream of their panoramas, views or plans.

use super::observer::Observer;
use super::run::Run;
use super::unwrap_facts::report_on;
use super::unwrap_map::{MappedPicture, PhotoSystem, PictureRequest, check_projection};
use super::unwrap_picture::{FramedPicture, UnwrapPicture};
use super::{Error, PhotoError, Stage};
use crate::parallel;
use crate::profile::Profile;
use crate::results::{FramesFacts, PhotoFacts, UnwrapMapFacts, UnwrapReport};
use crate::unwrap::FrameTable;
use crate::video::{FrameReader, FrameWriter, PixelFormat, VideoError, VideoFormat, VideoFrame};
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;
use std::time::Instant;

/// Name of the stream in reports.
const NAME: &str = "-";
/// Name of the stream in messages.
const INPUT: &str = "standard input";

/// Unwrapping of a stream of frames, Y4M or raw, to a stream of the same kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnwrapStream<'a> {
    /// What is shown.
    pub picture: UnwrapPicture,
    /// A file as `tolerance --replay` writes: how the part is mounted, and the camera's errors. Without it the mirror is the designed one.
    pub pose: Option<&'a Path>,
    /// Frames without headers; a Y4M stream without it.
    pub raw: Option<RawFrames>,
}

/// Frames without headers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawFrames {
    /// What a pixel is.
    pub format: RawFormat,
    /// Pixels across and down; without it those of the profile's camera.
    pub pixels: Option<[usize; 2]>,
}

/// Pixels of frames without headers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RawFormat {
    /// Red, green and blue, a byte each.
    Rgb24,
    /// A byte of grey.
    Gray8,
}

/// The input's frames and what becomes of each.
struct PreparedStream<'a> {
    reader: FrameReader<&'a mut (dyn Read + Send)>,
    table: FrameTable,
    framed: FramedPicture,
    map: UnwrapMapFacts,
}

impl UnwrapStream<'_> {
    /// Unwraps the frames of `input` to `output`, each as soon as it is there. A reader of the output that goes away ends it, and is no
    /// error.
    ///
    /// # Errors
    /// [`enum@Error`] when there is no such picture, or the input is none that can be read on; what is written then are whole frames.
    pub fn run(
        &self,
        profile: &Profile,
        input: &mut (dyn Read + Send),
        output: &mut (dyn Write + Send),
        observer: &dyn Observer,
    ) -> Result<UnwrapReport, Error> {
        check_projection(profile)?;
        self.picture.check()?;
        let run = Run::in_memory(profile, observer);
        let reader = run.stage(Stage::Read, || {
            let reader = self.reader(profile, input).map_err(fault)?;
            let [width, height] = reader.format().size;
            let name = reader.format().pixels.name;
            Ok((reader, format!("{INPUT}: {name}, {width} x {height} pixels")))
        })?;
        let pixels = reader.format().size;
        let (mut stream, system) = self.prepared(&run, reader)?;
        let count = run.stage(Stage::Frames, || {
            let begun = Instant::now();
            let count = stream.unwrap(output)?;
            let rate = count as f64 / begun.elapsed().as_secs_f64();
            Ok((count, format!("{count} frames, {rate:.1} a second")))
        })?;
        let PhotoSystem { scale: pixels_per_sensor_pixel, warnings } = system;
        let photo = PhotoFacts { name: NAME.into(), pixels, pixels_per_sensor_pixel };
        let frames = Some(FramesFacts { format: stream.reader.format().pixels.name, count });
        let report = report_on(profile, photo, self.pose, (&stream.framed, "remap"));
        Ok(UnwrapReport { frames, map: Some(stream.map), warnings, ..report })
    }

    fn reader<'i>(
        &self,
        profile: &Profile,
        input: &'i mut (dyn Read + Send),
    ) -> Result<FrameReader<&'i mut (dyn Read + Send)>, VideoError> {
        let Some(RawFrames { format, pixels }) = self.raw else { return FrameReader::y4m(input) };
        let format = match format {
            RawFormat::Rgb24 => PixelFormat::RGB24,
            RawFormat::Gray8 => PixelFormat::GRAY8,
        };
        let size = pixels.unwrap_or(profile.camera.pixels().map(|pixels| pixels as usize));
        Ok(FrameReader::raw(input, VideoFormat::raw(format, size)?))
    }

    fn prepared<'i>(
        &self,
        run: &Run,
        reader: FrameReader<&'i mut (dyn Read + Send)>,
    ) -> Result<(PreparedStream<'i>, PhotoSystem), Error> {
        let request = PictureRequest { photo: INPUT, picture: self.picture, pose: self.pose };
        let (size, pixels) = (reader.format().size, reader.format().pixels);
        request.made(run, size, |MappedPicture { framed, map }| {
            let table = FrameTable::new(&map, pixels);
            Ok(PreparedStream { reader, table, framed, map: UnwrapMapFacts::from(&map) })
        })
    }
}

impl PreparedStream<'_> {
    /// Unwraps frame by frame; how many were written. While one is worked on, the next is read.
    fn unwrap(&mut self, output: &mut (dyn Write + Send)) -> Result<u64, Error> {
        let from = self.reader.format().clone();
        let to = from.resized(self.framed.size());
        let [mut frame, mut next] = [(); 2].map(|()| VideoFrame::new(&from.pixels, from.size));
        let mut picture = VideoFrame::new(&to.pixels, to.size);
        let Some(mut writer) = unless_closed(FrameWriter::new(output, &to))? else { return Ok(0) };
        let mut count = 0;
        let mut is_frame = self.reader.read(&mut frame).map_err(fault)?;
        while is_frame {
            let (written, read) = parallel::join(
                || {
                    self.table.paint(&frame, &mut picture);
                    writer.write(&picture).and_then(|()| writer.flush())
                },
                || self.reader.read(&mut next),
            );
            let Some(()) = unless_closed(written)? else { break };
            count += 1;
            is_frame = read.map_err(fault)?;
            std::mem::swap(&mut frame, &mut next);
        }
        Ok(count)
    }
}

fn fault(source: VideoError) -> Error {
    PhotoError::Stream { input: INPUT, source }.into()
}

/// What was written, or none where nobody reads it any more.
fn unless_closed<T>(written: io::Result<T>) -> Result<Option<T>, Error> {
    match written {
        Ok(value) => Ok(Some(value)),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(None),
        Err(error) => Err(PhotoError::Output(error).into()),
    }
}
