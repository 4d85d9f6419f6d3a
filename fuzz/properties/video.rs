//! Streams of frames: Y4M, and raw ones of nine pixels by eight.

use morion::internals::video::{
    FrameReader, FrameWriter, PixelFormat, VideoError, VideoFormat, VideoFrame,
};

/// Most bytes of a frame that is read: larger ones end before they are whole.
const MOST: usize = 1 << 20;
/// Most bytes of a header's line or a frame's, which is kept.
const LINES: usize = 4096;

pub fn holds(bytes: &[u8]) {
    match FrameReader::y4m(bytes) {
        Ok(reader) => read(reader, bytes),
        Err(error) => told(&error),
    }
    for pixels in [PixelFormat::RGB24, PixelFormat::GRAY8] {
        match VideoFormat::raw(pixels, [9, 8]) {
            Ok(format) => read(FrameReader::raw(bytes, format), bytes),
            Err(error) => told(&error),
        }
    }
}

/// Whole frames come before what is wrong, no more of them than there are bytes for, and written again they read the same.
fn read(mut reader: FrameReader<&[u8]>, bytes: &[u8]) {
    let format = reader.format().clone();
    let size = format.pixels.bytes(format.size);
    assert!(format.header().len() <= LINES + 32, "a header is a line");
    if size > MOST {
        return;
    }
    let mut frames = Vec::new();
    let mut frame = VideoFrame::new(&format.pixels, format.size);
    let is_whole = loop {
        match reader.read(&mut frame) {
            Ok(true) => frames.push(frame.clone()),
            Ok(false) => break true,
            Err(error) => {
                told(&error);
                break false;
            }
        }
    };
    assert!(frames.len() * size <= bytes.len(), "frames are of bytes");
    if format.is_y4m() || !is_whole {
        assert!(!is_whole || frames.len() * size < bytes.len());
    } else {
        assert_eq!(frames.len() * size, bytes.len());
    }
    let mut written = Vec::new();
    let mut writer = FrameWriter::new(&mut written, &format).expect("memory takes all");
    frames.iter().for_each(|frame| writer.write(frame).expect("memory takes all"));
    let mut again = match format.is_y4m() {
        true => FrameReader::y4m(&written[..]).expect("a header that was written"),
        false => FrameReader::raw(&written[..], format.clone()),
    };
    assert_eq!(*again.format(), format);
    for wanted in &frames {
        assert!(again.read(&mut frame).expect("a whole frame") && frame == *wanted);
    }
    assert!(!again.read(&mut frame).expect("the stream's end"));
}

fn told(error: &VideoError) {
    let said = error.to_string();
    assert!(!said.contains(char::is_control), "{said:?}");
}
