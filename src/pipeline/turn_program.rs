//! Programs that turn a profile's mirror, read back and cut.

use super::lathe_shop::{FinishingTurns, Lathe, WrittenOperation, begun, finishing_feed};
use super::made_face::{MadeFace, PagePictures};
use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::geom::Contour;
use crate::machining::TurnSpacing;
use crate::profile::{LatheControl, Profile, TurnSpec};
use crate::program::TurningPath;
use crate::results::{FileFacts, ProgramReport};
use crate::turning::{
    Bar, FINE_SLOPE, LatheHeader, Meridian, TurnedOperation, TurningError, TurningTask,
    lathe_program_text,
};
use crate::verdict::{BarOnLathe, TurnedShape};

/// The command's error of a mirror that cannot be turned so.
pub(super) fn refused(profile: &Profile, source: TurningError) -> Error {
    Error::Turning { profile: profile.name.clone(), source }
}

/// Writes the programs, reads them back and turns the bar with them; the report so far, the face that finishing leaves, and pictures.
///
/// # Errors
/// [`Error::Turning`] where the mirror cannot be turned so, [`Error::File`] when the disk refuses.
pub(super) fn turned(
    run: &mut Run,
    (spec, control): (&TurnSpec, LatheControl),
    design: &Design,
) -> Result<(ProgramReport, Option<MadeFace>, PagePictures), Error> {
    let profile = run.profile;
    let refused = |why| refused(profile, why);
    let meridian = checked(profile, design).map_err(refused)?;
    let (shape, nose_mm) = (TurnedShape::round(&meridian), spec.nose.radius_mm);
    let (feed_mm, foreseen_px) = run.stage(Stage::Cut, || {
        let bulge = |curvature: f64| 1.0 - nose_mm * curvature;
        let bulges = meridian.places().map(|place| bulge(place.curvature));
        let least = bulges.fold(f64::INFINITY, f64::min);
        let turns = FinishingTurns {
            spacing: TurnSpacing::AlongMirror,
            chord_tilt: FINE_SLOPE,
            flattest: least,
            least_mm: 0.0,
        };
        let (feed_mm, foreseen) = finishing_feed(profile, spec, design, turns);
        Ok(((feed_mm, foreseen), format!("{feed_mm} mm in a turn")))
    })?;
    let task = task(spec, design, meridian, feed_mm);
    let operations = run.stage(Stage::Plan, || {
        let operations = task.operations().map_err(refused)?;
        let moves: usize = operations.iter().map(|operation| operation.motions.len()).sum();
        let note = format!("{moves} moves of {} programs", operations.len());
        Ok((operations, note))
    })?;
    let mut lathe = Lathe::new(BarOnLathe::new(design, &meridian, task.bar));
    let mut report = begun(profile, (spec, control.control()), (design, task.bar), foreseen_px);
    for operation in operations {
        let file = write(run, (&task, control), &operation)?;
        let bytes = run.files.staged(&file)?.read()?;
        report.files.push(FileFacts::of(&file, "ngc", &bytes));
        run.timer.always(Stage::Read, || {
            let read = TurningPath::read(&bytes);
            lathe.take(&mut report, &written(&operation), (file, read), spec);
            ((), operation.kind.name().to_owned())
        });
    }
    lathe.finished(run, report, (design, &shape), (spec, task.bar.top_mm)).map_err(refused)
}

/// The section of a part that is round.
fn checked<'a>(profile: &Profile, design: &'a Design) -> Result<Meridian<'a>, TurningError> {
    if let Some(tool) = &profile.part.forming {
        return Err(TurningError::Formed { form: tool.form.name() });
    }
    if let Some(Contour::Rect { .. }) = design.border.as_ref().map(|border| border.contour) {
        return Err(TurningError::NotRound {
            what: "the flat rim around the mirror is a rectangle",
        });
    }
    Meridian::new(&design.mirror)
}

/// What is to be turned.
fn task<'a>(
    spec: &'a TurnSpec,
    design: &Design,
    meridian: Meridian<'a>,
    feed_mm: f64,
) -> TurningTask<'a> {
    let highest = meridian.places().map(|place| place.at.y).fold(f64::NEG_INFINITY, f64::max);
    let border = design.border.as_ref();
    TurningTask {
        meridian,
        spec,
        feed_mm,
        bar: Bar {
            radius_mm: design.plan_bounds().max.x + spec.stock_mm,
            top_mm: highest + spec.stock_mm,
        },
        floor_mm: border.map_or(0.0, |border| border.top_mm),
        has_rim: border.is_some(),
    }
}

/// Writes the program of an operation; its name.
fn write(
    run: &mut Run,
    (task, control): (&TurningTask, LatheControl),
    operation: &TurnedOperation,
) -> Result<String, Error> {
    let file = format!("{}.ngc", operation.kind.name());
    let (profile, spec) = (run.profile, task.spec);
    let Bar { radius_mm, top_mm } = task.bar;
    let nose_mm = operation.nose_mm;
    let comments = [
        format!("{}: {}", profile.name, operation.kind.name()),
        format!("profile {}", &profile.sha256[..16]),
        format!("lathe, nose {nose_mm} mm radius, X is a diameter"),
        "tool point: X and Z where the nose is touched off".to_owned(),
        format!("bar {:.2} mm diameter, {}", 2.0 * radius_mm, spec.material.name()),
        format!("its top at Z {top_mm:.2}, Z0 on the base"),
    ];
    let header = LatheHeader {
        control,
        work_offset: spec.work_offset,
        comments: &comments,
        rounding_mm: 1e-3 * spec.finishing.chord_um,
        max_spindle_rpm: spec.machine.max_spindle_rpm,
    };
    let text = lathe_program_text(&header, operation);
    run.write(&file, |out| out.write_all(text.as_bytes()))?;
    Ok(file)
}

fn written(operation: &TurnedOperation) -> WrittenOperation {
    WrittenOperation {
        kind: operation.kind,
        nose_mm: operation.nose_mm,
        feed_mm_rev: operation.feed_mm_rev,
        spindle_rpm: operation.spindle_rpm,
        levels: operation.levels,
        allowance_mm: operation.allowance_mm,
        servo: None,
    }
}
