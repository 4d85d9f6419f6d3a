//! False-colour maps: a figure over the sensor or the part, with a scale and a key.

use super::{BitmapFont, Canvas, EncodingError, Srgb};
use crate::num::rounding::floor_125;

/// Pixels that the picture is wide at the least: the sensor's pixels become squares of more.
const WIDTH: u32 = 640;
/// But no higher for that: a sensor may be one pixel wide.
const HEIGHT: u32 = 2048;
const FONT: BitmapFont = BitmapFont::Px8x13;
/// Lengths below are units: a pixel in a picture of [`WIDTH`] pixels, more in wider ones, so that letters stay legible
/// where the picture is shown small.
const MARGIN: u32 = 10;
/// Width and height of a letter, and height of a line of the key.
const LETTER: [u32; 2] = [8, 13];
const LINE: u32 = 22;
/// Width and height of the scale.
const BAR: [u32; 2] = [256, 14];
/// Colours of the scale that a gradient goes through.
const STOPS: usize = 12;
/// Longest bar of a length.
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
    /// The picture: the map, below it the scale and the key; places of the key's colours have its letters.
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
        let unit = ((across + WIDTH / 2) / WIDTH).max(1);
        let places = self.key_places(across / unit);
        let key_lines = places.last().map_or(0, |place| place.1 + 1);
        let foot = unit * (2 * MARGIN + LINE * (3 + key_lines));
        let mut canvas = Canvas::new(across, zoom * height + foot);
        let left = (across - zoom * width) / 2;
        for (k, colour) in self.colours.iter().enumerate() {
            let (x, y) = (k as u32 % width, k as u32 / width);
            canvas.fill(left + zoom * x, zoom * y, [zoom, zoom], *colour);
        }
        for (k, place) in self.key_marks().into_iter().enumerate() {
            let Some(MarkedPlace { at, room }) = place else { continue };
            // Where the letter has its colour around it.
            if zoom * room >= unit * LETTER[1] / 2 {
                let corner = at.map(|x| zoom * x + zoom / 2);
                let [x, y] = [corner[0] + left, corner[1]];
                let [wide, high] = LETTER.map(|length| unit * length / 2);
                let ink = ink_on(self.keys[k].0);
                let at = [x.saturating_sub(wide), y.saturating_sub(high)];
                canvas.write(at, &letter(k).to_string(), (FONT, unit, ink));
            }
        }
        let mut foot = Foot { canvas: &mut canvas, top: zoom * height, unit };
        self.draw_scale(&mut foot);
        if let Some(pixel_mm) = self.pixel_mm {
            // Beside the scale.
            let [x, y] = [2 * MARGIN + LETTER[0] * 12 + BAR[0], MARGIN + LINE + 6];
            foot.draw_length([x, y], pixel_mm * f64::from(unit) / f64::from(zoom));
        }
        for (k, ((colour, text), (x, line))) in self.keys.iter().zip(places).enumerate() {
            let y = MARGIN + LINE * (3 + line);
            foot.fill([x, y], [BAR[1]; 2], [0; 3]);
            foot.fill([x + 1, y + 1], [BAR[1] - 2; 2], *colour);
            foot.write([x + BAR[1] + 6, y], &key_text(k, text));
        }
        canvas.png()
    }

    /// For each entry of the key the place of the map that is farthest from all other colours; none of colours that the
    /// map has not.
    #[must_use]
    pub fn key_marks(&self) -> Vec<Option<MarkedPlace>> {
        let width = self.pixels[0] as usize;
        let marks = self.keys.iter().map(|(colour, _)| {
            let room = self.room_around(*colour);
            // The first of several.
            let (k, room) = room.into_iter().enumerate().rev().max_by_key(|(_, room)| *room)?;
            let at = [k % width, k / width].map(|n| n as u32);
            (room > 0).then_some(MarkedPlace { at, room })
        });
        marks.collect()
    }

    /// For each pixel how many steps, also diagonal ones, lead to another colour or beyond the edges; two sweeps suffice
    /// (A. Rosenfeld and J. Pfaltz, *Distance functions on digital pictures*, 1968).
    fn room_around(&self, colour: Srgb) -> Vec<u32> {
        let [width, height] = self.pixels.map(|n| n as usize);
        let mut room: Vec<u32> =
            self.colours.iter().map(|own| if *own == colour { u32::MAX } else { 0 }).collect();
        let mut sweep = |k: usize, before: [[isize; 2]; 4]| {
            if room[k] == 0 {
                return;
            }
            let [x, y] = [k % width, k / width];
            let least = before.into_iter().map(|[dx, dy]| {
                let at = x.checked_add_signed(dx).zip(y.checked_add_signed(dy));
                at.filter(|(x, y)| *x < width && *y < height)
                    .map_or(0, |(x, y)| room[y * width + x])
            });
            room[k] = room[k].min(least.min().unwrap_or(0).saturating_add(1));
        };
        let before = [[-1, 0], [-1, -1], [0, -1], [1, -1]];
        (0..width * height).for_each(|k| sweep(k, before));
        let after = before.map(|step| step.map(|n: isize| -n));
        (0..width * height).rev().for_each(|k| sweep(k, after));
        room
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

    fn draw_scale(&self, foot: &mut Foot) {
        let [width, height] = BAR;
        let (left, top) = (MARGIN + LETTER[0] * 6, MARGIN + LINE);
        foot.write([MARGIN, MARGIN], &self.title);
        for k in 0..width {
            let colour = (self.ramp)(f64::from(k) / f64::from(width - 1));
            foot.fill([left + k, top], [1, height], colour);
        }
        let steps = (self.ticks.len() as u32).saturating_sub(1).max(1);
        for (k, text) in (0..).zip(&self.ticks) {
            let x = if self.ticks.len() == 1 { width / 2 } else { k * (width - 1) / steps };
            foot.fill([left + x, top + height], [1, 3], [0; 3]);
            let half = LETTER[0] * text.len() as u32 / 2;
            foot.write([(left + x).saturating_sub(half), top + height + 4], text);
        }
    }

    /// Where each entry of the key begins, and on which line.
    fn key_places(&self, across: u32) -> Vec<(u32, u32)> {
        let (mut x, mut line) = (MARGIN, 0);
        let place = |(k, (_, text)): (usize, &(Srgb, String))| {
            let letters = key_text(k, text).len() as u32;
            let wide = BAR[1] + 6 + LETTER[0] * letters + 2 * MARGIN;
            if x > MARGIN && x + wide > across {
                (x, line) = (MARGIN, line + 1);
            }
            let place = (x, line);
            x += wide;
            place
        };
        self.keys.iter().enumerate().map(place).collect()
    }
}

