//! Wavefront OBJ: every digit of the coordinates, and the designed mirror's own normals.

use super::text::lines;
use super::{Label, MeshCounts};
use crate::geom::{DVec2, DVec3, Precision};
use crate::mirror::Mirror;
use crate::parallel;
use crate::solid::Solid;
use std::io::{self, Write};

/// Writes `solid` as OBJ. The first `solid.optical()` facets carry the normals of `mirror` at
/// their corners (`v//vn`), the first `designed` of them those of the designed panel and the rest
/// those of its reflection, so that the ridge stays sharp; skirt and base have bare vertices.
/// Decimals are the shortest that read back to the same double.
///
/// # Errors
/// Whatever `out` returns, flushing included.
pub fn write_obj(
    out: &mut impl Write,
    solid: &Solid,
    mirror: &Mirror,
    designed: usize,
    label: &Label,
) -> io::Result<()> {
    let mesh = solid.mesh();
    let (optical, body) = mesh.triangles.split_at(solid.optical());
    let (plain, reflected) = optical.split_at(designed);
    let count = optical.iter().flatten().max().map_or(0, |&last| last as usize + 1);
    let normals = normals(mirror, &mesh.vertices[..count]);
    // Vertices on the ridge have a second normal, numbered after all the first ones.
    let ridge: Vec<u32> = (0..count as u32)
        .filter(|&v| mirror.folded && mesh.vertices[v as usize].y == 0.0)
        .collect();
    let second = |v: u32| match ridge.binary_search(&v) {
        Ok(k) => count + k,
        Err(_) => v as usize,
    };
    let flipped = |&v: &u32| normals[v as usize] * DVec3::new(1.0, -1.0, 1.0) + DVec3::ZERO;
    let all_normals: Vec<DVec3> =
        normals.iter().copied().chain(ridge.iter().map(flipped)).collect();

    header(out, label)?;
    lines(out, &mesh.vertices, vertex)?;
    lines(out, &all_normals, normal)?;
    writeln!(out, "{OPTICAL}")?;
    lines(out, plain, |text, t| smooth(text, &t.map(|v| (v + 1, v as usize + 1))))?;
    lines(out, reflected, |text, t| smooth(text, &t.map(|v| (v + 1, second(v) + 1))))?;
    writeln!(out, "{BODY}")?;
    lines(out, body, bare)?;
    out.flush()
}

/// Writes `solid` as OBJ without normals: a surface that is not the designed one has others.
///
/// # Errors
/// Whatever `out` returns, flushing included.
pub fn write_obj_bare(out: &mut impl Write, solid: &Solid, label: &Label) -> io::Result<()> {
    let mesh = solid.mesh();
    let (optical, body) = mesh.triangles.split_at(solid.optical());
    header(out, label)?;
    lines(out, &mesh.vertices, vertex)?;
    for (name, facets) in [(OPTICAL, optical), (BODY, body)] {
        writeln!(out, "{name}")?;
        lines(out, facets, bare)?;
    }
    out.flush()
}

const OPTICAL: &str = "# optical face";
const BODY: &str = "# skirt and base";

fn header(out: &mut impl Write, label: &Label) -> io::Result<()> {
    writeln!(out, "# Morion: profile {}, sha256 {}", Label::plain(&label.profile), label.sha256)?;
    writeln!(out, "# millimetres; {}", label.about())
}

fn vertex(text: &mut Vec<u8>, v: &DVec3) -> io::Result<()> {
    writeln!(text, "v {} {} {}", v.x, v.y, v.z)
}

fn normal(text: &mut Vec<u8>, n: &DVec3) -> io::Result<()> {
    writeln!(text, "vn {} {} {}", n.x, n.y, n.z)
}

/// A facet by the numbers of its vertices and normals.
fn smooth(text: &mut Vec<u8>, facet: &[(u32, usize); 3]) -> io::Result<()> {
    let [(a, p), (b, q), (c, r)] = facet;
    writeln!(text, "f {a}//{p} {b}//{q} {c}//{r}")
}

/// A facet without normals.
fn bare(text: &mut Vec<u8>, facet: &[u32; 3]) -> io::Result<()> {
    let [a, b, c] = facet.map(|v| v + 1);
    writeln!(text, "f {a} {b} {c}")
}

