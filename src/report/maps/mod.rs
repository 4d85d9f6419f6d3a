//! Pictures of a figure over the sensor or over the part, as PNG.

mod blur;
mod form_error;
mod frame;
mod gouge;
mod pixel_error;

pub use form_error::form_picture;
pub use gouge::gouge_picture;
pub use pixel_error::pixel_error_picture;
