//! The views of a part: plan, both sections through the axis, and an isometric view.

use super::DrawnPart;
use super::dimension::{
    AXIS, FAINT, HIDDEN, NARROW, SMALL, TEXT, WIDE, arrow, datum, leader, level, mm,
    profile_tolerance, upright,
};
use super::lines::{Segment, joined};
use super::paper::{Area, PaperLayout};
use super::part_edges::{PartEdges, ViewFrame};
use crate::geom::{DVec2, DVec3, DatumFeature};
use crate::num::{cos, sin};
use crate::profile::ViewArrangement;
use crate::render::{AxialPlane, PartSection};
use crate::results::{DrawingFacts, DrawnFeature};
use crate::sheet::{Pen, Sheet, TextAlign};

/// Deviation of a line from the part's, mm on paper.
const GRAIN: f64 = 2e-3;
/// Distance of hatching's lines, mm.
const HATCH: f64 = 2.4;
/// Distances of dimensions from the view, mm: the second row is beyond the symbols of datum features.
const FIRST: f64 = 9.0;
const SECOND: f64 = 16.0;
/// Distance of a cutting line's ends from the view, mm.
const CUT: f64 = 17.5;
/// How much further those beside upright dimensions are, whose figures stand on their outer side, mm.
const ASIDE: f64 = 3.5;
/// How far an axis goes beyond the view, mm.
const BEYOND: f64 = 4.0;
/// Largest scale of the isometric view, to that of the others.
const ISOMETRIC: f64 = 1.6;
/// Lines over the mirror in the isometric view, along each axis.
const MIRROR_LINES: u32 = 9;

/// A view of the part on the paper.
struct View {
    frame: ViewFrame,
    /// Where the part's origin is, mm.
    origin: [f64; 2],
    scale: f64,
}

impl View {
    fn at(&self, place: DVec2) -> [f64; 2] {
        [self.origin[0] + self.scale * place.x, self.origin[1] + self.scale * place.y]
    }

    /// Draws segments of the view, mm of the part.
    fn draw(&self, sheet: &mut Sheet, segments: &[Segment], pen: Pen) {
        for line in joined(segments, GRAIN / self.scale) {
            sheet.strokes(line.into_iter().map(|p| self.at(p)).collect(), pen);
        }
    }
}

/// The views of a part on a sheet.
pub(super) struct ViewPainter<'a> {
    pub part: &'a DrawnPart,
    pub facts: &'a DrawingFacts,
    pub layout: &'a PaperLayout,
    pub arrangement: ViewArrangement,
    pub edges: PartEdges,
}

