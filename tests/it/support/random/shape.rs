//! The shape that every face has, whatever its mirror.

use super::Case;
use morion::internals::geom::{DVec2, Outline, Precision, turn};
use morion::internals::mesh::Face;
use std::collections::HashMap;

impl Case {
    /// Whether facets are upright and tile the outline, neighbours share edges, and the rim is one
    /// loop, of a ring two; or what is wrong.
    pub fn hold_shape(&self, face: &Face) -> Result<(), String> {
        let mesh = &face.mesh;
        let mut places: Vec<DVec2> = Vec::new();
        for v in &mesh.vertices {
            places.push(self.mirror.chart.coordinates(*v).0);
        }
        let mut area = 0.0;
        for (t, facet) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = facet.map(|v| places[v as usize]);
            let twice = turn(a, b, c);
            area += 0.5 * twice;
            let rounded = mesh.corners(t).map(|v| v.as_vec3().as_dvec3().truncate());
            let single = self.limits.precision == Precision::Single;
            if !(twice > 0.0) || (single && !(turn(rounded[0], rounded[1], rounded[2]) > 0.0)) {
                return Err(format!("facet {t} is empty or inverted: {a} {b} {c}"));
            }
        }
        let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
        for &[a, b, c] in &mesh.triangles {
            for edge in [[a, b], [b, c], [c, a]] {
                let count = edges.entry(edge).or_default();
                *count += 1;
                if *count > 1 {
                    return Err(format!("two facets run along {edge:?} the same way"));
                }
            }
        }
        let mut next: HashMap<u32, u32> = HashMap::new();
        for &[a, b] in edges.keys() {
            if !edges.contains_key(&[b, a]) && next.insert(a, b).is_some() {
                return Err(format!("two rims meet at vertex {a}"));
            }
        }
        let mut loops = 0;
        while let Some(&start) = next.keys().next() {
            loops += 1;
            let mut at = start;
            while let Some(to) = next.remove(&at) {
                at = to;
            }
            if at != start {
                return Err(format!("the rim from vertex {start} ends at {at}"));
            }
        }
        let outline = self.mirror.full_outline();
        let wanted =
            if matches!(outline, Outline::Ring { inner, .. } if inner > 0.0) { 2 } else { 1 };
        let share = area / outline.area() - 1.0;
        let slack = match outline {
            Outline::Rect(_) => 1e-6,
            Outline::Ring { inner, outer } => 3.0 * Outline::EDGE * outer / (outer - inner),
        };
        if loops != wanted {
            return Err(format!("{loops} rims"));
        }
        if share.abs() > slack {
            return Err(format!("facets cover {share:e} more than the outline"));
        }
        Ok(())
    }
}
