//! Pictures of a figure over the sensor, with a scale and a key.

use crate::raster::{EncodingError, png};
use embedded_graphics::Drawable;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::{MonoTextStyle, ascii::FONT_8X13};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::prelude::{DrawTarget, Pixel};
use embedded_graphics::primitives::Rectangle;
use embedded_graphics::text::{Baseline, Text};
use std::convert::Infallible;

/// Red, green and blue, sRGB.
pub type Colour = [u8; 3];

/// Pixels that the picture is wide at the least: the sensor's pixels become squares of more.
const WIDTH: u32 = 640;
/// But no higher for that: a sensor may be one pixel wide.
const HEIGHT: u32 = 2048;
const MARGIN: u32 = 10;
/// A character's cell, and a line of the key.
const CELL: Size = Size::new(8, 13);
const LINE: u32 = 22;
const BAR: Size = Size::new(256, 14);

/// A colour a pixel of the sensor, and what the colours mean.
#[derive(Debug, Clone)]
pub struct Map {
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// Row by row from the upper left; one a pixel.
    pub colours: Vec<Colour>,
    /// What the scale is of.
    pub title: String,
    /// The scale from its lower to its upper end.
    pub ramp: fn(f64) -> Colour,
    /// The texts under the scale, evenly spaced from its lower to its upper end.
    pub ticks: Vec<String>,
    /// Further colours.
    pub keys: Vec<(Colour, String)>,
}

impl Map {
    /// The picture: the sensor, below it the scale and the key.
    ///
    /// # Errors
    /// What the encoder reports.
    ///
    /// # Panics
    /// When there is not one colour a pixel.
    pub fn png(&self) -> Result<Vec<u8>, EncodingError> {
        self.drawn(None)
    }

    /// The same of a part, with a bar of a round length: a pixel is `pixel_mm` wide.
    ///
    /// # Errors
    /// What the encoder reports.
    ///
    /// # Panics
    /// When there is not one colour a pixel.
    pub fn png_to_scale(&self, pixel_mm: f64) -> Result<Vec<u8>, EncodingError> {
        self.drawn(Some(pixel_mm))
    }

    fn drawn(&self, pixel_mm: Option<f64>) -> Result<Vec<u8>, EncodingError> {
        let [width, height] = self.pixels;
        assert_eq!(self.colours.len(), width as usize * height as usize, "one colour a pixel");
        let zoom = WIDTH.div_ceil(width).min(HEIGHT / height.max(1)).max(1);
        let across = (zoom * width).max(WIDTH);
        let places = self.key_places(across);
        let key_lines = places.last().map_or(0, |place| place.1 + 1);
        let foot = 2 * MARGIN + LINE * (2 + key_lines);
        let mut sheet = Sheet::new(across, zoom * height + foot);
        let left = (across - zoom * width) / 2;
        for (k, colour) in self.colours.iter().enumerate() {
            let (x, y) = (k as u32 % width, k as u32 / width);
            sheet.fill(left + zoom * x, zoom * y, Size::new(zoom, zoom), *colour);
        }
        let top = zoom * height + MARGIN;
        self.scale(&mut sheet, top);
        if let Some(pixel_mm) = pixel_mm {
            // Beside the ticks, below the title.
            let (x, y) = (2 * MARGIN + CELL.width * 8 + BAR.width, top + BAR.height + 10);
            sheet.length(x, y, pixel_mm / f64::from(zoom));
        }
        for ((colour, text), (x, line)) in self.keys.iter().zip(places) {
            let y = top + LINE * (2 + line);
            sheet.fill(x, y, Size::new(BAR.height, BAR.height), [0; 3]);
            sheet.fill(x + 1, y + 1, Size::new(BAR.height - 2, BAR.height - 2), *colour);
            sheet.write(x + BAR.height + 6, y, text);
        }
        png::encode(sheet.width, sheet.height, &sheet.rgb)
    }

