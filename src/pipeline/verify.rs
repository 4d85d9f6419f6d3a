//! `morion verify`: files of unknown making: CAM exports, and scans of parts that were made.

use super::check_file::{open, witness, witness_body};
use super::file_units::{declared, in_millimetres, unit_warning};
use super::page_figures::{ErrorMap, ErrorMapBuilder, MAP_COLUMNS};
use super::run::{Command, Run};
use super::step_export::compared;
use super::verify_options::VerifyOptions;
use super::verify_points::PointList;
use super::verify_program::{CutFindings, ProgramTool, Programmed, program_tool, programmed};
use super::{Error, Observer, Stage};
use crate::align::{Alignment, FormMap, FormMapBuilder, LengthUnit, SizeRange, align};
use crate::brep::{Body, RigidMotion};
use crate::design::Design;
use crate::export::{ImportedMesh, PointFormat};
use crate::geom::{DVec3, TriMesh, Welder};
use crate::mirror::Form;
use crate::part::{Promise, codec};
use crate::profile::{CadFormat, MeshFormat, Profile};
use crate::publish;
use crate::raster::{EncodingError, FalseColourMap};
use crate::report::{form_map, inspection_sheet};
use crate::results::{
    AlignmentFacts, FileFacts, FileFault, Reason, SCHEMA, ShapeFault, UnitFacts, VerifyReport,
};
use crate::verdict::{self, CheckedMesh, EachStrip, FileCheck, Findings, HeldTo};
use std::path::{Path, PathBuf};

/// A file of unknown making, and how it is looked at: writes `report.json` and `report.html` into NAME-verify.
#[derive(Debug, Clone, Copy)]
pub struct Verify<'a> {
    /// The file: an STL, OBJ, 3MF, GLB or STEP, a list of points as CSV, XYZ or PLY, or a program as NGC, NC, TAP, CNC or XZC.
    pub path: &'a Path,
    /// How it is looked at.
    pub options: VerifyOptions,
}

/// What a file to be verified is.
enum VerifiedFormat {
    Mesh(MeshFormat),
    Step,
    Points(PointFormat),
    Program { is_table: bool },
}

/// The form error's map, and the sheet of a list of points.
const MAP: &str = "form_error.png";
const SHEET: &str = "inspection.pdf";

/// Verifies the file at `path` in the part frame, with units by size.
///
/// # Errors
/// [`enum@Error`] when the file cannot be opened or named, or the profile cannot be designed. (A file that
/// opens but holds no sound mesh is a negative verdict.)
pub fn verify(
    source: &Profile,
    path: &Path,
    observer: &dyn Observer,
) -> Result<VerifyReport, Error> {
    let options = VerifyOptions::default();
    Ok(Verify { path, options }.in_memory(source, observer)?.0)
}

