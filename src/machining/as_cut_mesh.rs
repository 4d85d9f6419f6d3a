//! A lattice over the face along the lines of a raster, as a mesh of the as-cut surface.
//!
//! Rows run along the raster's lines, several to a stepover, one of them along the cusps; further rows
//! go through the corners of the outline and wherever its sides bend. Between two rows the face is a
//! set of strips, whose sides are taken for straight, and each strip is triangulated from side to side.
//! Then the rows are bent onto the cusps, but for their ends and those that the outline needs.

use super::cusps::{Cusps, straighten};
use super::{BallRaster, MachiningError, Passes};
use crate::geom::{DVec2, Outline, TriMesh, turn};
use crate::mirror::Mirror;
use crate::num::{cos, sin};
use crate::parallel;
use std::f64::consts::TAU;

/// Rows to a stepover.
pub const ROWS: usize = 8;
/// Corners of a round rim.
const CORNERS: usize = 1440;
/// Corners of a side that is not straight in the plan.
const SIDE: usize = 256;
/// How far the side of a strip may be from the outline, as a share of the face's size.
const STRAIGHT: f64 = 2e-5;

/// A polygon in the raster's coordinates: x along its lines, y across them.
type Loop = Vec<DVec2>;

/// The outlines of the panels of `mirror` in X and Y, counter-clockwise, each with its hole if it has one.
#[must_use]
pub fn plan_outlines(mirror: &Mirror) -> Vec<Vec<Loop>> {
    let place = |q: DVec2| mirror.extended_surface(q).at.truncate();
    let panel: Vec<Loop> = match mirror.outline {
        Outline::Rect(rect) => {
            let corners = [
                rect.min,
                DVec2::new(rect.max.x, rect.min.y),
                rect.max,
                DVec2::new(rect.min.x, rect.max.y),
            ];
            let parts = if mirror.chart.vergence == 0.0 { 1 } else { SIDE };
            let side = |k: usize| {
                let (from, to) = (corners[k], corners[(k + 1) % 4]);
                (0..parts).map(move |part| from.lerp(to, part as f64 / parts as f64))
            };
            vec![(0..4).flat_map(side).map(place).collect()]
        }
        Outline::Ring { inner, outer } => {
            let circle = |radius: f64, sense: f64| -> Loop {
                let angle = |k: usize| sense * TAU * k as f64 / CORNERS as f64;
                let at = |k: usize| DVec2::new(cos(angle(k)), sin(angle(k))) * radius;
                (0..CORNERS).map(at).map(place).collect()
            };
            let hole = (inner > 0.0).then(|| circle(inner, -1.0));
            std::iter::once(circle(outer, 1.0)).chain(hole).collect()
        }
    };
    if !mirror.folded {
        return vec![panel];
    }
    let image = |side: &Loop| side.iter().rev().map(|p| DVec2::new(p.x, 0.0 - p.y)).collect();
    let images = panel.iter().map(image).collect();
    vec![panel, images]
}

