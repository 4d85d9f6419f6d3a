//! Slopes of a face as a program cuts it, where facets do not follow its cusps.

use crate::geom::DVec2;
use crate::program::{SweptCutter, TurnedSlopes};
use crate::trace::FaceSlopes;

/// What tells the slopes of a cut.
#[derive(Debug)]
pub(super) enum SlopeSource {
    /// The lowest ball of a mill over a place.
    Milled(SweptCutter),
    /// The lowest nose of a lathe.
    Turned(TurnedSlopes),
}

/// Slopes of the first facets of a part as cut, which are its face.
#[derive(Debug)]
pub(crate) struct CutSlopes {
    source: SlopeSource,
    facets: u32,
}

impl CutSlopes {
    /// Those of so many facets.
    pub(super) fn new(source: SlopeSource, facets: usize) -> Self {
        Self { source, facets: facets as u32 }
    }
}

impl FaceSlopes for CutSlopes {
    fn slope_on(&self, facet: u32, at: DVec2) -> Option<DVec2> {
        if facet >= self.facets {
            return None;
        }
        match &self.source {
            SlopeSource::Milled(swept) => Some(swept.lowest(at)?.slope),
            SlopeSource::Turned(slopes) => slopes.slope_over(at),
        }
    }
}
