//! What programs of lathes and slow tool servos have in common: the feed of finishing, the report, and the bar as they are read back.

use super::Stage;
use super::made_face::{MadeFace, PagePictures, noted};
use super::program_travel::travelled;
use super::run::Run;
use crate::design::Design;
use crate::machining::{SurfaceAnalysis, TurnSpacing};
use crate::milling::{OperationKind, Speeds};
use crate::num::rounding::{floor_four_digits, significant};
use crate::num::stats::Summary;
use crate::profile::{Profile, ProgramControl, TurnSpec};
use crate::program::{MachineLimits, MachineTime, ProgramFault, TurningPath};
use crate::report::LeftPicture;
use crate::results::{
    FileFault, OperationFacts, ProgramReport, Reason, SCHEMA, ServoFacts, StockFacts,
};
use crate::turning::{Bar, ServoLimit, TurningError, usual_feed_mm};
use crate::verdict::{
    self, BarOnLathe, CutTask, TurnedLeft, TurnedShape, axis_faults, room_for_picture, turned_cut,
};
use std::f64::consts::PI;

/// Widest feed that is chosen where the profile names none, over the nose's radius: cusps are then an eighth of a hundredth of it high.
const WIDEST_FEED: f64 = 0.1;
/// The narrowest, mm: that of the finest diamond turning, and the least that a profile may ask for.
const NARROWEST_MM: f64 = 1e-3;
/// Height of cusps over what a polish takes away, of the study's first order.
const CUSPS_OF_POLISH: f64 = 0.9;

/// Turns of finishing over a mirror.
pub(super) struct FinishingTurns {
    /// Along which way they are a feed apart.
    pub spacing: TurnSpacing,
    /// Largest tilt of straight moves along the radius from their path over that of the cusps, to which it adds.
    pub chord_tilt: f64,
    /// The least `f^2 / (8 r h)` of cusps h high that a feed f and a nose r leave: `1 + r k`, where the mirror bulges with the curvature k
    /// along the radius, over the square of what turns are apart on the mirror over f.
    pub flattest: f64,
    /// The least feed that may be chosen, mm.
    pub least_mm: f64,
}

/// The feed of finishing, mm, which keeps the picture within the profile's limits where the profile does not name it, and what it is
/// foreseen to leave.
pub(super) fn finishing_feed(
    profile: &Profile,
    spec: &TurnSpec,
    design: &Design,
    turns: FinishingTurns,
) -> (f64, Option<Summary>) {
    let nose_mm = spec.nose.radius_mm;
    let analysis = SurfaceAnalysis::new(&design.mirror, &design.camera, design.view.as_ref());
    let FinishingTurns { spacing, chord_tilt, flattest, least_mm } = turns;
    // Cusps are tilted by up to f / (2 r), whatever the mirror's curvature.
    let foreseen = |feed_mm: f64| analysis.displacements_of_turns(0.5 * feed_mm / nose_mm, spacing);
    let finishing = &spec.finishing;
    if let Some(feed_mm) = finishing.feed_mm_rev {
        return (feed_mm, foreseen(feed_mm));
    }
    let narrowest_mm = least_mm.max(NARROWEST_MM);
    let widest_mm = (WIDEST_FEED * nose_mm).max(narrowest_mm).min(usual_feed_mm(spec));
    let widest = foreseen(widest_mm);
    let polish_um = finishing.polish_um;
    let for_picture = widest.and_then(|px| match finishing.budget_px {
        Some(budget_px) => Some(widest_mm * budget_px / px.p95),
        None if polish_um.is_some() => None,
        None => {
            let [rms_px, max_px] = room_for_picture(profile, design)?;
            Some(widest_mm * (rms_px / px.rms).min(max_px / (px.max * (1.0 + chord_tilt))))
        }
    });
    // (Chords stand out of the mirror too.)
    let chord_um = finishing.chord_um;
    let polished = polish_um.map(|um| CUSPS_OF_POLISH * (um - chord_um).max(0.5 * um));
    let heights_um = [finishing.scallop_um, polished].into_iter().flatten().reduce(f64::min);
    let for_height =
        heights_um.map(|um| f64::sqrt(8.0 * nose_mm * flattest.max(0.0) * (1e-3 * um)));
    let ends = [for_picture, for_height].into_iter().flatten();
    let feed_mm = floor_four_digits(ends.fold(widest_mm, f64::min).max(narrowest_mm));
    (feed_mm, foreseen(feed_mm))
}

/// The report before the first program.
pub(super) fn begun(
    profile: &Profile,
    (spec, control): (&TurnSpec, ProgramControl),
    (design, Bar { radius_mm, top_mm }): (&Design, Bar),
    foreseen_px: Option<Summary>,
) -> ProgramReport {
    let (volume_mm3, part_mm3) = (PI * radius_mm * radius_mm * top_mm, design.volume());
    ProgramReport {
        schema: SCHEMA,
        profile: profile.into(),
        material: spec.material,
        control,
        work_offset: spec.work_offset.name().to_owned(),
        stock: StockFacts {
            size_mm: [2.0 * radius_mm, 2.0 * radius_mm, top_mm],
            allowance_mm: spec.stock_mm,
            volume_mm3,
            part_mm3,
            removed_mm3: volume_mm3 - part_mm3,
        },
        angle_deg: None,
        operations: Vec::new(),
        machine_min: 0.0,
        reach_mm: 0.0,
        holder_diameter_mm: None,
        travel_mm: [0.0; 3],
        foreseen_px,
        program: None,
        as_cut: None,
        frame: None,
        accepted: None,
        files: Vec::new(),
        verdict: verdict::of::<Reason>(&[]),
        reasons: Vec::new(),
        warnings: Vec::new(),
    }
}

