//! Corners moved and edges flipped by all threads together, with the same outcome for any number of
//! them.

use super::triangulation::EditableTriangulation;
use super::vertex_model::VertexModel;
use crate::parallel;

/// Corners or edges a thread looks at at a time, at least.
const CHUNK: usize = 32;

/// Picks corners that are no neighbours, so that each can be moved without the others.
#[derive(Default)]
pub struct IndependentSets {
    /// The last pass in which a neighbour of the corner was picked.
    near: Vec<u32>,
    passes: u32,
}

impl IndependentSets {
    /// Moves all `corners` for which `better` knows a place, and reports them.
    pub fn move_all<C: VertexModel>(
        &mut self,
        net: &mut EditableTriangulation<C>,
        mut corners: Vec<u32>,
        better: impl Fn(&EditableTriangulation<C>, u32) -> Option<C> + Sync,
        mut moved: impl FnMut(&EditableTriangulation<C>, u32),
    ) {
        while !corners.is_empty() {
            let apart = self.split(net, &mut corners);
            let place = |&v: &u32| better(net, v);
            let places = parallel::map_slice(&apart, CHUNK, place);
            for (v, place) in apart.into_iter().zip(places) {
                if let Some(place) = place {
                    net.points[v as usize] = place;
                    moved(net, v);
                }
            }
        }
    }

    /// Takes such corners out of `corners`.
    fn split<C: VertexModel>(
        &mut self,
        net: &EditableTriangulation<C>,
        corners: &mut Vec<u32>,
    ) -> Vec<u32> {
        self.near.resize(net.points.len(), 0);
        self.passes += 1;
        let mut apart = Vec::with_capacity(corners.len() / 2);
        corners.retain(|&v| {
            if self.near[v as usize] == self.passes {
                return true;
            }
            for t in net.around(v) {
                for w in net.triangles[t as usize] {
                    self.near[w as usize] = self.passes;
                }
            }
            apart.push(v);
            false
        });
        apart
    }
}

/// Flips those of the edges that gain, and what is then to flip around them; the triangles that
/// changed are reported.
pub fn flip_all<C: VertexModel>(
    net: &mut EditableTriangulation<C>,
    edges: Vec<[u32; 2]>,
    changed: impl FnMut(u32),
) {
    let gains = |edge: &[u32; 2]| net.gains_by_flipping(*edge);
    let edges = parallel::gather(edges.len(), CHUNK, |part| {
        edges[part].iter().copied().filter(gains).collect()
    });
    net.flip_all(edges, changed);
}
