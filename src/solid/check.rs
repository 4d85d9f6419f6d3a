//! Is this mesh a solid, and if not, which facet is to blame?
//!
//! One criterion proves closedness, orientation and manifoldness together: around every vertex the
//! facets, each giving a step from its next corner to its last, form exactly one cycle. Only when
//! that fails are edges sorted to find out why.

use super::{Defect, OpenBoundary, SolidCheck};
use crate::geom::TriMesh;
use crate::parallel;
use std::ops::Range;

/// Defects reported in full; more of them are only counted.
const REPORTED: usize = 8;
/// Vertices or facets handled at a time; fixed, so that sums do not depend on the thread count.
const CHUNK: usize = 16_384;

/// Checks `mesh`: closed, oriented, manifold in edges and vertices, connected, no empty facet;
/// without through holes, unless [`SolidCheck::through`] says otherwise.
#[must_use]
pub fn check(mesh: &TriMesh) -> SolidCheck {
    let ((fans, single), ((mut defects, volume_mm3), components)) = parallel::join(
        || {
            let fans = VertexFans::new(mesh);
            let single = fans.all_single();
            (fans, single)
        },
        || parallel::join(|| (degenerate_facets(mesh), volume(mesh)), || components(mesh)),
    );
    let (mut closed, mut oriented, mut manifold) = (true, true, true);
    if !single {
        for defect in edge_defects(mesh).into_iter().chain(pinches(mesh, &fans)) {
            match defect {
                Defect::OpenEdge { .. } => closed = false,
                Defect::InconsistentEdge { .. } => oriented = false,
                _ => manifold = false,
            }
            defects.push(defect);
        }
    }
    let used = fans.used();
    let edges = if closed && oriented && manifold {
        3 * mesh.triangles.len() / 2
    } else {
        count_edges(mesh)
    };
    let defect_count = defects.len();
    defects.truncate(REPORTED);
    SolidCheck {
        closed,
        oriented,
        manifold,
        open: (!closed).then(|| open_boundary(mesh)),
        components,
        euler: used as i64 - edges as i64 + mesh.triangles.len() as i64,
        holes: 0,
        volume_mm3,
        defects,
        defect_count,
    }
}

/// The directed edges without a partner, in the order of their facets.
#[must_use]
pub fn open_edges(mesh: &TriMesh) -> Vec<(u32, u32)> {
    let fans = VertexFans::new(mesh);
    let open = |&[a, b, c]: &[u32; 3]| {
        let edges = [(a, b), (b, c), (c, a)].into_iter();
        edges.filter(|&(from, to)| !fans.has(to, from)).collect::<Vec<_>>()
    };
    let triangles = &mesh.triangles;
    parallel::gather(triangles.len(), CHUNK, |part| triangles[part].iter().flat_map(open).collect())
}

/// The same at a tenth of the cost, unless numbers of vertices around one on the rim balance each other by
/// chance: then some are missing. Around a vertex within a surface each neighbour is the next corner of one
/// facet and the last of another.
#[must_use]
pub(crate) fn likely_open_edges(mesh: &TriMesh) -> Vec<(u32, u32)> {
    let mut balance = vec![0u32; mesh.vertices.len()];
    for &[a, b, c] in &mesh.triangles {
        for (v, next, last) in [(a, b, c), (b, c, a), (c, a, b)] {
            let sum = &mut balance[v as usize];
            *sum = sum.wrapping_add(next).wrapping_sub(last);
        }
    }
    let at_rim = |v: u32| balance[v as usize] != 0;
    let edges = |&[a, b, c]: &[u32; 3]| {
        [(a, b), (b, c), (c, a)].into_iter().filter(|&(from, to)| at_rim(from) && at_rim(to))
    };
    let edges: Vec<(u32, u32)> = mesh.triangles.iter().flat_map(edges).collect();
    let mut sorted = edges.clone();
    sorted.sort_unstable();
    edges.into_iter().filter(|&(from, to)| sorted.binary_search(&(to, from)).is_err()).collect()
}

fn open_boundary(mesh: &TriMesh) -> OpenBoundary {
    let edges = open_edges(mesh);
    let mut parent: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    let mut loops = 0;
    let mut met = vec![false; parent.len()];
    for &(from, to) in &edges {
        for v in [from, to] {
            loops += usize::from(!std::mem::replace(&mut met[v as usize], true));
        }
        let (a, b) = (root(&mut parent, from), root(&mut parent, to));
        loops -= usize::from(a != b);
        parent[a.max(b) as usize] = a.min(b);
    }
    OpenBoundary { edges: edges.len(), loops }
}

