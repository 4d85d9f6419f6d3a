//! Numbers of rays by what became of them.

use super::pixel_trace::PixelTrace;
use super::ray_end::Outcome;

/// Numbers of rays aimed at the mirror by outcome.
#[derive(Debug, Clone, Copy, Default)]
pub struct OutcomeCounts {
    /// Rays aimed at the mirror.
    pub aimed: usize,
    /// Of these, reflected into the world.
    pub hit: usize,
    /// Meeting nothing.
    pub missed: usize,
    /// Reflected against the part itself.
    pub shadowed: usize,
    /// Meeting the back of a facet.
    pub back_face: usize,
    /// Hidden by an obstacle.
    pub obstructed: usize,
}

impl OutcomeCounts {
    /// Counts a pixel, if it is aimed.
    #[inline]
    pub(super) fn count(&mut self, pixel: &PixelTrace) {
        if !pixel.aimed {
            return;
        }
        self.aimed += 1;
        match pixel.outcome {
            Outcome::Hit => self.hit += 1,
            Outcome::Missed => self.missed += 1,
            Outcome::Shadowed(_) => self.shadowed += 1,
            Outcome::BackFace => self.back_face += 1,
            Outcome::Obstructed(_) => self.obstructed += 1,
        }
    }

    /// Adds the numbers of others.
    pub(super) fn add(&mut self, other: &Self) {
        self.aimed += other.aimed;
        self.hit += other.hit;
        self.missed += other.missed;
        self.shadowed += other.shadowed;
        self.back_face += other.back_face;
        self.obstructed += other.obstructed;
    }
}
