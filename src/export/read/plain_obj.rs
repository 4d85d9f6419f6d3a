//! OBJ of nothing but vertices, normals, triangles and comments, one space between words: read by many threads.

use super::ImportedMesh;
use crate::geom::{DVec3, TriMesh};
use crate::parallel;

/// Bytes that a thread reads at a time, up to the end of a line.
const PART: usize = 1 << 20;
/// Normal of a corner that names none.
const NONE: u32 = u32::MAX;

/// Lines of a part of a file, by kind.
#[derive(Default)]
struct Lines {
    vertices: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// Numbers of the corners, from 0 on.
    facets: Vec<[u32; 3]>,
    /// Numbers of their normals, likewise, or [`NONE`].
    facet_normals: Vec<[u32; 3]>,
}

/// The mesh of a plain OBJ whose vertices are finite and each at a place of its own, as `tobj` reads it and a
/// welder joins it; none of any other.
pub(super) fn read_plain_obj(bytes: &[u8]) -> Option<ImportedMesh> {
    let parts = parts(bytes);
    let mut all = Lines::default();
    for part in parallel::map_slice(&parts, 1, |part| lines(part)) {
        let part = part?;
        all.vertices.extend(part.vertices);
        all.normals.extend(part.normals);
        all.facets.extend(part.facets);
        all.facet_normals.extend(part.facet_normals);
    }
    let Lines { vertices, mut normals, facets, mut facet_normals } = all;
    let corners = facets.as_flattened();
    if facets.is_empty() || corners.iter().any(|&v| v as usize >= vertices.len()) {
        return None;
    }
    let normals = if normals.is_empty() {
        None
    } else {
        // `tobj` gives corners without a normal that of the corner before.
        let mut before = NONE;
        for normal in facet_normals.as_flattened_mut() {
            before = if *normal == NONE { before } else { *normal };
            *normal = before;
        }
        if facet_normals.as_flattened().iter().any(|&n| n as usize >= normals.len()) {
            return None;
        }
        parallel::for_each_mut(&mut normals, PART / 64, |_, n| *n = n.normalize_or_zero());
        let of_facet = |facet: &[u32; 3]| facet.map(|n| normals[n as usize]);
        Some(parallel::map_slice(&facet_normals, PART / 64, of_facet))
    };
    let mesh = TriMesh { vertices, triangles: facets }.as_welded()?;
    Some(ImportedMesh { mesh, normals })
}

/// The bytes in parts that end where lines do.
fn parts(mut bytes: &[u8]) -> Vec<&[u8]> {
    let mut parts = Vec::new();
    while !bytes.is_empty() {
        let least = PART.min(bytes.len());
        let rest = bytes[least..].iter().position(|&b| b == b'\n');
        let (part, after) = bytes.split_at(rest.map_or(bytes.len(), |more| least + more + 1));
        parts.push(part);
        bytes = after;
    }
    parts
}

/// The lines of a part; none if one is of another kind.
fn lines(part: &[u8]) -> Option<Lines> {
    let mut lines = Lines::default();
    // (Of the words of a file that is no text `tobj` says so.)
    let text = std::str::from_utf8(part).ok().filter(|text| text.is_ascii())?;
    for line in text.split('\n') {
        if let Some(numbers) = line.strip_prefix("v ") {
            lines.vertices.push(vector(numbers)?);
        } else if let Some(corners) = line.strip_prefix("f ") {
            let mut corners = corners.split(' ').map(corner);
            let mut next = || corners.next().flatten();
            let [(a, p), (b, q), (c, r)] = [next()?, next()?, next()?];
            if corners.next().is_some() {
                return None;
            }
            lines.facets.push([a, b, c]);
            lines.facet_normals.push([p, q, r]);
        } else if let Some(numbers) = line.strip_prefix("vn ") {
            lines.normals.push(vector(numbers)?);
        } else if !line.is_empty() && !line.starts_with("# ") {
            return None;
        }
    }
    Some(lines)
}

