//! Maps of a figure over the sensor or over the part.

mod blur;
mod curl;
mod form_error;
mod frame;
mod gouge;
mod pixel_error;

pub use blur::spot_map;
pub use curl::curl_map;
pub use form_error::form_map;
pub use gouge::gouge_map;
pub(super) use gouge::left_map;
pub use pixel_error::{design_error_map, pixel_error_map};