    fn scale(&self, sheet: &mut Sheet, top: u32) {
        let middle = BAR.width / 2;
        let at = |k: u32| f64::from(k) / f64::from(BAR.width - 1);
        let left = MARGIN + CELL.width * 4;
        for k in 0..BAR.width {
            sheet.fill(left + k, top, Size::new(1, BAR.height), (self.ramp)(at(k)));
        }
        sheet.write(left + BAR.width + MARGIN, top, &self.title);
        let steps = (self.ticks.len() as u32).saturating_sub(1).max(1);
        for (k, text) in (0..).zip(&self.ticks) {
            let x = if self.ticks.len() == 1 { middle } else { k * (BAR.width - 1) / steps };
            sheet.fill(left + x, top + BAR.height, Size::new(1, 3), [0; 3]);
            let half = CELL.width * text.len() as u32 / 2;
            sheet.write((left + x).saturating_sub(half), top + BAR.height + 4, text);
        }
    }

    /// Where each entry of the key begins, and on which line.
    fn key_places(&self, across: u32) -> Vec<(u32, u32)> {
        let (mut x, mut line) = (MARGIN, 0);
        let place = |(_, text): &(Colour, String)| {
            let wide = BAR.height + 6 + CELL.width * text.len() as u32 + 2 * MARGIN;
            if x > MARGIN && x + wide > across {
                (x, line) = (MARGIN, line + 1);
            }
            let place = (x, line);
            x += wide;
            place
        };
        self.keys.iter().map(place).collect()
    }
}

/// From black to white, without either end: the colours of what is lost stand out.
#[must_use]
pub fn grey(share: f64) -> Colour {
    [(50.0 + 195.0 * share.clamp(0.0, 1.0)).round() as u8; 3]
}

