//! Programs that cut a profile's mirror by a slow tool servo, read back and cut.

use super::lathe_shop::{FinishingTurns, Lathe, WrittenOperation, begun, finishing_feed};
use super::made_face::{MadeFace, PagePictures};
use super::run::Run;
use super::turn_program::refused;
use super::{Error, Stage};
use crate::design::Design;
use crate::machining::TurnSpacing;
use crate::profile::{Profile, ServoControl, ServoSpec, TurnSpec};
use crate::program::{ProgramFault, TurningPath};
use crate::results::{FileFacts, ProgramReport};
use crate::turning::{
    Bar, DiscSections, ServoHeader, ServoOperation, ServoTask, TurningError, servo_program_text,
};
use crate::verdict::{BarOnLathe, TurnedShape};

/// Writes the programs, reads them back and turns the bar with them; the report so far, the face that finishing leaves, and pictures.
///
/// # Errors
/// [`Error::Turning`] where the mirror cannot be cut so, [`Error::File`] when the disk refuses.
pub(super) fn servo_cut(
    run: &mut Run,
    (spec, servo): (&TurnSpec, &ServoSpec),
    design: &Design,
) -> Result<(ProgramReport, Option<MadeFace>, PagePictures), Error> {
    let profile = run.profile;
    let refused = |why| refused(profile, why);
    let sections = checked(profile, design).map_err(refused)?;
    let shape = TurnedShape::disc(&sections);
    let nose_mm = spec.nose.radius_mm;
    let task = task((spec, servo), design, &sections, nose_mm);
    let (feed_mm, foreseen_px) = run.stage(Stage::Cut, || {
        let flattest = -sections.most(|place| {
            let stretch = place.section.stretch();
            (nose_mm * place.section.curvature - 1.0) / (stretch * stretch)
        });
        let (spacing, least_mm) = (TurnSpacing::AlongRadius, task.least_feed_mm().unwrap_or(0.0));
        // (Its moves are tilted around the axis, square to the cusps.)
        let turns = FinishingTurns { spacing, chord_tilt: 0.0, flattest, least_mm };
        let (feed_mm, foreseen) = finishing_feed(profile, spec, design, turns);
        Ok(((feed_mm, foreseen), format!("{feed_mm} mm in a turn")))
    })?;
    let task = ServoTask { feed_mm, ..task };
    let operations = run.stage(Stage::Plan, || {
        let operations = task.operations().map_err(refused)?;
        let points: usize = operations.iter().map(|done| done.table.points.len()).sum();
        let note = format!("{points} points of {} programs", operations.len());
        Ok((operations, note))
    })?;
    let mut lathe = Lathe::new(BarOnLathe::of_disc(&sections, task.bar));
    let control = servo.control.control();
    let mut report = begun(profile, (spec, control), (design, task.bar), foreseen_px);
    for operation in operations {
        let file = write(run, &task, &operation)?;
        let bytes = run.files.staged(&file)?.read()?;
        report.files.push(FileFacts::of(&file, control.ending(), &bytes));
        run.timer.always(Stage::Read, || {
            let read = read(servo.control, &bytes);
            lathe.take(&mut report, &written(&operation), (file, read), spec);
            ((), operation.kind.name().to_owned())
        });
    }
    lathe.finished(run, report, (design, &shape), (spec, task.bar.top_mm)).map_err(refused)
}

/// The sections of a part that is no tool for forming.
fn checked<'a>(profile: &Profile, design: &'a Design) -> Result<DiscSections<'a>, TurningError> {
    if let Some(tool) = &profile.part.forming {
        return Err(TurningError::Formed { form: tool.form.name() });
    }
    DiscSections::new(&design.mirror)
}

/// What is to be cut.
fn task<'a>(
    (spec, servo): (&'a TurnSpec, &'a ServoSpec),
    design: &Design,
    sections: &'a DiscSections<'a>,
    feed_mm: f64,
) -> ServoTask<'a> {
    let bounds = design.plan_bounds();
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    let rim = sections.most(|place| place.section.at.x);
    let contour = design.border.as_ref().map(|border| border.contour.polygon());
    let around = contour.iter().flatten().map(|corner| corner.length()).fold(rim, f64::max);
    let highest = sections.most(|place| place.section.at.y);
    let border = design.border.as_ref();
    ServoTask {
        sections,
        spec,
        servo,
        feed_mm,
        bar: Bar { radius_mm: reach.max(around) + spec.stock_mm, top_mm: highest + spec.stock_mm },
        floor_mm: border.map_or(0.0, |border| border.top_mm),
        has_rim: border.is_some(),
    }
}

/// Writes the program of an operation; its name.
fn write(run: &mut Run, task: &ServoTask, operation: &ServoOperation) -> Result<String, Error> {
    let control = task.servo.control;
    let file = format!("{}.{}", operation.kind.name(), control.control().ending());
    let (profile, spec) = (run.profile, task.spec);
    let Bar { radius_mm, top_mm } = task.bar;
    let nose_mm = operation.nose_mm;
    let comments = [
        format!("{}: {}", profile.name, operation.kind.name()),
        format!("profile {}", &profile.sha256[..16]),
        format!("slow tool servo, nose {nose_mm} mm radius, X is a radius"),
        "tool point: X and Z where the nose is touched off".to_owned(),
        "C0 is the part's X, C grows as the tool goes to Y".to_owned(),
        format!("bar {:.2} mm diameter, {}", 2.0 * radius_mm, spec.material.name()),
        format!("its top at Z {top_mm:.2}, Z0 on the base"),
    ];
    let header = ServoHeader {
        control,
        work_offset: spec.work_offset,
        comments: &comments,
        rounding_mm: 1e-3 * spec.finishing.chord_um,
        safe_mm: task.safe_mm(),
    };
    let text = servo_program_text(&header, operation);
    run.write(&file, |out| out.write_all(text.as_bytes()))?;
    Ok(file)
}

/// Reads a program back.
fn read(control: ServoControl, bytes: &[u8]) -> Result<TurningPath, ProgramFault> {
    match control {
        ServoControl::Linuxcnc => TurningPath::read(bytes),
        ServoControl::Xzc => TurningPath::read_table(bytes),
    }
}

fn written(operation: &ServoOperation) -> WrittenOperation {
    WrittenOperation {
        kind: operation.kind,
        nose_mm: operation.nose_mm,
        feed_mm_rev: operation.feed_mm_rev,
        spindle_rpm: operation.rpm,
        levels: operation.levels,
        allowance_mm: operation.allowance_mm,
        servo: Some((operation.table.per_turn, operation.limit)),
    }
}
