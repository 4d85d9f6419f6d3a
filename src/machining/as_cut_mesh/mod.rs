//! A lattice over the face along the lines of a raster, as a mesh of the as-cut surface.
//!
//! Rows run along the raster's lines, several to a stepover, one of them along the cusps; further rows
//! go through the corners of the outline and wherever its sides bend. Between two rows the face is a
//! set of strips, whose sides are taken for straight, and each strip is triangulated from side to side.
//! Then the rows are snapped onto the cusps, but for their ends and those that the outline needs.

mod outlines;
mod strips;

pub use outlines::{bounding_corners, plan_outlines, rim_distances};

use super::cusps::{Cusps, straighten};
use super::{BallRaster, MachiningError, Passes};
use crate::geom::{DVec2, TriMesh};
use crate::parallel;
use outlines::Polygon;
use strips::LatticeRows;

/// Rows to a stepover.
pub const ROWS: usize = 8;

/// A lattice along the lines of a raster, of [`ROWS`] rows to a stepover.
#[derive(Debug, Clone, Copy)]
pub struct FaceLattice {
    /// The raster.
    pub raster: BallRaster,
    /// Step along its lines, mm.
    pub along_mm: f64,
    /// Place of a row across its lines, mm: where cusps are, facets follow them.
    pub row_mm: f64,
}

/// How many facets a lattice of this step along the lines would have, about.
#[must_use]
pub fn facet_estimate(outlines: &[Vec<Polygon>], raster: &BallRaster, along_mm: f64) -> f64 {
    let area = |side: &Polygon| {
        let next = side.iter().cycle().skip(1);
        side.iter().zip(next).map(|(a, b)| 0.5 * a.perp_dot(*b)).sum::<f64>()
    };
    let face: f64 = outlines.iter().flatten().map(area).sum();
    2.0 * face / (along_mm * raster.stepover_mm / ROWS as f64)
}

/// The as-cut face of `passes`: facets counter-clockwise from above.
///
/// # Errors
/// [`MachiningError::Uncut`] where no pass comes.
pub fn as_cut_face(
    outlines: &[Vec<Polygon>],
    passes: &Passes,
    along_mm: f64,
) -> Result<TriMesh, MachiningError> {
    let height = |at| passes.height(at);
    // Cusps are half-way between passes, one of which is half a stepover off the axis.
    let lattice = FaceLattice { raster: passes.raster(), along_mm, row_mm: 0.0 };
    face_of_cut(outlines, lattice, &height, |corners| {
        let cusps = Cusps::new(passes, corners, along_mm);
        move |x, y| cusps.snap(x, y)
    })
}

/// The as-cut face of any surface of which `height` is Z, mm, on a lattice: facets counter-clockwise from above. What
/// `snapping` makes of the corners of the face, x along the lines and y across them, tells where y of a place of the lattice
/// goes.
///
/// # Errors
/// [`MachiningError::Uncut`] where there is no height.
pub fn face_of_cut<S: Fn(f64, f64) -> f64 + Sync>(
    outlines: &[Vec<Polygon>],
    FaceLattice { raster, along_mm, row_mm }: FaceLattice,
    height: &(dyn Fn(DVec2) -> Option<f64> + Sync),
    snapping: impl FnOnce([DVec2; 2]) -> S,
) -> Result<TriMesh, MachiningError> {
    let (along, across) = (raster.along(), raster.along().perp());
    let turned = |p: &DVec2| DVec2::new(p.dot(along), p.dot(across));
    let mut panels: Vec<Vec<Polygon>> = outlines
        .iter()
        .map(|loops| loops.iter().map(|side| side.iter().map(turned).collect()).collect())
        .collect();
    let rows = LatticeRows::new(&mut panels, raster.stepover_mm / ROWS as f64, row_mm);
    let places: Vec<Vec<f64>> = (0..rows.y.len()).map(|k| rows.places(k, along_mm)).collect();
    let triangles = triangles(&rows, &places);
    let snap = snapping(bounding_corners(&panels));
    let levels = rows.y.iter().zip(&places);
    let straight: Vec<f64> = levels.flat_map(|(&y, line)| vec![y; line.len()]).collect();
    let snapped = parallel::map(rows.y.len(), 1, |k| snapped(&rows, k, &places[k], &snap));
    let mut y = snapped.concat();
    let x = places.concat();
    straighten(&x, &straight, &mut y, &triangles);
    let place = |k: usize| along * x[k] + across * y[k] + DVec2::ZERO;
    let heights = parallel::map(x.len(), 1, |k| height(place(k)));
    let vertex = |(k, height): (usize, Option<f64>)| {
        let at = place(k);
        height.map(|z| at.extend(z)).ok_or(MachiningError::Uncut { at })
    };
    let vertices = heights.into_iter().enumerate().map(vertex).collect::<Result<_, _>>()?;
    Ok(TriMesh { vertices, triangles })
}

