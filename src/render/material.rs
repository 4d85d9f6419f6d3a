//! Matt and glossy surfaces under a sky and one lamp.

use crate::geom::DVec3;
use crate::raster::srgb::hex;

/// Light of the sky on a surface that looks up, and on one that looks down.
const SKY: [f64; 2] = [0.42, 0.22];
/// Light of the lamp on a surface that faces it.
const LAMP: f64 = 0.68;
/// Squarings of the cosine between mirror direction and lamp: a highlight of about 10 degrees.
const GLOSS: u32 = 5;

/// Illumination of a scene: a sky and one lamp.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lighting {
    /// Unit vector upwards.
    pub up: DVec3,
    /// Unit vector towards the lamp.
    pub lamp: DVec3,
}

/// Reflectance of a surface: a matt colour and a highlight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Material {
    /// Linear colour of the matt part.
    pub colour: [f32; 3],
    /// Strength of the highlight.
    pub gloss: f64,
}

impl Material {
    /// A surface of an sRGB colour.
    #[must_use]
    pub(super) fn new(code: u32, gloss: f64) -> Self {
        Self { colour: hex(code), gloss }
    }
}

impl Lighting {
    /// Linear light from `material` with the unit normal `normal` in the direction against `seen_along`;
    /// `lit`: whether the lamp reaches it.
    #[must_use]
    pub(super) fn shade(
        &self,
        material: &Material,
        normal: DVec3,
        seen_along: DVec3,
        lit: bool,
    ) -> [f32; 3] {
        let [above, below] = SKY;
        let sky = 0.5 * ((above + below) + (above - below) * normal.dot(self.up));
        let lamp = if lit { normal.dot(self.lamp).max(0.0) } else { 0.0 };
        let mut shine = 0.0;
        if lamp > 0.0 && material.gloss > 0.0 {
            shine = (self.lamp - seen_along).normalize_or_zero().dot(normal).max(0.0);
            for _ in 0..GLOSS {
                shine *= shine;
            }
        }
        let matt = (sky + LAMP * lamp) as f32;
        let shine = (material.gloss * shine) as f32;
        material.colour.map(|c| c * matt + shine)
    }
}

/// The linear light of an open sky, paler towards the horizon, or of the ground, in the direction that
/// rises by the sine `rise` over the horizon.
#[must_use]
pub(super) fn backdrop(rise: f64) -> [f32; 3] {
    let [pale, deep] = if rise >= 0.0 { [0xe3ecf3, 0x86abd0] } else { [0xb9b2a6, 0x8a8073] };
    let away = 1.0 - rise.abs();
    let depth = (1.0 - away * away) as f32;
    let (pale, deep) = (hex(pale), hex(deep));
    std::array::from_fn(|c| pale[c] + (deep[c] - pale[c]) * depth)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIGHTS: Lighting = Lighting { up: DVec3::Z, lamp: DVec3::new(0.6, 0.0, 0.8) };

    #[test]
    fn a_surface_is_brightest_towards_the_lamp_and_dark_without_it() {
        let material = Material { colour: [1.0, 0.5, 0.25], gloss: 0.0 };
        let seen = |normal, lit| LIGHTS.shade(&material, normal, DVec3::NEG_Z, lit);
        let [facing, up, away] = [LIGHTS.lamp, DVec3::Z, -LIGHTS.lamp].map(|n| seen(n, true));
        assert!(facing[0] > up[0] && up[0] > away[0] && away[0] > 0.0);
        assert!((f64::from(facing[0] - seen(LIGHTS.lamp, false)[0]) - LAMP).abs() < 1e-6);
        assert!(facing.iter().all(|c| *c <= 1.1) && facing[1] == 0.5 * facing[0]);
    }

    #[test]
    fn gloss_shines_only_in_the_mirror_direction() {
        let material = Material { colour: [0.0; 3], gloss: 1.0 };
        let mirrored = DVec3::new(0.6, 0.0, -0.8);
        assert!(LIGHTS.shade(&material, DVec3::Z, mirrored, true)[0] > 0.999);
        assert!(LIGHTS.shade(&material, DVec3::Z, -LIGHTS.lamp, true)[0] < 0.01);
        assert_eq!(LIGHTS.shade(&material, DVec3::Z, mirrored, false)[0], 0.0);
    }
}
