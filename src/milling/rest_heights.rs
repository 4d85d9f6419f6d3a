//! Heights at which a flat or a bull-nosed cutter rests on a mirror that is to keep an allowance.
//!
//! A cutter of radius R and corner radius c that keeps an allowance a everywhere is one of R + a and c + a, which touches: a disc of the radius
//! f = R - c, around each place of which there is a ball of radius c + a. A ball that touches the mirror has its middle at
//! `contact + (c + a) n`. So the cutter rests where its disc meets the highest of those middles that lie over it. They are known over a lattice,
//! with their slopes, which are the mirror's; between them their surface is taken for straight.

use crate::geom::{Cutter, DVec2, DVec3, Rect};
use crate::mirror::{Mirror, SurfaceSamples};
use crate::parallel;

/// Places of the lattice along the longer side of a mirror.
const PLACES: f64 = 600.0;
/// Beyond its rims a mirror is taken to go on for so many radii of the corner with the allowance: a ball that meets a rim is nearer.
const BEYOND: f64 = 2.0;
/// Reach of a place of the lattice over its distance from the next, half a diagonal and some more.
const REACH: f64 = 0.75;
/// Middles of the balls around the disc, in cells of the plan.
pub(super) struct RestHeights {
    /// The disc's radius, mm.
    flat_mm: f64,
    /// What the tip is below the disc of a cutter that touches with its allowance, mm.
    corner_mm: f64,
    /// How far from a middle its surface is taken for straight, mm.
    reach_mm: f64,
    /// X and Y of the first cell, side of the cells, mm, columns and rows.
    first: DVec2,
    cell_mm: f64,
    size: [usize; 2],
    /// Middles and the slopes there, cell by cell.
    middles: Vec<Middle>,
    /// Number of the first middle of each cell, and of all.
    begins: Vec<u32>,
}

/// Middle of a ball that touches the mirror.
#[derive(Debug, Clone, Copy)]
struct Middle {
    at: DVec3,
    slope: DVec2,
}

impl RestHeights {
    /// Those of a cutter that keeps `allowance_mm` on `mirror`.
    pub(super) fn new(mirror: &Mirror, cutter: Cutter, allowance_mm: f64) -> Self {
        let ball_mm = cutter.corner_mm + allowance_mm;
        // One panel alone, which goes on beyond the ridge: over a crest both go on straight until they meet.
        let panel = Mirror { folded: false, ..mirror.clone() };
        let bounds = mirror.full_outline().bounds();
        let step = bounds.size().max_element() / PLACES;
        let middles = middles(&panel, (ball_mm, step), mirror.folded);
        let stretch = stretch(&panel, ball_mm);
        let reach_mm = REACH * step * stretch;
        let all = middles.iter().map(|middle| middle.at.truncate());
        let (low, high) =
            all.fold((DVec2::MAX, DVec2::MIN), |(low, high), at| (low.min(at), high.max(at)));
        let cell_mm = 2.0 * step;
        let columns = |side: f64| (side / cell_mm).floor().max(0.0) as usize + 1;
        let size = [columns(high.x - low.x), columns(high.y - low.y)];
        let mut found = Self {
            flat_mm: cutter.flat_mm(),
            corner_mm: cutter.corner_mm,
            reach_mm,
            first: low,
            cell_mm,
            size,
            middles: Vec::new(),
            begins: Vec::new(),
        };
        found.sort(middles);
        found
    }

    /// Puts the middles into their cells.
    fn sort(&mut self, middles: Vec<Middle>) {
        let cell = |middle: &Middle| {
            let at = (middle.at.truncate() - self.first) / self.cell_mm;
            let [column, row] = [at.x, at.y].map(|at| at.max(0.0) as usize);
            row.min(self.size[1] - 1) * self.size[0] + column.min(self.size[0] - 1)
        };
        let cells: Vec<usize> = middles.iter().map(cell).collect();
        let mut begins = vec![0u32; self.size[0] * self.size[1] + 1];
        cells.iter().for_each(|&k| begins[k + 1] += 1);
        for k in 1..begins.len() {
            begins[k] += begins[k - 1];
        }
        let mut order: Vec<usize> = (0..middles.len()).collect();
        order.sort_by_key(|&k| cells[k]);
        self.middles = order.into_iter().map(|k| middles[k]).collect();
        self.begins = begins;
    }

