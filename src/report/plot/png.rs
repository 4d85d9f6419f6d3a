//! A diagram as PNG, in the light shades.

use super::diagram::{Diagram, Ink, LETTER, Mark, Marker, Stroke};
use crate::geom::DVec2;
use crate::raster::{BitmapFont, Canvas, EncodingError, Srgb, TextBitmap};

/// Pixels a unit.
const SCALE: u32 = 2;
/// Letters as wide and as high as [`LETTER`] says.
const FONT: BitmapFont = BitmapFont::Px7x13;
/// Height of a letter's cell above its base line, units.
const ASCENT: f64 = 10.0;

impl Diagram {
    /// The diagram as PNG, two pixels a unit.
    ///
    /// # Errors
    /// What the encoder reports.
    pub(crate) fn png(&self) -> Result<Vec<u8>, EncodingError> {
        let scale = f64::from(SCALE);
        let [width, height] = (self.size * scale).to_array().map(|x| x.round() as u32);
        let mut canvas = Canvas::new(width, height);
        for mark in &self.marks {
            match mark {
                Mark::Lines { stroke, lines } => {
                    for line in lines {
                        draw_line(&mut canvas, *stroke, line);
                    }
                }
                Mark::Area { ink, opacity, corners } => {
                    fill(&mut canvas, corners, ink.srgb(), *opacity);
                }
                Mark::Point { ink, marker, at, radius } => match marker.corners(*at, *radius) {
                    Some(corners) => fill(&mut canvas, &corners, ink.srgb(), 1.0),
                    None => {
                        let inner = if *marker == Marker::Ring { radius - 0.6 } else { 0.0 };
                        let disc = [inner, *radius].map(|r| r * scale);
                        draw_disc(&mut canvas, *at * scale, disc, ink.srgb());
                    }
                },
                Mark::Text { ink, at, anchor, is_turned, text } => {
                    let left = LETTER[0] * text.chars().count() as f64 * anchor.share();
                    // To whole units: letters are squares of SCALE pixels.
                    let offset = DVec2::new(-left, -ASCENT).round();
                    draw_text(&mut canvas, at.round(), offset, *is_turned, (text, ink.srgb()));
                }
            }
        }
        canvas.png()
    }
}

