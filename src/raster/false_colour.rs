//! False-colour maps: a figure over the sensor or the part, with a scale and a key.

use super::{BitmapFont, Canvas, EncodingError, Srgb};
use crate::num::rounding::floor_125;

/// Pixels that the picture is wide at the least: the sensor's pixels become squares of more.
const WIDTH: u32 = 640;
/// But no higher for that: a sensor may be one pixel wide.
const HEIGHT: u32 = 2048;
const MARGIN: u32 = 10;
const FONT: BitmapFont = BitmapFont::Px8x13;
/// Width of a letter, and height of a line of the key, px.
const LETTER: u32 = 8;
const LINE: u32 = 22;
/// Width and height of the scale, px.
const BAR: [u32; 2] = [256, 14];
/// Colours of the scale that a gradient goes through.
const STOPS: usize = 12;
/// Longest bar of a length, px.
const LENGTH: f64 = 160.0;

/// A false-colour map: a colour for each pixel of a sensor or a raster, and what the colours mean.
#[derive(Debug, Clone)]
pub struct FalseColourMap {
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// Row by row from the upper left; one a pixel.
    pub colours: Vec<Srgb>,
    /// What the scale is of.
    pub title: String,
    /// The scale from its lower to its upper end.
    pub ramp: fn(f64) -> Srgb,
    /// The texts under the scale, evenly spaced from its lower to its upper end.
    pub ticks: Vec<String>,
    /// Further colours.
    pub keys: Vec<(Srgb, String)>,
    /// Width of a pixel on the part, mm: the map gets a bar of a round length. None for a sensor.
    pub pixel_mm: Option<f64>,
}

impl FalseColourMap {
    /// The picture: the map, below it the scale and the key.
    ///
    /// # Errors
    /// What the encoder reports.
    ///
    /// # Panics
    /// When there is not one colour a pixel.
    pub fn png(&self) -> Result<Vec<u8>, EncodingError> {
        let [width, height] = self.pixels;
        assert_eq!(self.colours.len(), width as usize * height as usize, "one colour a pixel");
        let zoom = WIDTH.div_ceil(width).min(HEIGHT / height.max(1)).max(1);
        let across = (zoom * width).max(WIDTH);
        let places = self.key_places(across);
        let key_lines = places.last().map_or(0, |place| place.1 + 1);
        let foot = 2 * MARGIN + LINE * (2 + key_lines);
        let mut canvas = Canvas::new(across, zoom * height + foot);
        let left = (across - zoom * width) / 2;
        for (k, colour) in self.colours.iter().enumerate() {
            let (x, y) = (k as u32 % width, k as u32 / width);
            canvas.fill(left + zoom * x, zoom * y, [zoom, zoom], *colour);
        }
        let top = zoom * height + MARGIN;
        self.draw_scale(&mut canvas, top);
        if let Some(pixel_mm) = self.pixel_mm {
            // Beside the ticks, below the title.
            let (x, y) = (2 * MARGIN + LETTER * 8 + BAR[0], top + BAR[1] + 10);
            draw_length(&mut canvas, [x, y], pixel_mm / f64::from(zoom));
        }
        for ((colour, text), (x, line)) in self.keys.iter().zip(places) {
            let y = top + LINE * (2 + line);
            canvas.fill(x, y, [BAR[1]; 2], [0; 3]);
            canvas.fill(x + 1, y + 1, [BAR[1] - 2; 2], *colour);
            canvas.write(x + BAR[1] + 6, y, text, FONT);
        }
        canvas.png()
    }

    /// The map alone, a dot a pixel, for pages that have their own scale and key.
    ///
    /// # Errors
    /// What the encoder reports.
    pub fn bare_png(&self) -> Result<Vec<u8>, EncodingError> {
        let [width, height] = self.pixels;
        let mut canvas = Canvas::new(width, height);
        for (k, colour) in self.colours.iter().enumerate() {
            canvas.fill(k as u32 % width, k as u32 / width, [1; 2], *colour);
        }
        canvas.png()
    }

