//! A false-colour map as a figure: the map, its scale and its key, with letters of the page's size.

use super::{Figure, escaped, image};
use crate::num::rounding::floor_125;
use crate::raster::palette::hexadecimal;
use crate::raster::{EncodingError, FalseColourMap, MarkedPlace, Srgb, ink_on, key_text, letter};

/// The map under a title, with its scale and key; `caption` says what to conclude.
///
/// # Errors
/// What the encoder reports.
pub(in crate::report) fn map_figure(
    title: &str,
    map: &FalseColourMap,
    caption: String,
) -> Result<Figure, EncodingError> {
    let picture = image(&map.bare_png()?, "map", &format!("Map: {}", map.title));
    let stops = map.scale_colours().map(hexadecimal);
    let tick = |text: Option<&String>| escaped(text.map_or("", String::as_str));
    let middle = map.ticks.get(map.ticks.len() / 2).filter(|_| map.ticks.len() > 2);
    let middle = middle.map_or(String::new(), |text| format!(", {} in the middle", escaped(text)));
    let (low, high) = (tick(map.ticks.first()), tick(map.ticks.last()));
    let scale = format!(
        "<div class=\"scale\" role=\"img\" aria-label=\"Scale from {low} to {high}{middle}\"><span>{low}</span>\
         <span class=\"ramp\" style=\"background:linear-gradient(to right,{})\"></span><span>{high}</span></div>",
        stops.join(",")
    );
    let key = |(k, (srgb, text)): (usize, &(Srgb, String))| {
        let (colour, text) = (hexadecimal(*srgb), escaped(&key_text(k, text)));
        format!("<span class=\"key\"><i style=\"background:{colour}\"></i>{text}</span>")
    };
    let keys: Vec<String> = map.keys.iter().enumerate().map(key).collect();
    let (letters, bar) = (letters(map), length_bar(map));
    let body = format!(
        "<div class=\"mapped\">{picture}{letters}</div>\n{bar}{scale}\n<div>{}</div>",
        keys.concat()
    );
    Ok(Figure { title: title.into(), body, caption })
}

/// Least room of a letter around its place, as a share of the map's width.
const LETTER_ROOM: f64 = 0.02;

/// A letter of the key on a map.
pub(crate) struct MapLetter {
    /// The letter.
    pub letter: char,
    /// From the map's left and top, percent of its width and height.
    pub at_percent: [f64; 2],
    /// Its colour.
    pub ink: Srgb,
}

/// Letters of the key where a map has room for them.
pub(crate) fn map_letters(map: &FalseColourMap) -> Vec<MapLetter> {
    let [width, height] = map.pixels.map(f64::from);
    let marks = map.key_marks().into_iter().enumerate();
    let letter_of = |(k, place): (usize, Option<MarkedPlace>)| {
        let MarkedPlace { at: [x, y], room } = place?;
        let at_percent = [(x, width), (y, height)].map(|(n, of)| 100.0 * (f64::from(n) + 0.5) / of);
        let has_room = f64::from(room) >= LETTER_ROOM * width;
        has_room.then(|| MapLetter { letter: letter(k), at_percent, ink: ink_on(map.keys[k].0) })
    };
    marks.filter_map(letter_of).collect()
}

/// The same as markup.
fn letters(map: &FalseColourMap) -> String {
    let markup = |MapLetter { letter, at_percent: [left, top], ink }: MapLetter| {
        let ink = hexadecimal(ink);
        format!(
            "<b aria-hidden=\"true\" style=\"left:{left:.1}%;top:{top:.1}%;color:{ink}\">{letter}</b>"
        )
    };
    map_letters(map).into_iter().map(markup).collect()
}

/// A bar of a round length at most a quarter of the map wide; nothing for a sensor.
fn length_bar(map: &FalseColourMap) -> String {
    map.pixel_mm.map_or(String::new(), |pixel_mm| {
        let width_mm = pixel_mm * f64::from(map.pixels[0]);
        let length_mm = floor_125(0.25 * width_mm);
        let share = 100.0 * length_mm / width_mm;
        format!("<div class=\"length\" style=\"width:{share:.2}%\">{length_mm} mm</div>\n")
    })
}