/// Mixes a colour into the pixels from `low` to `high` by what `alpha` says of each pixel's middle.
fn blend(canvas: &mut Canvas, [low, high]: [DVec2; 2], rgb: Srgb, alpha: impl Fn(DVec2) -> f64) {
    let (width, height) = canvas.size();
    let end = |x: f64, most: u32| x.ceil().clamp(0.0, f64::from(most)) as u32;
    for y in end(low.y - 1.0, height)..end(high.y, height) {
        for x in end(low.x - 1.0, width)..end(high.x, width) {
            let share = alpha(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            if share > 0.0 {
                canvas.blend(x as i32, y as i32, rgb, share.min(1.0));
            }
        }
    }
}

/// Draws a line through places, with its interruptions.
fn draw_line(canvas: &mut Canvas, stroke: Stroke, line: &[DVec2]) {
    let scale = f64::from(SCALE);
    let reach = 0.5 * stroke.width * scale;
    let mut draw = |from: DVec2, to: DVec2| {
        let [from, to] = [from * scale, to * scale];
        let along = to - from;
        let (low, high) = (from.min(to), from.max(to));
        let pad = DVec2::splat(reach + 1.0);
        let squared = along.length_squared().max(f64::MIN_POSITIVE);
        blend(canvas, [low - pad, high + pad], stroke.ink.srgb(), |at| {
            let t = ((at - from).dot(along) / squared).clamp(0.0, 1.0);
            reach + 0.5 - at.distance(from + along * t)
        });
    };
    let Some(lengths) = stroke.dash.lengths() else {
        line.windows(2).for_each(|ends| draw(ends[0], ends[1]));
        return;
    };
    let (mut phase, mut left) = (0, lengths[0]);
    for ends in line.windows(2) {
        let (mut at, length) = (0.0, ends[0].distance(ends[1]));
        while at < length {
            let step = f64::min(left, length - at);
            if phase == 0 {
                draw(
                    ends[0].lerp(ends[1], at / length),
                    ends[0].lerp(ends[1], (at + step) / length),
                );
            }
            (at, left) = (at + step, left - step);
            if left <= 1e-9 {
                phase = 1 - phase;
                left = lengths[phase];
            }
        }
    }
}

/// Draws what lies between two radii around `at`, pixels.
fn draw_disc(canvas: &mut Canvas, at: DVec2, [inner, outer]: [f64; 2], rgb: Srgb) {
    let pad = DVec2::splat(outer + 1.0);
    blend(canvas, [at - pad, at + pad], rgb, |pixel| {
        let r = pixel.distance(at);
        let inside = if inner > 0.0 { r - inner + 0.5 } else { 1.0 };
        inside.min(outer + 0.5 - r)
    });
}

/// Fills an outline, units.
fn fill(canvas: &mut Canvas, corners: &[DVec2], rgb: Srgb, opacity: f64) {
    let corners: Vec<DVec2> = corners.iter().map(|at| *at * f64::from(SCALE)).collect();
    let Some(ends) = corners.iter().map(|c| [*c, *c]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    else {
        return;
    };
    blend(canvas, ends, rgb, |at| {
        let next = corners.iter().cycle().skip(1);
        let crossings = corners.iter().zip(next).filter(|(a, b)| {
            let crosses = (a.y > at.y) != (b.y > at.y);
            crosses && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        if crossings.count() % 2 == 1 { opacity } else { 0.0 }
    });
}

/// Writes a text whose cells begin at `offset` of its base line's place, in units as it is read.
fn draw_text(
    canvas: &mut Canvas,
    at: DVec2,
    offset: DVec2,
    is_turned: bool,
    (text, rgb): (&str, Srgb),
) {
    let bitmap = TextBitmap::new(text, FONT);
    // A letter over lines is read by its rim.
    for (rim, rgb) in [(1.0, Ink::Paper.srgb()), (0.0, rgb)] {
        for [column, row] in bitmap.inked_pixels() {
            let place = offset + DVec2::new(column as f64, row as f64);
            // Upwards along the page where it is read from below.
            let place = if is_turned { DVec2::new(place.y, -1.0 - place.x) } else { place };
            let [x, y] = ((at + place - rim) * f64::from(SCALE)).to_array();
            if x >= 0.0 && y >= 0.0 {
                let side = SCALE + 2 * (rim as u32) * SCALE;
                canvas.fill(x as u32, y as u32, [side; 2], rgb);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::diagram::Anchor;
    use super::*;

    /// Columns, and rows of pixels.
    fn pixels(diagram: &Diagram) -> Vec<Vec<Srgb>> {
        let mut reader =
            png::Decoder::new(std::io::Cursor::new(diagram.png().unwrap())).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        let (pixels, _) = rgb.as_chunks::<3>();
        pixels.chunks(info.width as usize).map(<[_]>::to_vec).collect()
    }

    #[test]
    fn lines_areas_and_points_are_where_they_are_drawn() {
        let mut diagram = Diagram::new(40.0, 20.0);
        let at = |x: f64, y: f64| DVec2::new(x, y);
        diagram.lines(Stroke::solid(Ink::Blue, 2.0), [vec![at(2.0, 3.0), at(38.0, 3.0)]]);
        diagram.area(
            Ink::Red,
            1.0,
            [(2.0, 8.0), (10.0, 8.0), (10.0, 18.0), (2.0, 18.0)].map(|(x, y)| at(x, y)).to_vec(),
        );
        diagram.point(Ink::Green, Marker::Disc, at(20.0, 12.0), 3.0);
        diagram.point(Ink::Text, Marker::Ring, at(32.0, 12.0), 5.0);
        let rows = pixels(&diagram);
        assert_eq!((rows.len(), rows[0].len()), (40, 80));
        assert_eq!([rows[5][40], rows[6][40]], [Ink::Blue.srgb(); 2]);
        assert_eq!([rows[2][40], rows[9][40]], [[255; 3]; 2]);
        // The ring's line is about one pixel wide.
        assert!(rows[24][54].iter().all(|level| *level < 60), "{:?}", rows[24][54]);
        let count = |ink: Ink| rows.iter().flatten().filter(|p| **p == ink.srgb()).count();
        assert_eq!(count(Ink::Red), 16 * 20);
        assert_eq!([rows[24][40], rows[24][64]], [Ink::Green.srgb(), [255; 3]]);
    }

    #[test]
    fn dashes_leave_gaps_of_their_length() {
        let mut diagram = Diagram::new(100.0, 6.0);
        let line = vec![DVec2::new(0.0, 3.0), DVec2::new(33.0, 3.0), DVec2::new(100.0, 3.0)];
        diagram.lines(Stroke::dashed(Ink::Text, 2.0), [line]);
        let rows = pixels(&diagram);
        let inked = rows[5].iter().filter(|p| **p == Ink::Text.srgb()).count();
        // Ten strokes of 6 units, two pixels each; their ends are round.
        assert!((115..145).contains(&inked), "{inked}");
    }

    #[test]
    fn turned_texts_are_read_from_below() {
        let ink = |is_turned: bool| {
            let mut diagram = Diagram::new(60.0, 60.0);
            match is_turned {
                true => diagram.turned_text(Ink::Text, DVec2::new(30.0, 30.0), "Lj"),
                false => diagram.text(Ink::Text, DVec2::new(30.0, 30.0), Anchor::Middle, "Lj"),
            }
            pixels(&diagram)
        };
        let (level, turned) = (ink(false), ink(true));
        let turned_back: Vec<Vec<Srgb>> =
            (0..120).map(|y| (0..120).map(|x| turned[119 - x][y]).collect()).collect();
        assert!(level == turned_back && level.iter().flatten().any(|p| *p == Ink::Text.srgb()));
    }
}
