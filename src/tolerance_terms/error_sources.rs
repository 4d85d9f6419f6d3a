//! The table of error sources: of each its key, unit, random stream, what it acts on, which systems have
//! it and its usual limit.

use super::MisalignmentField;
use ActsOn::{Camera, Facets, Form, Layers, Map, Mounting, Size, Texture as InTexture};
use AppliesTo::{AnySystem, MappedMirror, RectangularMirror, RoundMirror, TelecentricCamera};
use FormTerm::{Legendre, Zernike};
use LimitUnit::{Kelvin, Microns, Millimetres, Milliradians, Ppm, Px, ShareOfMap};
use MisalignmentField as Field;
use UsualLimit::{ByMesh, ByProcess, Fixed, Uniform};

/// Unit of a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitUnit {
    /// Micrometres.
    Microns,
    /// Millimetres.
    Millimetres,
    /// Milliradians.
    Milliradians,
    /// 1e-6.
    Ppm,
    /// Kelvin.
    Kelvin,
    /// Pixels of the camera.
    Px,
    /// A measured form error's own heights.
    ShareOfMap,
}

impl LimitUnit {
    /// As reports write it.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Microns => "um",
            Millimetres => "mm",
            Milliradians => "mrad",
            Ppm => "ppm",
            Kelvin => "K",
            Px => "px",
            ShareOfMap => "of the map",
        }
    }
}

/// Polynomial of a form error, a departure along Z over X and Y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FormTerm {
    /// The Legendre term of these degrees in X and Y over the rectangle around a rectangular mirror.
    Legendre(u8, u8),
    /// The Zernike term of this index (Noll's) over the disc of a round mirror.
    Zernike(u8),
}

/// Texture of a part: every part has all of it, in a pattern that differs from part to part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Texture {
    /// Sinusoidal waves.
    Waviness,
    /// A random slope.
    Slope,
    /// Cusps of a ball cutter.
    Stepover,
}

/// Part of a made system that an error source changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActsOn {
    /// The part's pose, which no file of a mesh holds.
    Mounting(MisalignmentField),
    /// The part's size.
    Size,
    /// The camera's ray of an image point.
    Camera(MisalignmentField),
    /// The form of the surface.
    Form(FormTerm),
    /// The form of the surface, as measured.
    Map,
    /// The surface's texture.
    Texture(Texture),
    /// Flat terraces of a printer's layers.
    Layers,
    /// Flat facets of the mesh that the part is made from.
    Facets,
}

impl ActsOn {
    /// The number of the misalignment that it changes, if it changes one.
    #[must_use]
    pub fn misalignment(self) -> Option<MisalignmentField> {
        match self {
            Mounting(field) | Camera(field) => Some(field),
            Size => Some(Field::Growth),
            Form(_) | Map | InTexture(_) | Layers | Facets => None,
        }
    }

    /// Whether it is the part's pose.
    #[must_use]
    pub fn is_mounting(self) -> bool {
        matches!(self, Mounting(_))
    }

    /// Whether it is the camera's ray of an image point.
    #[must_use]
    pub fn is_camera(self) -> bool {
        matches!(self, Camera(_))
    }

    /// Whether it is the part's size.
    #[must_use]
    pub fn is_size(self) -> bool {
        self == Size
    }

    /// Whether it differs in a pattern from part to part.
    #[must_use]
    pub fn is_texture(self) -> bool {
        matches!(self, InTexture(_) | Facets)
    }
}

impl ErrorSourceRow {
    /// The rows of low form terms over a disc or a ring, or over a rectangle.
    pub fn of_form(round: bool) -> impl Iterator<Item = &'static Self> {
        let is_form = |row: &&Self| row.perturbation.form_term().is_some();
        let holds = move |row: &&Self| row.applies_to.holds(round, false, false);
        Self::TABLE.iter().filter(is_form).filter(holds)
    }
}

/// Systems that have an error source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AppliesTo {
    /// Every system.
    AnySystem,
    /// Those with a rectangular mirror.
    RectangularMirror,
    /// Those with a disc or a ring as mirror.
    RoundMirror,
    /// Those whose camera has parallel rays.
    TelecentricCamera,
    /// Those of a profile that names a measured form error.
    MappedMirror,
}