/// For every vertex, the (next, last) corners of the facets around it.
struct VertexFans {
    /// Vertices of each part but the last.
    size: usize,
    parts: Vec<FanPart>,
}

/// The same for the vertices from one on.
struct FanPart {
    start: Vec<u32>,
    steps: Vec<[u32; 2]>,
}

impl FanPart {
    /// Of the vertices of `range`.
    fn new(mesh: &TriMesh, range: Range<usize>) -> Self {
        let (first, count) = (range.start as u32, range.len());
        // (Beyond the range for those before it, too.)
        let number = |v: u32| v.wrapping_sub(first) as usize;
        let mut start = vec![0u32; count + 2];
        for &v in mesh.triangles.as_flattened() {
            if let Some(start) = start[2..].get_mut(number(v)) {
                *start += 1;
            }
        }
        for k in 2..start.len() {
            start[k] += start[k - 1];
        }
        let mut steps = vec![[0; 2]; start[count + 1] as usize];
        for &[a, b, c] in &mesh.triangles {
            for (v, step) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                if number(v) < count {
                    let next = &mut start[number(v) + 1];
                    steps[*next as usize] = step;
                    *next += 1;
                }
            }
        }
        Self { start, steps }
    }

    fn of(&self, v: usize) -> &[[u32; 2]] {
        &self.steps[self.start[v] as usize..self.start[v + 1] as usize]
    }
}

/// Vertices from which on fans are gathered by several threads, each of which looks at all facets.
const SHARED: usize = 1 << 15;
/// Threads at the most among which they are worth sharing out.
const SHARERS: usize = 4;

impl VertexFans {
    fn new(mesh: &TriMesh) -> Self {
        let count = mesh.vertices.len();
        let sharers = if count < SHARED { 1 } else { parallel::threads().min(SHARERS) };
        let size = count.div_ceil(sharers).max(1);
        let part = |k: usize| FanPart::new(mesh, k * size..count.min((k + 1) * size));
        Self { size, parts: parallel::map(count.div_ceil(size), 1, part) }
    }

    fn of(&self, v: usize) -> &[[u32; 2]] {
        self.parts[v / self.size].of(v % self.size)
    }

    fn has(&self, from: u32, to: u32) -> bool {
        self.of(from as usize).iter().any(|step| step[0] == to)
    }

    fn used(&self) -> usize {
        let used = |part: &FanPart| {
            let fans = part.start.windows(2).take(part.start.len() - 2);
            fans.filter(|fan| fan[1] > fan[0]).count()
        };
        self.parts.iter().map(used).sum()
    }

    /// Whether the steps at `v` form one cycle (or there are none).
    fn single(&self, v: usize) -> bool {
        is_cycle(self.of(v))
    }

    fn all_single(&self) -> bool {
        let all = |part: &FanPart| {
            let single = |mut range: Range<usize>| vec![range.all(|v| is_cycle(part.of(v)))];
            parallel::gather(part.start.len() - 2, CHUNK, single).into_iter().all(|single| single)
        };
        self.parts.iter().all(all)
    }
}

/// Whether steps around a vertex form one cycle (or there are none).
fn is_cycle(steps: &[[u32; 2]]) -> bool {
    let Some(&[first, mut at]) = steps.first() else {
        return true;
    };
    for _ in 1..steps.len() {
        if at == first {
            return false;
        }
        let mut onward = steps.iter().filter(|step| step[0] == at);
        match (onward.next(), onward.next()) {
            (Some(step), None) => at = step[1],
            _ => return false,
        }
    }
    at == first
}

fn degenerate_facets(mesh: &TriMesh) -> Vec<Defect> {
    let is_empty = |&t: &usize| {
        let area = mesh.area_vector(t).length_squared();
        !(area > 0.0 && area.is_finite())
    };
    let defect = |facet| Defect::DegenerateFacet { facet, at: mesh.corners(facet)[0] };
    parallel::gather(mesh.triangles.len(), CHUNK, |part| {
        part.filter(is_empty).map(defect).collect()
    })
}

/// Undirected edges with their facets and directions, sorted.
fn sorted_edges(mesh: &TriMesh) -> Vec<([u32; 2], usize, bool)> {
    let mut edges: Vec<_> = mesh
        .triangles
        .iter()
        .enumerate()
        .flat_map(|(facet, &[a, b, c])| {
            [(a, b), (b, c), (c, a)]
                .map(|(from, to)| ([from.min(to), from.max(to)], facet, from < to))
        })
        .collect();
    edges.sort_unstable();
    edges
}

