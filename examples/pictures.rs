//! Pictures of a mirror: a test world far away as the camera sees it, and the part from three sides.
//!
//! `cargo run --release --example pictures -- panoramic out`

use morion::{Command, Profile, RenderOptions, Silent};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let profile = Profile::load(&arguments.next().unwrap_or_else(|| "panoramic".into()))?;
    let out = arguments.next().map_or_else(|| std::env::temp_dir().join("morion"), PathBuf::from);
    for scene in ["grid", "views"] {
        // Rays meet the designed surface itself: no mesh is made.
        let wanted = RenderOptions { scene, smooth: true, ..RenderOptions::default() };
        let picture = wanted.publish(&profile, &out, &Silent)?;
        let [width, height] = picture.pixels;
        println!("{}: {width} x {height} pixels by {} rays", picture.file, picture.rays);
    }
    Ok(())
}
