//! Programs that mill a profile's mirror, read back and cut.

use super::made_face::{MadeFace, PagePictures, noted};
use super::program_travel::travelled;
use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::geom::Cutter;
use crate::machining::BallRaster;
use crate::milling::{Header, MillingError, MillingTask, Operation, StockBlock, program_text};
use crate::num::rounding::floor_four_digits;
use crate::profile::{CutterLengths, FinishingPath, FinishingSpec, MillSpec, Profile};
use crate::program::{MachineLimits, ToolPath};
use crate::report::LeftPicture;
use crate::results::{FileFacts, FileFault, OperationFacts, ProgramReport, Reason, SCHEMA};
use crate::verdict::{
    self, CutterSurvey, MachiningOptions, MilledBlock, ProgramCut, ProgramLeft, analysis_of,
    directed, stepover_for_picture, stock_corners,
};

/// The stepover over the ball's radius at which displacements are asked for, to which they are proportional.
const FIRST_STEPOVER: f64 = 0.05;
/// The stepovers over the ball's radius that are chosen where the profile names none: narrower lines take hours for scallops that a
/// polish takes away in minutes, a few micrometres high; wider ones leave more than it takes.
const USUAL_STEPOVERS: [f64; 2] = [1.0 / 15.0, 0.3];
/// Places of the grid from line to line, at least, of what a map shows.
const PLACES_A_LINE: f64 = 2.0;
/// Height of scallops over what a polish takes away, of the study's first order.
const SCALLOPS_OF_POLISH: f64 = 0.9;

pub(super) fn refused(profile: &Profile, source: impl Into<MillingError>) -> Error {
    Error::Milling { profile: profile.name.clone(), source: source.into() }
}

/// Writes the programs, reads them back and cuts the block with them; the report so far, the face that finishing leaves, and pictures.
///
/// # Errors
/// [`Error::Milling`] where the mirror cannot be milled so, [`Error::File`] when the disk refuses.
pub(super) fn milled(
    run: &mut Run,
    spec: &MillSpec,
    design: &Design,
) -> Result<(ProgramReport, Option<MadeFace>, PagePictures), Error> {
    let survey = run.stage(Stage::Cut, || {
        let survey = survey(run.profile, spec, design).map_err(|why| refused(run.profile, why))?;
        let note = survey.note();
        Ok((survey, note))
    })?;
    let task = task(spec, design, &survey);
    let operations = run.stage(Stage::Plan, || {
        let operations = task.operations().map_err(|why| refused(run.profile, why))?;
        let moves: usize = operations.iter().map(|operation| operation.motions.len()).sum();
        let note = format!("{moves} moves of {} programs", operations.len());
        Ok((operations, note))
    })?;
    let mut shop = Shop {
        block: MilledBlock::new(design, task.stock),
        limits: limits(spec),
        read: Vec::new(),
        left: Vec::new(),
        speeds_mm_min: Vec::new(),
    };
    let mut report = begun(run.profile, spec, &survey);
    for operation in operations {
        let file = write(run, &task, &operation)?;
        let bytes = run.files.staged(&file)?.read()?;
        report.files.push(FileFacts::of(&file, "ngc", &bytes));
        run.timer.always(Stage::Read, || {
            shop.read(&mut report, &operation, (file, &bytes), task.spec);
            ((), operation.kind.name().to_owned())
        });
    }
    let moves = shop.read.iter().flatten().flat_map(|path| &path.moves);
    let travel_mm = spec.machine.travel_mm.unwrap_or([f64::INFINITY; 3]);
    travelled(&mut report, moves, task.stock.top_mm, travel_mm)
        .map_err(|why| refused(run.profile, why))?;
    let ball_mm = spec.finishing.ball_mm;
    let face = shop.read.last().and_then(Option::as_ref).map(|path| MadeFace {
        cut: run
            .timer
            .always(Stage::Cut, || noted(ProgramCut::new(design, path, Cutter::ball(ball_mm)))),
        words: format!("as milled, ball {ball_mm}"),
    });
    let pictures = PagePictures { left: shop.left, speeds_mm_min: shop.speeds_mm_min };
    Ok((report, face, pictures))
}

