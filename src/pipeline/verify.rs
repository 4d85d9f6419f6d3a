//! Files of unknown making: CAM exports, and scans of parts that were made.

use super::check_file::{FileCheck, checked, open, witness};
use super::files::{self, Folder};
use super::observer::{Observer, Stage, StageTimer};
use super::verdict::Findings;
use super::{Error, Source, designed, verdict};
use crate::align::{Alignment, FormMap, LengthUnit, SizeRange, align};
use crate::design::Design;
use crate::export::ImportedMesh;
use crate::geom::Welder;
use crate::mirror::Form;
use crate::profile::Format;
use crate::report::{
    AlignmentFacts, ProfileId, Reason, ReasonKind, SCHEMA, UnitFacts, VerifyReport, form_picture,
};
use crate::trace::Outcome;
use std::path::{Path, PathBuf};

/// How a file of unknown making is looked at.
#[derive(Debug, Clone, Default)]
pub struct VerifyOptions {
    /// The unit of its coordinates; none: by its size.
    pub units: Option<LengthUnit>,
    /// Fit its pose first, judge it as a measured part, and write the form error's map and the report
    /// into NAME-verify below this folder.
    pub align: Option<PathBuf>,
}

/// The form error's map.
const MAP: &str = "form_error.png";
/// Shape is held to this where the profile has no limit of its own.
const USUAL_CHORD_UM: f64 = 10.0;

/// [`inspect`] in the part frame, with units by size.
///
/// # Errors
/// [`inspect`]'s.
pub fn verify(
    source: &Source,
    path: &Path,
    observer: &dyn Observer,
) -> Result<VerifyReport, Error> {
    inspect(source, path, &VerifyOptions::default(), observer)
}

/// Reads an STL, OBJ or 3MF of any making, checks it and traces it against what the profile of `source`
/// asks for.
///
/// # Errors
/// [`enum@Error`] when the file cannot be opened, named or aligned, or the profile cannot be
/// designed. (A file that opens but holds no sound mesh is a negative verdict.)
pub fn inspect(
    source: &Source,
    path: &Path,
    inspection: &VerifyOptions,
    observer: &dyn Observer,
) -> Result<VerifyReport, Error> {
    let profile = &source.profile;
    let clock = StageTimer::new(observer);
    let name = path.display().to_string();
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let known = Format::ALL.into_iter().filter(|format| format.is_mesh());
    let Some(format) = known.into_iter().find(|f| Some(f.name()) == extension.as_deref()) else {
        return Err(Error::Format { path: name });
    };
    if format == Format::ThreeMf && inspection.units.is_some() {
        return Err(Error::Declared { path: name });
    }
    let bytes = files::read(path)?;
    let folder = match &inspection.align {
        Some(out) => Some(Folder::create(&out.join(format!("{}-verify", profile.name)))?),
        None => None,
    };
    let design = clock.stage(Stage::Design, || designed(source))?;
    let form = Form::of(&design.mirror);
    // A file of unknown making has no proven bound; its shape is held to the profile's limit.
    let chord_mm = 1e-3 * profile.mesh.chord_um.unwrap_or(USUAL_CHORD_UM);

    let size = SizeRange::of(&design.mirror, design.border.as_ref());
    let (mut units, mut alignment, mut far, mut oversize) = (None, None, 0, None);
    let (file, read) = open(&clock, format, bytes, |mut reread| {
        // A 3MF says what its units are, and is read in millimetres.
        let found = match format {
            Format::ThreeMf => UnitFacts::new(LengthUnit::Mm, DECLARED),
            _ => in_millimetres(&mut reread, &size, inspection.units),
        };
        (reread, found)
    });
    let mut evidence = match read {
        Err(error) => FileCheck::unreadable(file, error),
        Ok((mut reread, found)) => {
            units = Some(found);
            oversize = size.size_factor(&reread.mesh);
            if folder.is_some() {
                let found = clock.stage(Stage::Align, || {
                    let found = align(&design.mirror, &reread.mesh);
                    let found = found.map_err(|source| Error::Align { path: name.clone(), source });
                    found.map(|found| {
                        let note =
                            format!("{:.3} um rms after {} steps", 1e3 * found.rms_mm, found.steps);
                        (found, note)
                    })
                })?;
                place(&mut reread, &found);
                alignment = Some(AlignmentFacts::new(&found));
            }
            far = leave_far(&mut reread, &design);
            witness(&clock, profile, &design, file, checked(&design, reread), chord_mm)
        }
    };
    evidence.measured = folder.is_some();
    evidence.rename(name.clone());
    let seen = evidence.seen.take();
    let map = seen.filter(|_| folder.is_some()).map(|(_, witness)| {
        FormMap::new(&design.mirror, &design.camera, |pixel| {
            let traced = &witness.pixels[pixel];
            (traced.outcome != Outcome::Missed).then_some(traced.hit_point)
        })
    });
    let measured = folder.is_some();
    let Findings { files, trace, frame, sharpness, accepted, mut reasons } =
        Findings::new(profile, &design, vec![evidence], chord_mm, None);
    let mut warnings = Vec::new();
    if far > 0 {
        let all = format!("{far} facets lie far from the part and were left out");
        // Of a measured part that is noise; of a part it is a fault.
        if measured {
            warnings.push(format!("{name}: {all}"));
        } else {
            reasons.push(Reason::new(ReasonKind::FarFacets, all).of_file(&name));
        }
    }
    // Scans may be of a piece of the part.
    if let Some((factor, unit)) = oversize.filter(|_| !measured) {
        reasons.insert(0, off_size(factor, unit).of_file(&name));
    }
    warnings.extend(units.and_then(|units| unit_warning(&name, units, measured)));
    let form_error_um = map.as_ref().and_then(FormMap::error);
    if measured {
        let reason = verdict::form(profile, &design, form_error_um.as_ref(), 1e3 * chord_mm);
        reasons.extend(reason.map(|reason| reason.of_file(&name)));
    }
    let report = VerifyReport {
        schema: SCHEMA,
        profile: ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() },
        layout: design.mounting,
        design: design.facts.clone(),
        form,
        files,
        trace,
        units,
        alignment,
        form_error_um,
        frame,
        sharpness,
        accepted,
        verdict: verdict::of(&reasons),
        reasons,
        warnings,
    };
    if let Some(folder) = folder {
        publish(&clock, &folder, map.as_ref(), &report)?;
    }
    Ok(report)
}

