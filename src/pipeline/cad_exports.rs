//! Files of the mirror as designed, not of a mesh: how each is written, foreseen, and checked after
//! it was written.

use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::export::step::{FittedMirror, fit_splines, write_step};
use crate::export::{ByteCounter, Label, compare_sag, read_sag, sag_bytes, sag_points, write_sag};
use crate::geom::ScanPath;
use crate::mirror::{Departure, Form};
use crate::part::cad;
use crate::profile::{self, CadFormat, PanelSpec, Profile, ProjectionSpec};
use crate::publish::sha256;
use crate::results::{FileFacts, FileFault, SagFacts, StepFacts};
use std::io::{self, Write};

/// A file of the mirror as designed.
pub(super) trait CadExport: Sync {
    /// Its format.
    fn format(&self) -> CadFormat;

    /// Writes it.
    ///
    /// # Errors
    /// That of `out`.
    fn write(&self, out: &mut dyn Write, label: &Label) -> io::Result<()>;

    /// Foresees its length.
    fn bytes(&self, label: &Label) -> u64;

    /// What the design has against its bytes, and a sag table's figures.
    fn faults(&self, bytes: &[u8], label: &Label) -> (Vec<FileFault>, Option<SagFacts>);

    /// Figures of the splines.
    fn step_facts(&self) -> Option<StepFacts> {
        None
    }
}

/// The files of the mirror of `design` that the profile asks for, each ready to be written.
///
/// # Errors
/// [`Error::Table`] when a sag table would have too many places, which can depend on the design;
/// [`Error::Step`] when no splines suit the mirror.
pub(super) fn cad_exports<'a>(
    profile: &Profile,
    design: &'a Design,
    form: &'a Form,
) -> Result<Vec<Box<dyn CadExport + 'a>>, Error> {
    let path = profile.sag.scan(profile.part.width_mm);
    let (points, most) = (sag_points(&path, &design.mirror), profile::SagTable::MOST_POINTS);
    if cad(profile).any(|format| format == CadFormat::Csv) && !(points <= most) {
        return Err(Error::Table { profile: profile.name.clone(), points, most });
    }
    let export = |format| -> Result<Box<dyn CadExport + 'a>, Error> {
        Ok(match format {
            CadFormat::Csv => Box::new(SagExport { design, form, path }),
            CadFormat::Step => {
                let fit = fit_splines(&design.mirror).and_then(|fit| {
                    fit.check_land(design.border.as_ref())?;
                    Ok(fit)
                });
                let fail = |source| Error::Step { profile: profile.name.clone(), source };
                Box::new(StepExport { design, fit: fit.map_err(fail)? })
            }
        })
    };
    cad(profile).map(export).collect()
}

/// What the bytes of one such file showed.
pub(super) struct CadCheck {
    /// The file.
    pub file: FileFacts,
    /// What is wrong with it, each without the file's name.
    pub faults: Vec<FileFault>,
    /// The sag table's figures, if it is one that can be read.
    pub sag: Option<SagFacts>,
}

/// Reads the bytes of a file that were written with `sha256`, and holds them against the design.
pub(super) fn check_export(
    run: &Run,
    export: &dyn CadExport,
    label: &Label,
    bytes: &[u8],
    written_sha256: &str,
) -> CadCheck {
    run.timer.always(Stage::Read, || {
        let format = export.format();
        let file = FileFacts {
            name: format.file_name().to_owned(),
            format: format.name().into(),
            bytes: bytes.len() as u64,
            sha256: sha256(bytes),
        };
        let (mut faults, sag) = export.faults(bytes, label);
        if file.sha256 != written_sha256 {
            faults.insert(0, FileFault::Altered);
        }
        let note = format!("{}: as designed", file.name);
        let note = faults.first().map_or(note, ToString::to_string);
        (CadCheck { file, faults, sag }, note)
    })
}

struct StepExport<'a> {
    design: &'a Design,
    fit: FittedMirror,
}