/// The study of the finishing raster, which keeps the picture within the profile's limits where it does not name its lines.
pub(super) fn survey<'a>(
    profile: &Profile,
    spec: &MillSpec,
    design: &'a Design,
) -> Result<CutterSurvey<'a>, MillingError> {
    let FinishingSpec { ball_mm, path, stepover_mm, budget_px, angle_deg, .. } = spec.finishing;
    let FinishingSpec { scallop_um, polish_um, chord_um, .. } = spec.finishing;
    // (Chords stand out of the mirror too.)
    let polished = polish_um.map(|um| SCALLOPS_OF_POLISH * (um - chord_um).max(0.5 * um));
    let scallop_um = [scallop_um, polished].into_iter().flatten().reduce(f64::min);
    let mut options = MachiningOptions {
        ball_mm,
        stepover_mm,
        angle_deg,
        budget_px,
        scallop_um,
        allowance_mm: spec.stock_mm,
        as_cut: false,
    };
    if !profile.is_one_surface() || profile.part.forming.is_some() {
        return Ok(CutterSurvey::of_path(profile, design, &options, path)?);
    }
    if stepover_mm.is_none() {
        let analysis = analysis_of(design, path);
        let (_, raster) = directed(&analysis, &options);
        let raster = BallRaster { stepover_mm: FIRST_STEPOVER * ball_mm, ..raster };
        let for_picture = match budget_px {
            Some(px) => analysis.stepover_for_pixels(&raster, px),
            None if polish_um.is_some() => None,
            None => stepover_for_picture(profile, design, &analysis, &raster),
        };
        let for_height = scallop_um.and_then(|um| analysis.stepover_for_height(&raster, 1e-3 * um));
        let ends = [for_picture, for_height].into_iter().flatten();
        let [narrowest, widest] = USUAL_STEPOVERS.map(|share| share * ball_mm);
        let narrowest = narrowest.max(ProgramCut::narrowest_mm(&design.mirror, path, ball_mm));
        let stepover_mm = ends.fold(widest, f64::min).max(narrowest);
        options.stepover_mm = Some(floor_four_digits(stepover_mm));
    }
    let survey = CutterSurvey::of_path(profile, design, &options, path)?;
    match &survey.hollow {
        Some(why) => Err(MillingError::Unreached {
            why: why.to_string(),
            what: "finishing",
            key: "program.ball_mm",
        }),
        None => Ok(survey),
    }
}

/// What is to be milled.
pub(super) fn task<'a>(
    spec: &'a MillSpec,
    design: &'a Design,
    survey: &'a CutterSurvey<'a>,
) -> MillingTask<'a> {
    let [min, max] = stock_corners(design, spec.stock_mm);
    let [.., top_mm] = survey.found.stock.size_mm;
    let border = design.border.as_ref();
    MillingTask {
        mirror: &design.mirror,
        analysis: &survey.analysis,
        spec,
        raster: survey.raster,
        stock: StockBlock { min, max, top_mm },
        floor_mm: border.map_or(0.0, |border| border.top_mm),
        has_rim: border.is_some(),
    }
}

/// Direction of the finishing lines, degrees; none of a spiral.
pub(super) fn direction_of(spec: &MillSpec, angle_deg: f64) -> Option<f64> {
    (spec.finishing.path == FinishingPath::Lines).then_some(angle_deg)
}

/// What the machine's axes can do.
pub(super) fn limits(spec: &MillSpec) -> MachineLimits {
    let machine = &spec.machine;
    MachineLimits {
        rapid_mm_min: machine.rapid_mm_min,
        acceleration_mm_s2: machine.acceleration_mm_s2,
        jerk_mm_s3: machine.jerk_mm_s3,
    }
}

fn begun(profile: &Profile, spec: &MillSpec, survey: &CutterSurvey) -> ProgramReport {
    let found = &survey.found;
    ProgramReport {
        schema: SCHEMA,
        profile: profile.into(),
        material: spec.material,
        control: spec.control.control(),
        work_offset: spec.work_offset.name().to_owned(),
        stock: found.stock,
        angle_deg: direction_of(spec, found.angle_deg),
        operations: Vec::new(),
        machine_min: 0.0,
        reach_mm: 0.0,
        holder_diameter_mm: Some(spec.machine.holder_diameter_mm),
        travel_mm: [0.0; 3],
        foreseen_px: found.scallops.as_ref().and_then(|scallops| scallops.pixel_error_px),
        program: None,
        as_cut: None,
        frame: None,
        accepted: None,
        files: Vec::new(),
        verdict: verdict::of(&found.reasons),
        reasons: Vec::new(),
        warnings: found.warnings.clone(),
    }
}

