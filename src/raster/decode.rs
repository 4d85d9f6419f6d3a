//! Bytes -> light.

use super::{MOST_PIXELS, MOST_SIDE, Raster, RasterError, srgb};
use image::error::ImageError;
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::{Cursor, ErrorKind};

/// See [`Raster::decode`].
pub fn decode(bytes: &[u8]) -> Result<Raster, RasterError> {
    let guessed = image::guess_format(bytes).map_err(|_| RasterError::Unknown)?;
    let format = match guessed {
        ImageFormat::Png => "PNG",
        ImageFormat::Jpeg => "JPEG",
        ImageFormat::OpenExr => "EXR",
        _ => return Err(RasterError::Unknown),
    };
    if guessed == ImageFormat::Jpeg && !ends(bytes) {
        return Err(RasterError::CutOff { format });
    }
    let failed = |error: ImageError| failure(format, &error);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), guessed);
    // The size is looked at here; decoders have room of their own.
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(16 * MOST_PIXELS);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(failed)?;
    let (width, height) = decoder.dimensions();
    let side = 1..=MOST_SIDE;
    let pixels = u64::from(width) * u64::from(height);
    if !(side.contains(&width) && side.contains(&height) && pixels <= MOST_PIXELS) {
        return Err(RasterError::Size { width, height });
    }
    // A tag that cannot be read is none.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut picture = DynamicImage::from_decoder(decoder).map_err(failed)?;
    picture.apply_orientation(orientation);
    Ok(linear(picture))
}

/// Whether a JPEG's last scan has an end: its decoder fills up what is missing.
fn ends(bytes: &[u8]) -> bool {
    let last = |marker: u8| bytes.windows(2).rposition(|pair| pair == [0xff, marker]);
    last(0xd9) > last(0xda)
}

fn failure(format: &'static str, error: &ImageError) -> RasterError {
    if let ImageError::IoError(error) = error
        && error.kind() == ErrorKind::UnexpectedEof
    {
        return RasterError::CutOff { format };
    }
    RasterError::Damaged { format, account: error.to_string() }
}

/// Light as a sum can bear it: no NaN, nothing negative, nothing beyond half precision's largest.
fn sound(light: f32) -> f32 {
    if light.is_nan() { 0.0 } else { light.clamp(0.0, 65_504.0) }
}

