//! 8-bit sRGB pictures as PNG files.

use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter, SrgbRenderingIntent};
use std::io::{self, Write};

/// The PNG file of `width` x `height` pixels of red, green and blue, row by row from the top left.
///
/// # Errors
/// A picture without pixels, or whose `rgb` is not 3 width height bytes long, cannot be written.
pub fn encode(width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut writer = encoder(&mut bytes, [width, height]).write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(bytes)
}

fn encoder<'a, W: Write>(out: W, [width, height]: [u32; 2]) -> Encoder<'a, W> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    // Half as large again as with the next level, but twenty times faster.
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder
}

/// Writes a PNG file of so many columns and rows as the bytes of its rows come: red, green and blue of each
/// pixel, which `rows` writes.
///
/// # Errors
/// Those of `out` and of `rows`; that of a picture without pixels, or with rows missing.
pub fn write_rows<T>(
    out: &mut dyn Write,
    pixels: [u32; 2],
    rows: impl FnOnce(&mut dyn Write) -> io::Result<T>,
) -> io::Result<T> {
    let mut writer = encoder(out, pixels).write_header()?;
    let mut stream = writer.stream_writer()?;
    let made = rows(&mut stream)?;
    stream.finish()?;
    writer.finish()?;
    Ok(made)
}
