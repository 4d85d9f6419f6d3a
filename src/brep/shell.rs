//! The closed shell of a solid: faces, edges and vertices, and whether they are one.

use super::StepError;
use super::context::SolidEntity;
use super::curve::Curve;
use super::entities::{Entities, Entity};
use super::face::TrimmedFace;
use super::geometry::{curve, surface};
use super::trim::Travel;
use crate::geom::DVec3;
use crate::parallel;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry::{Occupied, Vacant};

/// Share by which rounding of 10 decimals may pass the uncertainty.
const ROUNDING: f64 = 1.01;

/// An edge: its curve from the first vertex to the second.
struct Edge<'a> {
    entity: Entity<'a>,
    curve: Curve,
    range: [f64; 2],
    /// The numbers of both vertices.
    ends: [u64; 2],
    /// How often loops run along it, and against it.
    uses: [usize; 2],
}

/// A face before its edges are laid on its surface: for each the number, and whether the loop runs along it.
struct Bounds<'a> {
    entity: Entity<'a>,
    loops: Vec<(u64, bool)>,
    /// Vertices that bound the face by themselves.
    points: Vec<u64>,
    /// Number of loops, points included.
    count: usize,
    surface: u64,
    same: bool,
}

/// Faces of a closed shell, and how well they meet.
pub(super) struct Shell {
    pub faces: Vec<TrimmedFace>,
    /// Number of edges and of vertices.
    pub edges: usize,
    pub vertices: usize,
    /// Number of loops of edges, and of points that stand for one.
    pub loops: usize,
    /// Pieces that hang together by edges.
    pub components: usize,
    /// Largest distance of an edge from a face or of its ends from its vertices, mm.
    pub gap_mm: f64,
}

impl Shell {
    /// Reads the shell of a solid and checks that it is closed.
    ///
    /// # Errors
    /// [`StepError`] with the entity instance at fault.
    pub(super) fn read(entities: &Entities, solid: &SolidEntity) -> Result<Self, StepError> {
        let of_solid = entities.named("MANIFOLD_SOLID_BREP").next();
        let of_solid = of_solid.ok_or_else(|| StepError::of_file("no MANIFOLD_SOLID_BREP"))?;
        let shell = entities.entity(of_solid, solid.shell)?;
        if shell.keyword() != "CLOSED_SHELL" {
            return Err(shell.refused("closed shell"));
        }
        let (mut edges, mut bounds) = (BTreeMap::new(), Vec::new());
        for id in shell.references(1)? {
            bounds.push(read_bounds(entities, entities.entity(shell, id)?, &mut edges, solid)?);
        }
        for edge in edges.values() {
            check_uses(edge)?;
        }
        let limit = solid.uncertainty_mm * ROUNDING;
        let made = parallel::map_slice(&bounds, 1, |bounds| face(entities, bounds, &edges, limit));
        let faces = made.into_iter().collect::<Result<Vec<TrimmedFace>, StepError>>()?;
        let gap_mm = faces.iter().fold(0.0, |most: f64, face| most.max(face.trim.off_mm));
        let points = bounds.iter().flat_map(|bounds| bounds.points.iter().copied());
        let mut vertices: Vec<u64> =
            edges.values().flat_map(|edge| edge.ends).chain(points).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let loops = bounds.iter().map(|bounds| bounds.count).sum();
        let components = components(&bounds);
        Ok(Self { faces, edges: edges.len(), vertices: vertices.len(), loops, components, gap_mm })
    }
}

/// Number of sets of faces that hang together by edges.
fn components(faces: &[Bounds]) -> usize {
    let mut users: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (number, face) in faces.iter().enumerate() {
        for (edge, _) in &face.loops {
            users.entry(*edge).or_default().push(number);
        }
    }
    let (mut seen, mut count) = (vec![false; faces.len()], 0);
    for first in 0..faces.len() {
        let mut waiting = vec![first];
        count += usize::from(!seen[first]);
        while let Some(number) = waiting.pop() {
            if !std::mem::replace(&mut seen[number], true) {
                let edges = faces[number].loops.iter();
                waiting.extend(edges.flat_map(|(edge, _)| users[edge].iter().copied()));
            }
        }
    }
    count
}

/// That every edge is run along once and against once.
fn check_uses(edge: &Edge) -> Result<(), StepError> {
    match edge.uses {
        [1, 1] => Ok(()),
        [1, 0] | [0, 1] => {
            Err(edge.entity.fault("one face alone has this edge: the shell is open"))
        }
        [2, 0] | [0, 2] => {
            Err(edge.entity.fault("two loops run along it the same way: a face is turned over"))
        }
        [a, b] => Err(edge.entity.fault(format!("{} loops run along this edge, not two", a + b))),
    }
}

