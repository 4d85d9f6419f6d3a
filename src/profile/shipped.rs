//! The profiles that come with Morion.

use crate::packed_text::{PackedText, packed_text};
use std::sync::LazyLock;

/// A profile that comes with Morion and can be named without a path.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// Its name.
    pub name: &'static str,
    /// Its text, TOML.
    pub text: &'static str,
}

/// Names and texts of the shipped profiles.
macro_rules! packed {
    ($($name:literal),* $(,)?) => {
        [$(($name, packed_text!(concat!($name, ".toml")))),*]
    };
}
static PACKED: [(&str, PackedText); 24] = packed![
    "panoramic",
    "conquistador",
    "webcam",
    "machine-vision",
    "pi-hq",
    "phone",
    "robot-floor",
    "soccer",
    "side-view",
    "driver",
    "floor",
    "calibrated",
    "dome",
    "four-views",
    "conformal",
    "parabolic",
    "hyperbolic",
    "conical",
    "equiangular",
    "tangent-proportional",
    "area-proportional",
    "plane",
    "equi-areal",
    "cylinder",
];

/// The shipped profiles: the paper's two mirrors, those for cameras that people have, and the mirrors of
/// other papers.
pub fn shipped() -> &'static [Shipped] {
    static SHIPPED: LazyLock<Vec<Shipped>> = LazyLock::new(|| {
        PACKED.iter().map(|(name, text)| Shipped { name, text: text.text() }).collect()
    });
    &SHIPPED
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::Profile;

    #[test]
    fn all_are_valid_and_say_what_they_are() {
        for shipped in shipped() {
            let file = format!("{}.toml", shipped.name);
            match Profile::parse(shipped.name, &file, shipped.text.as_bytes()) {
                Ok(profile) => assert!(!profile.summary.is_empty(), "{file}"),
                Err(complaints) => panic!("{complaints}"),
            }
        }
    }

    #[test]
    fn every_file_in_profiles_is_shipped() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/profiles");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .expect("profiles/ is there")
            .map(|entry| entry.expect("readable").file_name())
            .map(|file| file.to_string_lossy().replace(".toml", ""))
            .collect();
        files.sort();
        let mut names: Vec<&str> = shipped().iter().map(|s| s.name).collect();
        names.sort();
        assert_eq!(files, names);
    }
}