/// A place of a map that stands for a colour of the key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MarkedPlace {
    /// Column and row.
    pub at: [u32; 2],
    /// Pixels from there to the nearest of another colour, or to the map's edge.
    pub room: u32,
}

/// The letter of the `k`-th entry of a key: colours alone are not told apart by everybody.
#[must_use]
pub fn letter(k: usize) -> char {
    (b'A'..=b'Z').nth(k % 26).map_or('?', char::from)
}

/// The text of the `k`-th entry of a key.
#[must_use]
pub fn key_text(k: usize, text: &str) -> String {
    format!("{} {text}", letter(k))
}

/// Black or white, which is read better on a colour.
#[must_use]
pub fn ink_on([red, green, blue]: Srgb) -> Srgb {
    let light = 0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue);
    if light > 110.0 { [0; 3] } else { [255; 3] }
}

/// What is below a map, in units from its upper left corner.
struct Foot<'a> {
    canvas: &'a mut Canvas,
    /// First row of the canvas.
    top: u32,
    /// Pixels a unit.
    unit: u32,
}

impl Foot<'_> {
    fn fill(&mut self, [x, y]: [u32; 2], size: [u32; 2], colour: Srgb) {
        let [x, y] = [x, y].map(|n| self.unit * n);
        self.canvas.fill(x, self.top + y, size.map(|n| self.unit * n), colour);
    }

    fn write(&mut self, [x, y]: [u32; 2], text: &str) {
        let at = [self.unit * x, self.top + self.unit * y];
        self.canvas.write(at, text, (FONT, self.unit, [0; 3]));
    }

    /// A bar of a round length, where a unit is `unit_mm` on the part.
    fn draw_length(&mut self, [x, y]: [u32; 2], unit_mm: f64) {
        let length_mm = floor_125(LENGTH * unit_mm);
        let wide = (length_mm / unit_mm).round() as u32;
        self.fill([x, y], [wide, 2], [0; 3]);
        for x in [x, x + wide - 2] {
            self.fill([x, y - 4], [2, 10], [0; 3]);
        }
        self.write([x + wide + MARGIN, y - 6], &format!("{length_mm} mm"));
    }
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
    fn letters_stand_where_a_colour_of_the_key_has_most_room() {
        let (key, other) = ([200, 0, 0], [1, 2, 3]);
        let colours = (0..60 * 40).map(|k| {
            let (x, y) = (k % 60, k / 60);
            let is_inside = (10..31).contains(&x) && (5..26).contains(&y) || x == 50;
            if is_inside { key } else { other }
        });
        let keys = vec![(key, "a".into()), ([9; 3], "nowhere".into())];
        let map = FalseColourMap { colours: colours.collect(), keys, ..map([60, 40]) };
        assert_eq!(map.key_marks(), [Some(MarkedPlace { at: [20, 15], room: 11 }), None]);
        let (width, _, rgb) = decoded(&map.png().unwrap());
        let zoom = 11;
        let around = |x: u32, y: u32| rgb[3 * (y * width + x) as usize..][..3] == [255; 3];
        let inked = (18 * zoom..23 * zoom)
            .flat_map(|x| (13 * zoom..18 * zoom).map(move |y| (x, y)))
            .filter(|(x, y)| around(*x, *y))
            .count();
        assert!(inked > 10, "{inked} white pixels of a letter");
    }

    #[test]
    fn letters_of_wide_maps_are_larger() {
        let letters = |width: u32| {
            let (across, _, rgb) = decoded(&map([width, 3]).png().unwrap());
            let (zoom, unit) = (WIDTH.div_ceil(width), (width / WIDTH) as usize);
            // Rows with ink between the map and the scale.
            let title = &rgb[3 * (3 * zoom * across) as usize..];
            let rows = title.chunks_exact(3 * across as usize).take(30 * unit);
            rows.filter(|row| row.chunks_exact(3).any(|c| c == [0; 3])).count()
        };
        let [narrow, wide] = [letters(640), letters(1920)];
        assert!(narrow > 5 && wide == 3 * narrow, "{narrow} {wide}");
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
