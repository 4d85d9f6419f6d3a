//! What a part has around its mirror: a flat rim to clamp it by, holes, marks.

use super::DVec2;

/// Material around the mirror, in the part frame, mm. Seen from above it lies between the mirror's
/// rim and the contour; its flat top is below the mirror's lowest point, so that a vertical wall
/// goes all around the mirror.
#[derive(Debug, Clone, PartialEq)]
pub struct Stock {
    /// The part's outer side, a vertical wall.
    pub contour: Contour,
    /// Z of the flat top, positive.
    pub top_mm: f64,
    /// Through holes, from the base to the flat top.
    pub holes: Vec<Drilled>,
    /// Conical dimples of 90 degrees in the flat top: half as deep as wide.
    pub marks: Vec<Drilled>,
}

/// A contour about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contour {
    /// A rectangle.
    Rect {
        /// Half its width and half its height.
        half: DVec2,
        /// The radius that its corners are rounded with; 0 for sharp ones.
        corner_mm: f64,
    },
    /// A circle.
    Circle {
        /// Its radius.
        radius_mm: f64,
    },
}

/// A round feature in the flat top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drilled {
    /// X and Y of its centre.
    pub at: DVec2,
    /// Its diameter in the flat top.
    pub diameter_mm: f64,
}
