//! The unit of a file of unknown making: as it declares, as is asked, or by its size.

use crate::align::{LengthUnit, SizeRange};
use crate::geom::TriMesh;
use crate::results::UnitFacts;

/// How a unit is called that the file names, that its size speaks for, and that nothing speaks for.
const DECLARED: &str = "declared";
const BY_SIZE: &str = "by size";
const ASSUMED: &str = "assumed";

/// Symbol of a unit that has none here, as a foot.
const NAMELESS: &str = "of its own";

/// The unit of a file that says how many mm it is.
pub(super) fn declared(mm_per_unit: f64) -> UnitFacts {
    let is_it = |unit: &LengthUnit| (unit.mm() - mm_per_unit).abs() <= 1e-9 * mm_per_unit;
    let name = LengthUnit::ALL.into_iter().find(is_it).map_or(NAMELESS, LengthUnit::name);
    UnitFacts { name, mm_per_unit, chosen: DECLARED }
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

#[cfg(test)]
mod tests {
    use super::declared;

    #[test]
    fn a_declared_unit_is_told_by_its_own_name() {
        for (mm, name) in [
            (1.0, "mm"),
            (25.4, "in"),
            (25.400000000000002, "in"),
            (1000.0, "m"),
            (304.8, "of its own"),
        ] {
            let units = declared(mm);
            assert_eq!((units.name, units.mm_per_unit, units.chosen), (name, mm, "declared"));
        }
    }
}