/// Writes the program of an operation; its name.
fn write(run: &mut Run, task: &MillingTask, operation: &Operation) -> Result<String, Error> {
    let file = format!("{}.ngc", operation.kind.name());
    let profile = run.profile;
    let StockBlock { min, max, top_mm } = task.stock;
    let [size, low] = [max - min, min];
    let comments = [
        format!("{}: {}", profile.name, operation.kind.name()),
        format!("profile {}", &profile.sha256[..16]),
        cutter_words(operation, task.spec),
        format!(
            "stock {:.2} x {:.2} x {top_mm:.2} mm, {}",
            size.x,
            size.y,
            task.spec.material.name()
        ),
        format!("its corner at X {:.2} Y {:.2}, its top at Z {top_mm:.2}", low.x, low.y),
        format!("zero: {}, mirror's middle, Z0 on the base", task.spec.work_offset.name()),
    ];
    let header = Header {
        control: task.spec.control,
        work_offset: task.spec.work_offset,
        comments: &comments,
        rounding_mm: 1e-3 * task.spec.finishing.chord_um,
    };
    let text = program_text(&header, operation);
    run.write(&file, |out| out.write_all(text.as_bytes()))?;
    Ok(file)
}

/// The cutter of an operation, as the head of its program tells it.
fn cutter_words(operation: &Operation, spec: &MillSpec) -> String {
    let CutterLengths { flute_mm, stickout_mm, .. } = operation.lengths;
    let teeth = flute_mm.map_or(String::new(), |mm| format!(" {mm} mm long"));
    let out = stickout_mm.map_or(String::new(), |mm| format!(", {mm} mm out of its holder"));
    let cutter = match operation.cutter.ball_mm() {
        Some(ball_mm) => format!("ball {ball_mm} mm radius"),
        None => operation.cutter.words(),
    };
    format!("{cutter}, {} teeth{teeth}{out}", spec.speeds.teeth)
}

/// The block in the course of its programs, as they are read back.
struct Shop {
    block: MilledBlock,
    limits: MachineLimits,
    /// The programs' moves, in their order; none of one that cannot be read.
    read: Vec<Option<ToolPath>>,
    /// What is left after each, by its name.
    left: Vec<(String, LeftPicture)>,
    /// Speeds in equal parts of the time of each that can be read.
    speeds_mm_min: Vec<Vec<f64>>,
}

impl Shop {
    /// Reads a program back, and cuts the block with it.
    fn read(
        &mut self,
        report: &mut ProgramReport,
        operation: &Operation,
        (file, bytes): (String, &[u8]),
        spec: &MillSpec,
    ) {
        let path = match ToolPath::read(bytes) {
            Ok(path) => path,
            Err(error) => {
                let fault = FileFault::Unreadable(error.to_string());
                report.reasons.push(Reason::from(fault).of_file(&file));
                self.read.push(None);
                return;
            }
        };
        let Operation { kind, cutter, allowance_mm, .. } = *operation;
        let other = cutter.ball_mm().is_none().then_some(cutter);
        let figures = [1e-3 * spec.finishing.chord_um, spec.machine.holder_diameter_mm];
        let ProgramLeft { left, lengths: [flute, stickout], faults } =
            self.block.cut(&path, operation, figures);
        let faults = faults.into_iter().map(Reason::from);
        report.reasons.extend(faults.map(|fault| fault.of_file(&file)));
        let time = self.limits.time(&path.moves);
        report.machine_min += time.minutes();
        report.operations.push(OperationFacts {
            ball_mm: cutter.ball_mm(),
            radius_mm: other.map(|cutter| cutter.radius_mm),
            corner_mm: other.map(|cutter| cutter.corner_mm),
            stepover_mm: Some(operation.stepover_mm),
            left,
            flute,
            stickout,
            ..OperationFacts::of_path(
                (kind, file),
                (operation.levels, allowance_mm, operation.speeds),
                &path,
                &time,
            )
        });
        let (left_mm, size, pitch_mm) = self.block.map();
        // Lines that the grid cannot show leave a pattern of its own.
        if operation.stepover_mm >= PLACES_A_LINE * pitch_mm {
            let map = ProgramReport::left_map(&left_mm, (size, pitch_mm), kind.name());
            self.left.push((kind.name().to_owned(), LeftPicture::Map(map)));
        }
        self.speeds_mm_min.push(time.speeds_mm_min);
        self.read.push(Some(path));
    }
}
