//! `morion program`: programs that mill a profile's mirror, read back, cut and traced.

use super::as_cut::written_as_cut;
use super::page_figures::{ErrorMap, ErrorMapBuilder, MAP_COLUMNS};
use super::run::{Command, Run};
use super::{Error, Stage};
use crate::design::Design;
use crate::machining::{BallRaster, SurfaceAnalysis};
use crate::milling::{Header, MillingError, MillingTask, Operation, StockBlock, program_text};
use crate::num::rounding::floor_four_digits;
use crate::profile::{CutterLengths, FinishingSpec, Profile, ProgramSpec};
use crate::program::{MachineLimits, MachineTime, ToolMove, ToolPath};
use crate::raster::{EncodingError, FalseColourMap};
use crate::report::Answer;
use crate::results::{
    AsCutFacts, CutDeparture, CuttingFault, FileFacts, FileFault, OperationFacts, ProgramReport,
    Reason, ReasonKind, SCHEMA,
};
use crate::verdict::{
    self, CutterSurvey, Findings, HeldTo, MachiningOptions, MilledBlock, ProgramCut, ProgramLeft,
    directed, stepover_for_picture, stock_corners,
};
use std::path::{Path, PathBuf};

/// Writes programs that mill the mirror as `[program]` of the profile asks: `roughing`, `semi-finishing` and `finishing.ngc`,
/// `program.json`, `program.html` and `as-cut.stl` into NAME/program.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ProgramOptions;

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

impl Command for ProgramOptions {
    type Report = ProgramReport;

    fn folder(&self, profile: &Profile) -> PathBuf {
        Path::new(&profile.name).join("program")
    }

    fn run(&self, run: &mut Run) -> Result<ProgramReport, Error> {
        let design = run.design()?;
        let survey = run.stage(Stage::Cut, || {
            let survey = survey(run.profile, &design).map_err(|why| refused(run.profile, why))?;
            let note = survey.note();
            Ok((survey, note))
        })?;
        let task = task(run.profile, &design, &survey);
        let operations = run.stage(Stage::Plan, || {
            let operations = task.operations().map_err(|why| refused(run.profile, why))?;
            let moves: usize = operations.iter().map(|operation| operation.motions.len()).sum();
            let note = format!("{moves} moves of {} programs", operations.len());
            Ok((operations, note))
        })?;
        let mut shop = Shop {
            block: MilledBlock::new(&design, task.stock),
            limits: limits(run.profile),
            read: Vec::new(),
            maps: Vec::new(),
            speeds_mm_min: Vec::new(),
        };
        let mut report = begun(run.profile, &survey);
        for operation in operations {
            let file = write(run, &task, &operation)?;
            let bytes = run.files.staged(&file)?.read()?;
            report.files.push(FileFacts::of(&file, "ngc", &bytes));
            run.timer.always(Stage::Read, || {
                shop.read(&mut report, &operation, (file, &bytes), task.spec);
                ((), operation.kind.name().to_owned())
            });
        }
        measured(run.profile, &task, &shop, &mut report)?;
        let errors = cut(run, &design, &shop, &mut report)?;
        report.verdict = verdict::of(&report.reasons);
        publish(run, &shop, errors.as_ref(), &report)?;
        Ok(report)
    }
}

/// The study of the finishing raster, which keeps the picture within the profile's limits where it does not name its lines.
pub(super) fn survey<'a>(
    profile: &Profile,
    design: &'a Design,
) -> Result<CutterSurvey<'a>, MillingError> {
    let FinishingSpec { ball_mm, stepover_mm, budget_px, angle_deg, .. } =
        profile.program.finishing;
    let FinishingSpec { scallop_um, polish_um, chord_um, .. } = profile.program.finishing;
    // (Chords stand out of the mirror too.)
    let polished = polish_um.map(|um| SCALLOPS_OF_POLISH * (um - chord_um).max(0.5 * um));
    let scallop_um = [scallop_um, polished].into_iter().flatten().reduce(f64::min);
    let mut options = MachiningOptions {
        ball_mm,
        stepover_mm,
        angle_deg,
        budget_px,
        scallop_um,
        allowance_mm: profile.program.stock_mm,
        as_cut: false,
    };
    if !profile.is_one_surface() || profile.part.forming.is_some() {
        return Ok(CutterSurvey::new(profile, design, &options)?);
    }
    if stepover_mm.is_none() {
        let analysis = SurfaceAnalysis::new(&design.mirror, &design.camera, design.view.as_ref());
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
        let narrowest = narrowest.max(ProgramCut::narrowest_mm(&design.mirror));
        let stepover_mm = ends.fold(widest, f64::min).max(narrowest);
        options.stepover_mm = Some(floor_four_digits(stepover_mm));
    }
    let survey = CutterSurvey::new(profile, design, &options)?;
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
    profile: &'a Profile,
    design: &'a Design,
    survey: &'a CutterSurvey<'a>,
) -> MillingTask<'a> {
    let [min, max] = stock_corners(design, profile.program.stock_mm);
    let [.., top_mm] = survey.found.stock.size_mm;
    let border = design.border.as_ref();
    MillingTask {
        mirror: &design.mirror,
        analysis: &survey.analysis,
        spec: &profile.program,
        raster: survey.raster,
        stock: StockBlock { min, max, top_mm },
        floor_mm: border.map_or(0.0, |border| border.top_mm),
        has_rim: border.is_some(),
    }
}

