//! Curves and surfaces of ISO 10303-42 from their entity instances.

use super::StepError;
use super::b_spline::{Knots, MOST_DEGREE, SplineCurve, SplineSurface, Weighted};
use super::curve::Curve;
use super::entities::{Entities, Entity};
use super::surface::{FaceSurface, Frame};
use crate::geom::DVec3;

/// Curves of curves up to which an edge's curve is followed.
const MOST_WRAPPERS: usize = 8;
/// Distance of a meridian from the plane of its axis, and beyond the axis, that rounding may cause, mm.
const OFF_PLANE: f64 = 1e-6;

/// The frame of an AXIS2_PLACEMENT_3D or an AXIS1_PLACEMENT.
pub(super) fn placement(entities: &Entities, place: Entity) -> Result<Frame, StepError> {
    let at = entities.point(place, place.reference(1)?)?;
    let direction = |k: usize| match place.is_absent(k) {
        true => Ok(None),
        false => entities.direction(place, k).map(Some),
    };
    let z = direction(2)?.unwrap_or_else(|| entities.turned(DVec3::Z));
    let x = match place.keyword() {
        "AXIS2_PLACEMENT_3D" => direction(3)?,
        "AXIS1_PLACEMENT" => None,
        _ => return Err(place.refused("placement")),
    };
    let across = if z.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
    let frame = Frame::new(at, z, x.unwrap_or(across));
    frame.ok_or_else(|| place.fault("its two directions are one"))
}

/// The curve that `id` names; and whether it runs against what its entity instance says.
pub(super) fn curve(
    entities: &Entities,
    from: Entity,
    id: u64,
) -> Result<(Curve, bool), StepError> {
    let (mut entity, mut is_reversed) = (entities.entity(from, id)?, false);
    for _ in 0..MOST_WRAPPERS {
        match entity.keyword() {
            "SURFACE_CURVE" | "SEAM_CURVE" | "INTERSECTION_CURVE" => {
                entity = entities.follow(entity, 1)?;
            }
            "TRIMMED_CURVE" => {
                is_reversed ^= !entity.flag(4)?;
                entity = entities.follow(entity, 1)?;
            }
            _ => return Ok((plain_curve(entities, from, entity)?, is_reversed)),
        }
    }
    Err(entity.fault("a curve of curves without end"))
}

fn plain_curve(entities: &Entities, from: Entity, entity: Entity) -> Result<Curve, StepError> {
    Ok(match entity.keyword() {
        "LINE" => {
            let at = entities.point(entity, entity.reference(1)?)?;
            let vector = entities.follow_as(entity, 2, "VECTOR")?;
            Curve::Line { at, along: entities.direction(vector, 1)? }
        }
        "CIRCLE" | "ELLIPSE" => {
            let frame = placement(entities, entities.follow(entity, 1)?)?;
            let radius = |k: usize| Ok(entity.positive(k)? * entities.mm);
            let (a, b) = (radius(2)?, radius(if entity.keyword() == "CIRCLE" { 2 } else { 3 })?);
            Curve::Ellipse { centre: frame.at, axes: [frame.x * a, frame.y * b] }
        }
        _ => Curve::Spline(spline_curve(entities, from, entity)?),
    })
}