fn linear(picture: DynamicImage) -> Raster {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let rgb: Vec<[f32; 3]> = match picture {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            picture.into_rgb32f().pixels().map(|pixel| pixel.0.map(sound)).collect()
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => {
            let light: Vec<f32> = (0..=u16::MAX).map(srgb::decode_fine).collect();
            let light = |code: u16| light[usize::from(code)];
            picture.into_rgb16().pixels().map(|pixel| pixel.0.map(light)).collect()
        }
        _ => picture.into_rgb8().pixels().map(|pixel| pixel.0.map(srgb::decode)).collect(),
    };
    Raster { width, height, rgb }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageBuffer, Luma, Rgb, RgbImage, Rgba};

    const SIZE: [u32; 2] = [24, 16];

    fn codes() -> RgbImage {
        RgbImage::from_fn(SIZE[0], SIZE[1], |x, y| Rgb([(x * 10) as u8, (y * 15) as u8, 128]))
    }

    fn file(picture: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        picture.into().write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    /// The largest difference from the light of `codes`.
    fn off(raster: &Raster) -> f32 {
        assert_eq!([raster.width, raster.height], SIZE.map(|n| n as usize));
        let codes = codes();
        let pixels = raster.rgb.iter().zip(codes.pixels().map(|p| p.0.map(srgb::decode)));
        pixels.flat_map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]).abs())).fold(0.0, f32::max)
    }

    #[test]
    fn every_format_gives_the_light_back() {
        let png = file(codes(), ImageFormat::Png);
        assert_eq!(off(&decode(&png).unwrap()), 0.0);
        assert_eq!(decode(&decode(&png).unwrap().to_png().unwrap()), decode(&png));
        assert!(off(&decode(&file(codes(), ImageFormat::Jpeg)).unwrap()) < 0.05);
        let light = ImageBuffer::from_fn(SIZE[0], SIZE[1], |x, y| {
            Rgb(codes().get_pixel(x, y).0.map(srgb::decode))
        });
        let exr = file(light, ImageFormat::OpenExr);
        assert_eq!(off(&decode(&exr).unwrap()), 0.0);
        let deep = |x, y| Rgb(codes().get_pixel(x, y).0.map(|code| u16::from(code) * 257));
        let deep: ImageBuffer<Rgb<u16>, _> = ImageBuffer::from_fn(SIZE[0], SIZE[1], deep);
        assert_eq!(off(&decode(&file(deep, ImageFormat::Png)).unwrap()), 0.0);
        let clear = |x, y| {
            let [r, g, b] = codes().get_pixel(x, y).0;
            Rgba([r, g, b, x as u8])
        };
        let clear = ImageBuffer::from_fn(SIZE[0], SIZE[1], clear);
        assert_eq!(off(&decode(&file(clear, ImageFormat::Png)).unwrap()), 0.0);
        let grey: ImageBuffer<Luma<u8>, _> = ImageBuffer::from_pixel(3, 2, Luma([188]));
        let grey = decode(&file(grey, ImageFormat::Png)).unwrap();
        assert_eq!(grey, Raster::new(3, 2, [srgb::decode(188); 3]));
    }

    #[test]
    fn light_that_is_no_light_does_not_spread() {
        let odd = Rgb([f32::NAN, f32::INFINITY, -3.0]);
        let raster =
            decode(&file(ImageBuffer::from_pixel(1, 1, odd), ImageFormat::OpenExr)).unwrap();
        assert_eq!(raster.rgb, [[0.0, 65_504.0, 0.0]]);
    }

    #[test]
    fn light_over_one_stays_in_an_exr() {
        let bright = ImageBuffer::from_pixel(2, 2, Rgb([900.0_f32, 0.25, 3.0]));
        let raster = decode(&file(bright, ImageFormat::OpenExr)).unwrap();
        assert_eq!(raster.rgb, [[900.0, 0.25, 3.0]; 4]);
    }

    #[test]
    fn cut_off_pictures_are_refused_wherever_they_end() {
        for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::OpenExr] {
            let picture: DynamicImage = match format {
                ImageFormat::OpenExr => DynamicImage::from(codes()).into_rgb32f().into(),
                _ => codes().into(),
            };
            let whole = file(picture, format);
            assert!(decode(&whole).is_ok());
            // A PNG without its last chunk, of 12 bytes, has all its pixels.
            let needed = whole.len() - if format == ImageFormat::Png { 12 } else { 0 };
            for length in (0..needed).step_by(7).chain([needed - 1]) {
                let error = decode(&whole[..length]).expect_err("it is cut off");
                assert!(!matches!(error, RasterError::Size { .. }), "{format:?} {length}: {error}");
            }
            let half = decode(&whole[..whole.len() * 2 / 3]).unwrap_err();
            // The reader of EXR does not tell an early end from other damage.
            let known = matches!(half, RasterError::CutOff { .. });
            assert_eq!(known, format != ImageFormat::OpenExr, "{format:?}: {half:?}");
        }
    }

    #[test]
    fn other_bytes_are_no_picture() {
        for bytes in [&b""[..], b"solid\n", b"GIF89a and more", b"\x89PN", b"{}"] {
            assert_eq!(decode(bytes), Err(RasterError::Unknown));
        }
    }

    #[test]
    fn headers_that_promise_too_much_are_refused_at_once() {
        let mut png = file(codes(), ImageFormat::Png);
        png[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
        // The checksum of the header, else that is the complaint.
        let sum = crc(&png[12..29]);
        png[29..33].copy_from_slice(&sum.to_be_bytes());
        let error = decode(&png).unwrap_err();
        assert_eq!(error, RasterError::Size { width: 65_535, height: 65_535 });
        assert!(error.to_string().contains("134217728 in all"), "{error}");
    }

    /// The checksum of PNG.
    fn crc(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(u32::MAX, |sum, byte| {
            (0..8).fold(sum ^ u32::from(*byte), |s, _| (s >> 1) ^ (0xedb8_8320 * (s & 1)))
        })
    }

    #[test]
    fn flipped_bits_never_panic() {
        for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::OpenExr] {
            let picture: DynamicImage = match format {
                ImageFormat::OpenExr => DynamicImage::from(codes()).into_rgb32f().into(),
                _ => codes().into(),
            };
            let whole = file(picture, format);
            for at in (0..whole.len()).step_by(3) {
                let mut bytes = whole.clone();
                bytes[at] ^= 1 << (at % 8);
                let _ = decode(&bytes);
            }
        }
    }

    #[test]
    fn photos_are_turned_as_their_tag_says() {
        let jpeg = file(codes(), ImageFormat::Jpeg);
        // An Exif segment with one tag: orientation 6, to be turned right for viewing.
        let mut exif = b"\xff\xe1\0\x22Exif\0\0MM\0*\0\0\0\x08\0\x01".to_vec();
        exif.extend(b"\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0");
        let tagged = [&jpeg[..2], &exif, &jpeg[2..]].concat();
        let (plain, turned) = (decode(&jpeg).unwrap(), decode(&tagged).unwrap());
        assert_eq!([turned.width, turned.height], [plain.height, plain.width]);
        // The upper left corner is at the upper right now.
        assert_eq!(turned.rgb[turned.width - 1], plain.rgb[0]);
    }
}