impl AppliesTo {
    /// Whether a system has it.
    #[must_use]
    pub fn holds(self, round: bool, telecentric: bool, mapped: bool) -> bool {
        match self {
            AnySystem => true,
            RectangularMirror => !round,
            RoundMirror => round,
            TelecentricCamera => telecentric,
            MappedMirror => mapped,
        }
    }
}

/// Limit of an error source where the profile has none, in the source's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UsualLimit {
    /// The same for all ways of making, with a uniform distribution.
    Uniform(f64),
    /// The same for all ways of making, always at the limit.
    Fixed(f64),
    /// As the preset's way of making leaves it.
    ByProcess,
    /// The bound of the mesh that the part is made from, always at the limit.
    ByMesh,
}

/// Row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorSourceRow {
    /// The error source.
    pub perturbation: Perturbation,
    /// Key in a profile, which ends in its unit.
    pub key: &'static str,
    /// Unit of its limit.
    pub unit: LimitUnit,
    /// Number of its random stream: trials stay the same whatever other sources there are.
    pub stream: u32,
    /// Part of the system that it changes.
    pub acts_on: ActsOn,
    /// Systems that have it.
    pub applies_to: AppliesTo,
    /// Its limit where the profile has none.
    pub usual: UsualLimit,
    /// Description: lines that begin with a space.
    pub what: &'static [&'static str],
}

macro_rules! error_sources {
    ($(
        $(#[doc = $what:literal])+
        $name:ident: $key:literal, $unit:ident, $stream:literal, $acts_on:expr, $applies_to:ident, $usual:expr;
    )+) => {
        /// Quantity of a made system that can be off, in the order of reports. Rotations and the growth are
        /// about the part frame's origin, the middle of the base.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Perturbation {
            $($(#[doc = $what])+ $name,)+
        }

        impl ErrorSourceRow {
            /// The table, in the order of reports.
            pub const TABLE: &'static [Self] = &[$(Self {
                perturbation: Perturbation::$name,
                key: $key,
                unit: $unit,
                stream: $stream,
                acts_on: $acts_on,
                applies_to: $applies_to,
                usual: $usual,
                what: &[$($what),+],
            }),+];
        }

        impl Perturbation {
            /// All keys, in the order of the table.
            pub const KEYS: &'static [&'static str] = &[$($key),+];
        }
    };
}

