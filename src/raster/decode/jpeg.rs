//! JPEG files, baseline and progressive.

use super::super::{Raster, RasterError, srgb};
use super::{checked, colour, exif};
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// The picture as linear light, turned as its Exif segment says.
pub(super) fn decode(bytes: &[u8]) -> Result<Raster, RasterError> {
    if !ends(bytes) {
        return Err(RasterError::CutOff { format: "JPEG" });
    }
    // The size is looked at here; no JPEG has longer sides.
    let options = DecoderOptions::default()
        .set_strict_mode(false)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX));
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(failure)?;
    let size = decoder.info().map_or([0; 2], |info| [info.width, info.height]);
    let [width, height] = checked(size[0].into(), size[1].into())?;
    let space = match decoder.input_colorspace() {
        Some(ColorSpace::Luma) => ColorSpace::Luma,
        _ => ColorSpace::RGB,
    };
    decoder.set_options(decoder.options().jpeg_set_out_colorspace(space));
    let samples = decoder.decode().map_err(failure)?;
    let pixels = samples.chunks_exact(space.num_components());
    let rgb = pixels.map(|pixel| colour(pixel, srgb::decode)).collect();
    let exif = decoder.exif().map(Vec::as_slice);
    Ok(exif::upright(Raster { width, height, rgb }, exif))
}

/// Whether a JPEG's last scan has an end: its decoder fills up what is missing.
fn ends(bytes: &[u8]) -> bool {
    let last = |marker: u8| bytes.windows(2).rposition(|pair| pair == [0xff, marker]);
    last(0xd9) > last(0xda)
}

fn failure(error: DecodeErrors) -> RasterError {
    RasterError::Damaged { format: "JPEG", account: error.to_string() }
}