    /// Z of the tip at rest with its axis over a place of the plan; none where nothing is below.
    pub(super) fn tip(&self, axis: DVec2) -> Option<f64> {
        let far = self.flat_mm + self.reach_mm;
        let around = Rect { min: axis - DVec2::splat(far), max: axis + DVec2::splat(far) };
        let cells = |low: f64, high: f64, first: f64, count: usize| {
            let [low, high] = [low, high].map(|at| (at - first) / self.cell_mm);
            let from = low.floor().max(0.0);
            let to = high.floor().min(count as f64 - 1.0);
            if to < from { 0..0 } else { from as usize..to as usize + 1 }
        };
        let columns = cells(around.min.x, around.max.x, self.first.x, self.size[0]);
        if columns.is_empty() {
            return None;
        }
        let rows = cells(around.min.y, around.max.y, self.first.y, self.size[1]);
        let mut highest = f64::NEG_INFINITY;
        for row in rows {
            let cell = |column: usize| row * self.size[0] + column;
            let [from, to] = [cell(columns.start), cell(columns.end - 1) + 1];
            let middles = self.begins[from] as usize..self.begins[to] as usize;
            for middle in &self.middles[middles] {
                highest = highest.max(self.over(middle, axis));
            }
        }
        highest.is_finite().then_some(highest - self.corner_mm)
    }

    /// Z of the highest place of a middle's surroundings over the disc about `axis`; none (minus infinity) beside it.
    fn over(&self, middle: &Middle, axis: DVec2) -> f64 {
        let off = middle.at.truncate() - axis;
        let distance = off.length();
        let beyond = distance - self.flat_mm;
        if beyond > self.reach_mm {
            return f64::NEG_INFINITY;
        }
        if beyond > 0.0 {
            // The place of the disc that is nearest to it.
            return middle.at.z - middle.slope.dot(off * (beyond / distance));
        }
        let steep = middle.slope.length();
        if !(steep > 0.0) {
            return middle.at.z;
        }
        // Upwards as far as it goes, but no farther than the disc does.
        let up = middle.slope / steep;
        let along = off.dot(up);
        let to_side = f64::sqrt(along * along - off.length_squared() + self.flat_mm * self.flat_mm);
        middle.at.z + steep * (to_side - along).clamp(0.0, self.reach_mm)
    }
}

/// Middles of balls of one radius that touch a panel, over a lattice so fine, mm; of a folded mirror those of both panels, each on its side.
fn middles(panel: &Mirror, (ball_mm, step): (f64, f64), folded: bool) -> Vec<Middle> {
    let beyond = BEYOND * ball_mm;
    let side = panel.outline.bounds().centre().y;
    let Rect { min, max } = panel.outline.bounds();
    let [min, max] = [min - DVec2::splat(beyond), max + DVec2::splat(beyond)];
    let count = |side: f64| (side / step).ceil() as usize + 1;
    let [columns, rows] = [count(max.x - min.x), count(max.y - min.y)];
    let middle = |q: DVec2| {
        let place = panel.extended_surface(q);
        let at = place.at + ball_mm * place.normal();
        let is_near = panel.outline.distance_outside(q) <= beyond;
        (is_near && !(folded && at.y * side < 0.0)).then_some(Middle { at, slope: place.slope })
    };
    let row = |k: usize| {
        let y = min.y + step * k as f64;
        let line = (0..columns).map(move |n| DVec2::new(min.x + step * n as f64, y));
        line.filter_map(middle).collect::<Vec<_>>()
    };
    let mut found = parallel::map(rows, 4, row).concat();
    if folded {
        let mirrored = |middle: &Middle| Middle {
            at: DVec3::new(middle.at.x, -middle.at.y, middle.at.z),
            slope: DVec2::new(middle.slope.x, -middle.slope.y),
        };
        let other: Vec<Middle> = found.iter().map(mirrored).collect();
        found.extend(other);
    }
    found
}

