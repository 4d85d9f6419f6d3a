//! The drawing library's raster backend: what it draws lands on a [`Canvas`].

use crate::raster::{BitmapFont, Canvas, TextBitmap};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontTransform,
};
use std::convert::Infallible;

/// Letters whose cells are about as high as is asked.
const FONTS: [BitmapFont; 3] = [BitmapFont::Px7x13, BitmapFont::Px9x15, BitmapFont::Px10x20];

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for &mut Canvas {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size()
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Drawn {
        let (red, green, blue) = color.rgb;
        self.blend(x, y, [red, green, blue], color.alpha);
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn {
        let bitmap = TextBitmap::new(text, font(style.size()));
        let (wide, high) = (bitmap.columns as i32, bitmap.rows as i32);
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
        for [column, row] in bitmap.inked_pixels() {
            let (x, y) = turned((column as i32, row as i32));
            self.draw_pixel((at.0 + x - anchor.0, at.1 + y - anchor.1), style.color())?;
        }
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        Ok(font(style.size()).extent(text).into())
    }
}

fn font(size: f64) -> BitmapFont {
    // A letter of 13 pixels is drawn in a cell of that height.
    let high = |font: &BitmapFont| f64::from(font.cell()[1]) <= size.max(13.0);
    FONTS.into_iter().rev().find(high).unwrap_or(FONTS[0])
}