/// The records that make a spline: degree and control points, knots, weights.
struct SplineRecords<'a> {
    /// The record with the degree, and the place of that.
    base: (Entity<'a>, usize),
    /// The record with the knots, and the place of the multiplicities.
    knots: Option<(Entity<'a>, usize)>,
    weights: Option<Entity<'a>>,
    /// The name of the kind, without `_CURVE` or `_SURFACE`.
    kind: &'a str,
}

impl<'a> SplineRecords<'a> {
    /// Those of the instance `id`; `what` is `CURVE` or `SURFACE`, whose knots of a simple instance are attribute `at`.
    fn find(
        entities: &'a Entities,
        from: Entity,
        first: Entity<'a>,
        (what, at): (&str, usize),
    ) -> Result<Self, StepError> {
        let records = entities.records(from, first.id)?;
        let named = |name: &str| {
            let name = format!("{name}_{what}");
            records.iter().copied().find(|record| record.keyword() == name)
        };
        let with_knots = format!("B_SPLINE_{what}_WITH_KNOTS");
        let knots = records.iter().copied().find(|record| record.keyword() == with_knots);
        let of = |kind: &'a str| named(kind).map(|record| (record, kind));
        let kind = ["BEZIER", "QUASI_UNIFORM", "UNIFORM"].into_iter().find_map(of);
        if let [single] = records[..] {
            return match (knots, kind) {
                (Some(_), _) => Ok(Self {
                    base: (single, 1),
                    knots: Some((single, at)),
                    weights: None,
                    kind: "",
                }),
                (_, Some((_, kind))) => {
                    Ok(Self { base: (single, 1), knots: None, weights: None, kind })
                }
                _ => Err(single.refused(&what.to_lowercase())),
            };
        }
        let weights = named("RATIONAL_B_SPLINE");
        match named("B_SPLINE") {
            Some(base) if knots.is_some() || kind.is_some() => Ok(Self {
                base: (base, 0),
                knots: knots.map(|record| (record, 0)),
                weights,
                kind: kind.map_or("", |(_, kind)| kind),
            }),
            _ => Err(first.refused(&what.to_lowercase())),
        }
    }

    /// The knots along axis `axis` of `axes`, of `count` control points.
    fn axis(&self, axis: usize, axes: usize, count: usize) -> Result<Knots, StepError> {
        let (base, at) = self.base;
        let degree = base.number(at + axis)?;
        let knots = match self.knots {
            Some((record, first)) => {
                let multiplicities = record.numbers(first + axis)?;
                let values = record.numbers(first + axes + axis)?;
                Knots::new(degree, &multiplicities, &values, count)
            }
            None if !(degree >= 1.0 && degree <= MOST_DEGREE as f64) => {
                Err(format!("the degree must be 1 to {MOST_DEGREE}, not {degree}"))
            }
            None => match self.kind {
                "BEZIER" => Knots::even(degree as usize, count, degree as usize, true),
                kind => Knots::even(degree as usize, count, 1, kind == "QUASI_UNIFORM"),
            },
        };
        knots.map_err(|fault| base.fault(fault))
    }
}

/// Control points with their weights, which must be more than 0.
fn weighted(
    entities: &Entities,
    base: Entity,
    ids: &[u64],
    weights: Option<(Entity, &[f64])>,
) -> Result<Vec<Weighted>, StepError> {
    if let Some((record, weights)) = weights
        && (weights.len() != ids.len() || weights.iter().any(|w| !(*w > 0.0)))
    {
        return Err(record.fault("every control point must have a weight of more than 0"));
    }
    let weight = |k: usize| weights.map_or(1.0, |(_, weights)| weights[k]);
    let point = |(k, &id): (usize, &u64)| Ok(Weighted::new(entities.point(base, id)?, weight(k)));
    ids.iter().enumerate().map(point).collect()
}

fn spline_curve(
    entities: &Entities,
    from: Entity,
    first: Entity,
) -> Result<SplineCurve, StepError> {
    let records = SplineRecords::find(entities, from, first, ("CURVE", 6))?;
    let (base, at) = records.base;
    let ids = base.references(at + 1)?;
    let knots = records.axis(0, 1, ids.len())?;
    let weights = records.weights.map(|record| Ok((record, record.numbers(0)?))).transpose()?;
    let weights = weights.as_ref().map(|(record, weights)| (*record, &weights[..]));
    Ok(SplineCurve { knots, points: weighted(entities, base, &ids, weights)? })
}

fn spline_surface(
    entities: &Entities,
    from: Entity,
    first: Entity,
) -> Result<SplineSurface, StepError> {
    let records = SplineRecords::find(entities, from, first, ("SURFACE", 8))?;
    let (base, at) = records.base;
    let rows = base.reference_rows(at + 2)?;
    let columns = rows.first().map_or(0, Vec::len);
    if rows.iter().any(|row| row.len() != columns) {
        return Err(base.fault("rows of control points of different lengths"));
    }
    let knots = [records.axis(0, 2, rows.len())?, records.axis(1, 2, columns)?];
    let weights = records.weights.map(|record| Ok((record, record.number_rows(0)?.concat())));
    let weights = weights.transpose()?;
    let weights = weights.as_ref().map(|(record, weights)| (*record, &weights[..]));
    Ok(SplineSurface::new(knots, weighted(entities, base, &rows.concat(), weights)?))
}

/// The surface that `id` names, as far as a face with these places on its edges needs it.
pub(super) fn surface(
    entities: &Entities,
    from: Entity,
    id: u64,
    places: &[DVec3],
) -> Result<FaceSurface, StepError> {
    let entity = entities.entity(from, id)?;
    let frame = || placement(entities, entities.follow(entity, 1)?);
    let radius = |k: usize| Ok(entity.positive(k)? * entities.mm);
    // A meridian of the frame's coordinates.
    let [x, z] = [DVec3::X, DVec3::Z];
    let revolved = |meridian: Curve| Ok(FaceSurface::Revolved { frame: frame()?, meridian });
    match entity.keyword() {
        "PLANE" => Ok(FaceSurface::Plane(frame()?)),
        "CYLINDRICAL_SURFACE" => revolved(Curve::Line { at: x * radius(2)?, along: z }),
        "CONICAL_SURFACE" => {
            let slope = crate::num::tan(entity.positive(3)? * entities.radians);
            let at = x * (entity.number(2)? * entities.mm);
            revolved(Curve::Line { at, along: (z + x * slope).normalize() })
        }
        "SPHERICAL_SURFACE" => {
            let r = radius(2)?;
            revolved(Curve::Ellipse { centre: DVec3::ZERO, axes: [x * r, z * r] })
        }
        "TOROIDAL_SURFACE" => {
            let (centre, r) = (x * radius(2)?, radius(3)?);
            if !(centre.x > r) {
                return Err(entity.fault("a torus that meets itself is not read"));
            }
            revolved(Curve::Ellipse { centre, axes: [x * r, z * r] })
        }
        "SURFACE_OF_REVOLUTION" => {
            let (meridian, _) = curve(entities, entity, entity.reference(1)?)?;
            let axis = placement(entities, entities.follow(entity, 2)?)?;
            turned(entity, &meridian, axis)
        }
        "SURFACE_OF_LINEAR_EXTRUSION" => {
            let (swept, _) = curve(entities, entity, entity.reference(1)?)?;
            let vector = entities.follow_as(entity, 2, "VECTOR")?;
            let along = entities.direction(vector, 1)?;
            extruded(entity, &swept, along, places)
        }
        _ => Ok(FaceSurface::Spline(spline_surface(entities, from, entity)?)),
    }
}

/// The surface of a curve turned about the Z of `axis`.
fn turned(entity: Entity, meridian: &Curve, axis: Frame) -> Result<FaceSurface, StepError> {
    let samples = meridian.samples();
    let local = samples.iter().map(|&p| axis.components(p - axis.at));
    let reach = |p: &DVec3| p.truncate().length_squared();
    let farthest = local.max_by(|a, b| reach(a).total_cmp(&reach(b))).unwrap_or(DVec3::X);
    let out = axis.x * farthest.x + axis.y * farthest.y;
    let Some(frame) = Frame::new(axis.at, axis.z, out) else {
        return Err(entity.fault("its curve lies on its axis"));
    };
    let at = |p: DVec3| frame.components(p - frame.at);
    let is_off = |p: &DVec3| !(at(*p).y.abs() <= OFF_PLANE && at(*p).x >= -OFF_PLANE);
    // A circle that reaches beyond the axis is cut there.
    let is_cut = matches!(meridian, Curve::Ellipse { .. } | Curve::Line { .. });
    let is_off = |p: &DVec3| if is_cut { !(at(*p).y.abs() <= OFF_PLANE) } else { is_off(p) };
    if samples.iter().any(is_off) {
        return Err(entity.fault("a curve that is not on one side of the axis, in a plane with it"));
    }
    let meridian = meridian.mapped(at, |v| frame.components(v));
    Ok(FaceSurface::Revolved { frame, meridian })
}

/// The surface of a curve moved along a direction, as far as `places` reach.
fn extruded(
    entity: Entity,
    swept: &Curve,
    along: DVec3,
    places: &[DVec3],
) -> Result<FaceSurface, StepError> {
    let line = match swept {
        Curve::Line { at, along: x } => {
            let frame = Frame::new(*at, x.cross(along), *x);
            let frame = frame.ok_or_else(|| entity.fault("a line along its own direction"))?;
            return Ok(FaceSurface::Plane(frame));
        }
        Curve::Ellipse { .. } => swept.as_spline().map_err(|fault| entity.fault(fault))?,
        Curve::Spline(spline) => spline.clone(),
    };
    // The curve's control points and the face's edges say how far it reaches along the direction.
    let hull = line.points.iter().map(|point| point.project().dot(along));
    let [low, high] = range(hull);
    let [first, last] = range(places.iter().map(|place| place.dot(along)));
    let (from, to) = (first - high, last - low);
    if !(from < to) {
        return Err(entity.fault("a surface without extent"));
    }
    let point = |p: &Weighted, by: f64| Weighted { p: p.p + along * (by * p.w), w: p.w };
    let points = line.points.iter().flat_map(|p| [point(p, from), point(p, to)]).collect();
    let straight = Knots::new(1.0, &[2.0; 2], &[from, to], 2).map_err(|e| entity.fault(e))?;
    Ok(FaceSurface::Spline(SplineSurface::new([line.knots, straight], points)))
}

/// Least and largest of some numbers.
fn range(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    numbers.fold(none, |[lo, hi], x| [lo.min(x), hi.max(x)])
}
