//! A false-colour map as a figure: the map, its scale and its key, with letters of the page's size.

use super::{Figure, escaped, image};
use crate::raster::palette::hexadecimal;
use crate::raster::{EncodingError, FalseColourMap, Srgb};

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
    let key = |(srgb, text): &(Srgb, String)| {
        let (colour, text) = (hexadecimal(*srgb), escaped(text));
        format!("<span class=\"key\"><i style=\"background:{colour}\"></i>{text}</span>")
    };
    let keys: Vec<String> = map.keys.iter().map(key).collect();
    let body = format!("{picture}\n{scale}\n<div>{}</div>", keys.concat());
    Ok(Figure { title: title.into(), body, caption })
}
