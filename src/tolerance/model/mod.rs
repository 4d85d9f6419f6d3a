//! The picture of a perturbed system, exact, for plain numbers and with derivatives alike.
//!
//! A sensor pixel's ray through the camera with its errors is taken into the frame of the part,
//! which is shifted, turned and grown; there it meets the designed surface plus the form error (a
//! departure along Z over the part's X and Y), is reflected, and goes back into the world, where
//! the imaging task says which image point the thing it meets belongs to.

mod ball_cutter;
mod content;
mod made_forms;
mod sample;
mod side_by_side;
mod state;
mod surface_departure;
mod system;

pub(super) use ball_cutter::BallCutter;
pub(super) use made_forms::FormBasis;
pub(super) use sample::{PixelSample, TextureSite};
pub(super) use side_by_side::SideBySide;
pub(super) use state::{PartPose, PerturbedState};
pub(super) use system::OpticalSystem;
