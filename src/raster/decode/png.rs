//! PNG files, of any colour type and depth.

use super::super::{MOST_PIXELS, Raster, RasterError, srgb};
use super::{checked, colour, exif};
use png::{BitDepth, Decoder, DecodingError, Limits, Transformations};
use std::io::{Cursor, ErrorKind};

/// The picture as linear light, turned as its Exif chunk says.
pub(super) fn decode(bytes: &[u8]) -> Result<Raster, RasterError> {
    // Twice the bytes of the largest picture with four 16-bit samples a pixel.
    let limits = Limits { bytes: 16 * MOST_PIXELS as usize };
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(failure)?;
    let [width, height] = checked(header.width, header.height)?;
    let mut reader = decoder.read_info().map_err(failure)?;
    let size = reader
        .output_buffer_size()
        .ok_or(RasterError::Size { width: width as u32, height: height as u32 })?;
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples).map_err(failure)?;
    let channels = frame.color_type.samples();
    let rgb = if frame.bit_depth == BitDepth::Sixteen {
        let light: Vec<f32> = (0..=u16::MAX).map(srgb::decode_fine).collect();
        let (samples, _) = samples.as_chunks::<2>();
        let light = |code: [u8; 2]| light[usize::from(u16::from_be_bytes(code))];
        samples.chunks_exact(channels).map(|pixel| colour(pixel, light)).collect()
    } else {
        samples.chunks_exact(channels).map(|pixel| colour(pixel, srgb::decode)).collect()
    };
    let exif = reader.info().exif_metadata.as_deref();
    Ok(exif::upright(Raster { width, height, rgb }, exif))
}

fn failure(error: DecodingError) -> RasterError {
    match error {
        DecodingError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => {
            RasterError::CutOff { format: "PNG" }
        }
        error => RasterError::Damaged { format: "PNG", account: error.to_string() },
    }
}