impl Command for Verify<'_> {
    type Report = VerifyReport;

    fn check(&self, _profile: &Profile) -> Result<(), Error> {
        let VerifyOptions { units, align, probe_mm, .. } = self.options;
        let format = self.format()?;
        let declares_unit = match format {
            VerifiedFormat::Mesh(format) => codec(format).declares_unit(),
            VerifiedFormat::Step => true,
            VerifiedFormat::Points(_) => false,
            VerifiedFormat::Program { .. } => true,
        };
        self.tool(&format)?;
        if declares_unit && units.is_some() {
            return Err(Error::Declared { path: self.name() });
        }
        let is_points = matches!(format, VerifiedFormat::Points(_));
        if is_points && !align {
            return Err(Error::Points { path: self.name() });
        }
        match probe_mm {
            Some(_) if !is_points => Err(Error::Probe { path: self.name() }),
            Some(mm) if !(mm > 0.0 && mm.is_finite()) => Err(Error::Option {
                option: "--probe-mm",
                must: "the radius of the ball, positive and finite".into(),
                found: mm.to_string(),
            }),
            _ => Ok(()),
        }
    }

    fn folder(&self, profile: &Profile) -> PathBuf {
        PathBuf::from(format!("{}-verify", profile.name))
    }

    /// Reads an STL, OBJ, 3MF, GLB or STEP of any making, checks it and traces it against what the profile asks for.
    fn run(&self, run: &mut Run) -> Result<VerifyReport, Error> {
        let bytes = publish::read(self.path)?;
        let mut design = run.design()?;
        let format = self.format()?;
        // What is measured was formed: no tool.
        if self.options.align || matches!(format, VerifiedFormat::Points(_)) {
            design = design.formed();
        }
        if let (Some(tool), VerifiedFormat::Step) = (&design.tool, &format) {
            let form = tool.spec.form.name();
            return Err(Error::ToolStep { path: self.name(), form });
        }
        if let VerifiedFormat::Points(format) = format {
            let VerifyOptions { units, probe_mm, .. } = self.options;
            let list = PointList { name: self.name(), format, units, probe_mm };
            let (report, map) = list.verified(run, &design, &bytes)?;
            let sheet = inspection_sheet(&report, &map);
            publish_maps(run, (None, None), sheet.as_deref(), &report)?;
            return Ok(report);
        }
        let form = Form::of(&design.mirror);
        let part = Part {
            run,
            design: &design,
            size: SizeRange::of(&design.mirror, design.made_body().0.border),
        };
        let found = match format {
            VerifiedFormat::Mesh(format) => self.look(&part, format, bytes)?,
            VerifiedFormat::Program { is_table } => {
                self.look_at_program(&part, &bytes, is_table)?
            }
            _ => self.look_at_body(&part, &bytes)?,
        };
        let map = found.map.as_ref();
        let form_error_um = map.and_then(FormMap::error);
        let measured = self.options.align;
        let limit_um = 1e3 * found.check.promise.chord_mm;
        let (name, units, alignment) = (self.name(), found.units, found.alignment);
        let Findings { files, trace, frame, sharpness, accepted, mut reasons } =
            Findings::new(run.profile, &design, vec![found.check]);
        let CutFindings { program, faults: cutting } = found.cut;
        let mut warnings: Vec<String> = Vec::new();
        let faults = cutting.into_iter().map(Reason::from);
        reasons.extend(faults.map(|fault| fault.of_file(&name)));
        let faults = found.faults.into_iter();
        reasons.extend(faults.map(|fault| Reason::from(fault).of_file(&name)));
        if found.far > 0 {
            let far = Reason::from(ShapeFault::FarFacets { count: found.far }).of_file(&name);
            // Of a measured part that is noise; of a part it is a fault.
            if measured {
                warnings.push(far.to_string());
            } else {
                reasons.push(far);
            }
        }
        // Scans may be of a piece of the part.
        if let Some((factor, unit)) = found.oversize.filter(|_| !measured) {
            reasons.insert(0, Reason::from(ShapeFault::Size { factor, unit }).of_file(&name));
        }
        warnings.extend(units.and_then(|units| unit_warning(&name, units, measured)));
        if measured {
            let reason = verdict::form(run.profile, &design, form_error_um.as_ref(), limit_um);
            reasons.extend(reason.map(|reason| reason.of_file(&name)));
        }
        let report = VerifyReport {
            schema: SCHEMA,
            profile: run.profile.into(),
            layout: design.mounting,
            design: design.facts.clone(),
            form,
            files,
            trace,
            units,
            alignment,
            form_error_um,
            measured_form: None,
            program,
            frame,
            sharpness,
            accepted,
            verdict: verdict::of(&reasons),
            reasons,
            warnings,
        };
        if measured || run.files.folder().is_some() {
            let errors = found.errors.and_then(|errors| errors.drawn(&design));
            publish_maps(run, (map, errors.as_ref()), None, &report)?;
        }
        Ok(report)
    }
}

/// The part that a file should be of.
struct Part<'r, 'a> {
    run: &'r Run<'a>,
    design: &'r Design,
    size: SizeRange,
}

