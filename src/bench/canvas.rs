//! A sheet of pixels that drawings with axes are drawn on: the raster counterpart of their SVG.

use crate::raster::{EncodingError, png};
use embedded_graphics::Drawable;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle, ascii};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::prelude::{DrawTarget, Pixel};
use embedded_graphics::text::{Baseline, Text};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontTransform,
};
use std::convert::Infallible;

/// Letters whose cells are about as high as is asked.
const FONTS: [&MonoFont; 3] = [&ascii::FONT_7X13, &ascii::FONT_9X15, &ascii::FONT_10X20];

/// A canvas of pixels, white at first.
pub struct RasterCanvas {
    size: (u32, u32),
    rgb: Vec<u8>,
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl RasterCanvas {
    /// Columns and rows.
    pub fn new(size: (u32, u32)) -> Self {
        Self { size, rgb: vec![255; 3 * size.0 as usize * size.1 as usize] }
    }

    /// What is on it.
    pub fn png(&self) -> Result<Vec<u8>, EncodingError> {
        png::encode(self.size.0, self.size.1, &self.rgb)
    }

    /// Where a pixel's bytes begin, if it is on it.
    fn at(&self, (x, y): BackendCoord) -> Option<usize> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        let (width, height) = self.size;
        (x < width && y < height).then(|| 3 * (y as usize * width as usize + x as usize))
    }
}

impl DrawingBackend for &mut RasterCanvas {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Drawn {
        let Some(at) = self.at(point) else { return Ok(()) };
        let (red, green, blue) = color.rgb;
        for (under, over) in self.rgb[at..at + 3].iter_mut().zip([red, green, blue]) {
            let mixed = f64::from(*under) * (1.0 - color.alpha) + f64::from(over) * color.alpha;
            *under = mixed.round() as u8;
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn {
        let font = font(style.size());
        let ((width, height), color) = (extent(text, font), style.color());
        let mut letters = Letters { size: Size::new(width, height), inked: Vec::new() };
        let ink = MonoTextStyle::new(font, Rgb888::BLACK);
        let Ok(_) = Text::with_baseline(text, Point::zero(), ink, Baseline::Top).draw(&mut letters);
        let (wide, high) = (width as i32, height as i32);
        let turned = |(x, y): BackendCoord| match style.transform() {
            FontTransform::None => (x, y),
            FontTransform::Rotate90 => (high - 1 - y, x),
            FontTransform::Rotate180 => (wide - 1 - x, high - 1 - y),
            FontTransform::Rotate270 => (y, wide - 1 - x),
        };
        // Anchors are of the text as it reads; turned, its width lies along Y.
        let left = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => wide / 2,
            HPos::Right => wide,
        };
        let top = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => high / 2,
            VPos::Bottom => high,
        };
        let anchor = turned((left, top));
        for inked in letters.inked {
            let (x, y) = turned(inked);
            self.draw_pixel((at.0 + x - anchor.0, at.1 + y - anchor.1), color)?;
        }
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        Ok(extent(text, font(style.size())))
    }
}

fn font(size: f64) -> &'static MonoFont<'static> {
    // A letter of 13 pixels is drawn in a cell of that height.
    let high = |font: &&&MonoFont| f64::from(font.character_size.height) <= size.max(13.0);
    FONTS.iter().rev().find(high).copied().unwrap_or(FONTS[0])
}

fn extent(text: &str, font: &MonoFont) -> (u32, u32) {
    let Size { width, height } = font.character_size;
    (width * text.chars().count() as u32, height)
}

/// The pixels of a text.
struct Letters {
    size: Size,
    inked: Vec<BackendCoord>,
}

impl OriginDimensions for Letters {
    fn size(&self) -> Size {
        self.size
    }
}

impl DrawTarget for Letters {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Infallible> {
        self.inked.extend(pixels.into_iter().map(|Pixel(at, _)| (at.x, at.y)));
        Ok(())
    }
}
