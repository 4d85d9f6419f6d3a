//! 8-bit sRGB pictures as PNG files.

use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter, SrgbRenderingIntent};

/// The PNG file of `width` x `height` pixels of red, green and blue, row by row from the top left.
///
/// # Errors
/// A picture without pixels, or whose `rgb` is not 3 width height bytes long, cannot be written.
pub fn encode(width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    // Half as large again as with the next level, but twenty times faster.
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(bytes)
}
