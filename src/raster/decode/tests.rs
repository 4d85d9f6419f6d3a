use super::*;
use crate::raster::srgb;
use ::exr::prelude::{Image, SpecificChannels, Vec2, WritableImage};
use ::png::{BitDepth, ColorType, Encoder};
use std::io::Cursor;

const SIZE: [usize; 2] = [24, 16];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Format {
    Png,
    Jpeg,
    Exr,
}

const FORMATS: [Format; 3] = [Format::Png, Format::Jpeg, Format::Exr];

/// The pixels' codes, row by row.
fn codes() -> Vec<[u8; 3]> {
    (0..SIZE[0] * SIZE[1])
        .map(|k| [(k % SIZE[0] * 10) as u8, (k / SIZE[0] * 15) as u8, 128])
        .collect()
}

fn png(size: [usize; 2], colour: ColorType, depth: BitDepth, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, size[0] as u32, size[1] as u32);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(samples).unwrap();
    bytes
}

fn jpeg(size: [usize; 2], colour: jpeg_encoder::ColorType, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = jpeg_encoder::Encoder::new(&mut bytes, 75);
    // Colours in full resolution, as the bound of their errors wants.
    encoder.set_sampling_factor(jpeg_encoder::SamplingFactor::F_1_1);
    encoder.encode(samples, size[0] as u16, size[1] as u16, colour).unwrap();
    bytes
}

fn exr(size: [usize; 2], light: &[[f32; 3]]) -> Vec<u8> {
    let pixel = |Vec2(x, y): Vec2<usize>| light[y * size[0] + x].into();
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_channels((size[0], size[1]), SpecificChannels::rgb(pixel));
    image.write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// The picture of `codes` in each format.
fn file(format: Format) -> Vec<u8> {
    let codes = codes();
    match format {
        Format::Png => png(SIZE, ColorType::Rgb, BitDepth::Eight, codes.as_flattened()),
        Format::Jpeg => jpeg(SIZE, jpeg_encoder::ColorType::Rgb, codes.as_flattened()),
        Format::Exr => {
            let light: Vec<_> = codes.iter().map(|rgb| rgb.map(srgb::decode)).collect();
            exr(SIZE, &light)
        }
    }
}

/// The largest difference from the light of `codes`.
fn off(raster: &Raster) -> f32 {
    assert_eq!([raster.width, raster.height], SIZE);
    let pixels = raster.rgb.iter().zip(codes().into_iter().map(|rgb| rgb.map(srgb::decode)));
    pixels.flat_map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]).abs())).fold(0.0, f32::max)
}

#[test]
fn every_format_gives_the_light_back() {
    let coded = file(Format::Png);
    assert_eq!(off(&decode(&coded).unwrap()), 0.0);
    assert_eq!(decode(&decode(&coded).unwrap().to_png().unwrap()), decode(&coded));
    assert!(off(&decode(&file(Format::Jpeg)).unwrap()) < 0.05);
    assert_eq!(off(&decode(&file(Format::Exr)).unwrap()), 0.0);
    // 257 times an 8-bit code is the same share of the 16-bit range: twice its byte.
    let twice = |code: u8| [code, code];
    let deep: Vec<u8> = codes().as_flattened().iter().copied().flat_map(twice).collect();
    let deep = png(SIZE, ColorType::Rgb, BitDepth::Sixteen, &deep);
    assert_eq!(off(&decode(&deep).unwrap()), 0.0);
    let clear: Vec<u8> = codes().iter().flat_map(|&[r, g, b]| [r, g, b, r]).collect();
    let clear = png(SIZE, ColorType::Rgba, BitDepth::Eight, &clear);
    assert_eq!(off(&decode(&clear).unwrap()), 0.0);
}

#[test]
fn grey_pictures_are_equal_in_all_colours() {
    let grey = Raster::new(3, 2, [srgb::decode(188); 3]);
    let coded = png([3, 2], ColorType::Grayscale, BitDepth::Eight, &[188; 6]);
    assert_eq!(decode(&coded).unwrap(), grey);
    let clear = png([3, 2], ColorType::GrayscaleAlpha, BitDepth::Eight, &[188, 7].repeat(6));
    assert_eq!(decode(&clear).unwrap(), grey);
    let coded = jpeg([3, 2], jpeg_encoder::ColorType::Luma, &[188; 6]);
    assert_eq!(decode(&coded).unwrap(), grey);
}

#[test]
fn light_that_is_no_light_does_not_spread() {
    let raster = decode(&exr([1, 1], &[[f32::NAN, f32::INFINITY, -3.0]])).unwrap();
    assert_eq!(raster.rgb, [[0.0, 65_504.0, 0.0]]);
}

#[test]
fn light_over_one_stays_in_an_exr() {
    let bright = [[900.0_f32, 0.25, 3.0]; 4];
    assert_eq!(decode(&exr([2, 2], &bright)).unwrap().rgb, bright);
}

#[test]
fn cut_off_pictures_are_refused_wherever_they_end() {
    for format in FORMATS {
        let whole = file(format);
        assert!(decode(&whole).is_ok());
        // A PNG without its last chunk, of 12 bytes, has all its pixels.
        let needed = whole.len() - if format == Format::Png { 12 } else { 0 };
        for length in (0..needed).step_by(7).chain([needed - 1]) {
            let error = decode(&whole[..length]).expect_err("it is cut off");
            assert!(!matches!(error, RasterError::Size { .. }), "{format:?} {length}: {error}");
        }
        let half = decode(&whole[..whole.len() * 2 / 3]).unwrap_err();
        // The reader of EXR does not tell an early end from other damage.
        let known = matches!(half, RasterError::CutOff { .. });
        assert_eq!(known, format != Format::Exr, "{format:?}: {half:?}");
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
    let mut png = file(Format::Png);
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
    for format in FORMATS {
        let whole = file(format);
        for at in (0..whole.len()).step_by(3) {
            let mut bytes = whole.clone();
            bytes[at] ^= 1 << (at % 8);
            let _ = decode(&bytes);
        }
    }
}

#[test]
fn photos_are_turned_as_their_tag_says() {
    let jpeg = file(Format::Jpeg);
    // An Exif segment with one tag: orientation 6, to be turned right for viewing.
    let mut exif = b"\xff\xe1\0\x22Exif\0\0MM\0*\0\0\0\x08\0\x01".to_vec();
    exif.extend(b"\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0");
    let tagged = [&jpeg[..2], &exif, &jpeg[2..]].concat();
    let (plain, turned) = (decode(&jpeg).unwrap(), decode(&tagged).unwrap());
    assert_eq!([turned.width, turned.height], [plain.height, plain.width]);
    // The upper left corner is at the upper right now.
    assert_eq!(turned.rgb[turned.width - 1], plain.rgb[0]);
}
