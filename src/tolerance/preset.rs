//! Usual limits of error sources, by the way of making.
//!
//! Orders of magnitude to start from, for parts some 50 mm wide; a shop's own figures belong in the
//! profile. Form is peak to valley of each low-order term, waviness peak to valley, slope RMS over
//! spatial wavelengths of millimetres.

use super::texture::TextureShape;
use crate::tolerance_terms::{
    ActsOn, Distribution, Perturbation, ProcessPreset, Texture, UsualLimit,
};

/// A way of making with its usual limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Process {
    /// The preset's name.
    pub preset: ProcessPreset,
    /// Error of the whole part's size, ppm.
    pub scale_ppm: f64,
    /// Each form error, um.
    pub form_um: f64,
    /// Waviness, um.
    pub waviness_um: f64,
    /// Random slope, mrad.
    pub slope_mrad: f64,
    /// From tool track to track, mm; 0 where there are none.
    pub stepover_mm: f64,
    /// Height of a printer's layers, um; 0 where there are none.
    pub layer_um: f64,
    /// Lengths and directions of all these, and the usual material's expansion.
    pub texture: TextureShape,
}

const fn texture(cte_ppm_per_k: f64, period: f64, correlation: f64, ball: f64) -> TextureShape {
    TextureShape {
        cte_ppm_per_k,
        waviness_period_mm: period,
        waviness_direction_deg: 90.0,
        slope_correlation_mm: correlation,
        ball_radius_mm: ball,
        stepover_direction_deg: 90.0,
        wavelength_nm: 550.0,
    }
}

impl Process {
    /// Single-point diamond turning with a slow tool servo in aluminium: figure of half a wave
    /// to a wave, 2 to 5 nm of roughness (R. Rhorer and C. Evans, *Fabrication of optics by
    /// diamond turning*, Handbook of Optics).
    const SPDT: Self = Self {
        preset: ProcessPreset::Spdt,
        scale_ppm: 20.0,
        form_um: 0.2,
        waviness_um: 0.05,
        slope_mrad: 0.05,
        stepover_mm: 0.005,
        layer_um: 0.0,
        texture: texture(23.0, 2.5, 5.0, 1.0),
    };

    /// Diamond ball milling on an ultra-precision machine: cusps of some 10 nm (E. Brinksmeier
    /// and W. Preuss, *Micro-machining*, 2012).
    const ULTRA_PRECISION_CNC: Self = Self {
        preset: ProcessPreset::UltraPrecisionCnc,
        scale_ppm: 50.0,
        form_um: 0.5,
        waviness_um: 0.1,
        slope_mrad: 0.1,
        stepover_mm: 0.01,
        layer_um: 0.0,
        texture: texture(23.0, 2.5, 5.0, 2.0),
    };

    /// A good five-axis machine in a climate of 1 K: positions to 2 to 5 um (ISO 230-2 data
    /// sheets).
    const PRECISION_CNC: Self = Self {
        preset: ProcessPreset::PrecisionCnc,
        scale_ppm: 100.0,
        form_um: 3.0,
        waviness_um: 0.5,
        slope_mrad: 0.5,
        stepover_mm: 0.02,
        layer_um: 0.0,
        texture: texture(23.0, 5.0, 5.0, 3.0),
    };

    /// A job shop's milling: class f of ISO 2768-1 holds 0.1 to 0.15 mm, machines themselves
    /// about a fifth of it.
    const STANDARD_CNC: Self = Self {
        preset: ProcessPreset::StandardCnc,
        scale_ppm: 500.0,
        form_um: 15.0,
        waviness_um: 3.0,
        slope_mrad: 2.0,
        stepover_mm: 0.1,
        layer_um: 0.0,
        texture: texture(23.0, 8.0, 5.0, 3.0),
    };

    /// Milled with precision and polished by hand: what is taken off goes with pressure, speed and
    /// time (F. W. Preston, *The theory and design of plate glass polishing machines*, 1927), so
    /// that the 10 um that cusps and pits want, uneven by a tenth, add 1 um to the milled form.
    /// Ripple and slope, 0.6 times those of milling, are an estimate.
    const POLISHED: Self = Self {
        preset: ProcessPreset::Polished,
        scale_ppm: 100.0,
        form_um: 4.0,
        waviness_um: 0.3,
        slope_mrad: 0.3,
        stepover_mm: 0.0,
        layer_um: 0.0,
        texture: texture(23.0, 8.0, 8.0, 3.0),
    };

    /// Stereolithography, coated as it comes: shrinkage of 0.2 %, layers of 25 to 50 um, and the
    /// expansion of acrylic resins (printers' and resins' data sheets). Sanded smooth it has none of
    /// the layers.
    const SLA_PRINT: Self = Self {
        preset: ProcessPreset::SlaPrint,
        scale_ppm: 2000.0,
        form_um: 50.0,
        waviness_um: 5.0,
        slope_mrad: 5.0,
        stepover_mm: 0.0,
        layer_um: 50.0,
        texture: texture(90.0, 8.0, 5.0, 3.0),
    };

    /// The limits of a preset.
    #[must_use]
    pub fn of(preset: ProcessPreset) -> Self {
        match preset {
            ProcessPreset::Spdt => Self::SPDT,
            ProcessPreset::UltraPrecisionCnc => Self::ULTRA_PRECISION_CNC,
            ProcessPreset::PrecisionCnc => Self::PRECISION_CNC,
            ProcessPreset::StandardCnc => Self::STANDARD_CNC,
            ProcessPreset::Polished => Self::POLISHED,
            ProcessPreset::SlaPrint => Self::SLA_PRINT,
        }
    }

    /// Usual limit of a perturbation, with its distribution; a mesh's own is not usual.
    #[must_use]
    pub fn usual(&self, kind: Perturbation) -> (f64, Distribution) {
        let row = kind.row();
        match row.usual {
            UsualLimit::Uniform(limit) => (limit, Distribution::Uniform),
            UsualLimit::Fixed(limit) => (limit, Distribution::Fixed),
            UsualLimit::ByMesh => (0.0, Distribution::Fixed),
            UsualLimit::ByProcess => match row.acts_on {
                ActsOn::Size => (self.scale_ppm, Distribution::Truncated),
                ActsOn::Form(_) => (self.form_um, Distribution::Truncated),
                ActsOn::Texture(Texture::Waviness) => (self.waviness_um, Distribution::Fixed),
                ActsOn::Texture(Texture::Slope) => (self.slope_mrad, Distribution::Fixed),
                ActsOn::Texture(Texture::Stepover) => (self.stepover_mm, Distribution::Fixed),
                ActsOn::Layers => (self.layer_um, Distribution::Fixed),
                ActsOn::Mounting(_) | ActsOn::Camera(_) | ActsOn::Map | ActsOn::Facets => {
                    (0.0, Distribution::Fixed)
                }
            },
        }
    }
}