    /// Colours of the scale from its lower to its upper end, for a gradient.
    #[must_use]
    pub fn scale_colours(&self) -> [Srgb; STOPS] {
        std::array::from_fn(|k| (self.ramp)(k as f64 / (STOPS - 1) as f64))
    }

    fn draw_scale(&self, canvas: &mut Canvas, top: u32) {
        let [width, height] = BAR;
        let left = MARGIN + LETTER * 4;
        for k in 0..width {
            let colour = (self.ramp)(f64::from(k) / f64::from(width - 1));
            canvas.fill(left + k, top, [1, height], colour);
        }
        canvas.write(left + width + MARGIN, top, &self.title, FONT);
        let steps = (self.ticks.len() as u32).saturating_sub(1).max(1);
        for (k, text) in (0..).zip(&self.ticks) {
            let x = if self.ticks.len() == 1 { width / 2 } else { k * (width - 1) / steps };
            canvas.fill(left + x, top + height, [1, 3], [0; 3]);
            let half = LETTER * text.len() as u32 / 2;
            canvas.write((left + x).saturating_sub(half), top + height + 4, text, FONT);
        }
    }

    /// Where each entry of the key begins, and on which line.
    fn key_places(&self, across: u32) -> Vec<(u32, u32)> {
        let (mut x, mut line) = (MARGIN, 0);
        let place = |(_, text): &(Srgb, String)| {
            let wide = BAR[1] + 6 + LETTER * text.len() as u32 + 2 * MARGIN;
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

/// A bar of a round length from `x`, `y`, where a pixel of the picture is `pixel_mm` wide.
fn draw_length(canvas: &mut Canvas, [x, y]: [u32; 2], pixel_mm: f64) {
    let length_mm = floor_125(LENGTH * pixel_mm);
    let wide = (length_mm / pixel_mm).round() as u32;
    canvas.fill(x, y, [wide, 2], [0; 3]);
    for x in [x, x + wide - 2] {
        canvas.fill(x, y - 4, [2, 10], [0; 3]);
    }
    canvas.write(x + wide + MARGIN, y - 6, &format!("{length_mm} mm"), FONT);
}

/// Columns, rows and bytes of a PNG file.
#[cfg(test)]
pub(crate) fn decoded(png: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rgb).unwrap();
    (info.width, info.height, rgb)
}

#[cfg(test)]
mod tests {
    use super::super::palette::viridis;
    use super::*;

    fn map(pixels: [u32; 2]) -> FalseColourMap {
        let count = pixels[0] * pixels[1];
        FalseColourMap {
            pixels,
            colours: (0..count).map(|k| [k as u8, 7, 9]).collect(),
            title: "a figure".into(),
            ramp: viridis,
            ticks: ["0", "1", "2"].map(String::from).to_vec(),
            keys: (0..9).map(|k| ([200, k, 0], format!("what is called {k}"))).collect(),
            pixel_mm: None,
        }
    }

    #[test]
    fn small_sensors_are_drawn_in_squares_and_every_key_is_there() {
        for pixels in [[7, 5], [160, 120], [700, 3]] {
            let map = map(pixels);
            let (width, height, rgb) = decoded(&map.png().unwrap());
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
        let map = FalseColourMap { pixel_mm: Some(0.3), ..map([160, 120]) };
        let (width, _, rgb) = decoded(&map.png().unwrap());
        // 0.075 mm a dot: 10 mm are 133 of them, the longest black run below the map.
        let below = &rgb[3 * 480 * width as usize..];
        let black: Vec<bool> = below.chunks_exact(3).map(|c| c == [0; 3]).collect();
        let longest = black.chunk_by(|a, b| a == b).filter(|run| run[0]).map(<[bool]>::len).max();
        assert_eq!(longest, Some(133));
    }
}
