//! Programs that turn a profile's mirror, read back and cut.

use super::made_face::{MadeFace, PagePictures, noted};
use super::program_travel::travelled;
use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::geom::Contour;
use crate::machining::SurfaceAnalysis;
use crate::milling::Speeds;
use crate::num::rounding::floor_four_digits;
use crate::num::stats::Summary;
use crate::profile::{Profile, TurnSpec};
use crate::program::{MachineLimits, MachineTime, TurningPath};
use crate::report::LeftPicture;
use crate::results::{
    FileFacts, FileFault, OperationFacts, ProgramReport, Reason, SCHEMA, StockFacts,
};
use crate::turning::{
    Bar, LatheHeader, Meridian, TurnedOperation, TurningError, TurningTask, lathe_program_text,
    usual_feed_mm,
};
use crate::verdict::{
    self, BarOnLathe, TurnedLeft, narrowest_feed_mm, room_for_picture, turned_cut, turned_facets,
};
use std::f64::consts::PI;

/// Widest feed that is chosen where the profile names none, over the nose's radius: cusps are then an eighth of a hundredth of it high.
const WIDEST_FEED: f64 = 0.1;
/// Height of cusps over what a polish takes away, of the study's first order.
const CUSPS_OF_POLISH: f64 = 0.9;

fn refused(profile: &Profile, source: TurningError) -> Error {
    Error::Turning { profile: profile.name.clone(), source }
}

