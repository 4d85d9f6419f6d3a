//! Files: solid -> STL and OBJ bytes, and the bytes of any such file -> triangles.

mod obj;
mod read;
mod stl;

pub use obj::write_obj;
pub use read::{ReadError, Reread, read_obj, read_stl};
pub use stl::write_stl;

/// What every file says about itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// Profile name.
    pub profile: String,
    /// SHA-256 of the profile, hexadecimal.
    pub sha256: String,
    /// Tolerances asked for and reached, on one line.
    pub tolerances: String,
}

impl Label {
    /// `text` with everything but printable ASCII replaced: headers and comments end at a newline.
    fn plain(text: &str) -> String {
        text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
    }
}
