//! Vertices moved and edges flipped by all threads together, with the same outcome for any number of them.

use super::triangulation::EditableTriangulation;
use super::vertex_model::VertexModel;
use crate::parallel;

/// Vertices or edges that a thread takes at a time, at least: some microseconds of work.
const CHUNK: usize = 32;

/// Picks sets of vertices of which none are neighbours, so that each can be moved without the others.
#[derive(Default)]
pub(crate) struct IndependentSets {
    /// For each vertex the last pass in which it or a neighbour was picked.
    last_pass: Vec<u32>,
    passes: u32,
}

impl IndependentSets {
    /// Moves all `vertices` for which `better` knows a position, and reports them to `moved`.
    pub(crate) fn move_all<C: VertexModel>(
        &mut self,
        net: &mut EditableTriangulation<C>,
        mut vertices: Vec<u32>,
        better: impl Fn(&EditableTriangulation<C>, u32) -> Option<C> + Sync,
        mut moved: impl FnMut(&EditableTriangulation<C>, u32),
    ) {
        while !vertices.is_empty() {
            let set = self.take_set(net, &mut vertices);
            let position = |&v: &u32| better(net, v);
            let positions = parallel::map_slice(&set, CHUNK, position);
            for (v, position) in set.into_iter().zip(positions) {
                if let Some(position) = position {
                    net.vertices[v as usize] = position;
                    moved(net, v);
                }
            }
        }
    }

    /// Takes an independent set out of `vertices`.
    fn take_set<C: VertexModel>(
        &mut self,
        net: &EditableTriangulation<C>,
        vertices: &mut Vec<u32>,
    ) -> Vec<u32> {
        self.last_pass.resize(net.vertices.len(), 0);
        self.passes += 1;
        let mut set = Vec::with_capacity(vertices.len() / 2);
        vertices.retain(|&v| {
            if self.last_pass[v as usize] == self.passes {
                return true;
            }
            for t in net.around(v) {
                for w in net.triangles[t as usize] {
                    self.last_pass[w as usize] = self.passes;
                }
            }
            set.push(v);
            false
        });
        set
    }
}

/// Flips those of the edges that gain by it, and then edges around them that do; reports the triangles that changed.
pub(crate) fn flip_all<C: VertexModel>(
    net: &mut EditableTriangulation<C>,
    edges: Vec<[u32; 2]>,
    changed: impl FnMut(u32),
) {
    let gains = |edge: &[u32; 2]| net.gains_by_flipping(*edge);
    let edges = parallel::gather(edges.len(), CHUNK, |part| {
        edges[part].iter().copied().filter(gains).collect()
    });
    net.flip_from(edges, changed);
}