/// How much farther apart than the contacts their middles are, at most: normals turn by no more than the second derivatives.
fn stretch(panel: &Mirror, ball_mm: f64) -> f64 {
    let (most, _) = SurfaceSamples::new(panel).largest(|place| place.hessian.norm());
    1.0 + ball_mm * most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mirror::fixtures::{quadric, roof, sloping};
    use crate::num::{cos, radians, sin, tan};

    const CUTTERS: [[f64; 2]; 3] = [[1.0, 0.0], [1.0, 0.2], [1.0, 1.0]];

    /// What an edge of this radius is lower by half a diagonal of the lattice beside its outermost place, mm; nothing of a ball.
    fn lost_mm(flat_mm: f64) -> f64 {
        let step = 8.0 / PLACES;
        if flat_mm > 0.0 { step * step / (4.0 * flat_mm) } else { 0.0 }
    }

    /// Over a plane the disc rests with its edge uphill: `(c + a) g - c + f s` over the plane, g the secant of its slope s.
    #[test]
    fn over_a_plane_the_edge_uphill_rests() {
        for slope in [[0.0, 0.0], [-0.5, 0.4]] {
            let mirror = sloping(slope, [0.0; 3], 0.0);
            let steep = DVec2::from_array(slope);
            for [radius_mm, corner_mm] in CUTTERS {
                let found = RestHeights::new(&mirror, Cutter { radius_mm, corner_mm }, 0.3);
                for at in [DVec2::ZERO, DVec2::new(1.3, -2.1), DVec2::new(-2.7, 2.9)] {
                    let secant = f64::sqrt(1.0 + steep.length_squared());
                    let exact = 7.0 + steep.dot(at) + (corner_mm + 0.3) * secant - corner_mm
                        + (radius_mm - corner_mm) * steep.length();
                    let z = found.tip(at).unwrap();
                    let off = lost_mm(radius_mm - corner_mm) * steep.length() + 1e-9;
                    assert!(
                        z < exact + 1e-9 && z > exact - off,
                        "{slope:?} {radius_mm} {corner_mm} {at}: {z} {exact}"
                    );
                }
            }
            assert_eq!(
                RestHeights::new(&mirror, Cutter::ball(1.0), 0.3).tip(DVec2::splat(40.0)),
                None
            );
        }
    }

    /// No place of a cutter at rest, which is larger by its allowance, is below the mirror, and one of them is on it: over bulging, hollow and
    /// twisted ground, tested with a lattice of the cutter's lower side of its own.
    #[test]
    fn a_cutter_at_rest_touches_and_does_not_cut() {
        for terms in [[-0.05, 0.0, -0.08], [0.06, 0.02, 0.03], [0.05, 0.08, -0.06]] {
            let mirror = quadric(terms, 0.0);
            for [radius_mm, corner_mm] in CUTTERS {
                let grown = Cutter { radius_mm: radius_mm + 0.3, corner_mm: corner_mm + 0.3 };
                let found = RestHeights::new(&mirror, Cutter { radius_mm, corner_mm }, 0.3);
                for at in [DVec2::ZERO, DVec2::new(1.3, -1.1), DVec2::new(-2.1, 1.9)] {
                    let tip = found.tip(at).unwrap() - 0.3;
                    let mut least = f64::INFINITY;
                    for k in 0..200 {
                        let off = grown.radius_mm * f64::from(k) / 200.0;
                        for n in 0..120 {
                            let angle = radians(3.0 * f64::from(n));
                            let place = at + off * DVec2::new(cos(angle), sin(angle));
                            let Some(height) = grown.height(off) else { continue };
                            least = least.min(tip + height - mirror.extended_surface(place).at.z);
                        }
                    }
                    assert!(
                        least > -3e-5 && least < 1e-3,
                        "{terms:?} {radius_mm} {corner_mm} {at}: {least}"
                    );
                }
            }
        }
    }

    /// Over a crest a flat cutter keeps its allowance over both sides, where they meet and beside it.
    #[test]
    fn a_crest_keeps_its_allowance() {
        let mirror = roof(-30.0);
        let found = RestHeights::new(&mirror, Cutter { radius_mm: 1.0, corner_mm: 0.0 }, 0.3);
        let top = 7.0 + 0.3 / cos(radians(30.0));
        for y in [0.0, 0.4, -0.9] {
            let z = found.tip(DVec2::new(0.5, y)).unwrap();
            assert!(z > top - 1e-9 && z < top + 0.01, "{y}: {z} {top}");
        }
        for y in [1.5, -2.5_f64] {
            let z = found.tip(DVec2::new(0.5, y)).unwrap();
            let exact = top - tan(radians(30.0)) * (y.abs() - 1.0);
            assert!((z - exact).abs() < lost_mm(1.0), "{y}: {z} {exact}");
        }
    }
}