fn count_edges(mesh: &TriMesh) -> usize {
    sorted_edges(mesh).chunk_by(|a, b| a.0 == b.0).count()
}

fn edge_defects(mesh: &TriMesh) -> Vec<Defect> {
    let defect = |group: &[([u32; 2], usize, bool)]| {
        let (ends, facet, _) = group[0];
        let edge = ends.map(|v| mesh.vertices[v as usize]);
        let along = group.iter().filter(|g| g.2).count();
        match group.len() {
            1 => Some(Defect::OpenEdge { facet, edge }),
            2 if along == 1 => None,
            2 => Some(Defect::InconsistentEdge { facet, edge }),
            facets => Some(Defect::NonManifoldEdge { facet, edge, facets }),
        }
    };
    sorted_edges(mesh).chunk_by(|a, b| a.0 == b.0).filter_map(defect).collect()
}

/// Vertices whose edges are all sound but whose facets form several fans.
fn pinches(mesh: &TriMesh, fans: &VertexFans) -> Vec<Defect> {
    let sound = |v: usize| {
        let steps = fans.of(v);
        steps.iter().all(|&[next, last]| {
            let leaving = steps.iter().filter(|s| s[0] == next).count();
            let arriving = steps.iter().filter(|s| s[1] == next).count();
            leaving == 1 && arriving == 1 && steps.iter().any(|s| s[0] == last)
        })
    };
    (0..mesh.vertices.len())
        .filter(|&v| !fans.single(v) && sound(v))
        .map(|v| {
            let here = |t: &[u32; 3]| t.contains(&(v as u32));
            let facet = mesh.triangles.iter().position(here).unwrap_or_default();
            Defect::NonManifoldVertex { facet, at: mesh.vertices[v] }
        })
        .collect()
}

/// The first of the vertices that hang together with `v`.
fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}

/// Pieces that hang together by vertices (unused vertices do not count).
fn components(mesh: &TriMesh) -> usize {
    let mut parent: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    let mut used = vec![false; parent.len()];
    for &[a, b, c] in &mesh.triangles {
        let (ra, rb, rc) = (root(&mut parent, a), root(&mut parent, b), root(&mut parent, c));
        let least = ra.min(rb).min(rc);
        for (v, r) in [(a, ra), (b, rb), (c, rc)] {
            parent[r as usize] = least;
            used[v as usize] = true;
        }
    }
    (0..parent.len()).filter(|&v| used[v] && parent[v] == v as u32).count()
}

