//! Boxes around boxes around the patches of all faces, by which a ray passes over those that it cannot meet.

use super::BodyHit;
use super::face::TrimmedFace;
use crate::geom::{DVec3, Ray};

/// Patches of a box that is not cut further.
const FEW: usize = 2;
/// Share of a coordinate by which boxes are enlarged: rounding is far below it.
const MARGIN: f64 = 1e-12;

/// A patch of a face; a plane face is one patch.
#[derive(Debug, Clone, Copy)]
struct Leaf {
    face: u32,
    patch: u32,
    bounds: [DVec3; 2],
}

/// A box with its patches, or the boxes that follow it and `other`.
#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: [DVec3; 2],
    /// The first patch and how many there are; none where there are boxes.
    leaves: [u32; 2],
    other: u32,
}

/// Binary tree of boxes around patches.
#[derive(Debug, Clone)]
pub(super) struct Hierarchy {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

impl Hierarchy {
    pub(super) fn new(faces: &[TrimmedFace]) -> Self {
        let mut leaves = Vec::new();
        for (number, face) in (0..).zip(faces) {
            if face.patches.is_empty() {
                leaves.push(Leaf { face: number, patch: 0, bounds: face.bounds });
            }
            let patches = (0..).zip(&face.patches);
            leaves.extend(patches.map(|(k, p)| Leaf { face: number, patch: k, bounds: p.bounds }));
        }
        let mut nodes = Vec::new();
        let count = leaves.len();
        cut(&mut leaves, [0, count], &mut nodes);
        Self { nodes, leaves }
    }

    /// The nearest place between two distances where a ray meets a face.
    pub(super) fn nearest(
        &self,
        faces: &[TrimmedFace],
        ray: &Ray,
        range: [f64; 2],
    ) -> Option<BodyHit> {
        let [least, mut most] = range;
        let across = ray.direction.any_orthonormal_pair();
        let (across, inverse) = ([across.0, across.1], ray.direction.recip());
        let (mut nearest, mut at) = (None, 0);
        let mut stack = Vec::with_capacity(64);
        loop {
            let node = self.nodes[at as usize];
            if meets(&node.bounds, ray, inverse, [least, most]) {
                let [first, count] = node.leaves;
                if count == 0 {
                    stack.push(node.other);
                    at += 1;
                    continue;
                }
                for leaf in &self.leaves[first as usize..][..count as usize] {
                    if !meets(&leaf.bounds, ray, inverse, [least, most]) {
                        continue;
                    }
                    let face = &faces[leaf.face as usize];
                    let hit = face.meet(ray, across, leaf.patch as usize, least);
                    if let Some((t, normal)) = hit.filter(|(t, _)| *t < most) {
                        most = t;
                        nearest = Some(BodyHit { t, face: leaf.face, normal });
                    }
                }
            }
            match stack.pop() {
                Some(other) => at = other,
                None => return nearest,
            }
        }
    }
}

/// Adds the box around some leaves and what is in it.
fn cut(leaves: &mut [Leaf], [from, to]: [usize; 2], nodes: &mut Vec<Node>) {
    let bounds = super::trim::bounds(leaves[from..to].iter().flat_map(|leaf| leaf.bounds));
    let own = nodes.len();
    nodes.push(Node {
        bounds: enlarged(bounds),
        leaves: [from as u32, (to - from) as u32],
        other: 0,
    });
    if to - from <= FEW {
        return;
    }
    let middle = |leaf: &Leaf| leaf.bounds[0] + leaf.bounds[1];
    let [lo, hi] = super::trim::bounds(leaves[from..to].iter().map(middle));
    let size = hi - lo;
    let axis = if size.x >= size.y.max(size.z) {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    // (Leaves keep the order of the file among equals.)
    leaves[from..to].sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
    let half = from + (to - from) / 2;
    cut(leaves, [from, half], nodes);
    let other = nodes.len() as u32;
    cut(leaves, [half, to], nodes);
    nodes[own] = Node { leaves: [0; 2], other, ..nodes[own] };
}

fn enlarged([lo, hi]: [DVec3; 2]) -> [DVec3; 2] {
    let margin = MARGIN * lo.abs().max(hi.abs()).max_element();
    [lo - DVec3::splat(margin), hi + DVec3::splat(margin)]
}

/// Whether a ray may be in a box between two distances: NaN says that it may.
fn meets(bounds: &[DVec3; 2], ray: &Ray, inverse: DVec3, [least, most]: [f64; 2]) -> bool {
    let [mut first, mut last] = [least, most];
    let margin = MARGIN * ray.origin.abs().max_element();
    for axis in 0..3 {
        let [lo, hi] = [bounds[0][axis] - margin, bounds[1][axis] + margin];
        let from = ray.origin[axis];
        if ray.direction[axis] == 0.0 {
            if from < lo || from > hi {
                return false;
            }
            continue;
        }
        let (a, b) = ((lo - from) * inverse[axis], (hi - from) * inverse[axis]);
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    !(first > last * (1.0 + 1e-12) + margin)
}