/// What a file showed.
struct Found {
    check: FileCheck,
    /// What curved faces lack of the design.
    faults: Vec<FileFault>,
    /// What a program cuts.
    cut: CutFindings,
    units: Option<UnitFacts>,
    alignment: Option<AlignmentFacts>,
    /// Facets far from the part, which are left out.
    far: usize,
    /// How many times too large it is, and the unit that would explain it.
    oversize: Option<(f64, Option<LengthUnit>)>,
    /// Form error of a measured part over the frame.
    map: Option<FormMap>,
    /// Pixel errors over the frame; none of a file that could not be read.
    errors: Option<ErrorMap>,
}

impl Verify<'_> {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// The format that the file's name ends in.
    fn format(&self) -> Result<VerifiedFormat, Error> {
        let ending = self.path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let mesh =
            MeshFormat::ALL.into_iter().find(|format| Some(format.name()) == ending.as_deref());
        match (mesh, ending.as_deref()) {
            (Some(format), _) => Ok(VerifiedFormat::Mesh(format)),
            (None, Some("step" | "stp")) => Ok(VerifiedFormat::Step),
            (None, Some("csv" | "xyz" | "txt" | "asc")) => {
                Ok(VerifiedFormat::Points(PointFormat::Text))
            }
            (None, Some("ngc" | "nc" | "tap" | "cnc" | "gcode")) => {
                Ok(VerifiedFormat::Program { is_table: false })
            }
            (None, Some("xzc")) => Ok(VerifiedFormat::Program { is_table: true }),
            (None, Some("ply")) => Ok(VerifiedFormat::Points(PointFormat::Ply)),
            _ => Err(Error::Format { path: self.name() }),
        }
    }

    /// Reads the file, brings it to millimetres and, if it is measured, into the part frame, and traces it.
    fn look(&self, part: &Part, format: MeshFormat, bytes: Vec<u8>) -> Result<Found, Error> {
        let Part { run, design, size } = part;
        let promise = Promise::of_profile(run.profile);
        let (file, read) = open(run, format, bytes, |mut reread| {
            let found = match codec(format).declares_unit() {
                // It is read in millimetres.
                true => declared(1.0),
                false => in_millimetres(&mut reread.mesh, size, self.options.units),
            };
            (reread, found)
        })?;
        let (mut reread, units) = match read {
            Ok(read) => read,
            Err(error) => {
                return Ok(self.unreadable(FileCheck::unreadable(file, format, promise, &error)));
            }
        };
        let oversize = size.size_factor(&reread.mesh);
        let alignment = match self.options.align {
            true => {
                let found = self.aligned(part, &reread.mesh)?;
                place(&mut reread, &found);
                Some(AlignmentFacts::new(&found))
            }
            false => None,
        };
        let far = leave_far(&mut reread, design);
        let checked = CheckedMesh::new(design, reread, None);
        let (faults, cut) = (Vec::new(), CutFindings::default());
        let about = About { faults, cut, units, alignment, far, oversize };
        Ok(self.traced(design, about, |each| {
            witness(run, design, (file, format), checked, promise, each)
        }))
    }

    /// Reads a STEP file, brings it, if it is measured, into the part frame, and traces it.
    fn look_at_body(&self, part: &Part, bytes: &[u8]) -> Result<Found, Error> {
        let Part { run, design, size } = part;
        let promise = Promise::of_profile(run.profile);
        let format = CadFormat::Step;
        let file = FileFacts::of(format.file_name(), format.name(), bytes);
        let read = run.timer.always(Stage::Read, || {
            let body = Body::read(bytes);
            let note = match &body {
                Ok(body) => format!("{}: {} curved faces", self.name(), body.facts().faces),
                Err(error) => error.to_string(),
            };
            (body, note)
        });
        let unreadable =
            |file, error| Ok(self.unreadable(FileCheck::unreadable(file, format, promise, &error)));
        let mut body = match read {
            Ok(body) => body,
            Err(error) => return unreadable(file, error),
        };
        let samples = body.sampled();
        let oversize = size.size_factor(&samples);
        let mut alignment = None;
        if self.options.align {
            let found = self.aligned(part, &samples)?;
            let motion = RigidMotion { rotation: found.pose.matrix(), shift: found.pose.shift };
            alignment = Some(AlignmentFacts::new(&found));
            body = match Body::read_moved(bytes, motion) {
                Ok(moved) => moved,
                Err(error) => return unreadable(file, error),
            };
        }
        // A measured part is held to its form.
        let faults = match self.options.align {
            true => Vec::new(),
            false => compared(&body, design, promise.chord_mm).1,
        };
        let units = declared(body.facts().unit_mm);
        let cut = CutFindings::default();
        let about = About { faults, cut, units, alignment, far: 0, oversize };
        Ok(self
            .traced(design, about, |each| witness_body(run, design, (file, body), promise, each)))
    }

    /// The tool that the file moves, if it is a program.
    ///
    /// # Errors
    /// [`enum@Error`] of options that do not go with the file.
    fn tool(&self, format: &VerifiedFormat) -> Result<Option<ProgramTool>, Error> {
        let is_program = matches!(format, VerifiedFormat::Program { .. });
        let is_table = matches!(format, VerifiedFormat::Program { is_table: true });
        program_tool(&self.name(), (is_program, is_table), &self.options)
    }

    /// Reads a program, cuts the mirror with it and traces what it leaves.
    fn look_at_program(&self, part: &Part, bytes: &[u8], is_table: bool) -> Result<Found, Error> {
        let Part { run, design, .. } = part;
        let promise = Promise::exact();
        let file = FileFacts::of(&self.name(), if is_table { "xzc" } else { "ngc" }, bytes);
        let tool = self.tool(&VerifiedFormat::Program { is_table })?;
        let tool = tool.ok_or_else(|| Error::Ball { path: self.name() })?;
        let (checked, cut) = match programmed(run, design, bytes, tool)? {
            Programmed::Cut(checked, cut) => (checked, cut),
            Programmed::Unread(error) => {
                let format = MeshFormat::Obj;
                return Ok(self.unreadable(FileCheck::unreadable(file, format, promise, &error)));
            }
            Programmed::Faulty(fault) => {
                let mut found = self.unreadable(FileCheck::untraced(file, promise));
                found.cut.faults.push(fault);
                return Ok(found);
            }
        };
        let (units, alignment, oversize) = (declared(1.0), None, None);
        let about = About { faults: Vec::new(), cut, units, alignment, far: 0, oversize };
        Ok(self.traced(design, about, |each| {
            witness(run, design, (file, MeshFormat::Obj), *checked, promise, each)
        }))
    }

    /// What the file is held to.
    fn held_to(&self) -> HeldTo {
        let VerifyOptions { align, ball_mm, cutter_mm, nose_mm, .. } = self.options;
        match (align, ball_mm.or(cutter_mm).or(nose_mm)) {
            (true, _) => HeldTo::Form,
            (false, Some(_)) => HeldTo::Picture,
            (false, None) => HeldTo::Design,
        }
    }

    /// A file that could not be read.
    fn unreadable(&self, mut check: FileCheck) -> Found {
        check.held_to = self.held_to();
        check.rename(self.name());
        let (units, alignment, oversize, map, errors) = (None, None, None, None, None);
        let (faults, cut) = (Vec::new(), CutFindings::default());
        Found { check, faults, cut, units, alignment, far: 0, oversize, map, errors }
    }

    /// A file as `witness` sees it, and the maps of its errors.
    fn traced(
        &self,
        design: &Design,
        about: About,
        witness: impl FnOnce(EachStrip) -> FileCheck,
    ) -> Found {
        let mut map = FormMapBuilder::new(&design.mirror, &design.camera);
        let mut errors = ErrorMapBuilder::new(design, MAP_COLUMNS);
        let mut check = witness(&mut |strip| {
            errors.add(strip);
            if self.options.align {
                map.add(strip.rows.clone(), |[column, row]| {
                    let pixel = (row - strip.rows.start) * strip.frame[0] + column;
                    let end = &strip.pixels[pixel];
                    (end.hit_point != DVec3::ZERO).then_some(end.hit_point)
                });
            }
        });
        check.held_to = self.held_to();
        check.rename(self.name());
        let map = self.options.align.then(|| map.finish());
        let errors = Some(errors.finish());
        let About { faults, cut, units, alignment, far, oversize } = about;
        let units = Some(units);
        Found { check, faults, cut, units, alignment, far, oversize, map, errors }
    }

    /// How a measured part is brought into the part frame.
    fn aligned(&self, part: &Part, mesh: &TriMesh) -> Result<Alignment, Error> {
        part.run.stage(Stage::Align, || {
            let found = align(&part.design.mirror, mesh)
                .map_err(|source| Error::Align { path: self.name(), source })?;
            let note = format!("{:.3} um rms after {} steps", 1e3 * found.rms_mm, found.steps);
            Ok((found, note))
        })
    }
}

