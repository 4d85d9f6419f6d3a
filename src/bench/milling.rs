//! Time on the machine against the pixel error of a mirror as milled.

use super::profile_edit::{document, set};
use super::{BenchRun, BenchSweep, BenchTime, Subject, SuggestedProgram, convergence_order, run};
use crate::num::rounding::floor_four_digits;
use crate::pipeline::{Error, ProgramForecast};
use crate::profile::{FinishingPath, FinishingSpec};
use crate::verdict::ProgramCut;
use toml_edit::{Item, Table, value};

const NAME: &str = "program";
/// Radii of balls that shops have, mm.
const RADII_MM: [f64; 5] = [1.0, 2.0, 3.0, 5.0, 8.0];
/// Stepovers over the ball's radius: from lines that a polish is to follow to those of hours.
const STEPOVERS: [f64; 6] = [0.4, 0.25, 0.16, 0.1, 0.06, 0.04];
/// What scallops are foreseen to leave, as a share of what they may: the chords of the moves along the lines add up to a sixteenth, and
/// a trace finds within two hundredths of that.
const AIM: f64 = 0.92;
/// Keys of what else would choose the lines.
const OTHER_KEYS: [&str; 3] = ["scallop_um", "budget_px", "polish_um"];

/// Programs of balls of several radii, the profile's own among them, with wider and narrower lines. The error is what the design
/// and its scallops leave, which are independent. Scallops are as steep as the lines are apart; the time is that of all operations.
/// A mirror that cannot be milled by a ball on three axes has no runs, nor has one of a lathe.
pub(super) fn sweep(subjects: &[Subject], quick: bool) -> BenchSweep {
    let mut runs: Vec<BenchRun> = Vec::new();
    for subject in subjects.iter().filter(|subject| subject.design.view.is_some()) {
        let Some(own) = subject.profile.program.mill() else { continue };
        let own_mm = own.finishing.ball_mm;
        let mut radii_mm = if quick { vec![own_mm] } else { RADII_MM.to_vec() };
        if !radii_mm.contains(&own_mm) {
            radii_mm.push(own_mm);
        }
        for ball_mm in radii_mm {
            let narrowest_mm = narrowest_mm(subject, ball_mm);
            let stepovers = STEPOVERS.iter().step_by(if quick { 2 } else { 1 });
            let stepovers_mm = stepovers.map(|share| share * ball_mm);
            // Programs that are refused, as of a ball that does not fit, have no place in the plot.
            let planned = stepovers_mm
                .filter(|stepover_mm| *stepover_mm >= narrowest_mm)
                .filter_map(|stepover_mm| planned(subject, ball_mm, stepover_mm).ok().flatten());
            runs.extend(planned.map(|milled| milled.run(subject.name())));
        }
    }
    let scallops = |run: &BenchRun| (run.setting, run.figures["scallop_rms_px"]);
    let order = convergence_order(&runs, "scallops ~ stepover", 1.0, scallops);
    BenchSweep {
        name: NAME,
        about: "Stepover and ball of the programs",
        time: BenchTime::Machine,
        setting: "stepover_mm",
        error: "pixel_rms_px",
        error_axis: "pixel error as milled, RMS, px",
        runs,
        orders: order.into_iter().collect(),
    }
}

/// The least distance of lines or turns of a ball that is looked at, mm.
fn narrowest_mm(subject: &Subject, ball_mm: f64) -> f64 {
    let path = subject.profile.program.mill().map(|spec| spec.finishing.path);
    let path = path.unwrap_or(FinishingPath::Lines);
    ProgramCut::narrowest_mm(&subject.design.mirror, path, ball_mm)
}

/// A mirror as milled.
struct Milled {
    ball_mm: f64,
    forecast: ProgramForecast,
    scallop_px: f64,
    pixel_px: f64,
}

impl Milled {
    fn run(self, profile: &str) -> BenchRun {
        let Self { ball_mm, forecast, scallop_px, pixel_px } = self;
        let figures = [
            ("ball_mm", ball_mm),
            ("scallop_rms_px", scallop_px),
            ("machine_min", forecast.machine_min),
            ("moves", forecast.moves as f64),
        ];
        let series = format!("R {ball_mm} mm");
        let time_ms = 6e4 * forecast.machine_min;
        run((profile, &series), forecast.stepover_mm, time_ms, pixel_px, figures.into())
    }
}