/// An operation as its program was written.
pub(super) struct WrittenOperation {
    pub kind: OperationKind,
    pub nose_mm: f64,
    pub feed_mm_rev: f64,
    pub spindle_rpm: f64,
    pub levels: usize,
    pub allowance_mm: f64,
    /// Points of a turn, and what holds the speed of C down; none of a lathe.
    pub servo: Option<(usize, ServoLimit)>,
}

/// The bar in the course of its programs, as they are read back.
pub(super) struct Lathe {
    bar: BarOnLathe,
    /// The programs' moves, in their order; none of one that cannot be read.
    read: Vec<Option<TurningPath>>,
    pictures: PagePictures,
}

impl Lathe {
    /// Before its first program.
    pub(super) fn new(bar: BarOnLathe) -> Self {
        let pictures = PagePictures { left: Vec::new(), speeds_mm_min: Vec::new() };
        Self { bar, read: Vec::new(), pictures }
    }

    /// Takes in a program as it was read back, and turns the bar with it.
    pub(super) fn take(
        &mut self,
        report: &mut ProgramReport,
        operation: &WrittenOperation,
        (file, read): (String, Result<TurningPath, ProgramFault>),
        spec: &TurnSpec,
    ) {
        let path = match read {
            Ok(path) => path,
            Err(error) => {
                let fault = FileFault::Unreadable(error.to_string());
                report.reasons.push(Reason::from(fault).of_file(&file));
                self.read.push(None);
                return;
            }
        };
        let WrittenOperation { kind, nose_mm, allowance_mm, .. } = *operation;
        let chord_mm = 1e-3 * spec.finishing.chord_um;
        let task = CutTask { kind, nose_mm, allowance_mm, chord_mm };
        let TurnedLeft { left, faults } = self.bar.cut(&path, task);
        let faults = faults.into_iter().chain(axis_faults(&spec.machine, &path));
        let faults = faults.map(Reason::from);
        report.reasons.extend(faults.map(|fault| fault.of_file(&file)));
        let time = time(spec, &path);
        report.machine_min += time.minutes();
        report.operations.push(OperationFacts { left, ..facts(operation, file, &path, &time) });
        let section = LeftPicture::Section(self.bar.section());
        self.pictures.left.push((kind.name().to_owned(), section));
        self.pictures.speeds_mm_min.push(time.speeds_mm_min);
        self.read.push(Some(path));
    }

    /// The report with what all programs travel, the face that the last of them leaves, and pictures.
    pub(super) fn finished(
        self,
        run: &mut Run,
        mut report: ProgramReport,
        (design, shape): (&Design, &TurnedShape),
        (spec, top_mm): (&TurnSpec, f64),
    ) -> Result<(ProgramReport, Option<MadeFace>, PagePictures), TurningError> {
        let moves = self.read.iter().flatten().flat_map(|path| &path.tool.moves);
        let [x, z] = spec.machine.travel_mm.unwrap_or([f64::INFINITY; 2]);
        travelled(&mut report, moves, top_mm, [x, f64::INFINITY, z])?;
        let nose_mm = spec.nose.radius_mm;
        let face = self.read.last().and_then(Option::as_ref).map(|path| MadeFace {
            cut: run.timer.always(Stage::Cut, || noted(turned_cut(design, shape, path, nose_mm))),
            words: format!("as turned, nose {nose_mm}"),
        });
        Ok((report, face, self.pictures))
    }
}

/// What is told of an operation but for what it leaves.
fn facts(
    operation: &WrittenOperation,
    file: String,
    path: &TurningPath,
    time: &MachineTime,
) -> OperationFacts {
    let WrittenOperation { feed_mm_rev, spindle_rpm, .. } = *operation;
    let feed_mm_min = match operation.servo {
        Some(_) => significant(feed_mm_rev * spindle_rpm, 5),
        None => feed_mm_rev * spindle_rpm,
    };
    let rates = path.axis_rates();
    let speeds = Speeds { spindle_rpm, feed_mm_min, entry_feed_mm_min: feed_mm_min };
    OperationFacts {
        nose_mm: Some(operation.nose_mm),
        feed_mm_rev: Some(feed_mm_rev),
        servo: operation.servo.map(|(points_rev, limited_by)| ServoFacts {
            points_rev,
            acceleration_mm_s2: rates.acceleration.most,
            speed_mm_min: rates.speed.most,
            limited_by,
        }),
        ..OperationFacts::of_path(
            (operation.kind, file),
            (operation.levels, operation.allowance_mm, speeds),
            &path.tool,
            time,
        )
    }
}

/// Time of a program: of moves of an axis C that which they are told to take.
fn time(spec: &TurnSpec, path: &TurningPath) -> MachineTime {
    let limits = MachineLimits {
        rapid_mm_min: spec.machine.rapid_mm_min,
        acceleration_mm_s2: spec.machine.acceleration_mm_s2,
        jerk_mm_s3: spec.machine.jerk_mm_s3,
    };
    if !path.is_commanded() {
        return limits.time(&path.tool.moves);
    }
    let minutes: Vec<f64> = path.commanded.iter().map(|turn| turn.minutes).collect();
    limits.told_time(&path.tool.moves, &minutes)
}
