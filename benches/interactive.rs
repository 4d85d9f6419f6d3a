//! From the text of a profile to what one sees who changes it: `cargo bench --bench interactive`.
//!
//! Each row is a whole way, text to PNG in memory on all cores: the design alone, the picture of the test world in
//! the smooth mirror, the map of its pixel errors.

use morion::internals::design::design_unmeasured;
use morion::{Command, Profile, RenderOptions, Silent, shipped};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

// As the program's own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Runs of which the median counts.
const RUNS: usize = 5;
/// Mirrors of every layout, all seen by 640 x 480 pixels or fewer.
const NAMES: [&str; 7] =
    ["conquistador", "panoramic", "conformal", "equiangular", "webcam", "driver", "robot-floor"];

fn main() -> Result<(), Box<dyn Error>> {
    println!("milliseconds, medians of {RUNS}");
    println!("{:<16} {:>8} {:>8} {:>8}", "profile", "design", "picture", "errors");
    for shipped in shipped().iter().filter(|shipped| NAMES.contains(&shipped.name)) {
        row(shipped.name, shipped.text)?;
    }
    // A low degree, as in a first sketch.
    let text =
        shipped().iter().find(|shipped| shipped.name == "conquistador").ok_or("shipped")?.text;
    row("of-degree-4", &text.replace("degree = 12", "degree = 4"))
}

fn row(name: &str, text: &str) -> Result<(), Box<dyn Error>> {
    let parse = || Profile::parse(name, name, text.as_bytes());
    let design = median(|| {
        black_box(design_unmeasured(&parse()?)?);
        Ok(())
    })?;
    let render = |scene| {
        median(|| {
            let wanted = RenderOptions { scene, smooth: true, ..RenderOptions::default() };
            black_box(wanted.in_memory(&parse()?, &Silent)?);
            Ok(())
        })
    };
    println!("{name:<16} {design:>8.1} {:>8.1} {:>8.1}", render("grid")?, render("errors")?);
    Ok(())
}

/// Median time of some runs, ms, after one that fills the caches.
fn median(mut run: impl FnMut() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    run()?;
    let mut times = Vec::new();
    for _ in 0..RUNS {
        let began = Instant::now();
        run()?;
        times.push(1e3 * began.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[RUNS / 2])
}