/// Writes the programs, reads them back and turns the bar with them; the report so far, the face that finishing leaves, and pictures.
///
/// # Errors
/// [`Error::Turning`] where the mirror cannot be turned so, [`Error::File`] when the disk refuses.
pub(super) fn turned(
    run: &mut Run,
    spec: &TurnSpec,
    design: &Design,
) -> Result<(ProgramReport, Option<MadeFace>, PagePictures), Error> {
    let profile = run.profile;
    let refused = |why| refused(profile, why);
    let meridian = checked(profile, design).map_err(refused)?;
    let (feed_mm, foreseen_px) = run.stage(Stage::Cut, || {
        let (feed_mm, foreseen) = feed(profile, spec, design, &meridian).map_err(refused)?;
        Ok(((feed_mm, foreseen), format!("{feed_mm} mm in a turn")))
    })?;
    let task = task(spec, design, meridian, feed_mm);
    let operations = run.stage(Stage::Plan, || {
        let operations = task.operations().map_err(refused)?;
        let moves: usize = operations.iter().map(|operation| operation.motions.len()).sum();
        let note = format!("{moves} moves of {} programs", operations.len());
        Ok((operations, note))
    })?;
    let mut lathe = Lathe {
        bar: BarOnLathe::new(design, &meridian, task.bar),
        read: Vec::new(),
        pictures: PagePictures { left: Vec::new(), speeds_mm_min: Vec::new() },
    };
    let mut report = begun(profile, spec, (design, task.bar), foreseen_px);
    for operation in operations {
        let file = write(run, &task, &operation)?;
        let bytes = run.files.staged(&file)?.read()?;
        report.files.push(FileFacts::of(&file, "ngc", &bytes));
        run.timer.always(Stage::Read, || {
            lathe.read(&mut report, &operation, (file, &bytes), spec);
            ((), operation.kind.name().to_owned())
        });
    }
    let moves = lathe.read.iter().flatten().flat_map(|path| &path.tool.moves);
    let [x, z] = spec.machine.travel_mm.unwrap_or([f64::INFINITY; 2]);
    travelled(&mut report, moves, task.bar.top_mm, [x, f64::INFINITY, z])
        .map_err(|why| refused(why.into()))?;
    let nose_mm = spec.nose.radius_mm;
    let face = lathe.read.last().and_then(Option::as_ref).map(|path| MadeFace {
        cut: run.timer.always(Stage::Cut, || noted(turned_cut(design, &meridian, path, nose_mm))),
        words: format!("as turned, nose {nose_mm}"),
    });
    Ok((report, face, lathe.pictures))
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

/// The feed of finishing, mm, which keeps the picture within the profile's limits where the profile does not name it, and what it is
/// foreseen to leave.
fn feed(
    profile: &Profile,
    spec: &TurnSpec,
    design: &Design,
    meridian: &Meridian,
) -> Result<(f64, Option<Summary>), TurningError> {
    let nose_mm = spec.nose.radius_mm;
    let analysis = SurfaceAnalysis::new(&design.mirror, &design.camera, design.view.as_ref());
    // Cusps are tilted by up to f / (2 r), whatever the mirror's curvature.
    let foreseen = |feed_mm: f64| analysis.displacements_of_turns(0.5 * feed_mm / nose_mm);
    let narrowest_mm = narrowest_feed_mm(meridian, nose_mm);
    let finishing = &spec.finishing;
    if let Some(feed_mm) = finishing.feed_mm_rev {
        let [facets, most] = turned_facets(meridian, nose_mm, feed_mm);
        if facets > most {
            // (Three decimals, upwards.)
            let least_mm = (1e3 * narrowest_mm).ceil() / 1e3;
            return Err(TurningError::Fine { feed_mm, facets, most, least_mm });
        }
        return Ok((feed_mm, foreseen(feed_mm)));
    }
    let widest_mm = (WIDEST_FEED * nose_mm).max(narrowest_mm).min(usual_feed_mm(spec));
    let widest = foreseen(widest_mm);
    let polish_um = finishing.polish_um;
    let for_picture = widest.and_then(|px| match finishing.budget_px {
        Some(budget_px) => Some(widest_mm * budget_px / px.p95),
        None if polish_um.is_some() => None,
        None => {
            let [rms_px, max_px] = room_for_picture(profile, design)?;
            Some(widest_mm * (rms_px / px.rms).min(max_px / px.max))
        }
    });
    // (Chords stand out of the mirror too.)
    let chord_um = finishing.chord_um;
    let polished = polish_um.map(|um| CUSPS_OF_POLISH * (um - chord_um).max(0.5 * um));
    let heights_um = [finishing.scallop_um, polished].into_iter().flatten().reduce(f64::min);
    let for_height = heights_um.map(|um| feed_for_height(meridian, nose_mm, 1e-3 * um));
    let ends = [for_picture, for_height].into_iter().flatten();
    let feed_mm = floor_four_digits(ends.fold(widest_mm, f64::min).max(narrowest_mm));
    Ok((feed_mm, foreseen(feed_mm)))
}

/// The feed whose cusps are no higher anywhere, mm: they are f^2 / (8 r (1 + r k)) high, where the mirror bulges with the curvature k.
fn feed_for_height(meridian: &Meridian, nose_mm: f64, height_mm: f64) -> f64 {
    let bulge = |curvature: f64| 1.0 - nose_mm * curvature;
    let least = meridian.places().map(|place| bulge(place.curvature)).fold(f64::INFINITY, f64::min);
    f64::sqrt(8.0 * nose_mm * least.max(0.0) * height_mm)
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

fn begun(
    profile: &Profile,
    spec: &TurnSpec,
    (design, Bar { radius_mm, top_mm }): (&Design, Bar),
    foreseen_px: Option<Summary>,
) -> ProgramReport {
    let (volume_mm3, part_mm3) = (PI * radius_mm * radius_mm * top_mm, design.volume());
    ProgramReport {
        schema: SCHEMA,
        profile: profile.into(),
        material: spec.material,
        control: spec.control.control(),
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

/// Writes the program of an operation; its name.
fn write(run: &mut Run, task: &TurningTask, operation: &TurnedOperation) -> Result<String, Error> {
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
        control: spec.control,
        work_offset: spec.work_offset,
        comments: &comments,
        rounding_mm: 1e-3 * spec.finishing.chord_um,
        max_spindle_rpm: spec.machine.max_spindle_rpm,
    };
    let text = lathe_program_text(&header, operation);
    run.write(&file, |out| out.write_all(text.as_bytes()))?;
    Ok(file)
}

/// The bar in the course of its programs, as they are read back.
struct Lathe {
    bar: BarOnLathe,
    /// The programs' moves, in their order; none of one that cannot be read.
    read: Vec<Option<TurningPath>>,
    pictures: PagePictures,
}

impl Lathe {
    /// Reads a program back, and turns the bar with it.
    fn read(
        &mut self,
        report: &mut ProgramReport,
        operation: &TurnedOperation,
        (file, bytes): (String, &[u8]),
        spec: &TurnSpec,
    ) {
        let path = match TurningPath::read(bytes) {
            Ok(path) => path,
            Err(error) => {
                let fault = FileFault::Unreadable(error.to_string());
                report.reasons.push(Reason::from(fault).of_file(&file));
                self.read.push(None);
                return;
            }
        };
        let TurnedOperation { kind, nose_mm, feed_mm_rev, spindle_rpm, allowance_mm, .. } =
            *operation;
        let chord_mm = 1e-3 * spec.finishing.chord_um;
        let TurnedLeft { left, faults } = self.bar.cut(&path, operation, chord_mm);
        let faults = faults.into_iter().map(Reason::from);
        report.reasons.extend(faults.map(|fault| fault.of_file(&file)));
        let [cutting_mm, rapid_mm] = path.tool.lengths_mm();
        let limits = MachineLimits {
            rapid_mm_min: spec.machine.rapid_mm_min,
            acceleration_mm_s2: spec.machine.acceleration_mm_s2,
        };
        let time = limits.time(&path.tool.moves);
        let machine_min = time.minutes();
        let MachineTime { at_feed_min, changing_min, rapid_min, speeds_mm_min } = time;
        report.machine_min += machine_min;
        let feed_mm_min = feed_mm_rev * spindle_rpm;
        report.operations.push(OperationFacts {
            operation: kind,
            file,
            ball_mm: None,
            stepover_mm: None,
            nose_mm: Some(nose_mm),
            feed_mm_rev: Some(feed_mm_rev),
            levels: operation.levels,
            allowance_mm,
            speeds: Speeds { spindle_rpm, feed_mm_min, entry_feed_mm_min: feed_mm_min },
            lines: path.tool.lines,
            moves: path.tool.moves.len(),
            cutting_mm,
            rapid_mm,
            machine_min,
            at_feed_min,
            changing_min,
            rapid_min,
            left,
            flute: None,
            stickout: None,
        });
        let section = LeftPicture::Section(self.bar.section());
        self.pictures.left.push((kind.name().to_owned(), section));
        self.pictures.speeds_mm_min.push(speeds_mm_min);
        self.read.push(Some(path));
    }
}
