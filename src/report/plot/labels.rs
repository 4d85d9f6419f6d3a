//! Labels beside what they name, none over another.

use super::diagram::{Anchor, Diagram, Ink, LETTER, text_width};
use crate::geom::DVec2;

/// Room between labels, units.
const GAP: f64 = 1.0;
/// Height of a letter above its base line, units.
const ASCENT: f64 = 10.0;

/// What labels keep clear of.
#[derive(Debug, Clone, Default)]
pub(super) struct Labels {
    /// Corners of earlier labels.
    taken: Vec<[DVec2; 2]>,
    /// Ends of upright and level lines, from the upper left.
    lines: Vec<[DVec2; 2]>,
}

impl Labels {
    /// Writes `text` at the first of some places that is inside the diagram and clear of all earlier labels, and of
    /// lines if there is such a place; nothing where none is.
    pub(super) fn write(
        &mut self,
        diagram: &mut Diagram,
        (ink, text): (Ink, &str),
        places: impl IntoIterator<Item = (DVec2, Anchor)>,
    ) {
        let size = diagram.size;
        let free = places.into_iter().filter_map(|(at, anchor)| {
            let extent = extent(at, anchor, text);
            let is_inside = extent[0].cmpge(DVec2::ZERO).all() && extent[1].cmple(size).all();
            let is_free = is_inside && !self.taken.iter().any(|taken| overlap(*taken, extent));
            is_free.then_some((at, anchor, extent))
        });
        let free: Vec<_> = free.collect();
        let is_clear = |place: &&(DVec2, Anchor, [DVec2; 2])| {
            !self.lines.iter().any(|line| overlap(*line, place.2))
        };
        if let Some(&(at, anchor, extent)) = free.iter().find(is_clear).or(free.first()) {
            self.taken.push(extent);
            diagram.text(ink, at, anchor, text);
        }
    }

    /// Lets labels keep clear of an upright or level line, if they can.
    pub(super) fn add_line(&mut self, ends: [DVec2; 2]) {
        self.lines.push(ends);
    }
}

fn overlap(a: [DVec2; 2], b: [DVec2; 2]) -> bool {
    a[0].cmplt(b[1] + GAP).all() && b[0].cmplt(a[1] + GAP).all()
}

/// Upper left and lower right corner of a text.
pub(super) fn extent(at: DVec2, anchor: Anchor, text: &str) -> [DVec2; 2] {
    let width = text_width(text);
    let corner = at - DVec2::new(anchor.share() * width, ASCENT);
    [corner, corner + DVec2::new(width, LETTER[1])]
}

#[cfg(test)]
mod tests {
    use super::super::diagram::Mark;
    use super::*;

    #[test]
    fn labels_never_overlap_nor_leave_the_picture() {
        let mut diagram = Diagram::new(200.0, 100.0);
        let mut labels = Labels::default();
        for k in 0..60 {
            let at = |row: i32| {
                let y = 12.0 + 15.0 * f64::from(row);
                (DVec2::new(f64::from(7 * k % 50) * 5.0 - 20.0, y), Anchor::Middle)
            };
            labels.write(&mut diagram, (Ink::Text, &format!("label {k}")), (0..9).map(at));
        }
        let extents: Vec<[DVec2; 2]> = diagram
            .marks
            .iter()
            .map(|mark| match mark {
                Mark::Text { at, anchor, text, .. } => extent(*at, *anchor, text),
                _ => unreachable!(),
            })
            .collect();
        assert!(extents.len() > 10);
        for (k, a) in extents.iter().enumerate() {
            assert!(a[0].cmpge(DVec2::ZERO).all() && a[1].cmple(diagram.size).all());
            for b in &extents[..k] {
                assert!(!overlap(*a, *b), "{a:?} {b:?}");
            }
        }
    }
}
