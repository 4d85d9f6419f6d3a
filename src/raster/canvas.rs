//! A canvas for diagrams: rectangles and texts on 8-bit sRGB pixels.

use super::text::{BitmapFont, TextBitmap};
use super::{EncodingError, png};

/// Red, green and blue, 8-bit sRGB.
pub type Srgb = [u8; 3];

/// Pixels in 8-bit sRGB, row by row from the upper left; white at first. What is drawn beyond the edges is
/// left out.
pub struct Canvas {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Canvas {
    /// A white canvas.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, rgb: vec![255; 3 * width as usize * height as usize] }
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Mixes `colour` into a pixel by `alpha`, from 0 (nothing changes) to 1 (only `colour` is seen).
    pub fn blend(&mut self, x: i32, y: i32, colour: Srgb, alpha: f64) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
        if x >= self.width || y >= self.height {
            return;
        }
        let at = 3 * (y as usize * self.width as usize + x as usize);
        for (under, over) in self.rgb[at..at + 3].iter_mut().zip(colour) {
            let mixed = f64::from(*under) * (1.0 - alpha) + f64::from(over) * alpha;
            *under = mixed.round() as u8;
        }
    }

    /// Fills the rectangle of these columns and rows, whose upper left pixel is (`x`, `y`).
    pub fn fill(&mut self, x: u32, y: u32, [columns, rows]: [u32; 2], colour: Srgb) {
        let end = |from: u32, count: u32, edge: u32| from.saturating_add(count).min(edge) as usize;
        let (right, bottom) = (end(x, columns, self.width), end(y, rows, self.height));
        for row in y as usize..bottom {
            let line = &mut self.rgb[3 * row * self.width as usize..][..3 * self.width as usize];
            if let Some(part) = line.get_mut(3 * x as usize..3 * right) {
                part.chunks_exact_mut(3).for_each(|pixel| pixel.copy_from_slice(&colour));
            }
        }
    }

    /// Writes `text` in letters whose dots are squares of so many pixels; (`x`, `y`) is the upper left pixel of its
    /// first letter's cell.
    pub fn write(
        &mut self,
        [x, y]: [u32; 2],
        text: &str,
        (font, dot, colour): (BitmapFont, u32, Srgb),
    ) {
        for place in TextBitmap::new(text, font).inked_pixels() {
            let [column, row] = place.map(|n| dot * n as u32);
            self.fill(x + column, y + row, [dot; 2], colour);
        }
    }

    /// The canvas as a PNG file.
    ///
    /// # Errors
    /// A canvas without pixels cannot be encoded.
    pub fn png(&self) -> Result<Vec<u8>, EncodingError> {
        png::encode(self.width, self.height, &self.rgb)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_drawn_beyond_the_edges_is_left_out() {
        let mut canvas = Canvas::new(4, 3);
        canvas.fill(3, 2, [9, 9], [1, 2, 3]);
        canvas.fill(7, 0, [1, 1], [0; 3]);
        canvas.blend(-1, 0, [0; 3], 1.0);
        canvas.blend(4, 0, [0; 3], 1.0);
        canvas.blend(0, 0, [0, 255, 100], 0.5);
        canvas.write([3, 2], "M", (BitmapFont::Px7x13, 1, [0; 3]));
        let (pixels, _) = canvas.rgb.as_chunks::<3>();
        assert_eq!((pixels[0], pixels[11]), ([128, 255, 178], [1, 2, 3]));
        assert!(pixels[1..11].iter().all(|pixel| *pixel == [255; 3]));
    }
}
