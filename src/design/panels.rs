//! Panels side by side: each is a mirror that is solved for alone, and all are raised or lowered to meet with the least
//! steps.
//!
//! Under a pinhole a mirror that shows what is far away may be scaled about the entrance pupil, which adds a constant to
//! its height f over the chart and changes nothing of what it shows. A panel's height is therefore free. Where two
//! panels meet, the wall between them lies in a plane through the pupil, so that the camera sees its edge alone.
//!
//! A wall must not cross itself: along the whole of a line between panels those on one side are above those on the
//! other. Which side is above follows from an order of the panels; every order is tried. There always is one: panels and
//! lines are convex and apart, so that in a direction which is along no line none comes before itself, and each line lies
//! between the panels on both of its sides.

use super::cause::FailureCause;
use super::facts::{DesignFacts, DividingLineFacts};
use super::layout::{DesignProblem, rectangle_of};
use super::surface;
use crate::geom::{CommonStretch, DVec2, DividingLine, Outline, Panels, Rect};
use crate::mirror::{HeightField, Mirror, PanelledSurface, Surface, TensorLegendre};
use crate::num::legendre::Series;
use crate::num::radians;
use crate::num::units::Mm;
use crate::optics::{
    Azimuthal, Camera, FramedView, ImagingTask, PanelledView, Projection, SampledMap, Target,
};
use crate::profile::{Method, PanelSpec, PanelViewSpec, Profile};
use std::sync::Arc;

/// Least height of a wall, mm: more than flat facets depart from the mirror, and than a file rounds.
const LEAST_STEP_MM: f64 = 0.1;
/// Places along a line between panels at which their heights are compared.
const PLACES: usize = 257;

/// The panels' problem as a whole, and its mirror.
pub(super) struct PanelledDesign {
    pub camera: Camera,
    pub view: ImagingTask,
    pub mirror: Mirror,
    pub facts: DesignFacts,
}

/// Solves each panel and joins them.
///
/// # Errors
/// [`FailureCause`] when a panel has no answer, or a height on a line between panels that is no number.
pub(super) fn solved(
    profile: &Profile,
    wanted: &[PanelSpec],
    method: &Method,
) -> Result<PanelledDesign, FailureCause> {
    let camera = Camera::new(&profile.camera, &profile.mount, profile.part.width_mm);
    let area = rectangle_of(profile, &camera);
    let parts = Panels(wanted.iter().map(|panel| part(&camera, area, panel)).collect());
    let lines = parts.dividing_lines();
    let views: Vec<FramedView> = wanted
        .iter()
        .zip(&parts.0)
        .map(|(panel, part)| view(profile, &camera, *part, panel))
        .collect();
    let (mut sheets, mut all_facts) = (Vec::new(), Vec::new());
    for (part, view) in parts.0.iter().zip(&views) {
        let view = Projection::Framed(view.clone());
        let problem = DesignProblem::framed(camera, *part, view, Target::Infinity, false);
        let (mirror, facts) = surface::solved(&problem, method)?;
        let Surface::Tensor(sheet) = mirror.surface else {
            unreachable!("a rectangle's mirror is a tensor series")
        };
        sheets.push(sheet);
        all_facts.push(facts);
    }
    let raised = heights(&parts, &lines, &sheets)
        .ok_or(FailureCause::NotFinite { what: "step between panels" })?;
    let sheets = sheets.iter().zip(raised).map(|(sheet, by)| raise(sheet, by)).collect();
    let mirror = Mirror {
        surface: Surface::Panels(PanelledSurface { parts: parts.clone(), sheets }),
        chart: camera.chart,
        outline: Outline::Rect(area),
        folded: false,
        mirror_symmetric: [false; 2],
    };
    let view = ImagingTask {
        projection: Projection::Panels(Arc::new(PanelledView {
            parts,
            picture: camera.picture,
            views,
        })),
        target: Target::Infinity,
        origin_mm: 0.0,
        fold: None,
        picture: camera.picture,
    };
    let dividing_lines = dividing_lines(&camera, wanted, &lines);
    Ok(PanelledDesign {
        camera,
        view,
        mirror,
        facts: DesignFacts { dividing_lines, ..joint(&all_facts) },
    })
}

/// The panel's part of the frame, mm.
fn picture_of(camera: &Camera, panel: &PanelSpec) -> Rect {
    let ([left, right], [top, bottom]) = (panel.columns.map(f64::from), panel.rows.map(f64::from));
    Rect { min: camera.image_point(left, bottom), max: camera.image_point(right, top) }
}

/// The panel's part of the mirror, between lines for its edges in the frame: at the frame's own edges it ends with the mirror.
fn part(camera: &Camera, area: Rect, panel: &PanelSpec) -> Rect {
    let [columns, rows] = camera.pixels;
    let line = |axis: usize, edge: u32, ends: [(u32, f64); 2]| {
        let end = ends.into_iter().find(|(end, _)| *end == edge);
        end.map_or_else(|| camera.line_at(axis, edge), |(_, at)| at)
    };
    let [left, right] =
        panel.columns.map(|edge| line(0, edge, [(0, area.min.x), (columns, area.max.x)]));
    let [top, bottom] = panel.rows.map(|edge| line(1, edge, [(0, area.max.y), (rows, area.min.y)]));
    Rect { min: DVec2::new(left, bottom), max: DVec2::new(right, top) }
}

