//! Is every vertex of a file where the part has one: on the designed mirror, on the base, or on the
//! skirt between them?

use crate::geom::{DVec2, DVec3};
use crate::mirror::Mirror;
use rayon::prelude::*;

/// Vertices that a thread handles at a time; fixed, so that results do not depend on the threads.
const CHUNK: usize = 16_384;

/// The vertex farthest from the part's surface, and how far that is, mm (along Z on the mirror and
/// the base, across it beside the outline). None without vertices.
pub fn worst_vertex(mirror: &Mirror, vertices: &[DVec3]) -> Option<(usize, f64)> {
    let farther = |a: (usize, f64), b: (usize, f64)| if b.1 <= a.1 { a } else { b };
    vertices
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, vertices)| {
            let mut row = (f64::NAN, mirror.row(0.0));
            let mut worst = (chunk * CHUNK, 0.0);
            for (k, &v) in vertices.iter().enumerate() {
                // Meshes list rows of equal Y together, and a row is costly to begin.
                if row.0 != v.y {
                    row = (v.y, mirror.row(v.y));
                }
                let sag = row.1.at(v.x).sag;
                worst = farther(worst, (chunk * CHUNK + k, distance(mirror, v, sag)));
            }
            worst
        })
        .reduce_with(farther)
}

fn distance(mirror: &Mirror, v: DVec3, sag: f64) -> f64 {
    let outline = mirror.outline();
    let q = v.truncate();
    let beside = (outline.min - q).max(q - outline.max);
    let from_rim = beside.max_element();
    if from_rim > 0.0 {
        return beside.max(DVec2::ZERO).length();
    }
    let on_skirt = if v.z >= 0.0 && v.z <= sag { -from_rim } else { f64::INFINITY };
    (v.z - sag).abs().min(v.z.abs()).min(on_skirt)
}
