//! The foot of the walls below a mirror.

/// Where the walls below a fitted mirror end, seen from above.
#[derive(Debug, Clone, Copy)]
pub(super) enum WallFoot {
    /// Straight below.
    Below,
    /// Outwards by so many mm for each mm from the plane of the foot: square to the sides of a rectangle, and to both at its
    /// corners, or along the radius.
    Drafted(f64),
}
