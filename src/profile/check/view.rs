//! The keys of a perspective or fisheye view, of the whole frame or of a panel.

use super::super::AzimuthalSpec;
use super::super::reader::Need::{Optional, Required};
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, NumbersFormat, flag, number, numbers, word};
use crate::optics::{AzimuthalLaw, Target};

/// The keys of a perspective or fisheye view.
pub(super) struct AzimuthalKeys {
    pub(super) law: Option<AzimuthalLaw>,
    pub(super) centre: Option<Located<[f64; 2]>>,
    pub(super) hfov: Option<Located<f64>>,
    pub(super) roll_deg: f64,
    pub(super) mirrored: bool,
}

impl AzimuthalKeys {
    /// The view, if every figure of it is there.
    pub(super) fn finish(self, target: Target) -> Option<AzimuthalSpec> {
        Some(AzimuthalSpec {
            law: self.law?,
            centre_deg: self.centre.map(|centre| centre.value),
            hfov_deg: self.hfov?.value,
            roll_deg: self.roll_deg,
            mirrored: self.mirrored,
            target,
        })
    }
}

/// The laws of views by their names: a perspective view, and those of fisheyes.
pub(super) const LAWS: [(&str, AzimuthalLaw); 4] = [
    ("perspective", AzimuthalLaw::Perspective),
    ("equidistant", AzimuthalLaw::Equidistant),
    ("equisolid", AzimuthalLaw::Equisolid),
    ("stereographic", AzimuthalLaw::Stereographic),
];

/// The keys of a view by one of `laws`, the first of which is usual: where there are several, `law` is a key.
pub(super) fn azimuthal(
    reader: &mut ProfileReader,
    section: &Section,
    laws: &[(&str, AzimuthalLaw)],
) -> AzimuthalKeys {
    let hint = match laws[0].1 {
        AzimuthalLaw::Perspective => "perspective keeps straight lines straight, and is usual",
        _ => "equidistant: the distance from the centre is proportional to the angle",
    };
    let law = match laws {
        [_, _, ..] if section.has("law") => word(reader, section, "law", laws, hint),
        laws => Some(laws[0].1),
    };
    let form = "the direction that the picture's centre shows, as in centre_deg = [90, 30]; \
                elevation 90 looks back to the camera";
    let keys = NumbersFormat {
        key: "centre_deg",
        parts: "[azimuth, elevation]",
        each: "from -360 to 360",
        form,
        limit: form,
    };
    let centre = section
        .has(keys.key)
        .then(|| numbers(reader, section, &keys, |f| (-360.0..=360.0).contains(&f)))
        .flatten()
        .filter(|centre| centre_elevation(reader, section, centre));
    let (must, most) = match law {
        Some(AzimuthalLaw::Perspective) => ("a number from 0.001 to 175", 175.0),
        _ => ("a number from 0.001 to 350", 350.0),
    };
    let hint = "the angle of view across the frame's width, in degrees";
    let hfov =
        number(reader, section, "hfov_deg", Required, must, hint, |f| (1e-3..=most).contains(&f));
    let must = "a number from -360 to 360";
    let hint = "the turn of the world in the picture, clockwise, in degrees";
    let roll = number(reader, section, "roll_deg", Optional, must, hint, |f| f.abs() <= 360.0);
    let mirrored = flag(reader, section, "mirrored").is_none_or(|mirrored| mirrored.value);
    AzimuthalKeys { law, centre, hfov, roll_deg: roll.map_or(0.0, |roll| roll.value), mirrored }
}

/// Whether the elevation of a view's centre is one.
fn centre_elevation(
    reader: &mut ProfileReader,
    section: &Section,
    centre: &Located<[f64; 2]>,
) -> bool {
    let elevation = centre.value[1];
    if (-89.0..=90.0).contains(&elevation) {
        return true;
    }
    let path = section.path_of("centre_deg");
    let message =
        format!("{path} must have an elevation from -89 to 90 degrees, found {elevation}");
    let hint = "90 looks back to the camera, 0 across its axis; no mirror shows what is straight behind it";
    reader.complain(centre.at, message, hint);
    false
}