/// From dark blue over green to yellow: ever brighter (the corners of matplotlib's viridis).
#[must_use]
pub fn viridis(share: f64) -> Colour {
    const CORNERS: [Colour; 5] =
        [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
    between(&CORNERS, share)
}

/// From blue over white to red, for departures: ColorBrewer's RdBu, which the colour-blind can read.
#[must_use]
pub fn diverging(share: f64) -> Colour {
    const CORNERS: [Colour; 9] = [
        [33, 102, 172],
        [67, 147, 195],
        [146, 197, 222],
        [209, 229, 240],
        [247, 247, 247],
        [253, 219, 199],
        [244, 165, 130],
        [214, 96, 77],
        [178, 24, 43],
    ];
    between(&CORNERS, share)
}

/// The colour at a share of the way along evenly spaced ones.
fn between(corners: &[Colour], share: f64) -> Colour {
    let along = share.clamp(0.0, 1.0) * (corners.len() - 1) as f64;
    let k = (along as usize).min(corners.len() - 2);
    let rest = along - k as f64;
    [0, 1, 2].map(|c| {
        let [a, b] = [corners[k], corners[k + 1]].map(|corner| f64::from(corner[c]));
        (a * (1.0 - rest) + b * rest).round() as u8
    })
}

/// White paper to draw on.
struct Sheet {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Sheet {
    fn new(width: u32, height: u32) -> Self {
        Self { width, height, rgb: vec![255; 3 * width as usize * height as usize] }
    }

    fn fill(&mut self, x: u32, y: u32, size: Size, colour: Colour) {
        let area = Rectangle::new(Point::new(x as i32, y as i32), size);
        let [r, g, b] = colour;
        let Ok(()) = self.fill_solid(&area, Rgb888::new(r, g, b));
    }

    fn write(&mut self, x: u32, y: u32, text: &str) {
        let style = MonoTextStyle::new(&FONT_8X13, Rgb888::BLACK);
        let at = Point::new(x as i32, y as i32);
        let Ok(_) = Text::with_baseline(text, at, style, Baseline::Top).draw(self);
    }
}

/// Longest bar of a length, dots.
const LENGTH: f64 = 160.0;

impl Sheet {
    /// A bar of a round length from (`x`, `y`), where a dot is `dot_mm` wide.
    fn length(&mut self, x: u32, y: u32, dot_mm: f64) {
        let length = round_length(LENGTH * dot_mm);
        let dots = (length / dot_mm).round() as u32;
        self.fill(x, y, Size::new(dots, 2), [0; 3]);
        for x in [x, x + dots - 2] {
            self.fill(x, y - 4, Size::new(2, 10), [0; 3]);
        }
        self.write(x + dots + MARGIN, y - 6, &format!("{length} mm"));
    }
}

/// The largest of 1, 2 and 5 times a power of ten that is no more than `most`.
fn round_length(most: f64) -> f64 {
    let round = |k: i32| format!("{}e{}", [1, 2, 5][k.rem_euclid(3) as usize], k.div_euclid(3));
    let all = (-18..18).rev().filter_map(|k| round(k).parse().ok());
    all.into_iter().find(|length: &f64| *length <= most).unwrap_or(most)
}

impl OriginDimensions for Sheet {
    fn size(&self) -> Size {
        Size::new(self.width, self.height)
    }
}

impl DrawTarget for Sheet {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I>(&mut self, pixels: I) -> Result<(), Infallible>
    where
        I: IntoIterator<Item = Pixel<Rgb888>>,
    {
        for Pixel(Point { x, y }, colour) in pixels {
            let inside = x >= 0 && y >= 0 && x < self.width as i32 && y < self.height as i32;
            if inside {
                let at = 3 * (y as usize * self.width as usize + x as usize);
                self.rgb[at..at + 3].copy_from_slice(&[colour.r(), colour.g(), colour.b()]);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(pixels: [u32; 2]) -> Map {
        let count = pixels[0] * pixels[1];
        Map {
            pixels,
            colours: (0..count).map(|k| [k as u8, 7, 9]).collect(),
            title: "a figure".into(),
            ramp: viridis,
            ticks: ["0", "1", "2"].map(String::from).to_vec(),
            keys: (0..9).map(|k| ([200, k, 0], format!("what is called {k}"))).collect(),
        }
    }

    fn decoded(map: &Map) -> (u32, u32, Vec<u8>) {
        let png = map.png().unwrap();
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        (info.width, info.height, rgb)
    }

    #[test]
    fn small_sensors_are_drawn_in_squares_and_every_key_is_there() {
        for pixels in [[7, 5], [160, 120], [700, 3]] {
            let map = map(pixels);
            let (width, height, rgb) = decoded(&map);
            let zoom = 640u32.div_ceil(pixels[0]);
            assert!(width >= 640 && height > zoom * pixels[1]);
            let left = (width - zoom * pixels[0]) / 2;
            let at = |x: u32, y: u32| {
                let start = 3 * (y * width + x) as usize;
                [rgb[start], rgb[start + 1], rgb[start + 2]]
            };
            for (k, colour) in map.colours.iter().enumerate() {
                let (x, y) = (k as u32 % pixels[0], k as u32 / pixels[0]);
                assert_eq!(at(left + zoom * x, zoom * y), *colour);
                assert_eq!(at(left + zoom * x + zoom - 1, zoom * y + zoom - 1), *colour);
            }
            for (colour, text) in &map.keys {
                let below = &rgb[3 * (zoom * pixels[1] * width) as usize..];
                assert!(below.chunks_exact(3).any(|c| c == colour), "{text} of {pixels:?}");
            }
        }
    }

    #[test]
    fn a_bar_has_its_length_in_the_squares_of_the_map() {
        let map = map([160, 120]);
        let png = map.png_to_scale(0.3).unwrap();
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let width = reader.next_frame(&mut rgb).unwrap().width as usize;
        // 0.075 mm a dot: 10 mm are 133 of them, the longest black run below the map.
        let below = &rgb[3 * 480 * width..];
        let black: Vec<bool> = below.chunks_exact(3).map(|c| c == [0; 3]).collect();
        let longest = black.chunk_by(|a, b| a == b).filter(|run| run[0]).map(<[bool]>::len).max();
        assert_eq!(longest, Some(133));
        for (most, exact) in [(12.0, 10.0), (3.1, 2.0), (0.099, 0.05), (5.0, 5.0)] {
            assert_eq!(round_length(most), exact);
        }
    }

    #[test]
    fn scales_get_brighter() {
        for ramp in [grey as fn(f64) -> Colour, viridis] {
            let light = |k: i32| {
                let [r, g, b] = ramp(f64::from(k) / 100.0).map(f64::from);
                0.2126 * r + 0.7152 * g + 0.0722 * b
            };
            assert!(
                (0..100).all(|k| light(k + 1) >= light(k) - 0.5) && light(100) > light(0) + 150.0
            );
        }
    }
}
