//! Frames of a stream, one after the other.

use super::y4m::MAGIC;
use super::{VideoError, VideoFormat, VideoFrame};
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Write};

/// Most bytes of a header's line: ffmpeg writes less than 100, and a comment may follow.
const MOST_LINE: usize = 4096;
/// The line before each frame of a Y4M stream; parameters may follow the word.
const FRAME: &str = "FRAME";
/// Bytes that are shown of what is none of ours.
const SHOWN: usize = 24;

/// Reader of a stream's frames.
#[derive(Debug)]
pub struct FrameReader<R> {
    input: BufReader<R>,
    format: VideoFormat,
    /// Frames that were read.
    count: u64,
    /// A frame as it comes, where it comes pixel by pixel.
    interleaved: Vec<u8>,
}

impl<R: Read> FrameReader<R> {
    /// The reader of a Y4M stream, whose header it reads.
    ///
    /// # Errors
    /// [`VideoError`].
    pub fn y4m(input: R) -> Result<Self, VideoError> {
        let mut input = BufReader::with_capacity(1 << 16, input);
        let line = header_line(&mut input)?;
        let format = VideoFormat::parse(&line)?;
        Ok(Self { input, format, count: 0, interleaved: Vec::new() })
    }

    /// The reader of frames without headers.
    pub fn raw(input: R, format: VideoFormat) -> Self {
        let bytes = if format.pixels.interleaved { format.pixels.bytes(format.size) } else { 0 };
        let input = BufReader::with_capacity(1 << 16, input);
        Self { input, format, count: 0, interleaved: vec![0; bytes] }
    }

    /// Size and pixels of its frames.
    pub fn format(&self) -> &VideoFormat {
        &self.format
    }

    /// Reads the next frame; false at the stream's end.
    ///
    /// # Errors
    /// [`VideoError`] with the frame's number.
    pub fn read(&mut self, frame: &mut VideoFrame) -> Result<bool, VideoError> {
        let number = self.count + 1;
        let failed = |source| VideoError::Read { frame: number, source };
        if self.input.fill_buf().map_err(failed)?.is_empty() {
            return Ok(false);
        }
        if self.format.is_y4m() {
            self.frame_line(number)?;
        }
        let wanted = self.format.pixels.bytes(self.format.size);
        let mut before = 0;
        let mut fill = |bytes: &mut [u8]| {
            let found = filled(&mut self.input, bytes).map_err(failed)?;
            before += found;
            let hint = match self.format.is_y4m() {
                true => "",
                false => ", or whether --raw and --pixels are those of its frames",
            };
            let cut = VideoError::CutOff { frame: number, found: before, wanted, hint };
            if found == bytes.len() { Ok(()) } else { Err(cut) }
        };
        if self.format.pixels.interleaved {
            fill(&mut self.interleaved)?;
            frame.separate(&self.interleaved);
        } else {
            frame.planes.iter_mut().try_for_each(|plane| fill(plane))?;
        }
        self.count = number;
        Ok(true)
    }

    /// Reads the line before frame `number`.
    fn frame_line(&mut self, number: u64) -> Result<(), VideoError> {
        let failed = |source| VideoError::Read { frame: number, source };
        let line = line(&mut self.input).map_err(failed)?;
        let is_frame = line.strip_prefix(FRAME.as_bytes()).is_some_and(|rest| {
            rest.first().is_some_and(|after| *after == b' ' || *after == b'\n')
        });
        match line.last() {
            Some(b'\n') if is_frame => Ok(()),
            _ if is_frame => {
                let place = format!("frame {number}");
                Err(VideoError::LongLine { place, most: MOST_LINE })
            }
            _ => Err(VideoError::NoFrame { frame: number, found: shown(&line) }),
        }
    }
}

/// The line of a Y4M stream's header, without its end.
fn header_line(input: &mut impl BufRead) -> Result<String, VideoError> {
    let failed = |source| VideoError::Read { frame: 0, source };
    let line = line(input).map_err(failed)?;
    if line.is_empty() {
        return Err(VideoError::Empty);
    }
    let after = line.get(MAGIC.len()).is_some_and(|after| *after == b' ' || *after == b'\n');
    if !(line.starts_with(MAGIC.as_bytes()) && after) {
        return Err(VideoError::NotY4m { found: shown(&line) });
    }
    if line.last() != Some(&b'\n') {
        return Err(VideoError::LongLine { place: "header".into(), most: MOST_LINE });
    }
    Ok(String::from_utf8_lossy(&line[..line.len() - 1]).into_owned())
}

/// The bytes up to the end of a line, `MOST_LINE` at most.
fn line(input: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut line = Vec::new();
    input.take(MOST_LINE as u64).read_until(b'\n', &mut line)?;
    Ok(line)
}

fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(SHOWN)]).trim_end().to_owned()
}