/// What the machine's axes can do.
pub(super) fn limits(profile: &Profile) -> MachineLimits {
    let machine = &profile.program.machine;
    MachineLimits {
        rapid_mm_min: machine.rapid_mm_min,
        acceleration_mm_s2: machine.acceleration_mm_s2,
    }
}

fn begun(profile: &Profile, survey: &CutterSurvey) -> ProgramReport {
    let found = &survey.found;
    ProgramReport {
        schema: SCHEMA,
        profile: profile.into(),
        material: profile.program.material,
        control: profile.program.control,
        work_offset: profile.program.work_offset.name().to_owned(),
        stock: found.stock,
        angle_deg: found.angle_deg,
        operations: Vec::new(),
        machine_min: 0.0,
        reach_mm: 0.0,
        holder_diameter_mm: profile.program.machine.holder_diameter_mm,
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
fn cutter_words(operation: &Operation, spec: &ProgramSpec) -> String {
    let CutterLengths { flute_mm, stickout_mm, .. } = operation.lengths;
    let teeth = flute_mm.map_or(String::new(), |mm| format!(" {mm} mm long"));
    let out = stickout_mm.map_or(String::new(), |mm| format!(", {mm} mm out of its holder"));
    format!("ball {} mm radius, {} teeth{teeth}{out}", operation.ball_mm, spec.speeds.teeth)
}

/// The block in the course of its programs, as they are read back.
struct Shop {
    block: MilledBlock,
    limits: MachineLimits,
    /// The programs' moves, in their order; none of one that cannot be read.
    read: Vec<Option<ToolPath>>,
    /// What is left after each, by its name.
    maps: Vec<(String, FalseColourMap)>,
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
        spec: &ProgramSpec,
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
        let Operation { kind, ball_mm, allowance_mm, .. } = *operation;
        let figures = [1e-3 * spec.finishing.chord_um, spec.machine.holder_diameter_mm];
        let ProgramLeft { left, lengths: [flute, stickout], faults } =
            self.block.cut(&path, operation, figures);
        let faults = faults.into_iter().map(Reason::from);
        report.reasons.extend(faults.map(|fault| fault.of_file(&file)));
        let [cutting_mm, rapid_mm] = path.lengths_mm();
        let time = self.limits.time(&path.moves);
        let machine_min = time.minutes();
        let MachineTime { at_feed_min, changing_min, rapid_min, speeds_mm_min } = time;
        report.machine_min += machine_min;
        report.operations.push(OperationFacts {
            operation: kind,
            file,
            ball_mm,
            stepover_mm: operation.stepover_mm,
            levels: operation.levels,
            allowance_mm,
            speeds: operation.speeds,
            lines: path.lines,
            moves: path.moves.len(),
            cutting_mm,
            rapid_mm,
            machine_min,
            at_feed_min,
            changing_min,
            rapid_min,
            left,
            flute,
            stickout,
        });
        let (left_mm, size, pitch_mm) = self.block.map();
        // Lines that the grid cannot show leave a pattern of its own.
        if operation.stepover_mm >= PLACES_A_LINE * pitch_mm {
            let map = ProgramReport::left_map(&left_mm, (size, pitch_mm), kind.name());
            self.maps.push((kind.name().to_owned(), map));
        }
        self.speeds_mm_min.push(speeds_mm_min);
        self.read.push(Some(path));
    }
}

/// What the programs travel, and how far a cutter stands out.
///
/// # Errors
/// [`MillingError::Travel`] where the machine is too small.
fn measured(
    profile: &Profile,
    task: &MillingTask,
    shop: &Shop,
    report: &mut ProgramReport,
) -> Result<(), Error> {
    let moves = || shop.read.iter().flatten().flat_map(|path: &ToolPath| &path.moves);
    let ends = |axis: usize| {
        let places = || moves().flat_map(|step: &ToolMove| [step.from[axis], step.to[axis]]);
        [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)]
    };
    for axis in 0..3 {
        let [low, high] = ends(axis);
        report.travel_mm[axis] = (high - low).max(0.0);
    }
    report.reach_mm = (task.stock.top_mm - ends(2)[0]).max(0.0);
    let travel = profile.program.machine.travel_mm.unwrap_or([f64::INFINITY; 3]);
    for (axis, (&needed_mm, travel_mm)) in report.travel_mm.iter().zip(travel).enumerate() {
        if needed_mm > travel_mm {
            let axis = ["X", "Y", "Z"][axis];
            return Err(refused(profile, MillingError::Travel { axis, needed_mm, travel_mm }));
        }
    }
    Ok(())
}

