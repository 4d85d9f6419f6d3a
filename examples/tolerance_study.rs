//! How well a mirror must be made: the yield by each process, and what to hold tighter.
//!
//! `cargo run --release --example tolerance_study -- conquistador`

use morion::{Command, Profile, Silent, ToleranceOptions, shipped};

const PROCESSES: [&str; 6] =
    ["spdt", "polished", "ultra-precision-cnc", "precision-cnc", "standard-cnc", "sla-print"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "conquistador".into());
    let text = shipped().iter().find(|profile| profile.name == name);
    let text = text.ok_or_else(|| format!("{name} is not shipped"))?.text;
    let folder = tempfile::tempdir()?;
    let trials = ToleranceOptions { range: 0..400, ..ToleranceOptions::default() };
    println!(
        "{name}: displacement of the picture and yield at 1 px RMS, of {} parts",
        trials.range.end
    );
    for process in PROCESSES {
        let path = folder.path().join(format!("{process}.toml"));
        std::fs::write(
            &path,
            format!("{text}\n[tolerance]\npreset = \"{process}\"\nbudget_px = 1\n"),
        )?;
        let profile = Profile::load(&path.to_string_lossy())?;
        let study = trials.publish(&profile, folder.path(), &Silent)?.study;
        let sources = study.sources.iter();
        let worst = sources.max_by(|a, b| a.share_of_variance.total_cmp(&b.share_of_variance));
        println!(
            "  {process:<20} P95 {:>7.3} px   yield {:>5.1} %   most: {}",
            study.adjusted.p95_px,
            100.0 * study.yields.share,
            worst.map_or("-", |source| &source.source),
        );
    }
    Ok(())
}
