//! Files of the mirror as designed, not of a mesh: how each is written, foreseen, and checked after
//! it was written.

use super::Error;
use super::files::sha256;
use crate::design::Design;
use crate::export::step::{FittedMirror, fit_splines, write_step};
use crate::export::{ByteCounter, Label, compare_sag, read_sag, sag_bytes, sag_points, write_sag};
use crate::mirror::{Departure, Form};
use crate::profile::{self, Format, Profile};
use crate::report::{FileFacts, Reason, ReasonKind, SagFacts};
use std::io::{self, Write};

/// What such files are drawn from.
pub struct CadExports<'a> {
    /// What was asked for.
    pub profile: &'a Profile,
    /// The mirror.
    pub design: &'a Design,
    /// Its best sphere and plane.
    pub form: &'a Form,
    /// Its splines, if STEP is asked for.
    pub fit: Option<&'a FittedMirror>,
    /// What every file says about itself.
    pub label: &'a Label,
}

/// Whether the sag table, if it is asked for, has no more places than any may have: how many there
/// are can depend on the design.
///
/// # Errors
/// [`Error::Table`] when it has.
pub fn check_table(profile: &Profile, design: &Design) -> Result<(), Error> {
    let points = sag_points(&profile.sag.scan(profile.part.width_mm), &design.mirror);
    let most = profile::SagTable::MOST_POINTS;
    if profile.formats.contains(&Format::Csv) && !(points <= most) {
        return Err(Error::Table { profile: profile.name.clone(), points, most });
    }
    Ok(())
}

/// The mirror's splines, if STEP is asked for.
///
/// # Errors
/// [`Error::Step`] when there are none.
pub fn fitted(profile: &Profile, design: &Design) -> Result<Option<FittedMirror>, Error> {
    if !profile.formats.contains(&Format::Step) {
        return Ok(None);
    }
    let made = fit_splines(&design.mirror).and_then(|fit| {
        fit.check_land(design.border.as_ref())?;
        Ok(fit)
    });
    made.map(Some).map_err(|source| Error::Step { profile: profile.name.clone(), source })
}

/// What the bytes of one such file showed.
pub struct CadCheck {
    /// The file.
    pub file: FileFacts,
    /// What is wrong with it, each without the file's name.
    pub reasons: Vec<Reason>,
    /// The sag table's figures, if it is one that can be read.
    pub sag: Option<SagFacts>,
}

/// What nine decimals may be off, mm and radians: rounding each of a normal's three turns it by
/// 0.87e-9 at most.
const LAST_DIGIT: f64 = 1e-9;

impl CadExports<'_> {
    /// Writes the file.
    pub fn write(&self, format: Format, mut out: impl Write) -> io::Result<()> {
        match format {
            Format::Csv => {
                let path = self.profile.sag.scan(self.profile.part.width_mm);
                write_sag(&mut out, &self.design.mirror, &path, self.label, &self.notes())
            }
            Format::Step => {
                let fit = self.fit.expect("splines for STEP");
                write_step(&mut out, fit, self.design.border.as_ref(), self.label)
            }
            Format::Stl | Format::Obj | Format::ThreeMf => unreachable!("a mesh"),
        }
    }

    /// Foresees its length.
    pub fn bytes(&self, format: Format) -> u64 {
        match format {
            Format::Csv => {
                let path = self.profile.sag.scan(self.profile.part.width_mm);
                sag_bytes(&self.design.mirror, &path, self.label, &self.notes())
            }
            Format::Step => {
                let mut bytes = ByteCounter::default();
                self.write(format, &mut bytes).map_or(0, |()| bytes.count())
            }
            Format::Stl | Format::Obj | Format::ThreeMf => unreachable!("a mesh"),
        }
    }

    /// Reads its bytes and holds them against the design.
    pub fn check(&self, format: Format, bytes: &[u8]) -> CadCheck {
        let (reasons, sag) = match format {
            Format::Csv => self.check_sag(bytes),
            Format::Step => (self.check_step(bytes), None),
            Format::Stl | Format::Obj | Format::ThreeMf => unreachable!("a mesh"),
        };
        let file = FileFacts {
            name: format.file_name().to_owned(),
            format: format.name().into(),
            bytes: bytes.len() as u64,
            sha256: sha256(bytes),
        };
        CadCheck { file, reasons, sag }
    }

    /// Nobody here reads STEP: the bytes must be those that the splines give.
    fn check_step(&self, bytes: &[u8]) -> Vec<Reason> {
        let mut again = Vec::with_capacity(bytes.len());
        let written = self.write(Format::Step, &mut again);
        let same = written.is_ok() && again == bytes;
        let off = || Reason::new(ReasonKind::OffDesign, "it is not what the design gives");
        if same { Vec::new() } else { vec![off()] }
    }

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
        vec![
            format!("design: {} of degree {}, {errors}", facts.method, facts.degree),
            format!(
                "best-fit sphere: radius of curvature {radius} (negative: a dome), {}",
                pv(&sphere.departure)
            ),
            format!("best-fit plane: {}", pv(&plane.departure)),
        ]
    }

    fn check_sag(&self, bytes: &[u8]) -> (Vec<Reason>, Option<SagFacts>) {
        let rows = match read_sag(bytes) {
            Ok(rows) => rows,
            Err(error) => {
                return (vec![Reason::new(ReasonKind::Unreadable, error.to_string())], None);
            }
        };
        let off = compare_sag(&rows, &self.design.mirror);
        let mut reasons = Vec::new();
        if rows.is_empty() {
            let remedy = "take a smaller pitch_mm and step_mm";
            let sentence = format!("it holds no rows, all beside the mirror; {remedy}");
            reasons.push(Reason::new(ReasonKind::EmptyTable, sentence));
        }
        if !(off.height_mm <= LAST_DIGIT) {
            let sentence = format!(
                "a height is {:.3e} mm off the design, over {LAST_DIGIT:e} mm",
                off.height_mm
            );
            reasons.push(Reason::new(ReasonKind::OffDesign, sentence));
        }
        if !(off.normal_rad <= LAST_DIGIT) {
            let sentence = format!(
                "a normal is {:.3e} rad off the design, over {LAST_DIGIT:e} rad",
                off.normal_rad
            );
            reasons.push(Reason::new(ReasonKind::OffDesign, sentence));
        }
        let facts = SagFacts {
            rows: rows.len(),
            height_error_mm: off.height_mm,
            normal_error_rad: off.normal_rad,
        };
        (reasons, Some(facts))
    }
}
