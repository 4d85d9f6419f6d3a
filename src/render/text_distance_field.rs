//! Short texts as distance fields: sharp and smooth at any size of pixel.

use crate::raster::{BitmapFont, TextBitmap};

const FONT: BitmapFont = BitmapFont::Px10x20;
/// Texels around the ink in which distances are known: the widest halo, and one to interpolate with.
const MARGIN: usize = 6;

/// A text as a field of signed distances from the outline of its ink, in texels of the font.
///
/// Place (0, 0) is the lower left corner of the first digit's cell on the baseline; x grows to the
/// right, y up.
pub(super) struct TextDistanceField {
    columns: usize,
    rows: usize,
    distance: Vec<f32>,
}

impl TextDistanceField {
    /// Draws `text`, a line of printable ASCII.
    #[must_use]
    pub(super) fn new(text: &str) -> Self {
        let (top, cap) = digit_rows();
        let bitmap = TextBitmap::new(text, FONT);
        let columns = bitmap.columns + 2 * MARGIN;
        let rows = cap + 2 * MARGIN;
        let inked = |x: usize, y_up: usize| {
            let (Some(x), Some(y)) = (x.checked_sub(MARGIN), (cap + MARGIN).checked_sub(y_up + 1))
            else {
                return false;
            };
            bitmap.inked(x, top + y)
        };
        let ink: Vec<bool> = (0..rows * columns).map(|i| inked(i % columns, i / columns)).collect();
        let paper: Vec<bool> = ink.iter().map(|&ink| !ink).collect();
        let to_ink = distances(&ink, columns, rows);
        let to_paper = distances(&paper, columns, rows);
        let distance = to_ink
            .iter()
            .zip(&to_paper)
            .map(|(&outside, &inside)| if outside > 0.0 { 0.5 - outside } else { inside - 0.5 })
            .collect();
        Self { columns, rows, distance }
    }

    /// Width of the text in texels.
    #[must_use]
    pub(super) fn width(&self) -> f32 {
        (self.columns - 2 * MARGIN) as f32
    }

    /// Height of a digit in texels.
    #[must_use]
    pub(super) fn height(&self) -> f32 {
        (self.rows - 2 * MARGIN) as f32
    }

    /// Signed distance in texels from the outline, positive in the ink; None where the nearest ink
    /// is out of sight.
    #[must_use]
    pub(super) fn distance(&self, x: f32, y: f32) -> Option<f32> {
        let x = x + (MARGIN as f32 - 0.5);
        let y = y + (MARGIN as f32 - 0.5);
        if !(x >= 0.0 && y >= 0.0) {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        if column + 1 >= self.columns || row + 1 >= self.rows {
            return None;
        }
        let (u, v) = (x - column as f32, y - row as f32);
        let at = row * self.columns + column;
        let [a, b] = [at, at + self.columns]
            .map(|i| self.distance[i] * (1.0 - u) + self.distance[i + 1] * u);
        Some(a * (1.0 - v) + b * v)
    }
}

/// Distance from each texel's centre to the nearest marked one's, at most `MARGIN`.
fn distances(marked: &[bool], columns: usize, rows: usize) -> Vec<f32> {
    let far = MARGIN as i32;
    let mut along = vec![far; marked.len()];
    for y in 0..rows {
        let row = y * columns..(y + 1) * columns;
        let mut sweep = |order: &mut dyn Iterator<Item = usize>| {
            let mut run = far;
            for i in order {
                run = if marked[i] { 0 } else { (run + 1).min(far) };
                along[i] = along[i].min(run);
            }
        };
        sweep(&mut row.clone());
        sweep(&mut row.rev());
    }
    (0..marked.len())
        .map(|i| {
            let (x, y) = (i % columns, i / columns);
            let reach = y.saturating_sub(MARGIN)..(y + MARGIN + 1).min(rows);
            let square = reach
                .map(|other| {
                    let down = other as i32 - y as i32;
                    along[other * columns + x].pow(2) + down.pow(2)
                })
                .fold(far * far, i32::min);
            (square as f32).sqrt()
        })
        .collect()
}

/// First row of a digit's ink in its cell and the count of its rows.
fn digit_rows() -> (usize, usize) {
    let zero = TextBitmap::new("0", FONT);
    let inked_row = |&y: &usize| (0..zero.columns).any(|x| zero.inked(x, y));
    let top = (0..zero.rows).find(inked_row).unwrap_or(0);
    let bottom = (0..zero.rows).rfind(inked_row).unwrap_or(zero.rows - 1);
    (top, bottom + 1 - top)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ink_share(
        label: &TextDistanceField,
        x: std::ops::Range<f32>,
        y: std::ops::Range<f32>,
    ) -> f32 {
        let steps = 60;
        let at = |range: &std::ops::Range<f32>, i: i32| {
            range.start + (range.end - range.start) * (i as f32 + 0.5) / steps as f32
        };
        let inked = (0..steps * steps)
            .filter(|i| {
                label.distance(at(&x, i % steps), at(&y, i / steps)).is_some_and(|d| d > 0.0)
            })
            .count();
        inked as f32 / (steps * steps) as f32
    }

    #[test]
    fn a_seven_stands_upright_and_is_not_mirrored() {
        let seven = TextDistanceField::new("7");
        let (w, h) = (seven.width(), seven.height());
        let bar = ink_share(&seven, 0.0..w, h * 0.85..h);
        let foot = ink_share(&seven, 0.0..w, 0.0..h * 0.15);
        assert!(bar > 1.5 * foot, "bar {bar}, foot {foot}");
        let right = ink_share(&seven, w * 0.5..w, h * 0.55..h * 0.8);
        let left = ink_share(&seven, 0.0..w * 0.5, h * 0.55..h * 0.8);
        assert!(right > 2.0 * left, "right {right}, left {left}");
    }

    #[test]
    fn texts_run_to_the_right() {
        let label = TextDistanceField::new("1-");
        let half = label.width() / 2.0;
        let low = 0.0..label.height() * 0.3;
        assert!(ink_share(&label, 0.0..half, low.clone()) > 0.1);
        assert_eq!(ink_share(&label, half..2.0 * half, low), 0.0);
    }

    #[test]
    fn distance_falls_by_one_a_texel_outside() {
        let label = TextDistanceField::new("1");
        let x = label.width() / 2.0;
        let below = |y: f32| label.distance(x, -y).unwrap();
        assert!((below(1.5) - below(2.5) - 1.0).abs() < 1e-6);
        assert!((below(0.5) + 0.5).abs() < 1e-6);
        assert_eq!(label.distance(x, -(MARGIN as f32)), None);
        assert_eq!(label.distance(f32::NAN, 0.0), None);
    }
}
