//! The frame-fill check and the blur: against closed forms, laws of optics, and pencils of rays traced
//! one by one.

mod blur;
mod fill;
mod solid_angle;
mod strips;