/// Cuts the mirror with the finishing program as it was read, writes the part as cut, reads it back and traces it; the map of its
/// pixel errors.
fn cut(
    run: &mut Run,
    design: &Design,
    shop: &Shop,
    report: &mut ProgramReport,
) -> Result<Option<FalseColourMap>, Error> {
    let Some(Some(path)) = shop.read.last() else { return Ok(None) };
    let ball_mm = run.profile.program.finishing.ball_mm;
    let cut = run.timer.always(Stage::Cut, || {
        let cut = ProgramCut::new(design, path, ball_mm);
        let note = match &cut {
            Ok(cut) => format!("{} optical triangles", cut.mesh.triangles.len()),
            Err(fault) => fault.to_string(),
        };
        (cut, note)
    });
    let of_program = |fault: CuttingFault| Reason::from(fault).of_file("finishing.ngc");
    let ProgramCut { mesh, facts, faults, warning } = match cut {
        Ok(cut) => cut,
        Err(fault) => {
            report.reasons.push(of_program(fault));
            return Ok(None);
        }
    };
    let optical_triangles = mesh.triangles.len();
    let polish_um = run.profile.program.finishing.polish_um;
    let high = polish_um.filter(|um| facts.highest.off_um > *um).map(|limit_um| {
        let CutDeparture { off_um: found_um, at_mm: [x, y, _], .. } = facts.highest;
        of_program(CuttingFault::Unpolished { found_um, limit_um, at_mm: [x, y] })
    });
    report.reasons.extend(high);
    report.program = Some(facts);
    report.reasons.extend(faults.into_iter().map(of_program));
    report.warnings.extend(warning);
    let mut errors = ErrorMapBuilder::new(design, MAP_COLUMNS);
    let words = format!("as milled, ball {ball_mm}");
    let mut check = written_as_cut(run, design, mesh, words, &mut |strip, _| errors.add(strip))?;
    check.held_to = HeldTo::Picture;
    let errors: ErrorMap = errors.finish();
    let Findings { files, trace, frame, accepted, reasons, .. } =
        Findings::new(run.profile, design, vec![check]);
    report.files.extend(files);
    let is_polished_off = |reason: &Reason| {
        polish_um.is_some() && matches!(reason.kind, ReasonKind::Picture(_) | ReasonKind::Rays(_))
    };
    report.reasons.extend(reasons.into_iter().filter(|reason| !is_polished_off(reason)));
    let trace = trace.into_iter().next();
    report.as_cut = trace.map(|trace| AsCutFacts { optical_triangles, trace });
    (report.frame, report.accepted) = (frame, accepted.filter(|_| polish_um.is_none()));
    Ok(errors.drawn(design))
}

fn publish(
    run: &mut Run,
    shop: &Shop,
    errors: Option<&FalseColourMap>,
    report: &ProgramReport,
) -> Result<(), Error> {
    let page = report
        .html(&shop.maps, errors, &shop.speeds_mm_min)
        .map_err(|error: EncodingError| Error::Picture(error.to_string()))?;
    run.publish(Stage::Report, |files, _| {
        files.add_bytes("program.html", page.as_bytes())?;
        files.add_report("program.json", &report.json())?;
        if report.as_cut.is_none() {
            files.remove(super::as_cut::FILE);
        }
        Ok(())
    })
}
