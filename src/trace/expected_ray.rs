//! What the witness is told to expect of a camera ray.

use crate::geom::DVec3;
use crate::optics::ShownContent;

/// Expected reflection of one camera ray: an entry of the table that the witness is handed.
#[derive(Debug, Clone, Copy)]
pub struct ExpectedRay {
    /// Whether the designed mirror is under the ray.
    pub aimed: bool,
    /// Unit direction that the projection wants it to see.
    pub direction: DVec3,
    /// What the smooth, designed mirror shows.
    pub designed: ShownContent,
}
