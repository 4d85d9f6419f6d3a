//! A coarse mesh of a mirror for drawings of the part: even, and within no limit.

use crate::geom::{DVec2, FaceMesh, Outline, Rect, TriMesh};
use crate::mirror::Mirror;
use crate::num::{cos, sin};
use std::f64::consts::TAU;

/// Cells along the longer side of a rectangle of panels.
const CELLS: f64 = 96.0;
/// Cells around a disc or ring, and from its middle to its rim.
const AROUND: u32 = 144;
const OUTWARDS: u32 = 48;

/// The face of all panels in some 14 000 facets, part frame, mm; none where walls between panels cross.
#[must_use]
pub fn coarse_mesh(mirror: &Mirror) -> Option<FaceMesh> {
    if !mirror.has_steps() {
        return Some(smooth_mesh(mirror, mirror.full_outline().bounds().size()).into());
    }
    let whole = mirror.outline.bounds().size();
    let panels = mirror.panels().into_iter().map(|panel| smooth_mesh(&panel, whole));
    mirror.with_walls(TriMesh::side_by_side(panels)).ok()
}

/// The same of a mirror without steps, by the size of the whole.
fn smooth_mesh(mirror: &Mirror, whole: DVec2) -> TriMesh {
    let (places, triangles) = match mirror.outline {
        Outline::Rect(panel) => rectangle(panel, whole),
        Outline::Ring { inner, outer } => ring(inner, outer),
    };
    let points = mirror.eval_many(&places);
    let vertices = places.iter().zip(&points).map(|(q, point)| mirror.position(*q, point));
    let mesh = TriMesh { vertices: vertices.collect(), triangles };
    if mirror.folded { mesh.with_reflection(1) } else { mesh }
}

/// Places on a panel of a rectangle of this size, and its triangles.
fn rectangle(panel: Rect, whole: DVec2) -> (Vec<DVec2>, Vec<[u32; 3]>) {
    let cell = whole.max_element() / CELLS;
    let counts = panel.size().to_array().map(|side| (side / cell).ceil().max(1.0) as u32);
    let [columns, rows] = counts;
    // Ends are met to the last bit.
    let share = |low: f64, high: f64, k: u32, count: u32| match k {
        0 => low,
        k if k == count => high,
        k => low + (high - low) * f64::from(k) / f64::from(count),
    };
    let x = |k: u32| share(panel.min.x, panel.max.x, k, columns);
    let y = |k: u32| share(panel.min.y, panel.max.y, k, rows);
    let places = (0..=rows)
        .flat_map(|row| (0..=columns).map(move |k| (k, row)))
        .map(|(k, row)| DVec2::new(x(k), y(row)));
    let corner = |k: u32, row: u32| row * (columns + 1) + k;
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |k| (k, row)));
    let quads = cells.map(|(k, row)| {
        [corner(k, row), corner(k + 1, row), corner(k + 1, row + 1), corner(k, row + 1)]
    });
    (places.collect(), quads.flat_map(halves).collect())
}

/// Places on a disc or ring, and its triangles.
fn ring(inner: f64, outer: f64) -> (Vec<DVec2>, Vec<[u32; 3]>) {
    let directions: Vec<DVec2> = (0..AROUND)
        .map(|k| TAU * f64::from(k) / f64::from(AROUND))
        .map(|angle| DVec2::new(cos(angle), sin(angle)))
        .collect();
    // A disc begins with its middle and the first circle around it.
    let first = u32::from(inner == 0.0);
    let radius = |k: u32| inner + (outer - inner) * f64::from(k) / f64::from(OUTWARDS);
    let mut places: Vec<DVec2> = (0..first).map(|_| DVec2::ZERO).collect();
    for k in first..=OUTWARDS {
        places.extend(directions.iter().map(|direction| *direction * radius(k)));
    }
    let corner = |k: u32, around: u32| first + (k - first) * AROUND + around % AROUND;
    let fan = (0..AROUND * first).map(|around| [0, corner(1, around), corner(1, around + 1)]);
    let cells = (first..OUTWARDS).flat_map(|k| (0..AROUND).map(move |around| (k, around)));
    let quads = cells.map(|(k, around)| {
        [corner(k, around), corner(k + 1, around), corner(k + 1, around + 1), corner(k, around + 1)]
    });
    let triangles = fan.chain(quads.flat_map(halves)).collect();
    (places, triangles)
}

/// Two triangles of four corners, counter-clockwise.
fn halves([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Precision;
    use crate::profile::{Profile, shipped};
    use crate::solid::Solid;

    #[test]
    fn shipped_mirrors_close_and_have_nearly_their_volume() {
        for shipped in shipped() {
            let profile = Profile::parse(shipped.name, "", shipped.text.as_bytes()).unwrap();
            let design = crate::design::design_unmeasured(&profile).unwrap();
            let mesh = coarse_mesh(&design.mirror).unwrap();
            assert!((3_000..20_000).contains(&mesh.triangles.len()), "{}", shipped.name);
            let solid = Solid::from_face(&mesh, design.features(), Precision::Single).unwrap();
            let (found, expected) = (solid.check().volume_mm3, design.volume());
            assert!((found / expected - 1.0).abs() < 5e-3, "{}: {found} {expected}", shipped.name);
        }
    }
}
