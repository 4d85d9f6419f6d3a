//! What is formed on a tool: the mirror's facets, from those of a file of the tool.

use super::tool::FormingTool;
use crate::geom::{DVec3, TriMesh};
use crate::mirror::Mirror;
use crate::parallel;
use crate::solid::open_edges;
use std::collections::BTreeMap;

/// Distance from a tool's face within which vertices are of it, as a share of the mirror's size: far above what
/// facets are off, and far below the height of walls.
const NEAR: f64 = 1e-3;
/// What rounding to single precision takes a vertex off the face by, as a share of the mirror's size.
const ROUNDED: f64 = 1e-6;
/// How far beyond the outline rounding and a file's digits take a vertex, as a share of the mirror's size.
const BEYOND: f64 = 1e-4;
/// By how much of their facets' size vertices on the edge are moved outwards, in the facets' planes: more than the normals
/// there, which facets on one side alone tell, leave of the edge.
const WIDENED: f64 = 0.02;
/// Vertices that a thread looks at at a time.
const CHUNK: usize = 1024;

/// The mirror of a piece formed on a tool, as facets: those of the tool's face, each vertex moved through the sheet
/// along the normal of the facets around it, and shrunk.
#[derive(Debug, Clone, PartialEq)]
pub struct FormedFace {
    /// The facets, in the part's frame, mm; the normals look to the camera's side.
    pub mesh: TriMesh,
    /// The vertex of the tool farthest from its surface, and how far that is, mm; none without vertices.
    pub worst_vertex: Option<(usize, f64)>,
}

impl FormedFace {
    /// The mirror that is formed on the facets `read` of a tool for `mirror`.
    #[must_use]
    pub fn of(tool: &FormingTool, mirror: &Mirror, read: &TriMesh) -> Self {
        let looks = parallel::map_slice(&read.vertices, CHUNK, |v| look(tool, mirror, *v));
        let farther = |a: (usize, f64), b: (usize, f64)| if b.1 <= a.1 { a } else { b };
        let worst_vertex = looks.iter().map(|look| look.off_mm).enumerate().reduce(farther);
        let on_face = |corners: &[u32; 3]| corners.iter().all(|&v| looks[v as usize].is_on_face);
        let mut mesh = TriMesh::default();
        let mut numbers = vec![u32::MAX; read.vertices.len()];
        for corners in read.triangles.iter().filter(|corners| on_face(corners)) {
            let mut corners = corners.map(|v| {
                let number = &mut numbers[v as usize];
                if *number == u32::MAX {
                    *number = mesh.vertices.len() as u32;
                    mesh.vertices.push(tool.to_part(read.vertices[v as usize]));
                }
                *number
            });
            if tool.is_hollow() {
                corners.swap(1, 2);
            }
            mesh.triangles.push(corners);
        }
        let offset_mm = tool.spec.offset_mm();
        if offset_mm != 0.0 {
            move_through(&mut mesh, -offset_mm);
        }
        Self { mesh, worst_vertex }
    }
}

/// What a vertex of a tool is.
struct VertexLook {
    is_on_face: bool,
    /// Distance from the tool's surface, mm.
    off_mm: f64,
}

fn look(tool: &FormingTool, mirror: &Mirror, v: DVec3) -> VertexLook {
    let (p, surface) = (tool.to_part(v), tool.surface(mirror));
    let outline = mirror.full_outline();
    let size = outline.bounds().size().max_element();
    let from_face = surface.place_over(p.truncate()).and_then(|place| {
        let (q, _) = mirror.chart.coordinates(place.at);
        let off_mm = (p.z - surface.beside(&place).z).abs() * place.normal().z;
        let is_near = outline.distance_outside(q) <= BEYOND * size && off_mm <= NEAR * size;
        is_near.then_some(off_mm)
    });
    // Most vertices are on the face, and there nothing else is asked.
    let off_mm = match from_face {
        Some(off_mm) if off_mm <= ROUNDED * size => off_mm,
        _ => from_face.unwrap_or(f64::INFINITY).min(tool.distance_around(v)),
    };
    VertexLook { is_on_face: from_face.is_some(), off_mm }
}