impl CadExport for StepExport<'_> {
    fn format(&self) -> CadFormat {
        CadFormat::Step
    }

    fn write(&self, mut out: &mut dyn Write, label: &Label) -> io::Result<()> {
        write_step(&mut out, &self.fit, self.design.border.as_ref(), label)
    }

    fn bytes(&self, label: &Label) -> u64 {
        let mut bytes = ByteCounter::default();
        self.write(&mut bytes, label).map_or(0, |()| bytes.count())
    }

    /// Nobody here reads STEP: the bytes must be those that the splines give.
    fn faults(&self, bytes: &[u8], label: &Label) -> (Vec<FileFault>, Option<SagFacts>) {
        let mut again = Vec::with_capacity(bytes.len());
        let written = self.write(&mut again, label);
        let same = written.is_ok() && again == bytes;
        (if same { Vec::new() } else { vec![FileFault::OffDesign] }, None)
    }

    fn step_facts(&self) -> Option<StepFacts> {
        let fit = &self.fit;
        Some(StepFacts { fit_error_nm: fit.error_mm * 1e6, control_points: fit.size() })
    }
}

struct SagExport<'a> {
    design: &'a Design,
    form: &'a Form,
    path: ScanPath,
}

/// What nine decimals may be off, mm and radians: rounding each of a normal's three turns it by
/// 0.87e-9 at most.
const LAST_DIGIT: f64 = 1e-9;

impl CadExport for SagExport<'_> {
    fn format(&self) -> CadFormat {
        CadFormat::Csv
    }

    fn write(&self, mut out: &mut dyn Write, label: &Label) -> io::Result<()> {
        write_sag(&mut out, &self.design.mirror, &self.path, label, &self.notes())
    }

    fn bytes(&self, label: &Label) -> u64 {
        sag_bytes(&self.design.mirror, &self.path, label, &self.notes())
    }

    fn faults(&self, bytes: &[u8], _label: &Label) -> (Vec<FileFault>, Option<SagFacts>) {
        let rows = match read_sag(bytes) {
            Ok(rows) => rows,
            Err(error) => return (vec![FileFault::Unreadable(error.to_string())], None),
        };
        let off = compare_sag(&rows, &self.design.mirror);
        let (off_mm, off_rad) = (off.height_mm, off.normal_rad);
        let mut faults = Vec::new();
        if rows.is_empty() {
            faults.push(FileFault::EmptyTable);
        }
        if !(off_mm <= LAST_DIGIT) {
            faults.push(FileFault::HeightError { off_mm, limit_mm: LAST_DIGIT });
        }
        if !(off_rad <= LAST_DIGIT) {
            faults.push(FileFault::NormalError { off_rad, limit_rad: LAST_DIGIT });
        }
        let facts =
            SagFacts { rows: rows.len(), height_error_mm: off_mm, normal_error_rad: off_rad };
        (faults, Some(facts))
    }
}

impl SagExport<'_> {
    fn notes(&self) -> Vec<String> {
        let facts = &self.design.facts;
        let errors = facts.ray_error_mrad.map_or("no projection".into(), |error| {
            format!("ray error {:.3} mrad rms, {:.3} mrad max", error.rms, error.max)
        });
        let Form { sphere, plane } = self.form;
        let pv = |departure: &Departure| {
            let sag = departure.sag_pv_mm.map_or("-".into(), |mm| format!("{mm:.6}"));
            format!("sag departure {sag} PV, square to it {:.6} PV", departure.pv_mm)
        };
        let radius = sphere.radius_of_curvature_mm.map_or("none".into(), |mm| format!("{mm:.6}"));
        let mut notes = vec![
            format!("design: {} of degree {}, {errors}", facts.method, facts.degree),
            format!(
                "best-fit sphere: radius of curvature {radius} (negative: a dome), {}",
                pv(&sphere.departure)
            ),
            format!("best-fit plane: {}", pv(&plane.departure)),
        ];
        if let Some(ProjectionSpec::Panels(panels)) = &self.design.profile.projection {
            notes.extend(panels.iter().enumerate().map(|(k, PanelSpec { columns, rows, .. })| {
                let ([left, right], [top, bottom]) = (columns, rows);
                format!("panel {}: columns {left} to {right}, rows {top} to {bottom}", k + 1)
            }));
        }
        notes
    }
}