/// Programs of `subject` with this ball and stepover; none where pixel errors are not known.
fn planned(subject: &Subject, ball_mm: f64, stepover_mm: f64) -> Result<Option<Milled>, Error> {
    let mut profile = subject.profile.clone();
    let Some(spec) = profile.program.mill_mut() else { return Ok(None) };
    spec.finishing = FinishingSpec {
        ball_mm,
        stepover_mm: Some(stepover_mm),
        scallop_um: None,
        budget_px: None,
        polish_um: None,
        ..spec.finishing
    };
    let spec = *spec;
    let forecast = ProgramForecast::new(&profile, &spec, &subject.design)?;
    let own = subject.design.facts.pixel_error_px;
    let milled = forecast.scallops_px.zip(own).map(|(scallops, own)| Milled {
        ball_mm,
        scallop_px: scallops.rms,
        pixel_px: (own.rms * own.rms + scallops.rms * scallops.rms).sqrt(),
        forecast,
    });
    Ok(milled)
}

/// The program of the least time on the machine whose mirror has `target_px`, by the runs of `sweeps`: of each ball the widest lines
/// that its scallops allow.
pub(super) fn suggest(
    subject: &Subject,
    sweeps: &[BenchSweep],
    target_px: f64,
) -> Option<SuggestedProgram> {
    let sweep = sweeps.iter().find(|sweep| sweep.name == NAME)?;
    let own_px = subject.design.facts.pixel_error_px?.rms;
    let left_px = (target_px * target_px - own_px * own_px).max(0.0).sqrt();
    let mut balls: Vec<&BenchRun> = Vec::new();
    for run in sweep.runs.iter().filter(|run| run.profile == subject.name()) {
        if balls.iter().all(|other| other.series != run.series) {
            balls.push(run);
        }
    }
    let programs = balls.into_iter().filter_map(|widest| {
        let ball_mm = widest.figures["ball_mm"];
        // Displacements are proportional to the stepover.
        let stepover_mm = AIM * left_px * widest.setting / widest.figures["scallop_rms_px"];
        let stepover_mm = floor_four_digits(stepover_mm.min(widest.setting));
        let fits = stepover_mm >= narrowest_mm(subject, ball_mm);
        let milled = fits.then(|| planned(subject, ball_mm, stepover_mm).ok().flatten())??;
        Some(SuggestedProgram {
            ball_mm,
            stepover_mm,
            // (But for the rounding of radians.)
            angle_deg: milled.forecast.angle_deg.map(|angle| (1e6 * angle).round() / 1e6),
            pixel_rms_px: milled.pixel_px,
            machine_min: milled.forecast.machine_min,
            file: format!("{}-program.toml", subject.name()),
        })
    });
    programs.min_by(|a, b| a.machine_min.total_cmp(&b.machine_min))
}

/// `text` with the ball and the lines of a program; none where it is no table.
pub(super) fn edited(text: &[u8], program: &SuggestedProgram) -> Option<String> {
    let mut profile = document(text)?;
    let table = profile.entry("program").or_insert(Item::Table(Table::new()));
    for key in OTHER_KEYS {
        table.as_table_like_mut()?.remove(key);
    }
    let SuggestedProgram { ball_mm, stepover_mm, angle_deg, .. } = *program;
    let figures =
        [("ball_mm", Some(ball_mm)), ("stepover_mm", Some(stepover_mm)), ("angle_deg", angle_deg)];
    for (key, figure) in figures {
        let Some(figure) = figure else { continue };
        set(table, key, value(figure));
    }
    Some(profile.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Profile, shipped};

    #[test]
    fn a_profile_with_a_program_stays_valid() {
        let program = SuggestedProgram {
            ball_mm: 5.0,
            stepover_mm: 0.25,
            angle_deg: Some(90.0),
            pixel_rms_px: 1.0,
            machine_min: 60.0,
            file: "a.toml".into(),
        };
        for shipped in shipped() {
            let before = format!(
                "{}\n[program]\npolish_um = 3\nball_mm = 2 # the one at hand\n",
                shipped.text
            );
            for (text, had) in [(shipped.text, false), (&before, true)] {
                let text = edited(text.as_bytes(), &program).unwrap();
                let after = Profile::parse(shipped.name, shipped.name, text.as_bytes());
                let after = after.unwrap_or_else(|error| panic!("{error}\n{text}"));
                let FinishingSpec { ball_mm, stepover_mm, angle_deg, polish_um, .. } =
                    after.program.mill().unwrap().finishing;
                assert_eq!((ball_mm, stepover_mm), (5.0, Some(0.25)), "{text}");
                assert_eq!((angle_deg, polish_um), (Some(90.0), None), "{text}");
                assert_eq!(text.contains("ball_mm = 5.0 # the one at hand"), had, "{text}");
            }
        }
    }
}
