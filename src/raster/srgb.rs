//! sRGB codes and linear light, with the same bits everywhere.

use std::sync::LazyLock;

use crate::num;

const BINS: usize = 4096;

struct Tables {
    linear: [f32; 256],
    /// Least light of each code.
    floor: [f32; 256],
    /// Code at the dark end of each of `BINS` equal bins of light.
    start: Vec<u8>,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let linear = std::array::from_fn(|code| decode_exact(code as f64) as f32);
    let floor = std::array::from_fn(|code| match code {
        0 => f32::NEG_INFINITY,
        _ => decode_exact(code as f64 - 0.5) as f32,
    });
    let start = (0..BINS)
        .map(|bin| {
            let light = bin as f32 / BINS as f32;
            (floor.partition_point(|&least| least <= light) - 1) as u8
        })
        .collect();
    Tables { linear, floor, start }
});

/// The light of a code in 0..=255, fractions too.
fn decode_exact(code: f64) -> f64 {
    let c = code / 255.0;
    if c <= 0.04045 { c / 12.92 } else { num::exp(2.4 * num::log((c + 0.055) / 1.055)) }
}

/// The linear light, 0 to 1, of an 8-bit sRGB code.
#[must_use]
pub fn decode(code: u8) -> f32 {
    TABLES.linear[usize::from(code)]
}

/// The linear light, 0 to 1, of a 16-bit sRGB code.
#[must_use]
pub fn decode_fine(code: u16) -> f32 {
    decode_exact(f64::from(code) / 257.0) as f32
}

/// The linear colour of a 24-bit code such as `0xdce3cf`.
#[must_use]
pub fn hex(code: u32) -> [f32; 3] {
    [16, 8, 0].map(|shift| decode((code >> shift & 0xff) as u8))
}

/// The 8-bit sRGB code nearest to a linear light; what lies outside 0 to 1 is clipped, NaN is black.
#[must_use]
pub fn encode(light: f32) -> u8 {
    let tables = &*TABLES;
    // A float-to-integer cast saturates, and takes NaN to 0.
    let bin = ((light * BINS as f32) as usize).min(BINS - 1);
    let mut code = usize::from(tables.start[bin]);
    while code < 255 && light >= tables.floor[code + 1] {
        code += 1;
    }
    code as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_survives_the_round_trip() {
        for code in 0..=255 {
            assert_eq!(encode(decode(code)), code);
        }
    }

    #[test]
    fn rounding_switches_half_way_between_codes() {
        for code in 1..=255_u8 {
            let edge = decode_exact(f64::from(code) - 0.5);
            assert_eq!(encode((edge - 1e-6) as f32), code - 1);
            assert_eq!(encode((edge + 1e-6) as f32), code);
        }
    }

    #[test]
    fn light_out_of_range_is_clipped() {
        assert_eq!(encode(-1.0), 0);
        assert_eq!(encode(f32::NAN), 0);
        assert_eq!(encode(1.0), 255);
        assert_eq!(encode(7.0), 255);
        assert_eq!(encode(f32::INFINITY), 255);
    }

    #[test]
    fn known_values_of_the_standard() {
        assert!((decode(188) - 0.502_886).abs() < 1e-5);
        assert_eq!(encode(0.5), 188);
        assert_eq!(encode(0.18), 118);
        assert_eq!(hex(0xff_00_bc), [1.0, 0.0, decode(188)]);
    }
}
