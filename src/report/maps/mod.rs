//! Pictures of a figure over the sensor or over the part, as PNG.

mod blur;
mod false_colour;
mod form_error;
mod frame;
mod gouge;
mod palette;

pub use form_error::form_picture;
pub use gouge::gouge_picture;