/// What is known of a file before it is traced.
struct About {
    faults: Vec<FileFault>,
    cut: CutFindings,
    units: UnitFacts,
    alignment: Option<AlignmentFacts>,
    far: usize,
    oversize: Option<(f64, Option<LengthUnit>)>,
}

/// Facets that reach this many times as far as the part does are none of it.
const FAR: f64 = 8.0;

/// Leaves out facets far from the part, among which the search for the others would be slow, and counts
/// them.
fn leave_far(reread: &mut ImportedMesh, design: &Design) -> usize {
    let outline = design.mirror.full_outline().bounds().size().length();
    let reach = FAR * (outline + design.mirror.chart.plane_mm.abs());
    let mesh = &reread.mesh;
    let near = |t: usize| mesh.corners(t).iter().all(|v| v.length() <= reach);
    let kept: Vec<usize> = (0..mesh.triangles.len()).filter(|&t| near(t)).collect();
    let far = mesh.triangles.len() - kept.len();
    if far > 0 {
        let mut welder = Welder::new(kept.len());
        kept.iter().for_each(|&t| welder.add(mesh.corners(t)));
        let normals = reread.normals.as_ref();
        reread.normals = normals.map(|normals| kept.iter().map(|&t| normals[t]).collect());
        reread.mesh = welder.finish();
    }
    far
}

