//! The orientation tag of Exif: how a camera was held.

use super::super::Raster;

/// Number of the tag, and of its type, an unsigned 16-bit integer (Exif 2.32, 4.6.4).
const TAG: u16 = 0x112;
const SHORT: u16 = 3;

/// `raster` as its Exif data say that it is to be seen; a tag that cannot be read is none.
pub(super) fn upright(raster: Raster, exif: Option<&[u8]>) -> Raster {
    match exif.and_then(orientation) {
        Some(held @ 2..=8) => turned(&raster, held),
        _ => raster,
    }
}

/// The tag's value, 1 to 8.
fn orientation(exif: &[u8]) -> Option<u16> {
    let big = match exif.get(..4)? {
        b"II*\0" => false,
        b"MM\0*" => true,
        _ => return None,
    };
    let short = |at: usize| {
        let bytes = *exif.get(at..)?.first_chunk()?;
        Some(if big { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    };
    let long = |at: usize| {
        let bytes = *exif.get(at..)?.first_chunk()?;
        Some(if big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    };
    let directory = usize::try_from(long(4)?).ok()?;
    let entries = usize::from(short(directory)?);
    for entry in (0..entries).map(|k| directory + 2 + 12 * k) {
        if short(entry)? == TAG && short(entry + 2)? == SHORT && long(entry + 4)? == 1 {
            return short(entry + 8);
        }
    }
    None
}

/// The pixels in the order of upright rows, for an orientation of 2 to 8.
fn turned(raster: &Raster, held: u16) -> Raster {
    let (w, h) = (raster.width, raster.height);
    let [width, height] = if held < 5 { [w, h] } else { [h, w] };
    let from = |x: usize, y: usize| match held {
        2 => [w - 1 - x, y],
        3 => [w - 1 - x, h - 1 - y],
        4 => [x, h - 1 - y],
        5 => [y, x],
        6 => [y, h - 1 - x],
        7 => [w - 1 - y, h - 1 - x],
        _ => [w - 1 - y, x],
    };
    let row = |y: usize| (0..width).map(move |x| from(x, y));
    let rgb = (0..height).flat_map(row).map(|[x, y]| raster.rgb[y * w + x]).collect();
    Raster { width, height, rgb }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An Exif block with one tag, in either order of bytes.
    fn block(held: u8, big: bool) -> Vec<u8> {
        match big {
            true => {
                [b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0", &[held, 0, 0][..]].concat()
            }
            false => {
                [b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0", &[held, 0, 0, 0][..]].concat()
            }
        }
    }

    #[test]
    fn each_orientation_puts_the_marked_corners_where_they_belong() {
        // Three columns and two rows, each pixel its own number.
        let raster = Raster { width: 3, height: 2, rgb: (0..6).map(|k| [k as f32; 3]).collect() };
        let expected: [&[u8]; 8] = [
            &[0, 1, 2, 3, 4, 5],
            &[2, 1, 0, 5, 4, 3],
            &[5, 4, 3, 2, 1, 0],
            &[3, 4, 5, 0, 1, 2],
            &[0, 3, 1, 4, 2, 5],
            &[3, 0, 4, 1, 5, 2],
            &[5, 2, 4, 1, 3, 0],
            &[2, 5, 1, 4, 0, 3],
        ];
        for (held, expected) in (1..=8).zip(expected) {
            for big in [true, false] {
                let seen = upright(raster.clone(), Some(&block(held, big)));
                let numbers: Vec<u8> = seen.rgb.iter().map(|rgb| rgb[0] as u8).collect();
                assert_eq!(numbers, expected, "{held}");
                assert_eq!(seen.width, if held < 5 { 3 } else { 2 });
            }
        }
    }

    #[test]
    fn a_tag_that_cannot_be_read_is_none() {
        let raster = Raster::new(2, 1, [0.5; 3]);
        let whole = block(6, true);
        let short = (0..whole.len() - 3).map(|length| whole[..length].to_vec());
        let absurd = [block(0, true), block(9, false), b"MM\0*\xff\xff\xff\xff".to_vec()];
        for exif in short.chain(absurd) {
            assert_eq!(upright(raster.clone(), Some(&exif)), raster);
        }
    }
}