/// The warning of a unit that nothing speaks for, or none but the file's size.
fn unit_warning(name: &str, units: UnitFacts, measured: bool) -> Option<String> {
    match units {
        UnitFacts { chosen: ASSUMED, .. } => Some(format!(
            "{name}: no unit makes this file as large as the part; taken as millimetres (--units \
             says otherwise)"
        )),
        // A measured part is cut; a file to be cut from is what this matters for.
        UnitFacts { chosen: BY_SIZE, mm_per_unit, name: unit }
            if mm_per_unit != 1.0 && !measured =>
        {
            Some(format!(
                "{name}: taken as {unit} by its size; shops take such files as millimetres"
            ))
        }
        _ => None,
    }
}

/// How a unit is called that the file names, that its size speaks for, and that nothing speaks for.
const DECLARED: &str = "declared";
const BY_SIZE: &str = "by size";
const ASSUMED: &str = "assumed";

/// Brings a mesh to millimetres.
fn in_millimetres(
    reread: &mut ImportedMesh,
    size: &SizeRange,
    asked: Option<LengthUnit>,
) -> UnitFacts {
    let (unit, chosen) = match asked {
        Some(unit) => (unit, "asked"),
        None => match size.unit(&reread.mesh) {
            (unit, true) => (unit, BY_SIZE),
            (unit, false) => (unit, ASSUMED),
        },
    };
    unit.convert(&mut reread.mesh);
    UnitFacts::new(unit, chosen)
}

/// A part that is `factor` times as large as it should be, as two units are if there is one.
fn off_size(factor: f64, unit: Option<LengthUnit>) -> Reason {
    let (times, way) = if factor > 1.0 { (factor, "large") } else { (1.0 / factor, "small") };
    let sentence = match unit {
        Some(unit) => {
            let times = (1e6 * times).round() / 1e6;
            format!("the part is {times} times too {way}: is the unit {}?", unit.word())
        }
        None => format!("the part is about {times:.1} times too {way}"),
    };
    Reason::new(ReasonKind::Size, sentence)
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

/// Writes the form error's map and the report.
fn publish(
    clock: &StageTimer,
    folder: &Folder,
    map: Option<&FormMap>,
    report: &VerifyReport,
) -> Result<(), Error> {
    clock.stage(Stage::Report, || {
        let picture = map.map(|map| {
            form_picture(map, report.form_error_um.as_ref())
                .map_err(|error| Error::Picture(error.to_string()))
        });
        let (mut files, mut stale) = (Vec::new(), Vec::new());
        match picture.transpose()? {
            Some(png) => files.push(folder.stage(MAP, |out| out.write_all(&png))?),
            None => stale.push(MAP),
        }
        let text = report.json();
        files.push(folder.stage("report.json", |out| out.write_all(text.as_bytes()))?);
        folder.replace(files, &stale)?;
        Ok(((), folder.path().display().to_string()))
    })
}