impl ViewPainter<'_> {
    pub(super) fn draw(&self, sheet: &mut Sheet) {
        self.plan(sheet);
        self.section_y0(sheet);
        self.section_x0(sheet);
        self.isometric(sheet);
    }

    fn view(&self, right: DVec3, up: DVec3, is_cut: bool, origin: [f64; 2]) -> View {
        View { frame: ViewFrame { right, up, is_cut }, origin, scale: self.layout.scale.factor() }
    }

    /// The part's rim in the plan.
    fn rim(&self) -> Area {
        let ([x, y], [u, v]) = (self.layout.plan, self.facts.least_mm);
        let (scale, [wide, high, _]) = (self.layout.scale.factor(), self.facts.size_mm);
        Area {
            left: x + scale * u,
            low: y + scale * v,
            right: x + scale * (u + wide),
            high: y + scale * (v + high),
        }
    }

    /// The plan, from the camera's side.
    fn plan(&self, sheet: &mut Sheet) {
        let view = self.view(DVec3::X, DVec3::Y, false, self.layout.plan);
        let circles = &self.part.circles;
        let lies_on = |p: &DVec2, (centre, radius): &(DVec2, f64)| {
            (p.distance(*centre) - radius).abs() <= 1e-9 * (radius + centre.length())
        };
        // Chords of a circle are drawn as the circle.
        let is_chord = |s: &Segment| circles.iter().any(|c| s.iter().all(|end| lies_on(end, c)));
        let seen = self.edges.seen(&view.frame);
        let segments: Vec<Segment> = seen.iter().copied().filter(|s| !is_chord(s)).collect();
        view.draw(sheet, &segments, WIDE);
        for circle in circles {
            let is_seen = seen.iter().any(|s| s.iter().all(|end| lies_on(end, circle)));
            let pen = if is_seen { WIDE } else { HIDDEN };
            sheet.circle(view.at(circle.0), circle.1 * view.scale, pen);
        }
        let Area { left, low, right, high } = self.rim();
        axes(sheet, [left - BEYOND, right + BEYOND], [low - BEYOND, high + BEYOND], view.origin);
        for place in &self.part.inspected {
            let [x, y] = view.at(*place);
            sheet.strokes(vec![[x - 0.6, y], [x + 0.6, y]], FAINT);
            sheet.strokes(vec![[x, y - 0.6], [x, y + 0.6]], FAINT);
        }
        let [size_x, size_y, _] = self.facts.size_mm.map(mm);
        if self.facts.is_round {
            level(sheet, [left, right], [low, low - SECOND], &format!("\u{d8}{size_x}"));
        } else {
            level(sheet, [left, right], [low, low - SECOND], &size_x);
            upright(sheet, [low, high], [left, left - SECOND], &size_y);
        }
        self.axis_places(sheet);
        if self.facts.rim_mm.is_some() {
            self.mirror_size(sheet, &view, [right, high]);
        }
        if let Some(radius) = self.facts.corner_radius_mm {
            let inset = radius * view.scale * (1.0 - std::f64::consts::FRAC_1_SQRT_2);
            let tip = [right - inset, low + inset];
            let text = format!("4x R{}", mm(radius));
            leader(sheet, tip, [right + 7.0, low - 8.0], &text);
        }
        self.features(sheet, &view);
        self.plan_datums(sheet, &view);
        self.cutting_lines(sheet);
    }

    /// Where the axis is, if not in the middle of the part.
    fn axis_places(&self, sheet: &mut Sheet) {
        let (Area { left, low, .. }, [x, y]) = (self.rim(), self.layout.plan);
        let ([u, v], [wide, high, _]) = (self.facts.least_mm, self.facts.size_mm);
        if is_aside(u, wide) {
            level(sheet, [left, x], [low, low - FIRST], &mm(-u));
        }
        if is_aside(v, high) {
            upright(sheet, [low, y], [left, left - FIRST], &mm(-v));
        }
    }

    /// The mirror's own size, where a rim is around it, and where the axis is, if not in the mirror's middle.
    fn mirror_size(&self, sheet: &mut Sheet, view: &View, [right, high]: [f64; 2]) {
        let DrawingFacts { mirror_least_mm: least, mirror_mm: size, .. } = self.facts;
        let (first, extent) = (DVec2::from_array(*least), DVec2::from_array(*size));
        let ([left, low], [far, top]) = (view.at(first), view.at(first + extent));
        let [size_x, size_y] = size.map(mm);
        if self.facts.is_round {
            return level(sheet, [left, far], [high, high + FIRST], &format!("\u{d8}{size_x}"));
        }
        level(sheet, [left, far], [high, high + FIRST], &size_x);
        upright(sheet, [low, top], [right, right + FIRST], &size_y);
        // The axis stands in a second row: in the first its figure could meet the mirror's size. Its lines begin beyond that figure.
        let [x, y] = view.origin;
        let from_figure = |edge: f64| [edge + SECOND - 2.5, edge + SECOND];
        if is_aside(least[0], size[0]) {
            level(sheet, [left, x], from_figure(high), &mm(-least[0]));
        }
        if is_aside(least[1], size[1]) {
            upright(sheet, [low, y], from_figure(right), &mm(-least[1]));
        }
    }

    /// Numbers of holes and marks, with their axes.
    fn features(&self, sheet: &mut Sheet, view: &View) {
        for DrawnFeature { name, at_mm, diameter_mm, .. } in &self.facts.features {
            let at = view.at(DVec2::from_array(*at_mm));
            let reach = 0.5 * diameter_mm * view.scale + 1.5;
            axes(sheet, [at[0] - reach, at[0] + reach], [at[1] - reach, at[1] + reach], at);
            let out = outwards(*at_mm, 0.6) * (reach + 3.6);
            let place = [at[0] + out.x, at[1] + out.y - 0.36 * SMALL];
            sheet.text(place, SMALL, name, TextAlign::Centre);
        }
    }

    /// Datum features that the plan shows: sides, a round outside and holes.
    fn plan_datums(&self, sheet: &mut Sheet, view: &View) {
        let rim = self.rim();
        for (letter, feature) in self.part.datums.lettered() {
            match feature {
                DatumFeature::Base => {}
                DatumFeature::FrontSide => {
                    let x = rim.left + 0.8 * rim.width();
                    datum(sheet, [x, rim.low], [0.0, -1.0], letter);
                }
                DatumFeature::LeftSide => {
                    let y = rim.low + 0.15 * rim.height();
                    datum(sheet, [rim.left, y], [-1.0, 0.0], letter);
                }
                DatumFeature::Outside => {
                    let way = std::f64::consts::FRAC_1_SQRT_2;
                    let [x, y] = rim.middle().map(|at| at - way * 0.5 * rim.width());
                    let at = [x, y];
                    datum(sheet, at, [-way, -way], letter);
                }
                DatumFeature::Hole(k) => {
                    let name = DrawnFeature::hole_name(k);
                    let named = |f: &&DrawnFeature| f.name == name;
                    if let Some(hole) = self.facts.features.iter().find(named) {
                        let at = view.at(DVec2::from_array(hole.at_mm));
                        let out = outwards(hole.at_mm, -0.3);
                        let rim = out * (0.5 * hole.diameter_mm * view.scale);
                        datum(sheet, [at[0] + rim.x, at[1] + rim.y], out.to_array(), letter);
                    }
                }
            }
        }
    }

    /// Where the sections are, and from which side they are seen.
    fn cutting_lines(&self, sheet: &mut Sheet) {
        let (Area { left, low, right, high }, [x, y]) = (self.rim(), self.layout.plan);
        let from_left = match self.arrangement {
            ViewArrangement::FirstAngle => 1.0,
            ViewArrangement::ThirdAngle => -1.0,
        };
        for (end, out) in [(left, -1.0), (right, 1.0)] {
            let at = [end + out * (CUT + ASIDE), y];
            mark_cut(sheet, at, [out, 0.0], [0.0, 1.0], "A");
        }
        for (end, out) in [(low, -1.0), (high, 1.0)] {
            let at = [x, end + out * CUT];
            mark_cut(sheet, at, [0.0, out], [from_left, 0.0], "B");
        }
    }

    /// The section Y = 0, seen towards +Y.
    fn section_y0(&self, sheet: &mut Sheet) {
        let view = self.view(DVec3::X, DVec3::Z, true, self.layout.section_y0);
        self.cut(sheet, &view, AxialPlane::Y0, 1.0);
        let Area { left, right, .. } = self.rim();
        let ([x, base], [_, _, height]) = (view.origin, self.facts.size_mm);
        let top = base + height * view.scale;
        sheet.strokes(vec![[x, base - BEYOND], [x, top + BEYOND]], AXIS);
        upright(sheet, [base, top], [left, left - FIRST], &mm(height));
        let lowest = base + self.facts.lowest_mm * view.scale;
        upright(sheet, [base, lowest], [right, right + FIRST], &mm(self.facts.lowest_mm));
        if let Some(rim) = self.facts.rim_mm {
            let high = base + rim * view.scale;
            upright(sheet, [base, high], [right, right + SECOND], &mm(rim));
        }
        if let Some(leg) = self.facts.edge_chamfer_mm {
            let half = 0.5 * leg * view.scale;
            let text = format!("edges {} x 45\u{b0}", mm(leg));
            leader(sheet, [right - half, base + half], [right + 7.0, base - 11.0], &text);
        }
        datum(sheet, [0.7 * left + 0.3 * x, base], [0.0, -1.0], 'A');
        if let Some(zone) = self.facts.pmi.surface_profile_mm {
            let (tip, knee) = self.on_mirror(&view, top);
            sheet.strokes(vec![tip, knee], NARROW);
            let way = [tip[0] - knee[0], tip[1] - knee[1]];
            let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
            arrow(sheet, tip, way.map(|w| w / length));
            let letters: Vec<char> =
                self.part.datums.lettered().map(|(letter, _)| letter).collect();
            profile_tolerance(sheet, knee, &mm(zone), &letters);
        }
        self.caption(sheet, [x, base - 12.5], "A-A");
    }

    /// A place of the mirror in the section Y = 0, and one above the view from which a leader comes to it.
    fn on_mirror(&self, view: &View, top: f64) -> ([f64; 2], [f64; 2]) {
        let reach = self.facts.mirror_least_mm[0] + 0.25 * self.facts.mirror_mm[0];
        let heights = self.part.sections[0].edges.iter().flatten();
        let near = heights.filter(|p| (p.x - reach).abs() < 0.1 * self.facts.mirror_mm[0]);
        let at = near.max_by(|a, b| a.y.total_cmp(&b.y)).copied().unwrap_or(DVec2::ZERO);
        let tip = view.at(at);
        (tip, [tip[0] - 5.0, top + 6.0])
    }

    /// The section X = 0, seen from the left in the first angle, from the right in the third.
    fn section_x0(&self, sheet: &mut Sheet) {
        let right = match self.arrangement {
            ViewArrangement::FirstAngle => DVec3::Z,
            ViewArrangement::ThirdAngle => -DVec3::Z,
        };
        let view = self.view(right, DVec3::Y, true, self.layout.section_x0);
        self.cut(sheet, &view, AxialPlane::X0, right.z);
        let ([base, y], [_, _, height]) = (view.origin, self.facts.size_mm);
        let middle = base + 0.5 * right.z * height * view.scale;
        let reach = 0.5 * height * view.scale + BEYOND;
        sheet.strokes(vec![[middle - reach, y], [middle + reach, y]], AXIS);
        self.caption(sheet, [middle, self.rim().high + 4.0], "B-B");
    }

    fn caption(&self, sheet: &mut Sheet, at: [f64; 2], text: &str) {
        sheet.text(at, TEXT + 1.0, text, TextAlign::Centre);
    }

    /// A part that is cut: the cut's outline, hatched, and what stands behind it.
    fn cut(&self, sheet: &mut Sheet, view: &View, plane: AxialPlane, turned: f64) {
        let section = &self.part.sections[usize::from(plane == AxialPlane::X0)];
        let outline = section_lines(section, plane, turned);
        view.draw(sheet, &hatching(&outline, HATCH / view.scale), NARROW);
        let mut seen = self.edges.seen(&view.frame);
        seen.extend(outline);
        view.draw(sheet, &seen, WIDE);
    }

    /// An isometric view into its place, as large as it fits.
    fn isometric(&self, sheet: &mut Sheet) {
        let right = DVec3::new(1.0, 1.0, 0.0).normalize();
        let up = DVec3::new(-1.0, 1.0, 2.0).normalize();
        let frame = ViewFrame { right, up, is_cut: false };
        let edges = self.edges.seen(&frame);
        let places = || edges.iter().flatten().copied();
        let low = places().fold(DVec2::INFINITY, DVec2::min);
        let high = places().fold(DVec2::NEG_INFINITY, DVec2::max);
        let Area { left, low: foot, .. } = self.layout.isometric;
        let room = DVec2::new(self.layout.isometric.width(), self.layout.isometric.height() - 8.0);
        let fits = (0.94 * room / (high - low)).min_element();
        let scale = fits.min(ISOMETRIC * self.layout.scale.factor());
        let middle = DVec2::new(left, foot + 8.0) + 0.5 * room - scale * 0.5 * (low + high);
        let view = View { frame, origin: middle.to_array(), scale };
        let values = |axis: usize| -> Vec<f64> {
            let share = |k: u32| f64::from(k) / f64::from(MIRROR_LINES + 1) + 1e-7;
            let (least, size) = (self.facts.mirror_least_mm[axis], self.facts.mirror_mm[axis]);
            (1..=MIRROR_LINES).map(|k| least + share(k) * size).collect()
        };
        for axis in 0..2 {
            let lines = self.edges.mirror_lines(&frame, axis, &values(axis));
            view.draw(sheet, &lines, FAINT);
        }
        view.draw(sheet, &edges, Pen::black(0.35));
        let at = [self.layout.isometric.middle()[0], foot + 2.0];
        sheet.text(at, SMALL, "isometric, not to scale", TextAlign::Centre);
    }
}