/// Brings a mesh, and the file's normals, into the part frame.
fn place(reread: &mut ImportedMesh, alignment: &Alignment) {
    alignment.apply(&mut reread.mesh);
    let matrix = alignment.pose.matrix();
    for (t, normals) in reread.normals.iter_mut().flatten().enumerate() {
        *normals = normals.map(|normal| matrix * normal);
        if alignment.turned_over {
            normals.swap(1, 2);
            // Files may have the facets the wrong way round and the normals right.
            let outwards = reread.mesh.area_vector(t);
            *normals = normals.map(|n| if n.dot(outwards) < 0.0 { -n } else { n });
        }
    }
}

/// Writes the report, its page, the form error's map of a measured part, and the sheet of one that was touched.
fn publish_maps(
    run: &mut Run,
    (map, errors): (Option<&FormMap>, Option<&FalseColourMap>),
    sheet: Option<&[u8]>,
    report: &VerifyReport,
) -> Result<(), Error> {
    let picture = |error: EncodingError| Error::Picture(error.to_string());
    run.publish(Stage::Report, |files, _| {
        let map = map.map(|map| form_map(map, report.form_error_um.as_ref()));
        match &map {
            Some(map) => {
                files.add_bytes(MAP, &map.png().map_err(picture)?)?;
            }
            None => files.remove(MAP),
        }
        match sheet {
            Some(sheet) => {
                files.add_bytes(SHEET, sheet)?;
            }
            None => files.remove(SHEET),
        }
        let page = report.html(errors, map.as_ref()).map_err(picture)?;
        files.add_bytes("report.html", page.as_bytes())?;
        files.add_report("report.json", &report.json())?;
        Ok(())
    })
}
