//! Heights of panels that meet: each panel's is free, and they are raised so that walls between them are small and shadow
//! little.
//!
//! A wall must not cross itself: along the whole of a line between panels those on one side are above those on the
//! other. Which side is above follows from an order of the panels; every order is tried. There always is one: panels and
//! lines are convex and apart, so that in a direction which is along no line none comes before itself, and each line lies
//! between the panels on both of its sides.
//!
//! Rays that leave the lower panel towards the wall meet it next to its foot. How wide that strip is for each mm of the
//! wall follows from the slope of the lower mirror alone, to the first order in its width (docs/theory.md, T131).

use crate::geom::{Chart, CommonStretch, DVec2, DVec3, DividingLine, Panels, Rect};
use crate::mirror::{HeightField, TensorLegendre};
use crate::optics::reflect;

/// Least height of a wall, mm: more than flat facets depart from the mirror, and than a file rounds.
const LEAST_STEP_MM: f64 = 0.1;
/// Places along a line between panels at which their heights are compared.
const PLACES: usize = 257;
/// Share of the frame that may be shadowed more than in the best order for smaller walls: nobody misses so little of a
/// picture.
const MORE_SHADED: f64 = 1e-3;

/// Panels, the lines between them, and how the surfaces over them meet there.
pub(super) struct PanelJoint<'a> {
    parts: &'a Panels,
    lines: &'a [DividingLine],
    meetings: Vec<Meeting>,
}

/// Two panels on both sides of a line between panels.
struct Meeting {
    /// The line.
    line: usize,
    /// The panel below the line's coordinate and the one above.
    pair: [usize; 2],
    /// Length of the line that they have in common, mm: 0 where they touch at a corner alone.
    length_mm: f64,
    /// What was found at places along it.
    places: Vec<MeetingPlace>,
    /// Least and largest height of the first panel over the second, mm.
    over: [f64; 2],
    /// Mean of it, mm.
    mean_mm: f64,
}

/// A place on a line between two panels.
struct MeetingPlace {
    /// Height of the first panel over the second, mm.
    over_mm: f64,
    /// Width of the strip of each panel, mm of the chart, that a wall of 1 mm beside it shadows.
    shaded: [f64; 2],
}

/// Panels raised in one order.
pub(super) struct RaisedPanels {
    /// The rank of each panel in that order, the highest one last.
    pub order: Vec<usize>,
    /// Area of the walls, mm^2.
    walls_mm2: f64,
    /// Area of the chart that they shadow, mm^2.
    shaded_mm2: f64,
    /// How much each panel is raised, mm.
    pub by: Vec<f64>,
}

impl<'a> PanelJoint<'a> {
    /// The surfaces of each panel beside the lines between them.
    pub(super) fn new(
        chart: &Chart,
        parts: &'a Panels,
        lines: &'a [DividingLine],
        sheets: &[TensorLegendre],
    ) -> Self {
        let meetings = |(number, line): (usize, &DividingLine)| {
            let stretches = line.stretches(parts).into_iter();
            let meeting = |stretch| Meeting::new(chart, sheets, (number, line), stretch);
            stretches.map(meeting).collect::<Vec<_>>()
        };
        Self { parts, lines, meetings: lines.iter().enumerate().flat_map(meetings).collect() }
    }

    /// The panels raised in the order with the smallest walls of those that shadow [`MORE_SHADED`] more than the best at most.
    /// None where a height on a line between panels is no number.
    pub(super) fn best(&self) -> Option<RaisedPanels> {
        let mut tried = Vec::new();
        for_each_order(self.parts.0.len(), &mut |order| tried.extend(self.raised(order)));
        let least = tried.iter().map(|raised| raised.shaded_mm2).reduce(f64::min)?;
        let area: f64 = self.parts.0.iter().map(Rect::area).sum();
        let shadows_little =
            |raised: &RaisedPanels| raised.shaded_mm2 <= least + MORE_SHADED * area;
        // (The first of equal ones.)
        let smaller =
            |a: RaisedPanels, b: RaisedPanels| if b.walls_mm2 < a.walls_mm2 { b } else { a };
        tried.into_iter().filter(shadows_little).reduce(smaller)
    }