/// Three numbers, each rounded to the nearest double.
fn vector(words: &str) -> Option<DVec3> {
    let mut numbers = words.split(' ').map(|word| word.parse::<f64>().ok());
    let mut next = || numbers.next().flatten();
    let vector = DVec3::new(next()?, next()?, next()?);
    numbers.next().is_none().then_some(vector)
}

/// A corner of a facet: its vertex, and its normal or [`NONE`], both from 0 on.
fn corner(word: &str) -> Option<(u32, u32)> {
    match word.split_once("//") {
        Some((vertex, normal)) => Some((number(vertex)?, number(normal)?)),
        None => Some((number(word)?, NONE)),
    }
}

/// A number that counts from 1 on, as one from 0 on.
fn number(word: &str) -> Option<u32> {
    let digits = word.bytes().all(|b| b.is_ascii_digit());
    let number: u32 = word.parse().ok().filter(|_| digits)?;
    number.checked_sub(1)
}

#[cfg(test)]
mod tests {
    use super::super::{read_any_obj, read_obj};
    use super::*;

    const VERTICES: &str = "v 0 0 0\nv 1 0 -0.0\nv 0 1e-3 0\nv 1 1 0.1\nvn 0 0 2\nvn 0 1 1\n";

    #[test]
    fn plain_files_are_read_as_tobj_reads_them() {
        for facets in [
            "f 1//1 2 3\n",
            "# text\n\nf 4//2 3 2\nf 1 2 3",
            "f 1//1 2//1 3//2\nf 2 4 3\n",
            "f 1//2 2//1 3//2\nf 2 4//1 3\n",
        ] {
            let text = [VERTICES, facets].concat();
            let plain = read_plain_obj(text.as_bytes()).expect(facets);
            assert_eq!(plain, read_any_obj(text.as_bytes()).unwrap(), "{facets}");
            // Without normals nothing refers to them.
            let text = text.replace("vn ", "# ");
            let plain = read_plain_obj(text.as_bytes()).expect(facets);
            assert!(plain.normals.is_none());
            assert_eq!(plain, read_any_obj(text.as_bytes()).unwrap(), "{facets}");
        }
        // More than one part, facets first.
        let count = PART / 8;
        let facets: String = (1..=count).map(|k| format!("f {k} {} {}\n", k + 1, k + 2)).collect();
        let vertices: String = (0..count + 2).map(|k| format!("v {k} 0.{k} 1\n")).collect();
        let text = facets + &vertices;
        assert!(parts(text.as_bytes()).len() > 4);
        let plain = read_plain_obj(text.as_bytes()).unwrap();
        assert_eq!(plain, read_any_obj(text.as_bytes()).unwrap());
    }

    #[test]
    fn all_other_files_are_left_to_tobj() {
        for more in [
            "f 1 2 3\n",
            "f 1 2 3 4\n",
            "f 1 2\n",
            "f 1 2 5\n",
            "f 0 1 2\n",
            "f -1 -2 -3\n",
            "f +1 2 3\n",
            "f 1/1 2/1 3/1\n",
            "f 1//3 2//1 3//1\n",
            "f 1 2 3//1\n",
            "f 1  2 3\n",
            "f 1 2 3 \n",
            "f 1 2 3\r\n",
            "f\t1 2 3\n",
            "o part\nf 1 2 3\n",
            "v 0 0 0\nf 1 2 3\n",
            "f 1 2 x\n",
            "v 0 0 inf\nf 1 2 5\n",
            "v 2 2 2 2\nf 1 2 3\n",
            "#text\nf 1 2 3\n",
            "# \u{e9}\nf 1 2 3\n",
            "",
        ] {
            let text = [VERTICES, more].concat();
            assert_eq!(read_plain_obj(text.as_bytes()), None, "{more}");
            let words = |read: Result<ImportedMesh, _>| read.map_err(|error| format!("{error:?}"));
            let (any, all) = (read_any_obj(text.as_bytes()), read_obj(text.as_bytes()));
            assert_eq!(words(any), words(all), "{more}");
        }
    }
}
