//! The sag table: rows of the design, and held against it once they were read back.

use super::cad_export::{CadExport, CadFigures, CadFindings};
use crate::design::Design;
use crate::export::{Label, compare_sag, read_sag, sag_bytes, write_sag};
use crate::geom::ScanPath;
use crate::mirror::{Departure, Form};
use crate::profile::{CadFormat, PanelSpec, ProjectionSpec};
use crate::results::{FileFault, SagFacts};
use std::io::{self, Write};

/// The sag table of a designed mirror.
pub(super) struct SagExport<'a> {
    pub design: &'a Design,
    /// Its departure from a sphere and a plane, for the comments.
    pub form: &'a Form,
    /// Where it is sampled.
    pub path: ScanPath,
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

    fn check(&self, bytes: &[u8]) -> CadFindings {
        let rows = match read_sag(bytes) {
            Ok(rows) => rows,
            Err(error) => {
                let faults = vec![FileFault::Unreadable(error.to_string())];
                return CadFindings { faults, figures: None, body: None };
            }
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
        CadFindings { faults, figures: Some(CadFigures::Sag(facts)), body: None }
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
