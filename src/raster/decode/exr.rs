//! OpenEXR files: the first layer with channels R, G and B.

use super::super::{Raster, RasterError};
use super::checked;
use exr::prelude::{ReadChannels, ReadLayers, Vec2, read};
use std::io::Cursor;

/// The light in the display window; places outside of the data window are black.
pub(super) fn decode(bytes: &[u8]) -> Result<Raster, RasterError> {
    let ([width, height], rgb) = channels(bytes, [0.0; 3])?;
    let rgb = rgb.into_iter().map(|light| light.map(sound)).collect();
    Ok(Raster { width, height, rgb })
}

/// Width and height of the display window, and R, G and B of its places as they are: `outside` of the data window.
///
/// # Errors
/// [`RasterError`] when no layer has them, or the file is damaged or too large.
pub fn channels(
    bytes: &[u8],
    outside: [f32; 3],
) -> Result<([usize; 2], Vec<[f32; 3]>), RasterError> {
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(failure)?;
    let coloured = |header: &&exr::meta::header::Header| {
        let has = |name: &str| header.channels.find_index_of_channel(&name.into()).is_some();
        !header.deep && ["R", "G", "B"].into_iter().all(has)
    };
    let Some(header) = reader.headers().iter().find(coloured) else {
        let account = "no layer has channels R, G and B".to_owned();
        return Err(RasterError::Damaged { format: "EXR", account });
    };
    let window = header.shared_attributes.display_window;
    let offset = header.own_attributes.layer_position - window.position;
    let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    let [width, height] = checked(side(window.size.width()), side(window.size.height()))?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            move |_, _| vec![outside; width * height],
            move |rgb: &mut Vec<[f32; 3]>, at: Vec2<usize>, (red, green, blue): (f32, f32, f32)| {
                let Vec2(x, y) = at.to_i32() + offset;
                if let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y))
                    && x < width
                    && y < height
                {
                    rgb[y * width + x] = [red, green, blue];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_chunks(reader)
        .map_err(failure)?;
    Ok(([width, height], image.layer_data.channel_data.pixels))
}

/// Light as a sum can bear it: no NaN, nothing negative, nothing beyond half precision's largest.
fn sound(light: f32) -> f32 {
    if light.is_nan() { 0.0 } else { light.clamp(0.0, 65_504.0) }
}

fn failure(error: exr::error::Error) -> RasterError {
    RasterError::Damaged { format: "EXR", account: error.to_string() }
}
