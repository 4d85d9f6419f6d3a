//! Where the body stands in its file: its representation, units and uncertainty.

use super::StepError;
use super::entities::{Entities, Entity};

/// Uncertainty of a file that does not say its own, mm: what CAD programs join faces with.
const USUAL_UNCERTAINTY: f64 = 1e-5;
/// Least uncertainty that curves are held to, mm: coordinates in inches with 10 digits are no better.
const LEAST_UNCERTAINTY: f64 = 1e-7;

/// The one solid of a file.
pub(super) struct SolidEntity {
    /// Number of the closed shell.
    pub shell: u64,
    /// Number of the solid itself.
    pub id: u64,
    /// What the file says points and curves may be apart, mm.
    pub uncertainty_mm: f64,
}

/// Instances that place a representation elsewhere.
const PLACED: [&str; 3] =
    ["ITEM_DEFINED_TRANSFORMATION", "MAPPED_ITEM", "CARTESIAN_TRANSFORMATION_OPERATOR_3D"];
/// Solids that are none of one closed shell.
const OTHER_SOLIDS: [&str; 4] =
    ["BREP_WITH_VOIDS", "FACETED_BREP", "CSG_SOLID", "SHELL_BASED_SURFACE_MODEL"];

/// Finds the one solid of the file, and sets the units of `entities`.
///
/// # Errors
/// [`StepError`] where there are none or several, another kind of solid, a transformation, or a unit that is not
/// known.
pub(super) fn find_solid(entities: &mut Entities) -> Result<SolidEntity, StepError> {
    for keyword in OTHER_SOLIDS {
        if let Some(other) = entities.named(keyword).next() {
            return Err(other.refused("solid"));
        }
    }
    for keyword in PLACED {
        if let Some(placed) = entities.named(keyword).next() {
            return Err(
                placed.fault("a part within an assembly is not read; export the part alone")
            );
        }
    }
    let mut solids = entities.named("MANIFOLD_SOLID_BREP");
    let solid = solids.next();
    let solid = solid.ok_or_else(|| StepError::of_file("no MANIFOLD_SOLID_BREP in the file"))?;
    if let Some(second) = solids.next() {
        return Err(second.fault("a second solid; the file must hold one alone"));
    }
    drop(solids);
    let (id, shell) = (solid.id, solid.reference(1)?);
    let (mm, radians, uncertainty) = match representation(entities, id)? {
        Some(context) => units(entities, context)?,
        None => return Err(solid.fault("it is in no representation, which would name the unit")),
    };
    (entities.mm, entities.radians) = (mm, radians);
    let uncertainty_mm = uncertainty.unwrap_or(USUAL_UNCERTAINTY).max(LEAST_UNCERTAINTY);
    Ok(SolidEntity { shell, id, uncertainty_mm })
}

/// The representation that has the solid among its items, and the number of its context.
fn representation(entities: &Entities, solid: u64) -> Result<Option<(Entity<'_>, u64)>, StepError> {
    for keyword in ["ADVANCED_BREP_SHAPE_REPRESENTATION", "SHAPE_REPRESENTATION"] {
        for shape in entities.named(keyword) {
            if shape.references(1)?.contains(&solid) {
                return Ok(Some((shape, shape.reference(2)?)));
            }
        }
    }
    Ok(None)
}

/// Millimetres of the unit of length, radians of that of angle, and the uncertainty in mm.
fn units(
    entities: &Entities,
    (shape, context): (Entity, u64),
) -> Result<(f64, f64, Option<f64>), StepError> {
    let (mut mm, mut radians) = (None, 1.0);
    let assigned = entities.part(shape, context, "GLOBAL_UNIT_ASSIGNED_CONTEXT")?;
    let assigned = assigned.ok_or_else(|| shape.fault("its context assigns no units"))?;
    for unit in assigned.references(0)? {
        if entities.part(assigned, unit, "LENGTH_UNIT")?.is_some() {
            mm = Some(1e3 * size(entities, assigned, unit, 0)?);
        } else if entities.part(assigned, unit, "PLANE_ANGLE_UNIT")?.is_some() {
            radians = size(entities, assigned, unit, 0)?;
        }
    }
    let mm = mm.ok_or_else(|| assigned.fault("no unit of length"))?;
    let mut uncertainty = None;
    let global = entities.part(shape, context, "GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT")?;
    if let Some(global) = global {
        for id in global.references(0)? {
            let measure = entities.entity(global, id)?;
            if measure.keyword() == "UNCERTAINTY_MEASURE_WITH_UNIT" {
                let unit = 1e3 * size(entities, measure, measure.reference(1)?, 0)?;
                uncertainty = Some(measure.number(0)? * unit);
            }
        }
    }
    Ok((mm, radians, uncertainty))
}

/// Conversions upon conversions up to which a unit is followed.
const MOST_CONVERSIONS: usize = 8;

/// Size of a unit in metres or radians.
fn size(entities: &Entities, from: Entity, unit: u64, depth: usize) -> Result<f64, StepError> {
    if let Some(si) = entities.part(from, unit, "SI_UNIT")? {
        let prefix = match si.enumeration(0) {
            None => 1.0,
            Some("MILLI") => 1e-3,
            Some("CENTI") => 1e-2,
            Some("DECI") => 1e-1,
            Some("KILO") => 1e3,
            Some("MICRO") => 1e-6,
            Some(other) => return Err(si.fault(format!("the prefix {other} is not known"))),
        };
        return match si.enumeration(1) {
            Some("METRE" | "RADIAN") => Ok(prefix),
            _ => Err(si.fault("neither a metre nor a radian")),
        };
    }
    let Some(converted) = entities.part(from, unit, "CONVERSION_BASED_UNIT")? else {
        return Err(from.fault(format!("#{unit} is no unit that is read")));
    };
    if depth == MOST_CONVERSIONS {
        return Err(converted.fault("a unit of units of units without end"));
    }
    let id = converted.reference(1)?;
    let records = entities.records(converted, id)?;
    let measure =
        records.into_iter().find(|record| record.keyword().ends_with("MEASURE_WITH_UNIT"));
    let measure = measure.ok_or_else(|| converted.fault(format!("#{id} is no measure")))?;
    let factor = measure.positive(0)?;
    Ok(factor * size(entities, measure, measure.reference(1)?, depth + 1)?)
}