fn read_bounds<'a>(
    entities: &'a Entities,
    entity: Entity<'a>,
    edges: &mut BTreeMap<u64, Edge<'a>>,
    solid: &SolidEntity,
) -> Result<Bounds<'a>, StepError> {
    if !matches!(entity.keyword(), "ADVANCED_FACE" | "FACE_SURFACE") {
        return Err(entity.refused("face"));
    }
    let (surface, same) = (entity.reference(2)?, entity.flag(3)?);
    let (mut loops, mut points, mut count) = (Vec::new(), Vec::new(), 0);
    for id in entity.references(1)? {
        count += 1;
        let bound = entities.entity(entity, id)?;
        if !matches!(bound.keyword(), "FACE_OUTER_BOUND" | "FACE_BOUND") {
            return Err(bound.refused("bound"));
        }
        let forward = bound.flag(2)?;
        let edge_loop = entities.follow(bound, 1)?;
        match edge_loop.keyword() {
            // The tip of a cone or the pole of a sphere.
            "VERTEX_LOOP" => {
                points.push(edge_loop.reference(1)?);
                continue;
            }
            "EDGE_LOOP" => {}
            _ => return Err(edge_loop.refused("loop")),
        }
        let (mut first, mut last) = (None, None);
        for id in edge_loop.references(1)? {
            let oriented = entities.entity(edge_loop, id)?;
            if oriented.keyword() != "ORIENTED_EDGE" {
                return Err(oriented.refused("edge of a loop"));
            }
            let (id, along) = (oriented.reference(3)?, oriented.flag(4)?);
            let edge = match edges.entry(id) {
                Occupied(known) => known.into_mut(),
                Vacant(new) => {
                    new.insert(read_edge(entities, entities.entity(oriented, id)?, solid)?)
                }
            };
            let [from, to] = if along { edge.ends } else { [edge.ends[1], edge.ends[0]] };
            if last.is_some_and(|last| last != from) {
                return Err(oriented.fault("it does not begin where the edge before it ends"));
            }
            (first, last) = (first.or(Some(from)), Some(to));
            edge.uses[usize::from(along != forward)] += 1;
            loops.push((id, along == forward));
        }
        if first != last {
            return Err(edge_loop.fault("it does not end where it begins"));
        }
    }
    Ok(Bounds { entity, loops, points, count, surface, same })
}

fn read_edge<'a>(
    entities: &'a Entities,
    entity: Entity<'a>,
    solid: &SolidEntity,
) -> Result<Edge<'a>, StepError> {
    if entity.keyword() != "EDGE_CURVE" {
        return Err(entity.refused("edge"));
    }
    let ends = [entity.reference(1)?, entity.reference(2)?];
    let mut places = [DVec3::ZERO; 2];
    for (place, id) in places.iter_mut().zip(ends) {
        let vertex = entities.entity(entity, id)?;
        if vertex.keyword() != "VERTEX_POINT" {
            return Err(vertex.refused("vertex"));
        }
        *place = entities.point(vertex, vertex.reference(1)?)?;
    }
    let (curve, is_reversed) = curve(entities, entity, entity.reference(3)?)?;
    let forward = entity.flag(4)? != is_reversed;
    let mut range = places.map(|place| curve.nearest(place));
    let limit = solid.uncertainty_mm * ROUNDING;
    for (t, place) in range.iter().zip(places) {
        let off = curve.at(*t).0.distance(place);
        if !(off <= limit) {
            let fault =
                format!("its curve passes a vertex at {off:.1e} mm; at most {limit:.1e} mm");
            return Err(entity.fault(fault));
        }
    }
    let sign = if forward { 1.0 } else { -1.0 };
    let is_round = ends[0] == ends[1];
    let least = 1e-12 * (range[0].abs() + range[1].abs());
    if is_round || !(sign * (range[1] - range[0]) > least) {
        let period =
            curve.period(limit).ok_or_else(|| entity.fault("its curve runs the other way"))?;
        range[1] = if is_round { range[0] } else { range[1] };
        range[1] += sign * period;
        if !(sign * (range[1] - range[0]) > least) {
            range[1] += sign * period;
        }
    }
    Ok(Edge { entity, curve, range, ends, uses: [0; 2] })
}

fn face(
    entities: &Entities,
    bounds: &Bounds,
    edges: &BTreeMap<u64, Edge>,
    limit: f64,
) -> Result<TrimmedFace, StepError> {
    let own = || bounds.loops.iter().filter_map(|(id, along)| Some((id, *along, edges.get(id)?)));
    let places: Vec<DVec3> = own()
        .flat_map(|(_, _, edge)| {
            edge.curve.breaks(edge.range).into_iter().map(|t| edge.curve.at(t).0)
        })
        .collect();
    let surface = surface(entities, bounds.entity, bounds.surface, &places)?;
    let count = |wanted: &u64| bounds.loops.iter().filter(|(id, _)| id == wanted).count();
    // A face meets itself along a seam, which bounds nothing.
    let travels: Vec<Travel> = own()
        .filter(|(id, ..)| count(id) == 1)
        .map(|(_, along, edge)| {
            let [from, to] = edge.range;
            Travel { curve: &edge.curve, range: if along { [from, to] } else { [to, from] } }
        })
        .collect();
    let face = TrimmedFace::new(surface, bounds.same, &travels);
    let face = face.map_err(|fault| bounds.entity.fault(fault))?;
    let off = face.trim.off_mm;
    if !(off <= limit) {
        let fault = format!("an edge is {off:.1e} mm off its surface; at most {limit:.1e} mm");
        return Err(bounds.entity.fault(fault));
    }
    Ok(face)
}