/// What a panel, on its part of the mirror, is to show.
fn view(profile: &Profile, camera: &Camera, part: Rect, panel: &PanelSpec) -> FramedView {
    let picture = picture_of(camera, panel);
    let wanted = match &panel.view {
        PanelViewSpec::Map(map) => {
            let map = SampledMap::new(&map.samples, picture, camera.image_of(part));
            return FramedView::Map(Arc::new(map));
        }
        PanelViewSpec::Azimuthal(view) => view,
    };
    let law = wanted.law.to_reach(radians(0.5 * wanted.hfov_deg), 0.5 * picture.size().x);
    let centre_deg = wanted.centre_deg.unwrap_or([0.0, 90.0]);
    let view = Azimuthal::new(law, centre_deg, wanted.roll_deg, wanted.mirrored, &profile.mount);
    FramedView::Azimuthal(view.about(picture.centre()))
}

/// How far lines between panels are from the edges that they stand for, in the picture of a lens that bends them.
fn dividing_lines(
    camera: &Camera,
    wanted: &[PanelSpec],
    lines: &[DividingLine],
) -> Option<DividingLineFacts> {
    if !camera.picture.is_distorted() {
        return None;
    }
    let departure = |line: &DividingLine| {
        let below = &wanted[line.sides[0][0]];
        let edge = if line.axis == 0 { below.columns[1] } else { below.rows[0] };
        let edge = camera.image_point(f64::from(edge), f64::from(edge))[line.axis];
        let [from, to] = line.ends;
        let places = (0..PLACES).map(|k| from + (to - from) * (k as f64 / (PLACES - 1) as f64));
        let seen = places.map(|along| camera.picture.image_point(line.place(along)));
        // What lies beyond the frame nobody sees.
        let seen = seen.filter(|&image| camera.frames(image));
        seen.map(|image| (image[line.axis] - edge).abs()).fold(0.0, f64::max)
    };
    let largest = lines.iter().map(departure).fold(0.0, f64::max);
    Some(DividingLineFacts { departure_px: camera.to_px(Mm(largest)).0 })
}

/// The surface higher by so many mm.
fn raise(sheet: &TensorLegendre, by: f64) -> TensorLegendre {
    let (rows, columns) = sheet.series.shape();
    let series = Series::from_fn(rows, columns, |i, j| {
        let rise = if i == 0 && j == 0 { by / sheet.scale_mm } else { 0.0 };
        sheet.series.coefficient(i, j) + rise
    });
    TensorLegendre { series, ..sheet.clone() }
}

/// The figures of all fits together.
fn joint(all: &[DesignFacts]) -> DesignFacts {
    let most = |of: fn(&DesignFacts) -> Option<f64>| all.iter().filter_map(of).reduce(f64::max);
    DesignFacts {
        unknowns: all.iter().map(|facts| facts.unknowns).sum(),
        steps: all.iter().map(|facts| facts.steps).max().unwrap_or(0),
        condition: most(|facts| facts.condition),
        gradient_residual: all.iter().map(|facts| facts.gradient_residual).sum(),
        ..all[0].clone()
    }
}

/// Two panels on both sides of a line between panels.
struct Meeting {
    /// The line.
    line: usize,
    /// The panel below the line's coordinate and the one above.
    pair: [usize; 2],
    /// Least and largest height of the first over the second, mm.
    over: [f64; 2],
    /// Length of the line that they have in common, mm: 0 where they touch at a corner alone.
    length_mm: f64,
    /// Mean height of the first over the second, mm.
    mean_mm: f64,
}

/// How much each panel is raised, mm; none where a height on a line between panels is no number.
fn heights(parts: &Panels, lines: &[DividingLine], sheets: &[TensorLegendre]) -> Option<Vec<f64>> {
    let meetings: Vec<Meeting> =
        lines.iter().enumerate().flat_map(|(k, line)| meetings(parts, sheets, k, line)).collect();
    let mut best: Option<(f64, Vec<f64>)> = None;
    for_each_order(parts.0.len(), &mut |order| {
        let Some(signs) = sides_above(lines, order) else { return };
        let raised = least_steps(&meetings, &signs, order);
        let walls_mm2: f64 = meetings
            .iter()
            .map(|m| {
                m.length_mm * signs[m.line] * (m.mean_mm + raised[m.pair[0]] - raised[m.pair[1]])
            })
            .sum();
        if walls_mm2.is_finite() && best.as_ref().is_none_or(|(least, _)| walls_mm2 < *least) {
            best = Some((walls_mm2, raised));
        }
    });
    let (_, raised) = best?;
    let area: f64 = parts.0.iter().map(Rect::area).sum();
    let mean = parts.0.iter().zip(&raised).map(|(part, by)| part.area() * by).sum::<f64>() / area;
    Some(raised.into_iter().map(|by| by - mean).collect())
}

/// The pairs of panels on both sides of a line.
fn meetings(
    parts: &Panels,
    sheets: &[TensorLegendre],
    number: usize,
    line: &DividingLine,
) -> Vec<Meeting> {
    let meeting = |stretch: CommonStretch| {
        let CommonStretch { pair, ends: [from, to] } = stretch;
        let length_mm = to - from;
        let over = |k: usize| {
            let q = line.place(from + length_mm * (k as f64 / (PLACES - 1) as f64));
            let [below, above] = pair.map(|k| sheets[k].height(q));
            below - above
        };
        let all: Vec<f64> = (0..PLACES).map(over).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mean_mm = all.iter().sum::<f64>() / PLACES as f64;
        Meeting { line: number, pair, over: [least, most], length_mm, mean_mm }
    };
    line.stretches(parts).into_iter().map(meeting).collect()
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
    // The upper and the lower panel of each meeting, and by how much more the upper one must be raised.
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
