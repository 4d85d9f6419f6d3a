//! The program of an inspection in DMIS (ISO 22093), which the software of coordinate measuring machines reads.

use super::InspectionPlan;
use std::io::{self, Write};

/// Distances of approach and of retreat, mm.
const APPROACH_MM: f64 = 3.0;

/// Writes the plan as a DMIS program: each point a feature with its nominal place and normal, measured, and held to a
/// profile tolerance of `width_mm` about the design, if there is one. `notes` are comments. The part's frame must be set
/// up before, by its datum features; safe ways between them are the machine's.
///
/// # Errors
/// That of `out`.
pub fn write_dmis(
    out: &mut impl Write,
    plan: &InspectionPlan,
    width_mm: Option<f64>,
    notes: &[String],
) -> io::Result<()> {
    writeln!(out, "DMISMN/'Morion inspection of a mirror',05.2")?;
    for note in notes {
        // (Lines of a program are short.)
        for line in textwrap::wrap(note, 70) {
            writeln!(out, "$$ {line}")?;
        }
    }
    writeln!(out, "UNITS/MM,ANGDEC")?;
    if let Some(width_mm) = width_mm {
        let half = 0.5 * width_mm;
        writeln!(out, "T(MIRROR)=TOL/PROFP,-{half:.5},{half:.5}")?;
    }
    writeln!(out, "MODE/PROG,MAN")?;
    writeln!(out, "SNSET/APPRCH,{APPROACH_MM:.1}")?;
    writeln!(out, "SNSET/RETRCT,{APPROACH_MM:.1}")?;
    for (k, point) in plan.points.iter().enumerate() {
        let name = format!("P{:05}", k + 1);
        let [x, y, z] = point.at.to_array();
        let [i, j, n] = point.normal.to_array();
        let place = format!("CART,{x:.6},{y:.6},{z:.6},$\n     {i:.9},{j:.9},{n:.9}");
        writeln!(out, "F({name})=FEAT/POINT,{place}")?;
        writeln!(out, "MEAS/POINT,F({name}),1")?;
        writeln!(out, "PTMEAS/{place}")?;
        writeln!(out, "ENDMES")?;
        match width_mm {
            Some(_) => writeln!(out, "OUTPUT/FA({name}),TA(MIRROR)")?,
            None => writeln!(out, "OUTPUT/FA({name})")?,
        }
    }
    writeln!(out, "ENDFIL")?;
    out.flush()
}