/// Enclosed volume by the divergence theorem, summed in fixed chunks.
fn volume(mesh: &TriMesh) -> f64 {
    let six_fold = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
        a.dot(b.cross(c))
    };
    let sums = parallel::map_chunks(&mesh.triangles, CHUNK, |chunk| -> f64 {
        chunk.iter().map(six_fold).sum()
    });
    sums.iter().sum::<f64>() / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{DVec3, PartFeatures, Precision};
    use crate::solid::Solid;

    fn cube() -> TriMesh {
        Solid::from_face(&crate::solid::tests::face(), PartFeatures::NONE, Precision::Double)
            .unwrap()
            .mesh()
            .clone()
    }

    #[test]
    fn many_vertices_are_shared_out_and_the_check_is_the_same() {
        let side = 200u32;
        let vertex = |k: u32| DVec3::new(f64::from(k % side), f64::from(k / side), 2.0);
        let quad = |k: u32| {
            let a = k / (side - 1) * side + k % (side - 1);
            [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
        };
        let face = TriMesh {
            vertices: (0..side * side).map(vertex).collect(),
            triangles: (0..(side - 1) * (side - 1)).flat_map(quad).collect(),
        };
        assert!(face.vertices.len() > SHARED);
        assert_eq!(likely_open_edges(&face), open_edges(&face));
        assert_eq!(open_edges(&face).len(), 4 * (side as usize - 1));
        let mut broken = face.clone();
        broken.triangles.remove(40_000);
        broken.triangles.swap_remove(9);
        assert_eq!(likely_open_edges(&broken), open_edges(&broken));
        for mesh in [face, broken] {
            let [one, three] = [1, 3].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| check(&mesh))
            });
            assert_eq!(one, three);
        }
    }

    #[test]
    fn a_missing_facet_is_found_by_its_edges() {
        let mut mesh = cube();
        mesh.triangles.remove(5);
        let found = check(&mesh);
        assert!(!found.closed && found.oriented && found.manifold);
        assert_eq!(found.defect_count, 3);
        assert!(found.reasons()[0].starts_with("open: only facet"));
        assert_eq!(found.open, Some(OpenBoundary { edges: 3, loops: 1 }));
        // The last facet is one of the base, without a corner in common with the top.
        for (gone, edges, loops) in [([0, 13], 6, 2), ([0, 1], 4, 1)] {
            let mut mesh = cube();
            for t in gone.into_iter().rev() {
                mesh.triangles.remove(t);
            }
            assert_eq!(check(&mesh).open, Some(OpenBoundary { edges, loops }));
        }
        assert_eq!(check(&cube()).open, None);
    }

    #[test]
    fn a_turned_facet_is_found() {
        let mut mesh = cube();
        mesh.triangles[4].swap(0, 1);
        let found = check(&mesh);
        assert!(found.closed && !found.oriented && found.manifold);
        assert!(matches!(found.defects[0], Defect::InconsistentEdge { .. }));
    }

    #[test]
    fn a_fin_is_not_manifold() {
        let mut mesh = cube();
        mesh.vertices.push(DVec3::new(0.0, 0.0, 9.0));
        let fin = mesh.vertices.len() as u32 - 1;
        let [a, b, _] = mesh.triangles[0];
        mesh.triangles.extend([[a, b, fin], [b, a, fin]]);
        let found = check(&mesh);
        assert!(found.closed && !found.manifold);
    }

    #[test]
    fn two_bodies_are_counted_and_a_shared_corner_is_a_pinch() {
        let mut apart = cube();
        let count = apart.vertices.len() as u32;
        let other = cube();
        apart.vertices.extend(other.vertices.iter().map(|&v| v + DVec3::splat(10.0)));
        apart.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + count)));
        let found = check(&apart);
        assert_eq!((found.components, found.euler), (2, 4));
        assert!(found.closed && found.manifold && !found.is_solid());

        // The corner (1, 1, 2) of one is the corner (-1, -1, 0) of the other.
        let mut welder = crate::geom::Welder::new(apart.triangles.len());
        for t in &apart.triangles {
            welder.add(t.map(|v| {
                let p = apart.vertices[v as usize];
                if v < count { p } else { p - DVec3::splat(10.0) + DVec3::new(2.0, 2.0, 2.0) }
            }));
        }
        let found = check(&welder.finish());
        assert!(found.closed && found.oriented && !found.manifold);
        assert!(matches!(found.defects[..], [Defect::NonManifoldVertex { .. }]));
        assert_eq!(found.components, 1);
    }

    #[test]
    fn inside_out_has_negative_volume() {
        let mut mesh = cube();
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let found = check(&mesh);
        assert_eq!(found.volume_mm3, -8.0);
        assert!(found.closed && found.oriented && !found.is_solid());
    }

    #[test]
    fn an_empty_facet_and_a_nan_are_degenerate() {
        let mut mesh = cube();
        mesh.vertices[1] = mesh.vertices[0];
        assert!(check(&mesh).defects.iter().any(|d| matches!(d, Defect::DegenerateFacet { .. })));
        let mut mesh = cube();
        mesh.vertices[1].x = f64::NAN;
        assert!(!check(&mesh).is_solid());
    }

    #[test]
    fn a_torus_is_no_mirror() {
        let (n, m) = (8u32, 6u32);
        let vertex = |i: u32, j: u32| {
            let turn = |k: u32, of: u32| f64::from(k) * 2.0 * std::f64::consts::PI / f64::from(of);
            let (a, b) = (turn(i, n), turn(j, m));
            let far = 3.0 + crate::num::cos(b);
            DVec3::new(far * crate::num::cos(a), far * crate::num::sin(a), crate::num::sin(b))
        };
        let index = |i: u32, j: u32| (i % n) * m + j % m;
        let vertices = (0..n * m).map(|k| vertex(k / m, k % m)).collect();
        let quad = |k: u32| {
            let (i, j) = (k / m, k % m);
            let (a, b, c, d) = (index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
            [[a, b, c], [a, c, d]]
        };
        let found = check(&TriMesh { vertices, triangles: (0..n * m).flat_map(quad).collect() });
        assert!(found.closed && found.oriented && found.manifold && found.volume_mm3 > 0.0);
        assert_eq!(found.euler, 0);
        assert!(found.reasons()[0].contains("handles"));
        assert!(found.clone().through(1).is_solid());
        assert!(found.through(2).reasons()[0].contains("0 instead of -2"));
    }
}
