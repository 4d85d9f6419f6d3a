//! Wavefront OBJ: every digit of the coordinates, and the designed mirror's own normals.

use super::Label;
use crate::geom::{DVec2, DVec3};
use crate::mirror::Mirror;
use crate::solid::Solid;
use rayon::prelude::*;
use std::io::{self, Write};

/// Lines formatted by a thread at a time.
const CHUNK: usize = 8192;

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

    writeln!(out, "# Morion: profile {}, sha256 {}", Label::plain(&label.profile), label.sha256)?;
    writeln!(out, "# millimetres; {}", Label::plain(&label.tolerances))?;
    lines(out, &mesh.vertices, |text, v| writeln!(text, "v {} {} {}", v.x, v.y, v.z))?;
    lines(out, &all_normals, |text, n| writeln!(text, "vn {} {} {}", n.x, n.y, n.z))?;
    writeln!(out, "# optical face")?;
    lines(out, plain, |text, t| {
        let [a, b, c] = t.map(|v| v + 1);
        writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}")
    })?;
    lines(out, reflected, |text, t| {
        let [(a, p), (b, q), (c, r)] = t.map(|v| (v + 1, second(v) + 1));
        writeln!(text, "f {a}//{p} {b}//{q} {c}//{r}")
    })?;
    writeln!(out, "# skirt and base")?;
    lines(out, body, |text, t| {
        let [a, b, c] = t.map(|v| v + 1);
        writeln!(text, "f {a} {b} {c}")
    })?;
    out.flush()
}

/// The mirror's unit normals at `vertices`.
fn normals(mirror: &Mirror, vertices: &[DVec3]) -> Vec<DVec3> {
    let places: Vec<DVec2> = vertices.iter().map(|&v| mirror.chart.coordinates(v).0).collect();
    let lines: Vec<&[DVec2]> = places.chunk_by(|a, b| a.y == b.y).collect();
    let evaluate = |line: &&[DVec2]| {
        let points = mirror.along(line);
        let unit = |(&q, point)| mirror.normal(q, &point).normalize() + DVec3::ZERO;
        line.iter().zip(points).map(unit).collect::<Vec<_>>()
    };
    lines.par_iter().map(evaluate).collect::<Vec<_>>().concat()
}

/// One line of text an item, formatted in parallel, written in order.
fn lines<T: Sync>(
    out: &mut impl Write,
    items: &[T],
    line: impl Fn(&mut Vec<u8>, &T) -> io::Result<()> + Sync,
) -> io::Result<()> {
    let format = |chunk: &[T]| -> io::Result<Vec<u8>> {
        let mut text = Vec::with_capacity(64 * chunk.len());
        chunk.iter().try_for_each(|item| line(&mut text, item))?;
        Ok(text)
    };
    // A few chunks at a time, so that the text of a large file is never in memory as a whole.
    for group in items.chunks(16 * CHUNK) {
        let texts: Vec<_> = group.par_chunks(CHUNK).map(format).collect();
        for text in texts {
            out.write_all(&text?)?;
        }
    }
    Ok(())
}
