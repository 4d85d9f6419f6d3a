//! Finer meshes: edges are split until none is too long.

use super::{DVec3, TriMesh};
use crate::parallel;

impl TriMesh {
    /// The same mesh, with edges split until none is longer than `longest` mm: each at the place
    /// that `between` gives for the middle of its ends, which must be about there. Facets stay
    /// oriented, and neighbours go on sharing their corners. None when that takes more than `most`
    /// facets.
    #[must_use]
    pub fn split(
        mut self,
        longest: f64,
        most: usize,
        between: impl Fn(DVec3, DVec3) -> DVec3 + Sync,
    ) -> Option<Self> {
        loop {
            let Self { vertices, triangles } = &mut self;
            let length = |a: u32, b: u32| (vertices[a as usize] - vertices[b as usize]).length();
            let mut edges: Vec<[u32; 2]> = parallel::gather(triangles.len(), 1, |part| {
                let edges = triangles[part].iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
                let long = edges.filter(|&[a, b]| length(a, b) > longest);
                long.map(|[a, b]| [a.min(b), a.max(b)]).collect()
            });
            if triangles.len() + edges.len() > most {
                return None;
            }
            parallel::sort_unstable_by(&mut edges, Ord::cmp);
            edges.dedup();
            if edges.is_empty() {
                return Some(self);
            }
            let first = vertices.len() as u32;
            let at = |v: u32| vertices[v as usize];
            let middles = parallel::map_slice(&edges, 1, |&[a, b]| between(at(a), at(b)));
            vertices.extend(middles);
            let middle = |a: u32, b: u32| {
                edges.binary_search(&[a.min(b), a.max(b)]).ok().map(|k| first + k as u32)
            };
            let cut = |&triangle: &[u32; 3]| cut(triangle, vertices, middle);
            let finer = parallel::gather(triangles.len(), 1, |part| {
                triangles[part].iter().flat_map(cut).collect()
            });
            *triangles = finer;
        }
    }
}

/// A facet cut at the middles of its sides, where they have any.
fn cut(
    [a, b, c]: [u32; 3],
    vertices: &[DVec3],
    middle: impl Fn(u32, u32) -> Option<u32>,
) -> Vec<[u32; 3]> {
    let away = |a: u32, b: u32| (vertices[a as usize] - vertices[b as usize]).length_squared();
    // Turned so that cut sides come first.
    let turned = |k: usize| {
        let corners = [a, b, c, a, b];
        let [a, b, c] = [corners[k], corners[k + 1], corners[k + 2]];
        ([a, b, c], [middle(a, b), middle(b, c), middle(c, a)])
    };
    for ([a, b, c], sides) in [0, 1, 2].map(turned) {
        return match sides {
            [None, None, None] => vec![[a, b, c]],
            [Some(m), None, None] => vec![[a, m, c], [m, b, c]],
            [Some(m), Some(n), None] if away(a, n) <= away(m, c) => {
                vec![[m, b, n], [a, m, n], [a, n, c]]
            }
            [Some(m), Some(n), None] => vec![[m, b, n], [a, m, c], [m, n, c]],
            [Some(m), Some(n), Some(o)] => vec![[a, m, o], [m, b, n], [o, n, c], [m, n, o]],
            _ => continue,
        };
    }
    unreachable!("one of three turns brings the cut sides to the front")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four facets about a corner in the middle of a square of side 2.
    fn fan() -> TriMesh {
        let corners = [(0.1, -0.2), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        TriMesh {
            vertices: corners.map(|(x, y)| DVec3::new(x, y, x * y)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
        }
    }

    fn middle(a: DVec3, b: DVec3) -> DVec3 {
        let q = 0.5 * (a + b);
        DVec3::new(q.x, q.y, q.x * q.y)
    }

    #[test]
    fn no_long_edge_is_left_and_neighbours_stay_neighbours() {
        for longest in [5.0, 1.9, 1.3, 0.7, 0.31, 0.1] {
            let fine = fan().split(longest, 1_000_000, middle).unwrap();
            let mut sides: Vec<[u32; 2]> = Vec::new();
            let mut area = 0.0;
            for (t, &[a, b, c]) in fine.triangles.iter().enumerate() {
                sides.extend([[a, b], [b, c], [c, a]]);
                let up = fine.area_vector(t).z;
                assert!(up > 0.0, "{longest}: facet {t} is turned over");
                area += 0.5 * up;
            }
            assert!((area - 4.0).abs() < 1e-12, "{longest}: {area}");
            for &[a, b] in &sides {
                let [p, q] = [a, b].map(|v| fine.vertices[v as usize]);
                assert!((p - q).length() <= longest);
                assert!(p.z == p.x * p.y || a == 0);
            }
            // A side without its opposite lies on the rim, and is met once.
            sides.sort_unstable();
            let alone = |s: &&[u32; 2]| sides.binary_search(&[s[1], s[0]]).is_err();
            let rim: Vec<_> = sides.iter().filter(alone).collect();
            let round: f64 = rim
                .iter()
                .map(|s| {
                    let [p, q] = s.map(|v| fine.vertices[v as usize].truncate());
                    (p - q).length()
                })
                .sum();
            assert!((round - 8.0).abs() < 1e-12, "{longest}: {round}");
        }
        assert_eq!(fan().split(5.0, 4, middle), Some(fan()));
        assert_eq!(fan().split(0.1, 500, middle), None);
    }

    #[test]
    fn facets_do_not_grow_thinner_without_end() {
        let fine = fan().split(0.02, 1_000_000, middle).unwrap();
        let quality = |t: usize| {
            let [a, b, c] = fine.corners(t);
            let longest = (a - b).length().max((b - c).length()).max((c - a).length());
            fine.area_vector(t).length() / (longest * longest)
        };
        let worst = (0..fine.triangles.len()).map(quality).fold(f64::INFINITY, f64::min);
        let before = 0.8 / 4.4;
        assert!(worst > 0.4 * before, "{worst}");
        assert!(fine.triangles.len() < 90_000, "{}", fine.triangles.len());
    }
}
