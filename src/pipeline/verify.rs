//! Files of unknown making: CAM exports, and scans of parts that were made.

use super::examine::{Evidence, checked, open, witness};
use super::files::{self, Folder};
use super::observer::{Clock, Observer, Stage};
use super::sight::Seen;
use super::{Error, Source, assemble, designed};
use crate::align::{Alignment, FormMap, Size, Unit, align};
use crate::design::Design;
use crate::export::Reread;
use crate::mirror::Form;
use crate::profile::Format;
use crate::report::{AlignmentFacts, Report, UnitFacts, form_picture};
use crate::trace::Outcome;
use std::path::{Path, PathBuf};

/// How a file of unknown making is looked at.
#[derive(Debug, Clone, Default)]
pub struct Inspection {
    /// The unit of its coordinates; none: by its size.
    pub units: Option<Unit>,
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
pub fn verify(source: &Source, path: &Path, observer: &dyn Observer) -> Result<Report, Error> {
    inspect(source, path, &Inspection::default(), observer)
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
    inspection: &Inspection,
    observer: &dyn Observer,
) -> Result<Report, Error> {
    let profile = &source.profile;
    let clock = Clock::new(observer);
    let name = path.display().to_string();
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let known = Format::ALL.into_iter().filter(|format| format.is_mesh());
    let Some(format) = known.into_iter().find(|f| Some(f.name()) == extension.as_deref()) else {
        return Err(Error::Format { path: name });
    };
    let bytes = files::read(path)?;
    let folder = match &inspection.align {
        Some(out) => Some(Folder::create(&out.join(format!("{}-verify", profile.name)))?),
        None => None,
    };
    let design = clock.stage(Stage::Design, || designed(source))?;
    let form = Form::of(&design.mirror);

    let (mut units, mut alignment) = (None, None);
    let (file, read) = open(&clock, format, bytes, |mut reread| {
        let found = in_millimetres(&mut reread, &design, inspection.units);
        (reread, found)
    });
    let mut evidence = match read {
        Err(error) => Evidence::unreadable(file, error),
        Ok((mut reread, found)) => {
            units = Some(found);
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
            witness(&clock, profile, &design, file, checked(&design, reread))
        }
    };
    evidence.measured = folder.is_some();
    evidence.rename(name.clone());
    let seen = evidence.seen.take();
    // A file of unknown making has no proven bound; its shape is held to the profile's limit.
    let chord_mm = 1e-3 * profile.mesh.chord_um.unwrap_or(USUAL_CHORD_UM);
    let mut report = assemble(profile, &design, form, None, vec![evidence], chord_mm);
    report.units = units;
    if let Some(UnitFacts { chosen: ASSUMED, .. }) = units {
        report.warnings.push(format!(
            "{name}: no unit makes this file as large as the part; taken as millimetres (--units \
             says otherwise)"
        ));
    }
    report.alignment = alignment;
    if let Some(folder) = folder {
        publish(&clock, &folder, &design, seen.as_ref(), &mut report)?;
    }
    Ok(report)
}

/// How a unit is called that nothing speaks for.
const ASSUMED: &str = "assumed";

/// Brings a mesh to millimetres.
fn in_millimetres(reread: &mut Reread, design: &Design, asked: Option<Unit>) -> UnitFacts {
    let (unit, chosen) = match asked {
        Some(unit) => (unit, "asked"),
        None => match Size::of(&design.mirror, design.stock.as_ref()).unit(&reread.mesh) {
            (unit, true) => (unit, "by size"),
            (unit, false) => (unit, ASSUMED),
        },
    };
    unit.convert(&mut reread.mesh);
    UnitFacts { name: unit.name(), mm_per_unit: unit.mm(), chosen }
}

/// Brings a mesh, and the file's normals, into the part frame.
fn place(reread: &mut Reread, alignment: &Alignment) {
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

/// Writes the form error's map and the report, into which the form error goes.
fn publish(
    clock: &Clock,
    folder: &Folder,
    design: &Design,
    seen: Option<&Seen>,
    report: &mut Report,
) -> Result<(), Error> {
    clock.stage(Stage::Report, || {
        let map = seen.map(|(_, witness)| {
            FormMap::new(&design.mirror, &design.camera, |pixel| {
                let seen = &witness.seen[pixel];
                (seen.outcome != Outcome::Missed).then_some(seen.at)
            })
        });
        report.form_error_um = map.as_ref().and_then(FormMap::error);
        let picture = map.map(|map| {
            form_picture(&map, report.form_error_um.as_ref())
                .map_err(|error| Error::Picture(error.to_string()))
        });
        let mut files = Vec::new();
        match picture.transpose()? {
            Some(png) => files.push(folder.stage(MAP, |out| out.write_all(&png))?),
            None => folder.clears(MAP)?,
        }
        let nothing = files.is_empty();
        let text = report.json();
        files.push(folder.stage("report.json", |out| out.write_all(text.as_bytes()))?);
        files.into_iter().try_for_each(files::Staged::publish)?;
        if nothing {
            folder.remove(MAP)?;
        }
        Ok(((), folder.path().display().to_string()))
    })
}