    /// The panels in an order of them, raised as little as that takes, by nothing in the mean. None where a line has panels
    /// on one side between those on the other, or a height on a line is no number.
    pub(super) fn raised(&self, order: &[usize]) -> Option<RaisedPanels> {
        let signs = sides_above(self.lines, order)?;
        let by = least_steps(&self.meetings, &signs, order);
        let of_walls = |m: &Meeting| {
            let [sign, rise] = [signs[m.line], by[m.pair[0]] - by[m.pair[1]]];
            m.length_mm * sign * (m.mean_mm + rise)
        };
        let shaded = |m: &Meeting| {
            let sign = signs[m.line];
            let lower = usize::from(sign > 0.0);
            let (rise, part) = (by[m.pair[0]] - by[m.pair[1]], &self.parts.0[m.pair[lower]]);
            let depth_mm = part.size()[self.lines[m.line].axis];
            let width =
                |at: &MeetingPlace| (at.shaded[lower] * sign * (at.over_mm + rise)).min(depth_mm);
            m.length_mm * m.places.iter().map(width).sum::<f64>() / PLACES as f64
        };
        let walls_mm2: f64 = self.meetings.iter().map(of_walls).sum();
        let shaded_mm2: f64 = self.meetings.iter().map(shaded).sum();
        let areas = self.parts.0.iter().map(Rect::area);
        let volume: f64 = areas.clone().zip(&by).map(|(area, by)| area * by).sum();
        let mean = volume / areas.sum::<f64>();
        let by = by.into_iter().map(|by| by - mean).collect();
        let order = order.to_vec();
        let is_finite = walls_mm2.is_finite() && shaded_mm2.is_finite();
        is_finite.then_some(RaisedPanels { order, walls_mm2, shaded_mm2, by })
    }
}

impl Meeting {
    fn new(
        chart: &Chart,
        sheets: &[TensorLegendre],
        (number, line): (usize, &DividingLine),
        CommonStretch { pair, ends: [from, to] }: CommonStretch,
    ) -> Self {
        let length_mm = to - from;
        let place = |k: usize| {
            let q = line.place(from + length_mm * (k as f64 / (PLACES - 1) as f64));
            let [below, above] = pair.map(|k| sheets[k].at(q));
            let shaded = |side: usize, slope| shaded_per_mm(chart, q, slope, (line.axis, side));
            MeetingPlace {
                over_mm: below.f - above.f,
                shaded: [shaded(0, below.slope), shaded(1, above.slope)],
            }
        };
        let places: Vec<MeetingPlace> = (0..PLACES).map(place).collect();
        let over = || places.iter().map(|at| at.over_mm);
        let ends = [over().fold(f64::INFINITY, f64::min), over().fold(f64::NEG_INFINITY, f64::max)];
        let mean_mm = over().sum::<f64>() / PLACES as f64;
        Self { line: number, pair, length_mm, over: ends, mean_mm, places }
    }
}

/// Width of the strip beside a wall, mm of the chart, that 1 mm of the wall shadows: of a panel of chart slope `slope` at
/// `q`, on the side of a line of constant `axis` on which that coordinate is smaller (0) or larger (1) (docs/theory.md, T131).
fn shaded_per_mm(chart: &Chart, q: DVec2, slope: DVec2, (axis, side): (usize, usize)) -> f64 {
    let [across, along] = [DVec3::AXES[axis], DVec3::AXES[1 - axis]];
    // The plane through the camera's ray and the line, on whose other side the higher panel is.
    let ray = chart.tangent_at(q).extend(-1.0);
    let into = ray.cross(along).normalize();
    let towards = if side == 0 { 1.0 } else { -1.0 };
    let into = into * (towards * into.dot(across).signum());
    let normal = (-DVec2::from_array(chart.slope(q.to_array(), slope.to_array()))).extend(1.0);
    // The reflected ray is as long as the camera's, by which a mm of the plane is wider in the chart.
    let width = reflect(ray, normal).dot(into) / into.dot(across).abs();
    if width > 0.0 { width } else { 0.0 }
}