/// Moves the vertices by `through_mm` along the normals of the facets around them; the edge is widened.
fn move_through(mesh: &mut TriMesh, through_mm: f64) {
    let mut normals = vertex_normals(mesh);
    let edge = edge_vertices(mesh, &normals);
    for (&v, at_edge) in &edge {
        normals[v as usize] = at_edge.normal(mesh.vertices[v as usize]);
    }
    for (v, normal) in normals.iter().enumerate() {
        mesh.vertices[v] += through_mm * *normal;
    }
    for (&v, at_edge) in &edge {
        let v = &mut mesh.vertices[v as usize];
        // (Moved along the normals, the way to the facets' middle is the same but for their turning.)
        *v += WIDENED * at_edge.out;
    }
}

/// What is around a vertex on the edge of a mesh.
#[derive(Default)]
struct EdgeVertex {
    /// Sums over its facets: area vectors, areas, and middles times areas.
    area_vector: DVec3,
    area: f64,
    middle: DVec3,
    /// From the middles of its facets to it, mm, their sum.
    out: DVec3,
    /// Sums over its neighbours that are not on the edge: their normals, their places, their number.
    inner_normal: DVec3,
    inner: DVec3,
    inner_count: f64,
}

impl EdgeVertex {
    /// The unit normal at the vertex, which is at `v`: those of its facets, which hold at their middle, and beyond that as they
    /// change from the neighbours inside.
    fn normal(&self, v: DVec3) -> DVec3 {
        let normal = self.area_vector.normalize_or(DVec3::Z);
        if self.inner_count == 0.0 {
            return normal;
        }
        let (middle, inner) = (self.middle / self.area, self.inner / self.inner_count);
        let way = middle - inner;
        let share = (v - middle).dot(way) / way.length_squared();
        let turn = normal - self.inner_normal / self.inner_count;
        (normal + share * turn).normalize_or(DVec3::Z)
    }
}

/// Unit normals at the vertices by the facets around each, weighted as for a sphere, on which they are exact (N. Max,
/// Weights for computing vertex normals from facet normals, 1999).
fn vertex_normals(mesh: &TriMesh) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; mesh.vertices.len()];
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|v| mesh.vertices[v as usize]);
        for ([at, next, last], &v) in [[a, b, c], [b, c, a], [c, a, b]].into_iter().zip(corners) {
            let (to, from) = (next - at, last - at);
            let weight = to.length_squared() * from.length_squared();
            normals[v as usize] += to.cross(from) / weight;
        }
    }
    normals.iter().map(|normal| normal.normalize_or(DVec3::Z)).collect()
}

/// The vertices on the edge of a mesh with these normals, by their numbers.
fn edge_vertices(mesh: &TriMesh, normals: &[DVec3]) -> BTreeMap<u32, EdgeVertex> {
    let open = open_edges(mesh).into_iter().flat_map(|(from, to)| [from, to]);
    let mut all: BTreeMap<u32, EdgeVertex> =
        open.map(|vertex| (vertex, EdgeVertex::default())).collect();
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let inner: Vec<u32> = corners.iter().copied().filter(|v| !all.contains_key(v)).collect();
        let at = |v: u32| mesh.vertices[v as usize];
        let middle = corners.iter().map(|&v| at(v)).sum::<DVec3>() / 3.0;
        let area_vector = mesh.area_vector(t);
        for v in corners {
            let Some(vertex) = all.get_mut(v) else { continue };
            vertex.area_vector += area_vector;
            vertex.area += area_vector.length();
            vertex.middle += area_vector.length() * middle;
            vertex.out += at(*v) - middle;
            vertex.inner_normal += inner.iter().map(|&v| normals[v as usize]).sum::<DVec3>();
            vertex.inner += inner.iter().map(|&v| at(v)).sum::<DVec3>();
            vertex.inner_count += inner.len() as f64;
        }
    }
    all
}