// Usual limits of mounting, camera and climate: a mount with ground faces and pins leaves 50 um and half a
// milliradian, and so does a camera on it; a heated room; telecentric lenses lean by 0.1 degrees and less,
// and distort by 0.1 % and less (makers' data sheets), half of which remains.
error_sources! {
    /// The mirror is shifted along X.
    DecentreX: "decentre_x_um", Microns, 0, Mounting(Field::ShiftX), AnySystem, Uniform(50.0);
    /// The mirror is shifted along Y.
    DecentreY: "decentre_y_um", Microns, 1, Mounting(Field::ShiftY), AnySystem, Uniform(50.0);
    /// The mirror is shifted towards the camera.
    Despace: "despace_um", Microns, 2, Mounting(Field::ShiftZ), AnySystem, Uniform(50.0);
    /// The mirror is turned about X.
    TiltX: "tilt_x_mrad", Milliradians, 3, Mounting(Field::TiltX), AnySystem, Uniform(0.5);
    /// The mirror is turned about Y.
    TiltY: "tilt_y_mrad", Milliradians, 4, Mounting(Field::TiltY), AnySystem, Uniform(0.5);
    /// The mirror is turned about the axis.
    Clocking: "clocking_mrad", Milliradians, 5, Mounting(Field::Clocking), AnySystem, Uniform(1.0);
    /// The part is larger.
    Scale: "scale_ppm", Ppm, 6, Size, AnySystem, ByProcess;
    /// The part is warmer, and larger by its thermal expansion.
    Temperature: "temperature_k", Kelvin, 7, Size, AnySystem, Uniform(10.0);
    /// The camera's picture is magnified.
    Magnification: "magnification_ppm", Ppm, 8, Camera(Field::Magnification), AnySystem, Uniform(500.0);
    /// The chief rays of a telecentric camera lean outwards, by the angle at half the frame's width.
    Telecentricity: "telecentricity_mrad", Milliradians, 9, Camera(Field::Telecentricity),
        TelecentricCamera, Uniform(1.0);
    /// The sensor is shifted along X.
    PrincipalX: "principal_x_px", Px, 10, Camera(Field::PrincipalX), AnySystem, Uniform(1.0);
    /// The sensor is shifted along Y.
    PrincipalY: "principal_y_px", Px, 11, Camera(Field::PrincipalY), AnySystem, Uniform(1.0);
    /// Third-order radial distortion, at half the frame's width.
    Distortion: "distortion_ppm", Ppm, 12, Camera(Field::Distortion), AnySystem, Uniform(500.0);
    /// Third-order coma of the lens along X (decentering distortion), at half the frame's width.
    Coma: "coma_ppm", Ppm, 19, Camera(Field::Coma), AnySystem, Uniform(0.0);
    /// Form error: the Legendre term of degree 2 in X.
    Legendre20: "legendre_20_um", Microns, 120, Form(Legendre(2, 0)), RectangularMirror, ByProcess;
    /// Form error: the Legendre term of degrees 1 in X and 1 in Y.
    Legendre11: "legendre_11_um", Microns, 111, Form(Legendre(1, 1)), RectangularMirror, ByProcess;
    /// Form error: the Legendre term of degree 2 in Y.
    Legendre02: "legendre_02_um", Microns, 102, Form(Legendre(0, 2)), RectangularMirror, ByProcess;
    /// Form error: the Legendre term of degree 3 in X.
    Legendre30: "legendre_30_um", Microns, 130, Form(Legendre(3, 0)), RectangularMirror, ByProcess;
    /// Form error: the Legendre term of degrees 2 in X and 1 in Y.
    Legendre21: "legendre_21_um", Microns, 121, Form(Legendre(2, 1)), RectangularMirror, ByProcess;
    /// Form error: the Legendre term of degrees 1 in X and 2 in Y.
    Legendre12: "legendre_12_um", Microns, 112, Form(Legendre(1, 2)), RectangularMirror, ByProcess;
    /// Form error: the Legendre term of degree 3 in Y.
    Legendre03: "legendre_03_um", Microns, 103, Form(Legendre(0, 3)), RectangularMirror, ByProcess;
    /// Form error: the Legendre term of degree 4 in X.
    Legendre40: "legendre_40_um", Microns, 140, Form(Legendre(4, 0)), RectangularMirror, ByProcess;
    /// Form error: the Legendre term of degrees 2 in X and 2 in Y.
    Legendre22: "legendre_22_um", Microns, 122, Form(Legendre(2, 2)), RectangularMirror, ByProcess;
    /// Form error: Noll's Zernike term 4, defocus.
    Zernike4: "zernike_4_um", Microns, 204, Form(Zernike(4)), RoundMirror, ByProcess;
    /// Form error: Noll's Zernike term 5, oblique astigmatism.
    Zernike5: "zernike_5_um", Microns, 205, Form(Zernike(5)), RoundMirror, ByProcess;
    /// Form error: Noll's Zernike term 6, astigmatism.
    Zernike6: "zernike_6_um", Microns, 206, Form(Zernike(6)), RoundMirror, ByProcess;
    /// Form error: Noll's Zernike term 7, coma along Y.
    Zernike7: "zernike_7_um", Microns, 207, Form(Zernike(7)), RoundMirror, ByProcess;
    /// Form error: Noll's Zernike term 8, coma along X.
    Zernike8: "zernike_8_um", Microns, 208, Form(Zernike(8)), RoundMirror, ByProcess;
    /// Form error: Noll's Zernike term 9, trefoil along Y.
    Zernike9: "zernike_9_um", Microns, 209, Form(Zernike(9)), RoundMirror, ByProcess;
    /// Form error: Noll's Zernike term 10, trefoil along X.
    Zernike10: "zernike_10_um", Microns, 210, Form(Zernike(10)), RoundMirror, ByProcess;
    /// Form error: Noll's Zernike term 11, spherical.
    Zernike11: "zernike_11_um", Microns, 211, Form(Zernike(11)), RoundMirror, ByProcess;
    /// A measured form error, in its own heights.
    Map: "map_share", ShareOfMap, 13, Map, MappedMirror, Fixed(1.0);
    /// A ripple, peak to valley, of a known period and direction and any phase.
    Waviness: "waviness_um", Microns, 14, InTexture(Texture::Waviness), AnySystem, ByProcess;
    /// A random slope error with a Gaussian autocorrelation: RMS of the gradient of its height along Z.
    Slope: "slope_mrad", Milliradians, 15, InTexture(Texture::Slope), AnySystem, ByProcess;
    /// Cusps that a ball cutter leaves between tracks so far apart, of any phase.
    Stepover: "stepover_mm", Millimetres, 16, InTexture(Texture::Stepover), AnySystem, ByProcess;
    /// Flat terraces that a printer's layers of this height leave: what reflects is level.
    Layers: "layer_um", Microns, 18, Layers, AnySystem, ByProcess;
    /// Flat facets of the mesh that the part is made from: the bound of the picture's displacement.
    Facets: "facets_px", Px, 17, Facets, AnySystem, ByMesh;
}