/// Foresees the length of what [`write_obj`] writes of a solid of this size: from the lines of
/// vertices and facets like its own.
#[must_use]
pub fn obj_bytes(size: &MeshCounts, mirror: &Mirror, precision: Precision, label: &Label) -> u64 {
    let places = sample(mirror, precision);
    let points = mirror.eval_many(&places);
    let on_mirror: Vec<DVec3> =
        places.iter().zip(&points).map(|(&q, point)| mirror.position(q, point)).collect();
    let feet: Vec<DVec3> = on_mirror.iter().map(|v| v.truncate().extend(0.0)).collect();
    let numbers = |count: usize| -> Vec<u32> {
        (0..SAMPLES).map(|k| ((k as f64 + 0.5) / SAMPLES as f64 * count as f64) as u32).collect()
    };
    let vertices = size.face_vertices + size.more_vertices;
    let smooth_facets: Vec<_> =
        numbers(size.face_vertices).iter().map(|&v| [(v + 1, v as usize + 1); 3]).collect();
    let bare_facets: Vec<_> = numbers(vertices).iter().map(|&v| [v; 3]).collect();
    let mut head = Vec::new();
    // Writing to memory cannot fail.
    let _ = header(&mut head, label);
    let head = head.len() + OPTICAL.len() + BODY.len() + 2;
    let text = size.face_vertices as f64
        * (mean(&on_mirror, vertex) + mean(&normals(mirror, &on_mirror), normal))
        + size.more_vertices as f64 * mean(&feet, vertex)
        + size.optical as f64 * mean(&smooth_facets, smooth)
        + size.more as f64 * mean(&bare_facets, bare);
    head as u64 + text as u64
}

/// Places for typical lines along each axis, and in all for numbers.
const SIDE: usize = 32;
const SAMPLES: usize = SIDE * SIDE;

/// Places all over the mirror, with digits like those of a mesh's vertices.
fn sample(mirror: &Mirror, precision: Precision) -> Vec<DVec2> {
    let outline = mirror.full_outline();
    let bounds = outline.bounds();
    // No round share of the sides: coordinates of few digits are rare.
    let share = |k: usize| (k as f64 + std::f64::consts::FRAC_1_SQRT_2) / (SIDE + 1) as f64;
    let single = precision == Precision::Single && mirror.chart.is_plan();
    let place = |k: usize| {
        let q = bounds.min + bounds.size() * DVec2::new(share(k % SIDE), share(k / SIDE));
        if single { q.as_vec2().as_dvec2() } else { q }
    };
    (0..SAMPLES).map(place).filter(|&q| outline.contains(q)).collect()
}

/// The mean length of the items' lines.
fn mean<T>(items: &[T], line: impl Fn(&mut Vec<u8>, &T) -> io::Result<()>) -> f64 {
    let mut text = Vec::new();
    for item in items {
        let _ = line(&mut text, item);
    }
    text.len() as f64 / items.len().max(1) as f64
}

/// The mirror's unit normals at `vertices`.
fn normals(mirror: &Mirror, vertices: &[DVec3]) -> Vec<DVec3> {
    if mirror.has_steps() {
        let panels = mirror.panels();
        let unit = |v: &DVec3| {
            let (q, panel) = (mirror.chart.coordinates(*v).0, &panels[mirror.panel_at(*v)]);
            panel.normal(q, &panel.at(q)).normalize() + DVec3::ZERO
        };
        return parallel::map_slice(vertices, 1 << 10, unit);
    }
    let places: Vec<DVec2> = vertices.iter().map(|&v| mirror.chart.coordinates(v).0).collect();
    let lines: Vec<&[DVec2]> = places.chunk_by(|a, b| a.y == b.y).collect();
    let evaluate = |line: &&[DVec2]| {
        let points = mirror.eval_many(line);
        let unit = |(&q, point)| mirror.normal(q, &point).normalize() + DVec3::ZERO;
        line.iter().zip(points).map(unit).collect::<Vec<_>>()
    };
    parallel::map_slice(&lines, 1, evaluate).concat()
}
