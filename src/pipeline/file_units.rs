//! The unit of a file of unknown making: as it declares, as is asked, or by its size.

use crate::align::{LengthUnit, SizeRange};
use crate::geom::TriMesh;
use crate::results::UnitFacts;

/// How a unit is called that the file names, that its size speaks for, and that nothing speaks for.
const DECLARED: &str = "declared";
const BY_SIZE: &str = "by size";
const ASSUMED: &str = "assumed";

/// The unit of a file that says it: what it was read in.
pub(super) fn declared() -> UnitFacts {
    UnitFacts::new(LengthUnit::Mm, DECLARED)
}

/// Brings the vertices of a mesh of a part of this size to millimetres.
pub(super) fn in_millimetres(
    mesh: &mut TriMesh,
    size: &SizeRange,
    asked: Option<LengthUnit>,
) -> UnitFacts {
    let (unit, chosen) = match asked {
        Some(unit) => (unit, "asked"),
        None => match size.unit(mesh) {
            (unit, true) => (unit, BY_SIZE),
            (unit, false) => (unit, ASSUMED),
        },
    };
    unit.convert(mesh);
    UnitFacts::new(unit, chosen)
}

/// The warning of a unit that nothing speaks for, or none but the file's size.
pub(super) fn unit_warning(name: &str, units: UnitFacts, measured: bool) -> Option<String> {
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