/// Fills `bytes` as far as the stream goes; how many there are.
fn filled(input: &mut impl Read, bytes: &mut [u8]) -> io::Result<usize> {
    let mut found = 0;
    while found < bytes.len() {
        match input.read(&mut bytes[found..]) {
            Ok(0) => break,
            Ok(more) => found += more,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(found)
}

/// Writer of a stream's frames.
#[derive(Debug)]
pub struct FrameWriter<W> {
    output: W,
    is_y4m: bool,
    /// A frame as it goes, where it goes pixel by pixel.
    interleaved: Vec<u8>,
}

impl<W: Write> FrameWriter<W> {
    /// The writer of frames of this format; it writes their header.
    ///
    /// # Errors
    /// That of the output.
    pub fn new(mut output: W, format: &VideoFormat) -> io::Result<Self> {
        output.write_all(format.header().as_bytes())?;
        let bytes = if format.pixels.interleaved { format.pixels.bytes(format.size) } else { 0 };
        Ok(Self { output, is_y4m: format.is_y4m(), interleaved: vec![0; bytes] })
    }

    /// Writes a frame.
    ///
    /// # Errors
    /// That of the output.
    pub fn write(&mut self, frame: &VideoFrame) -> io::Result<()> {
        if self.is_y4m {
            self.output.write_all(b"FRAME\n")?;
        }
        if !self.interleaved.is_empty() {
            frame.interleave(&mut self.interleaved);
            return self.output.write_all(&self.interleaved);
        }
        frame.planes.iter().try_for_each(|plane| self.output.write_all(plane))
    }

    /// Hands what is written on to whoever reads.
    ///
    /// # Errors
    /// That of the output.
    pub fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::video::PixelFormat;

    fn frames<R: Read>(mut reader: FrameReader<R>) -> Result<Vec<VideoFrame>, VideoError> {
        let mut frames = Vec::new();
        let mut frame = VideoFrame::new(&reader.format().pixels, reader.format().size);
        while reader.read(&mut frame)? {
            frames.push(frame.clone());
        }
        Ok(frames)
    }

    #[test]
    fn a_stream_that_is_read_and_written_is_the_same() {
        let tags = PixelFormat::Y4M.iter().map(|format| format.name);
        for tag in tags {
            let header = format!("YUV4MPEG2 W9 H11 F25:1 Ip A1:1 C{tag} XNOTE\n");
            let format = VideoFormat::parse(header.trim_end()).unwrap();
            let bytes = format.pixels.bytes([9, 11]);
            let mut stream = header.into_bytes();
            for k in 0..3 {
                stream.extend(b"FRAME\n");
                stream.extend((0..bytes).map(|i| (7 * i + k) as u8));
            }
            let read = frames(FrameReader::y4m(&stream[..]).unwrap()).unwrap();
            let mut written = Vec::new();
            let mut writer = FrameWriter::new(&mut written, &format).unwrap();
            read.iter().for_each(|frame| writer.write(frame).unwrap());
            assert!(written == stream, "{tag}");
        }
    }

    #[test]
    fn colours_of_raw_frames_are_planes_in_between() {
        let format = VideoFormat::raw(PixelFormat::RGB24, [9, 8]).unwrap();
        let stream: Vec<u8> = (0..2 * 9 * 8 * 3).map(|k| k as u8).collect();
        let read = frames(FrameReader::raw(&stream[..], format.clone())).unwrap();
        assert_eq!(read.len(), 2);
        assert_eq!([0, 1, 2].map(|plane| read[0].planes[plane][5]), [15, 16, 17]);
        let mut written = Vec::new();
        let mut writer = FrameWriter::new(&mut written, &format).unwrap();
        read.iter().for_each(|frame| writer.write(frame).unwrap());
        assert!(written == stream);
    }

    #[test]
    fn a_damaged_stream_is_refused_at_its_place() {
        let stream = |body: &[u8]| [b"YUV4MPEG2 W8 H8 Cmono\n", body].concat();
        let frame = [b"FRAME Ip\n".to_vec(), vec![5; 64]].concat();
        let told = |stream: Vec<u8>| match FrameReader::y4m(&stream[..]).map(frames) {
            Err(error) | Ok(Err(error)) => error.to_string(),
            Ok(Ok(frames)) => format!("{} frames", frames.len()),
        };
        let long = [b"YUV4MPEG2 X".to_vec(), vec![b'x'; 10_000]].concat();
        for (stream, words) in [
            (stream(&[]), "0 frames"),
            (stream(&frame.repeat(2)), "2 frames"),
            (stream(&[&frame[..], &frame[..50]].concat()), "frame 2 ends after 41 of its 64 bytes"),
            (stream(&[&frame[..], b"FR"].concat()), "frame 2: \"FR\" stands in the place"),
            (stream(&[&frame[..], b"FRAMES\n"].concat()), "frame 2: \"FRAMES\" stands"),
            (
                stream(&[b"FRAME X".to_vec(), vec![b'x'; 10_000]].concat()),
                "frame 1: its line does not end",
            ),
            (long, "header: its line does not end within 4096 bytes"),
            (b"\x89PNG\r\n".to_vec(), "is not the YUV4MPEG2 that"),
            (b"YUV4MPEG20 W8 H8\n".to_vec(), "is not the YUV4MPEG2 that"),
            (Vec::new(), "nothing comes in"),
        ] {
            let told = told(stream);
            assert!(told.contains(words), "{told}");
        }
    }
}
