//! What drawings with axes have in common.

use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;

/// An empty drawing.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// What the drawing library reports.
pub(crate) type Failure = Box<dyn Error>;

/// Colours that the colour-blind tell apart (M. Okabe and K. Ito, *Color universal design*, 2008).
pub(super) const BLUE: RGBColor = RGBColor(0, 114, 178);
/// Vermilion.
pub(super) const RED: RGBColor = RGBColor(213, 94, 0);
/// Bluish green.
pub(super) const GREEN: RGBColor = RGBColor(0, 158, 115);

/// What `draw` leaves on a white ground, as SVG.
pub(crate) fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&Area) -> Result<(), Failure>,
) -> Result<String, Failure> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        draw(&root)?;
        root.present()?;
    }
    Ok(svg)
}