/// Whether the axis is not in the middle of what begins at `least` and is so long, mm.
fn is_aside(least: f64, size: f64) -> bool {
    (2.0 * least + size).abs() > 1e-3
}

/// The unit vector away from the axis, turned by so much, radians; upwards on the axis itself.
fn outwards(at: [f64; 2], turn: f64) -> DVec2 {
    let way = DVec2::from_array(at).try_normalize().unwrap_or(DVec2::Y);
    DVec2::new(cos(turn), sin(turn)).rotate(way)
}

/// Axes through a place, from and to these X and Y.
fn axes(sheet: &mut Sheet, [left, right]: [f64; 2], [low, high]: [f64; 2], [x, y]: [f64; 2]) {
    sheet.strokes(vec![[left, y], [right, y]], AXIS);
    sheet.strokes(vec![[x, low], [x, high]], AXIS);
}

/// An end of a cutting line, which leads in the direction `out`, with an arrow in the direction of sight.
fn mark_cut(sheet: &mut Sheet, at: [f64; 2], out: [f64; 2], sight: [f64; 2], letter: &str) {
    let beside = |p: [f64; 2], way: [f64; 2], d: f64| [p[0] + d * way[0], p[1] + d * way[1]];
    let end = beside(at, out, 5.0);
    sheet.strokes(vec![at, end], WIDE);
    let middle = beside(at, out, 4.0);
    let tail = beside(middle, sight, -7.0);
    sheet.strokes(vec![tail, middle], NARROW);
    arrow(sheet, middle, sight);
    let letter_at = beside(beside(middle, sight, -6.0), out, 2.2);
    sheet.text([letter_at[0], letter_at[1] - 1.2], TEXT + 0.5, letter, TextAlign::Centre);
}

