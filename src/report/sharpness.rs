//! How sharp a picture can be, in reports.

use super::answer::{AnswerRows, ToRows};
use crate::results::{ApertureFacts, SharpnessFacts, three_digits};

/// Sharpness in plain words.
pub(crate) struct PlainSharpness<'a>(pub &'a SharpnessFacts);

impl ToRows for PlainSharpness<'_> {
    fn add_to(&self, rows: &mut AnswerRows) {
        let through = |facts: &ApertureFacts| {
            let ApertureFacts { sharp, resolved: [across, up], .. } = facts;
            let (lens, spot) = (facts.lens(), three_digits(sharp.spot_px));
            format!("through {lens}: spots of {spot} px, some {across} x {up} of them")
        };
        rows.terminal("sharp", format!("best {}", through(&self.0.best)));
        if let Some(given) = &self.0.given {
            rows.terminal("", through(given));
        }
    }
}

impl ToRows for SharpnessFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        rows.terminal("sharp", format!("best through {}", self.best.line()));
        rows.page("sharpest", self.best.line());
        if let Some(given) = &self.given {
            rows.terminal("", format!("through {}", given.line()));
            rows.page("through the lens", given.line());
        }
    }
}

impl SharpnessFacts {
    /// Spots longer than this, px, leave pixels unused.
    const RESOLVED: f64 = 3.0;

    /// What to know of a mirror under which no aperture resolves the pixels.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let ApertureFacts { sharp, resolved: [across, up], .. } = self.best;
        (sharp.spot_px > Self::RESOLVED).then(|| {
            format!(
                "no aperture resolves the pixels: through {}, the best one, spots are {} px long (p95), \
                 about {across} x {up} of them; a mirror four times as large has spots half as long",
                self.best.lens(),
                three_digits(sharp.spot_px)
            )
        })
    }
}