/// The facets of all strips, over vertices numbered row by row.
fn triangles(rows: &LatticeRows, places: &[Vec<f64>]) -> Vec<[u32; 3]> {
    let mut first = vec![0u32];
    for line in places {
        first.push(first[first.len() - 1] + line.len() as u32);
    }
    let mut triangles = Vec::new();
    for (k, strips) in rows.strips.iter().enumerate() {
        for [left, right] in strips {
            let part = |row: usize, from: f64, to: f64| {
                let all = &places[row];
                let begin = all.partition_point(|&x| x < from);
                let end = all.partition_point(|&x| x <= to);
                (first[row] + begin as u32, &all[begin..end])
            };
            let (low, high) = (part(k, left[0], right[0]), part(k + 1, left[1], right[1]));
            zip(&mut triangles, low, high);
        }
    }
    triangles
}

/// y of the places of row `k`, snapped onto the cusps but where sides of strips meet it.
fn snapped(
    rows: &LatticeRows,
    k: usize,
    places: &[f64],
    snap: &(impl Fn(f64, f64) -> f64 + Sync),
) -> Vec<f64> {
    let (y, fixed) = (rows.y[k], rows.fixed(k));
    let stays = |x: f64| !rows.free[k] || fixed.binary_search_by(|at| at.total_cmp(&x)).is_ok();
    places.iter().map(|&x| if stays(x) { y } else { snap(x, y) }).collect()
}

/// Triangulates a strip between two lines of vertices, each the number of its first and their x, by
/// steps on the line that is behind.
fn zip(triangles: &mut Vec<[u32; 3]>, low: (u32, &[f64]), high: (u32, &[f64])) {
    let (mut a, mut b) = (0, 0);
    loop {
        let [p, q] = [low.0 + a as u32, high.0 + b as u32];
        let step_low = match (low.1.get(a + 1), high.1.get(b + 1)) {
            (None, None) => break,
            (Some(below), Some(above)) => below <= above,
            (below, _) => below.is_some(),
        };
        if step_low {
            triangles.push([p, p + 1, q]);
            a += 1;
        } else {
            triangles.push([p, q + 1, q]);
            b += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Outline, turn};
    use crate::mirror::Mirror;
    use crate::mirror::fixtures::quadric;
    use crate::num::radians;

    /// The area of a mesh in the plan, which must be a face whose edges meet one or two facets, and how many
    /// edges it has on its rim.
    fn plan(mesh: &TriMesh) -> (f64, usize) {
        let mut edges = std::collections::BTreeMap::new();
        let mut area = 0.0;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.vertices[v as usize].truncate());
            assert!(turn(a, b, c) > 0.0);
            area += 0.5 * turn(a, b, c);
            for k in 0..3 {
                let (from, to) = (t[k], t[(k + 1) % 3]);
                *edges.entry((from.min(to), from.max(to))).or_insert(0) +=
                    if from < to { 1 } else { -1 };
            }
        }
        (area, edges.values().filter(|&&n| n != 0).count())
    }

    fn meshed(mirror: &Mirror, raster: BallRaster) -> TriMesh {
        let outlines = plan_outlines(mirror);
        let passes = Passes::new(mirror, bounding_corners(&outlines), raster).unwrap();
        as_cut_face(&outlines, &passes, 0.9).unwrap()
    }

    #[test]
    fn squares_discs_and_rings_are_covered_once_at_any_angle() {
        for outline in [
            None,
            Some(Outline::Ring { inner: 0.0, outer: 4.0 }),
            Some(Outline::Ring { inner: 1.5, outer: 4.0 }),
        ] {
            for degrees in [0.0, 90.0, 45.0, 17.0, 1e-5] {
                let mut mirror = quadric([-0.02, 0.0, -0.01], 0.0);
                mirror.outline = outline.unwrap_or(mirror.outline);
                let raster = BallRaster { ball_mm: 3.0, stepover_mm: 0.8, angle: radians(degrees) };
                let mesh = meshed(&mirror, raster);
                let (area, rim) = plan(&mesh);
                let exact = mirror.outline.area();
                assert!((area / exact - 1.0).abs() < 1e-4, "{outline:?} {degrees}: {area} {exact}");
                assert!(rim > 60);
                let open = crate::solid::rim(&mesh.into()).unwrap();
                assert_eq!(open.edges + open.hole_edges, rim, "{outline:?} {degrees}");
            }
        }
    }

    #[test]
    fn panels_meet_in_the_ridge_and_curved_sides_are_followed() {
        for (vergence, folded) in [(0.03, false), (0.0, true), (0.03, true)] {
            for degrees in [0.0, 90.0, 25.0] {
                let mut mirror = quadric([-0.06, 0.0, -0.02], vergence);
                mirror.folded = folded;
                if let (true, Outline::Rect(rect)) = (folded, &mut mirror.outline) {
                    rect.min.y = 0.0;
                }
                let raster = BallRaster { ball_mm: 3.0, stepover_mm: 0.8, angle: radians(degrees) };
                let mesh = meshed(&mirror, raster);
                let (area, rim) = plan(&mesh);
                let exact = mirror.footprint(0.0);
                assert!((area / exact - 1.0).abs() < 1e-4, "{vergence} {degrees}: {area} {exact}");
                let open = crate::solid::rim(&mesh.clone().into()).unwrap();
                assert_eq!((open.edges, open.hole_edges), (rim, 0), "{vergence} {degrees}");
                if folded {
                    let ridge = mesh.vertices.iter().filter(|v| v.y.abs() < 1e-12).count();
                    assert!(ridge > 8, "{ridge}");
                }
            }
        }
    }
}