/// The outline of a section in its view, mm: the section has its horizontal axis and Z.
fn section_lines(section: &PartSection, plane: AxialPlane, turned: f64) -> Vec<Segment> {
    let place = |p: DVec2| match plane {
        AxialPlane::Y0 => p,
        AxialPlane::X0 => DVec2::new(turned * p.y, p.x),
    };
    section.edges.iter().map(|edge| edge.map(place)).collect()
}

/// Lines at 45 degrees inside an outline, so far apart, mm.
fn hatching(outline: &[Segment], apart: f64) -> Vec<Segment> {
    let across = DVec2::new(-1.0, 1.0) * std::f64::consts::FRAC_1_SQRT_2;
    let along = DVec2::new(1.0, 1.0) * std::f64::consts::FRAC_1_SQRT_2;
    let offsets = outline.iter().flatten().map(|p| p.dot(across));
    let (low, high) = offsets
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let mut lines = Vec::new();
    let mut offset = low + 0.5 * apart;
    while offset < high {
        let crossing = |[a, b]: &Segment| {
            let [from, to] = [a, b].map(|p| p.dot(across) - offset);
            let at = || a.lerp(*b, from / (from - to)).dot(along);
            ((from < 0.0) != (to < 0.0)).then(at)
        };
        let mut places: Vec<f64> = outline.iter().filter_map(crossing).collect();
        places.sort_by(f64::total_cmp);
        for pair in places.chunks_exact(2) {
            lines.push([pair[0], pair[1]].map(|at| across * offset + along * at));
        }
        offset += apart;
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hatching_fills_a_ring_and_leaves_its_hole() {
        let square = |half: f64| {
            let corners =
                [[-half, -half], [half, -half], [half, half], [-half, half]].map(DVec2::from_array);
            (0..4).map(move |k| [corners[k], corners[(k + 1) % 4]]).collect::<Vec<Segment>>()
        };
        let outline = [square(10.0), square(4.0)].concat();
        let lines = hatching(&outline, 0.01);
        // Lengths times their distance are the area.
        let area: f64 = lines.iter().map(|[a, b]| a.distance(*b) * 0.01).sum();
        assert!((area / (400.0 - 64.0) - 1.0).abs() < 1e-3, "{area}");
        let inside = |p: DVec2| p.abs().max_element() < 4.0 - 1e-9;
        assert!(!lines.iter().any(|[a, b]| inside(a.midpoint(*b))));
    }
}