impl Perturbation {
    /// All, in the order of reports.
    pub fn all() -> impl Iterator<Item = Self> {
        ErrorSourceRow::TABLE.iter().map(|row| row.perturbation)
    }

    /// Its row of the table.
    #[must_use]
    pub const fn row(self) -> &'static ErrorSourceRow {
        // Variants and rows are written by one macro, in one order.
        &ErrorSourceRow::TABLE[self as usize]
    }

    /// The one with this key.
    #[must_use]
    pub fn of_key(key: &str) -> Option<Self> {
        Self::all().find(|perturbation| perturbation.key() == key)
    }

    /// Its key in a profile, which ends in its unit.
    #[must_use]
    pub const fn key(self) -> &'static str {
        self.row().key
    }

    /// Whether every part has all of it, in a pattern that differs from part to part.
    #[must_use]
    pub fn is_texture(self) -> bool {
        self.row().acts_on.is_texture()
    }

    /// Whether it is a strength without a sign.
    #[must_use]
    pub fn is_unsigned(self) -> bool {
        self.is_texture() || self.row().acts_on == Layers
    }

    /// Whether it is usually finer than pixels, which see the mean of it: its displacement grows faster
    /// than its limit.
    #[must_use]
    pub fn is_fine(self) -> bool {
        matches!(self.row().acts_on, InTexture(Texture::Stepover) | Facets)
    }

    /// The polynomial of a form error.
    #[must_use]
    pub fn form_term(self) -> Option<FormTerm> {
        match self.row().acts_on {
            Form(term) => Some(term),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_name_their_source_and_streams_differ() {
        for (k, row) in ErrorSourceRow::TABLE.iter().enumerate() {
            assert_eq!(row.perturbation.row(), row);
            assert_eq!(Perturbation::of_key(row.key), Some(row.perturbation));
            let before = &ErrorSourceRow::TABLE[..k];
            assert!(before.iter().all(|other| other.stream != row.stream), "{}", row.key);
        }
        assert_eq!(Perturbation::of_key("colour"), None);
    }

    /// `docs/tolerances.md` has a row for each error source, with what the table says of it.
    #[test]
    fn the_page_of_tolerances_has_the_table() {
        let row = |row: &ErrorSourceRow| {
            let systems = match row.applies_to {
                AnySystem => "all",
                RectangularMirror => "rectangles",
                RoundMirror => "discs and rings",
                TelecentricCamera => "telecentric",
                MappedMirror => "with `map_file`",
            };
            let usual = match row.usual {
                Uniform(limit) => format!("{limit}"),
                Fixed(limit) => format!("{limit}, fixed"),
                ByProcess => "by preset".to_owned(),
                ByMesh => "by mesh".to_owned(),
            };
            format!("| `{}` |{} | {systems} | {usual} |", row.key, row.what.concat())
        };
        let page = include_str!("../../docs/tolerances.md");
        let head = "| key | error | systems | usual limit |\n|---|---|---|---|\n";
        let told =
            page.split_once(head).map(|(_, rest)| rest.lines().take_while(|l| !l.is_empty()));
        let told: Vec<&str> = told.into_iter().flatten().collect();
        let known: Vec<String> = ErrorSourceRow::TABLE.iter().map(row).collect();
        assert_eq!(told, known, "\n{}", known.join("\n"));
    }

    #[test]
    fn keys_end_in_their_unit() {
        for row in ErrorSourceRow::TABLE {
            let unit = if row.unit == ShareOfMap { "share" } else { row.unit.label() };
            assert_eq!(
                row.key.rsplit('_').next(),
                Some(unit.to_lowercase().as_str()),
                "{}",
                row.key
            );
        }
    }
}
