//! The part to turn by WebGL, and a still picture of it where there is none and on paper.

use super::{Figure, image};
use crate::packed_text::{PackedText, packed_text};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;

/// What is used of three.js; see `assets/three`.
pub(crate) static THREE: PackedText = packed_text!("three.min.js");
/// The viewer.
pub(crate) const VIEWER: &str = include_str!("assets/viewer.js");

/// What `glb`, a file in that format, has, to be turned; `still` is a PNG of it, and `made` its name and size in words.
pub(in crate::report) fn part_figure(glb: &[u8], still: &[u8], made: &str) -> Figure {
    let still =
        image(still, "still", "The part seen from above and to the right of the picture's foot");
    let (three, glb) = (THREE.text(), BASE64_STANDARD.encode(glb));
    let body = format!(
        "<div id=\"part3d\" class=\"part3d\">{still}</div>\n\
         <script id=\"part-glb\" type=\"application/octet-stream\">{glb}</script>\n\
         <script>/*! three.js, (c) three.js authors, MIT licence */\n{three}</script>\n<script>\n{VIEWER}</script>"
    );
    let caption = format!(
        "The {made}. Drag, or use the arrow keys, to turn it; wheel, pinch, + and - bring it nearer or \
         farther; Home brings it back. Drawn with fewer facets than the files have."
    );
    Figure { title: "Part".into(), body, caption }
}
