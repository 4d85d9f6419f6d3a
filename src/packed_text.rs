//! Texts that the build packs: large ones of which a run needs few.

use flate2::read::ZlibDecoder;
use std::io::Read;
use std::sync::OnceLock;

/// A text that is unpacked when it is asked for first; made by `packed_text!`.
#[derive(Debug)]
pub(crate) struct PackedText {
    packed: &'static [u8],
    text: OnceLock<String>,
}

/// The [`PackedText`] of a file that `build.rs` lists.
macro_rules! packed_text {
    ($name:expr) => {
        $crate::packed_text::PackedText::new(include_bytes!(concat!(env!("OUT_DIR"), "/", $name)))
    };
}
pub(crate) use packed_text;

impl PackedText {
    /// The text of these bytes, of `build.rs`.
    pub(crate) const fn new(packed: &'static [u8]) -> Self {
        Self { packed, text: OnceLock::new() }
    }

    /// The text.
    pub(crate) fn text(&self) -> &str {
        self.text.get_or_init(|| {
            let mut text = String::new();
            let read = ZlibDecoder::new(self.packed).read_to_string(&mut text);
            read.expect("the build packed it");
            text
        })
    }
}
