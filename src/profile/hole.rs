//! Holes with a table of their own, and whether they fit into the part.

use super::PartSpec;
use super::border::{
    BorderConflict, BorderFeature, BorderSpec, extent_text, is_in_land, is_tight, overlap, rim,
    too_close,
};
use crate::geom::{BlindHole, DVec2, Drilled, Hole, HoleBottom, Outline};

/// A hole, and where the profile has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoleSpec {
    /// Its mouth and its cylinder.
    pub hole: Hole,
    /// Depth of the cylinder, mm, and its ground; none of a through hole.
    pub blind: Option<(f64, HoleBottom)>,
    /// Line and column of its place, from 1.
    pub place: (usize, usize),
}

impl HoleSpec {
    /// Least material between a blind hole and the surface above it, and over a counterbore, mm: two threads of M3, what
    /// drills that run on by some tenths leave, and what printers need for three walls of 0.4 mm but for a fifth.
    pub const LEAST_WALL_MM: f64 = 1.0;

    /// The blind hole; none of a through hole.
    #[must_use]
    pub fn blind(&self) -> Option<BlindHole> {
        self.blind.map(|(depth_mm, bottom)| BlindHole { hole: self.hole, depth_mm, bottom })
    }

    /// Its mouth in the base, as wide as it is anywhere.
    fn spot(&self) -> Drilled {
        Drilled { at: self.hole.at, diameter_mm: 2.0 * self.hole.mouth_radius() }
    }

    /// Why a through hole that ends at `top_mm` has no room for its counterbore or its chamfers, and the height at which
    /// it has.
    #[must_use]
    pub fn shallow(&self, top_mm: f64) -> Option<(String, f64)> {
        let Hole { counterbore, chamfer_mm, at, .. } = self.hole;
        let (what, left) = match counterbore {
            Some(counterbore) => {
                (format!("a counterbore {} mm deep", counterbore.depth_mm), Self::LEAST_WALL_MM)
            }
            None if chamfer_mm > 0.0 => {
                (format!("chamfers of {chamfer_mm} mm"), BorderSpec::CLEAR_MM)
            }
            None => return None,
        };
        let least = self.hole.mouth_depth_mm() + chamfer_mm + left;
        let message = format!(
            "the through hole at [{}, {}] must leave {left} mm beside its mouths, found {what} in \
             {top_mm:.3} mm of material",
            at.x, at.y
        );
        (!(least <= top_mm + BorderSpec::ROUNDING_MM)).then_some((message, least))
    }
}

impl PartSpec {
    /// Everything that does not fit around and below a mirror with this outline, a rectangle or a ring about the axis, but
    /// for what the mirror's heights decide.
    #[must_use]
    pub fn conflicts(&self, mirror: &Outline) -> Vec<BorderConflict> {
        let border = self.border.as_ref();
        let mut conflicts = border.map_or_else(Vec::new, |border| border.conflicts(mirror));
        if conflicts.iter().any(|conflict| conflict.feature == BorderFeature::Edges) {
            return conflicts;
        }
        let mut before: Vec<(BorderFeature, Drilled)> = Vec::new();
        if let Some(border) = border {
            let holes = border.holes.iter().enumerate();
            before.extend(holes.map(|(k, spot)| (BorderFeature::Hole(k), *spot)));
            let marks = border.marks.iter().enumerate();
            before.extend(marks.map(|(k, spot)| (BorderFeature::Mark(k), *spot)));
        }
        for (k, spec) in self.holes.iter().enumerate() {
            let feature = BorderFeature::Drilling(k);
            let others: Vec<(BorderFeature, &Drilled)> =
                before.iter().map(|(feature, spot)| (*feature, spot)).collect();
            conflicts.extend(match (spec.blind(), border) {
                (None, None) => Some(without_rim(feature, spec.hole.at)),
                (None, Some(border)) => border
                    .misplaced(mirror, &others, feature, &spec.spot())
                    .or_else(|| no_room(border, mirror, feature, spec)),
                (Some(blind), _) => self.blind_conflict(mirror, &others, (feature, spec), &blind),
            });
            before.push((feature, spec.spot()));
        }
        conflicts
    }

    /// The conflict of a blind hole with the part's side, with other features or with the flat rim above it.
    fn blind_conflict(
        &self,
        mirror: &Outline,
        before: &[(BorderFeature, &Drilled)],
        (feature, spec): (BorderFeature, &HoleSpec),
        blind: &BlindHole,
    ) -> Option<BorderConflict> {
        let spot = spec.spot();
        let (flat, [edge, reaches]) = match &self.border {
            Some(border) => (border.flat_contour(mirror), border.edge_words()),
            None => (rim(mirror), ["the part's side", "the part reaches"]),
        };
        let gap = flat.inset(spot.at) - spot.radius();
        if is_tight(gap) {
            let hint = format!(
                "{reaches} {}; move the hole inwards or make it smaller",
                extent_text(&flat)
            );
            return Some(too_close(feature, &spot, edge, gap, hint));
        }
        let overlapped =
            before.iter().find_map(|(other, there)| overlap((feature, &spot), (*other, there)));
        overlapped.or_else(|| {
            let border = self.border.as_ref()?;
            let is_below = rim(mirror).inset(spot.at) - spot.radius() < HoleSpec::LEAST_WALL_MM;
            is_below.then(|| under_rim(border.rim_mm, feature, blind)).flatten()
        })
    }
}

/// The conflict of a through hole of a part without a flat rim.
fn without_rim(feature: BorderFeature, at: DVec2) -> BorderConflict {
    BorderConflict {
        feature,
        message: format!(
            "hole.depth_mm must be given in a part without a flat rim, found the through hole \
             [{}, {}], which would go through the mirror",
            at.x, at.y
        ),
        hint: "a hole with depth_mm is drilled from the base; part.border_mm = 8 puts a flat rim \
               around the mirror"
            .to_owned(),
    }
}

/// The conflict of a through hole's counterbore or chamfers with the flat rim.
fn no_room(
    border: &BorderSpec,
    mirror: &Outline,
    feature: BorderFeature,
    spec: &HoleSpec,
) -> Option<BorderConflict> {
    // (How high a land is, the design tells.)
    let drilled = !is_in_land(mirror, spec.hole.at);
    let (message, least) = drilled.then(|| spec.shallow(border.rim_mm)).flatten()?;
    let hint = format!("set part.rim_mm = {least:.3} or more, or leave the counterbore out");
    Some(BorderConflict { feature, message, hint })
}

/// The conflict of a blind hole with the flat rim above it.
pub fn under_rim(rim_mm: f64, feature: BorderFeature, blind: &BlindHole) -> Option<BorderConflict> {
    let (left, at) = (rim_mm - blind.tip_mm(), blind.hole.at);
    if left >= HoleSpec::LEAST_WALL_MM - BorderSpec::ROUNDING_MM {
        return None;
    }
    let message = format!(
        "the blind hole at [{}, {}] must leave {} mm under the flat rim, found {left:.3} mm over its \
         ground at Z {:.3} mm",
        at.x,
        at.y,
        HoleSpec::LEAST_WALL_MM,
        blind.tip_mm()
    );
    let hint = format!(
        "set part.rim_mm = {:.3} or more, or drill less deep",
        blind.tip_mm() + HoleSpec::LEAST_WALL_MM + 5e-4
    );
    Some(BorderConflict { feature, message, hint })
}
