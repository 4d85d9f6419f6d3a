//! Texts in fixed-width bitmap letters.

use embedded_graphics::Drawable;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle, ascii};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::{DrawTarget, Pixel};
use embedded_graphics::text::{Baseline, Text};
use std::convert::Infallible;

/// Size of the letters, named by columns and rows of a letter's cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BitmapFont {
    /// 7 x 13 pixels.
    Px7x13,
    /// 8 x 13 pixels.
    Px8x13,
    /// 10 x 20 pixels.
    Px10x20,
}

impl BitmapFont {
    fn mono(self) -> &'static MonoFont<'static> {
        match self {
            Self::Px7x13 => &ascii::FONT_7X13,
            Self::Px8x13 => &ascii::FONT_8X13,
            Self::Px10x20 => &ascii::FONT_10X20,
        }
    }

    /// Columns and rows of a letter's cell.
    #[must_use]
    pub fn cell(self) -> [u32; 2] {
        let Size { width, height } = self.mono().character_size;
        [width, height]
    }

    /// Columns and rows of `text`.
    #[must_use]
    pub fn extent(self, text: &str) -> [u32; 2] {
        let [width, height] = self.cell();
        [width * text.chars().count() as u32, height]
    }
}

/// Bitmap of a line of text: which pixels have ink, row by row from the upper left.
pub struct TextBitmap {
    /// Pixels in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    ink: Vec<bool>,
}

impl TextBitmap {
    /// The bitmap of `text`, in which a question mark stands for what is not printable ASCII.
    #[must_use]
    pub fn new(text: &str, font: BitmapFont) -> Self {
        let [columns, rows] = font.extent(text).map(|n| n as usize);
        let mut bitmap = Self { columns, rows, ink: vec![false; columns * rows] };
        let style = MonoTextStyle::new(font.mono(), BinaryColor::On);
        let Ok(_) =
            Text::with_baseline(text, Point::zero(), style, Baseline::Top).draw(&mut bitmap);
        bitmap
    }

    /// Whether there is ink at column `x` and row `y`; none beyond the edges.
    #[must_use]
    pub fn inked(&self, x: usize, y: usize) -> bool {
        x < self.columns && self.ink.get(y * self.columns + x).copied().unwrap_or(false)
    }

    /// Column and row of each pixel with ink.
    pub fn inked_pixels(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let inked = self.ink.iter().enumerate().filter(|(_, ink)| **ink);
        inked.map(|(k, _)| [k % self.columns, k / self.columns])
    }
}

impl OriginDimensions for TextBitmap {
    fn size(&self) -> Size {
        Size::new(self.columns as u32, self.rows as u32)
    }
}

impl DrawTarget for TextBitmap {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Infallible> {
        for Pixel(Point { x, y }, colour) in pixels {
            if let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y))
                && x < self.columns
                && let Some(ink) = self.ink.get_mut(y * self.columns + x)
            {
                *ink = colour.is_on();
            }
        }
        Ok(())
    }
}