/// The smallest rectangle around outlines: its lower left and upper right corner.
#[must_use]
pub fn bounding_corners(outlines: &[Vec<Loop>]) -> [DVec2; 2] {
    let all = outlines.iter().flatten().flatten();
    let (lo, hi) = all.fold((DVec2::MAX, DVec2::MIN), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    [lo, hi]
}

/// One side of a strip: where it meets the row below and the row above.
type Side = [f64; 2];

/// Rows and the strips between them.
struct Rows {
    /// y of each row.
    y: Vec<f64>,
    /// Whether the outline leaves the row free to bend.
    free: Vec<bool>,
    /// Strips over each row but the last: left and right side.
    strips: Vec<Vec<[Side; 2]>>,
}

/// How many facets a lattice of this step along the lines would have, about.
#[must_use]
pub fn facet_estimate(outlines: &[Vec<Loop>], raster: &BallRaster, along_mm: f64) -> f64 {
    let area = |side: &Loop| {
        let next = side.iter().cycle().skip(1);
        side.iter().zip(next).map(|(a, b)| 0.5 * a.perp_dot(*b)).sum::<f64>()
    };
    let face: f64 = outlines.iter().flatten().map(area).sum();
    2.0 * face / (along_mm * raster.stepover_mm / ROWS as f64)
}

/// The as-cut face: facets counter-clockwise from above.
///
/// # Errors
/// [`MachiningError::Uncut`] where no pass comes.
pub fn as_cut_face(
    outlines: &[Vec<Loop>],
    passes: &Passes,
    along_mm: f64,
) -> Result<TriMesh, MachiningError> {
    let raster = passes.raster();
    let (along, across) = (raster.along(), raster.along().perp());
    let turned = |p: &DVec2| DVec2::new(p.dot(along), p.dot(across));
    let mut panels: Vec<Vec<Loop>> = outlines
        .iter()
        .map(|loops| loops.iter().map(|side| side.iter().map(turned).collect()).collect())
        .collect();
    let rows = rows(&mut panels, raster.stepover_mm / ROWS as f64);
    let places: Vec<Vec<f64>> = (0..rows.y.len()).map(|k| places(&rows, k, along_mm)).collect();
    let triangles = triangles(&rows, &places);
    let cusps = Cusps::new(passes, bounding_corners(&panels), along_mm);
    let levels = rows.y.iter().zip(&places);
    let straight: Vec<f64> = levels.flat_map(|(&y, line)| vec![y; line.len()]).collect();
    let mut y: Vec<f64> =
        (0..rows.y.len()).flat_map(|k| bent(&rows, k, &places[k], &cusps)).collect();
    let x = places.concat();
    straighten(&x, &straight, &mut y, &triangles);
    let place = |k: usize| along * x[k] + across * y[k] + DVec2::ZERO;
    let heights = parallel::map(x.len(), 1, |k| passes.height(place(k)));
    let vertex = |(k, height): (usize, Option<f64>)| {
        let at = place(k);
        height.map(|z| at.extend(z)).ok_or(MachiningError::Uncut { at })
    };
    let vertices = heights.into_iter().enumerate().map(vertex).collect::<Result<_, _>>()?;
    Ok(TriMesh { vertices, triangles })
}

/// The facets of all strips, over vertices numbered row by row.
fn triangles(rows: &Rows, places: &[Vec<f64>]) -> Vec<[u32; 3]> {
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

/// y of the places of row `k`, bent onto the cusps but where sides of strips meet it.
fn bent(rows: &Rows, k: usize, places: &[f64], cusps: &Cusps) -> Vec<f64> {
    let (y, fixed) = (rows.y[k], fixed(rows, k));
    let stays = |x: f64| !rows.free[k] || fixed.binary_search_by(|at| at.total_cmp(&x)).is_ok();
    places.iter().map(|&x| if stays(x) { y } else { cusps.bent(x, y) }).collect()
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

/// Where the rows of `panels` lie, `pitch` apart or closer, and the strips between them. Corners a hair off a
/// row are put on it.
fn rows(panels: &mut [Vec<Loop>], pitch: f64) -> Rows {
    let hair = 0.02 * pitch;
    let points = || panels.iter().flatten().flatten();
    let [lo, hi] = points().fold([f64::MAX, f64::MIN], |[lo, hi], p| [lo.min(p.y), hi.max(p.y)]);
    let size = points().fold(0.0f64, |most, p| most.max(p.abs().max_element()));
    let mut y = bends(panels, size, hair);
    let first = (lo / pitch).ceil() as i64;
    let last = (hi / pitch).floor() as i64;
    for corner in panels.iter_mut().flatten().flatten() {
        if let Some(row) = y.iter().find(|row| (*row - corner.y).abs() <= hair) {
            corner.y = *row;
        }
    }
    // Even rows give way to those that the outline needs.
    let fixed = y.clone();
    let clear = |at: &f64| fixed.iter().all(|row| (row - at).abs() > 0.05 * pitch);
    y.extend((first..=last).map(|k| k as f64 * pitch).filter(clear));
    y.sort_by(f64::total_cmp);
    let strips = y.windows(2).map(|pair| strips(panels, [pair[0], pair[1]])).collect();
    let free = y.iter().map(|at| !fixed.contains(at)).collect();
    Rows { y, free, strips }
}

/// The rows that the outline needs: through its corners and turns, and so near each other that its
/// sides are straight between them.
fn bends(panels: &[Vec<Loop>], size: f64, hair: f64) -> Vec<f64> {
    let mut y: Vec<f64> = Vec::new();
    let mut add = |at: f64| {
        if y.iter().all(|row| (row - at).abs() > hair) {
            y.push(at);
        }
    };
    for side in panels.iter().flatten() {
        let count = side.len();
        let corner = |k: usize| side[k % count];
        // Corners where the outline turns back in y, or turns sharply.
        let sharp = |k: usize| {
            let (into, out) = (corner(k) - corner(k + count - 1), corner(k + 1) - corner(k));
            into.y * out.y <= 0.0 || into.perp_dot(out).abs() > 0.1 * into.length() * out.length()
        };
        let turns: Vec<usize> = (0..count).filter(|&k| sharp(k)).collect();
        for (n, &from) in turns.iter().enumerate() {
            add(corner(from).y);
            let to = if n + 1 < turns.len() { turns[n + 1] } else { turns[0] + count };
            split(&corner, from, to, STRAIGHT * size, &mut add);
        }
    }
    y
}

/// Adds rows between two corners until the outline is nowhere farther than `off` from the chord.
fn split(
    corner: &impl Fn(usize) -> DVec2,
    from: usize,
    to: usize,
    off: f64,
    add: &mut impl FnMut(f64),
) {
    let (a, b) = (corner(from), corner(to));
    let away = |k: usize| turn(a, b, corner(k)).abs() / (b - a).length();
    let farthest = (from + 1..to).max_by(|&i, &j| away(i).total_cmp(&away(j)));
    if let Some(k) = farthest.filter(|&k| away(k) > off) {
        add(corner(k).y);
        split(corner, from, k, off, add);
        split(corner, k, to, off, add);
    }
}

/// The strips between two rows: pairs of sides of each panel, from left to right.
fn strips(panels: &[Vec<Loop>], [low, high]: [f64; 2]) -> Vec<[Side; 2]> {
    let middle = 0.5 * (low + high);
    let mut all = Vec::new();
    for loops in panels {
        let mut sides: Vec<(f64, Side)> = Vec::new();
        for side in loops {
            let count = side.len();
            for k in 0..count {
                let (a, b) = (side[k], side[(k + 1) % count]);
                if (a.y > middle) == (b.y > middle) {
                    continue;
                }
                // Along the outline to where it meets the rows.
                let rising = b.y > a.y;
                let meet = |row: f64| {
                    let up = (row > middle) == rising;
                    let step = if up { 1 } else { count - 1 };
                    let edges = (0..count).map(|n| (k + n * step) % count);
                    let edges = edges.map(|k| {
                        if up {
                            (side[k], side[(k + 1) % count])
                        } else {
                            (side[(k + 1) % count], side[k])
                        }
                    });
                    let reached = |to: DVec2| if row > middle { to.y >= row } else { to.y <= row };
                    let edge = edges.into_iter().find(|&(_, to)| reached(to));
                    edge.map_or(f64::NAN, |(from, to)| at_row(from, to, row))
                };
                let side = [meet(low), meet(high)];
                sides.push((0.5 * (side[0] + side[1]), side));
            }
        }
        sides.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.extend(sides.chunks_exact(2).map(|pair| [pair[0].1, pair[1].1]));
    }
    all.sort_by(|a, b| (a[0][0] + a[0][1]).total_cmp(&(b[0][0] + b[0][1])));
    all
}

/// x of an edge on a row that it meets, the same bits whichever end comes first.
fn at_row(a: DVec2, b: DVec2, row: f64) -> f64 {
    let [lo, hi] = if a.y < b.y { [a, b] } else { [b, a] };
    if row <= lo.y {
        return lo.x;
    }
    if row >= hi.y {
        return hi.x;
    }
    lo.x + (hi.x - lo.x) * ((row - lo.y) / (hi.y - lo.y))
}

/// Where the sides of strips meet a row.
fn fixed(rows: &Rows, k: usize) -> Vec<f64> {
    let above = rows.strips.get(k).into_iter().flatten().flatten().map(|side| side[0]);
    let below = k.checked_sub(1).map(|k| &rows.strips[k]);
    let below = below.into_iter().flatten().flatten().map(|side| side[1]);
    let mut fixed: Vec<f64> = above.chain(below).collect();
    fixed.sort_by(f64::total_cmp);
    fixed.dedup();
    fixed
}

/// The places of one row: where sides of strips meet it, and between them `along_mm` apart.
fn places(rows: &Rows, k: usize, along_mm: f64) -> Vec<f64> {
    let fixed = fixed(rows, k);
    let mut all = Vec::new();
    for pair in fixed.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        all.push(from);
        let covers = |[left, right]: &[Side; 2], end: usize| left[end] <= from && to <= right[end];
        let above = rows.strips.get(k).is_some_and(|strips| strips.iter().any(|s| covers(s, 0)));
        let below = k > 0 && rows.strips[k - 1].iter().any(|s| covers(s, 1));
        if above || below {
            let margin = 0.25 * along_mm;
            let (first, last) =
                (((from + margin) / along_mm).ceil(), ((to - margin) / along_mm).floor());
            all.extend((first as i64..=last as i64).map(|n| n as f64 * along_mm));
        }
    }
    all.extend(fixed.last());
    all
}

#[cfg(test)]
mod tests {
    use super::*;
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
                let open = crate::solid::rim(&mesh).unwrap();
                assert_eq!(open[0] + open[1], rim, "{outline:?} {degrees}");
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
                let exact = mirror.footprint();
                assert!((area / exact - 1.0).abs() < 1e-4, "{vergence} {degrees}: {area} {exact}");
                assert_eq!(crate::solid::rim(&mesh).unwrap(), [rim, 0], "{vergence} {degrees}");
                if folded {
                    let ridge = mesh.vertices.iter().filter(|v| v.y.abs() < 1e-12).count();
                    assert!(ridge > 8, "{ridge}");
                }
            }
        }
    }
}