/// Calls `visit` with every order of the numbers below `count`, each as the rank of each number.
fn for_each_order(count: usize, visit: &mut impl FnMut(&[usize])) {
    fn place(ranks: &mut Vec<usize>, count: usize, visit: &mut impl FnMut(&[usize])) {
        if ranks.len() == count {
            return visit(ranks);
        }
        for rank in 0..count {
            if !ranks.contains(&rank) {
                ranks.push(rank);
                place(ranks, count, visit);
                ranks.pop();
            }
        }
    }
    place(&mut Vec::new(), count, visit);
}

/// For each line 1 where its first side is above the second in this order of the panels and -1 where it is below;
/// none where a line has panels on one side between those on the other.
fn sides_above(lines: &[DividingLine], rank: &[usize]) -> Option<Vec<f64>> {
    let sign = |line: &DividingLine| {
        let ranks = |side: usize| line.sides[side].iter().map(|&k| rank[k]);
        if ranks(0).min() > ranks(1).max() {
            Some(1.0)
        } else if ranks(0).max() < ranks(1).min() {
            Some(-1.0)
        } else {
            None
        }
    };
    lines.iter().map(sign).collect()
}

/// How much each panel is raised in an order of them, mm: one after the other as little as the walls below take, and then
/// each as far as makes the walls smaller, as often as there are panels.
fn least_steps(meetings: &[Meeting], signs: &[f64], rank: &[usize]) -> Vec<f64> {
    let count = rank.len();
    // The upper and the lower panel of each meeting, by how much more the upper one must be raised, and along what length.
    let steps: Vec<([usize; 2], f64, f64)> = meetings
        .iter()
        .map(|m| {
            let ([a, b], [least, most]) = (m.pair, m.over);
            match signs[m.line] > 0.0 {
                true => ([a, b], LEAST_STEP_MM - least, m.length_mm),
                false => ([b, a], LEAST_STEP_MM + most, m.length_mm),
            }
        })
        .collect();
    let mut raised = vec![0.0f64; count];
    let floor = |raised: &[f64], k: usize| {
        let needed = steps.iter().filter(|(pair, ..)| pair[0] == k);
        needed.map(|(pair, rise, _)| raised[pair[1]] + rise).reduce(f64::max)
    };
    let ceiling = |raised: &[f64], k: usize| {
        let needed = steps.iter().filter(|(pair, ..)| pair[1] == k);
        needed.map(|(pair, rise, _)| raised[pair[0]] - rise).reduce(f64::min)
    };
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&k| rank[k]);
    for &k in &order {
        raised[k] = floor(&raised, k).unwrap_or(0.0);
    }
    // A panel that moves may free its neighbours.
    for _ in 0..count {
        for &k in order.iter().rev() {
            let length = |side: usize| -> f64 {
                steps.iter().filter(|(pair, ..)| pair[side] == k).map(|step| step.2).sum()
            };
            let to = if length(0) > length(1) { floor(&raised, k) } else { ceiling(&raised, k) };
            raised[k] = to.unwrap_or(raised[k]);
        }
    }
    raised
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{sin, tan};

    /// Where the ray of `q` meets the plane through `at` across `normal`, mm.
    fn on_plane(chart: &Chart, q: DVec2, (at, normal): (DVec3, DVec3)) -> DVec3 {
        let ray = chart.tangent_at(q).extend(-1.0);
        let pupil = DVec3::new(0.0, 0.0, chart.plane_mm + 1.0 / chart.vergence);
        pupil + ray * ((at - pupil).dot(normal) / ray.dot(normal))
    }

    /// Under parallel rays the strip beside a wall of 1 mm is sin 2a wide where the mirror's slope is tan a.
    #[test]
    fn a_tilted_plane_is_shaded_as_wide_as_the_sine_of_twice_its_slope() {
        let chart = Chart::on_axis(1e-9, 3.0);
        for angle in [0.1, 0.4, 0.7, 1.2, 1.5f64] {
            let slope = DVec2::new(0.0, tan(angle));
            let [below, above] =
                [0, 1].map(|side| shaded_per_mm(&chart, DVec2::ZERO, slope, (1, side)));
            assert_eq!(below, 0.0, "no ray leans to where the mirror rises");
            assert!((above - sin(2.0 * angle)).abs() < 1e-8, "{angle}: {above}");
        }
    }

    /// The ray from the edge of that strip meets the wall at its top, by the positions of rays, planes and the wall.
    #[test]
    fn the_ray_from_the_edge_of_the_shade_meets_the_top_of_the_wall() {
        let (chart, step) = (Chart::on_axis(1.0 / 120.0, 12.0), 1e-6);
        let mut found = 0;
        for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            for k in 0..49 {
                let slope = 0.35 * DVec2::new(f64::from(k % 7 - 3), f64::from(k / 7 - 3));
                let q = DVec2::new(17.0, -31.0);
                let chart_slope =
                    DVec2::from_array(chart.chart_slope(q.to_array(), slope.to_array()));
                let width = step * shaded_per_mm(&chart, q, chart_slope, (axis, side));
                if width == 0.0 {
                    continue;
                }
                let plane = (chart.point(q, 2.0), (-slope).extend(1.0));
                let away = DVec2::AXES[axis] * if side == 0 { -width } else { width };
                let from = on_plane(&chart, q + away, plane);
                let ray = chart.tangent_at(q + away).extend(-1.0);
                let seen = reflect(ray, plane.1);
                let wall = chart.tangent_at(q).extend(-1.0).cross(DVec3::AXES[1 - axis]);
                let met = from + seen * ((chart.point(q, 0.0) - from).dot(wall) / seen.dot(wall));
                let (at, f) = chart.coordinates(met);
                let (_, foot) = chart.coordinates(on_plane(&chart, at, plane));
                assert!(
                    (at - q)[axis].abs() < 1e-12 && ((f - foot) / step - 1.0).abs() < 1e-4,
                    "{slope}"
                );
                found += 1;
            }
        }
        assert_eq!(found, 98);
    }

    /// Side of the grid whose tilings are tried.
    const GRID: usize = 4;

    /// Adds every tiling of the cells that are not `taken` by as many rectangles as `left` at most.
    fn tilings(taken: [[bool; GRID]; GRID], left: usize, made: &Panels, all: &mut Vec<Panels>) {
        let free = (0..GRID * GRID).find(|k| !taken[k / GRID][k % GRID]);
        let Some(first) = free else { return all.push(made.clone()) };
        if left == 0 {
            return;
        }
        let (row, column) = (first / GRID, first % GRID);
        for bottom in row + 1..=GRID {
            for right in column + 1..=GRID {
                let (mut now, mut is_free) = (taken, true);
                for line in &mut now[row..bottom] {
                    for cell in &mut line[column..right] {
                        is_free &= !std::mem::replace(cell, true);
                    }
                }
                if is_free {
                    let [min, max] = [[column, row], [right, bottom]]
                        .map(|[x, y]| DVec2::new(x as f64, y as f64));
                    let mut more = made.clone();
                    more.0.push(Rect { min, max });
                    tilings(now, left - 1, &more, all);
                }
            }
        }
    }

    #[test]
    fn every_arrangement_has_an_order_without_crossing_walls() {
        let mut all = Vec::new();
        tilings([[false; GRID]; GRID], 6, &Panels(Vec::new()), &mut all);
        // Rectangles of one, two and three, and so on: a pinwheel is among them.
        assert!(all.len() > 1000, "{}", all.len());
        for tiling in all {
            let (lines, mut found) = (tiling.dividing_lines(), 0);
            for_each_order(tiling.0.len(), &mut |order| {
                found += usize::from(sides_above(&lines, order).is_some());
            });
            assert!(found > 0, "{tiling:?}");
        }
    }
}
