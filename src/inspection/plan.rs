//! Places where a part is to be touched: evenly over the mirror, enough for a form of some degree, away from its rims.

use crate::geom::{DVec2, DVec3, Outline, Rect};
use crate::mirror::Mirror;
use crate::num::{cos, sin};
use std::f64::consts::TAU;

/// A place where a part is to be touched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedPoint {
    /// Place on the designed mirror, mm.
    pub at: DVec3,
    /// The mirror's unit normal there, from which the probe comes.
    pub normal: DVec3,
}

/// The places where a part is to be touched, in the order of the way between them.
#[derive(Debug, Clone, PartialEq)]
pub struct InspectionPlan {
    /// The places.
    pub points: Vec<PlannedPoint>,
    /// Distance between neighbours on the plane of the picture, mm.
    pub spacing_mm: f64,
}

/// Largest degree of a form that a plan is made for.
pub const MOST_DEGREE: usize = 40;
/// Points to a degree across the mirror's longer side. A polynomial of degree d takes d + 1; three times as many leave
/// noise a third of its amplitude, and tell of what is finer.
const PER_DEGREE: usize = 3;
/// Distance from the rim as a share of the width, and at least, mm, where nobody says more: edges are rounded and
/// broken, and a ball of usual size must not touch them.
const MARGIN: f64 = 0.02;
const LEAST_MARGIN_MM: f64 = 0.5;
/// Places along each side of a rim from which distances are taken.
const RIM_PLACES: usize = 400;
/// The golden angle's share of a turn: rings begin where the others do not.
const GOLDEN: f64 = 0.381_966_011_250_105;

/// The usual distance of points from rims, mm.
#[must_use]
pub fn least_margin_mm(mirror: &Mirror) -> f64 {
    (MARGIN * mirror.full_outline().bounds().size().max_element()).max(LEAST_MARGIN_MM)
}

/// Plans the points of a form of `degree`: rows there and back over rectangles, rings over discs, on each panel for
/// itself, no closer than `margin_mm` to its rims, ridges and steps.
#[must_use]
pub fn plan_points(mirror: &Mirror, degree: usize, margin_mm: f64) -> InspectionPlan {
    let across = (PER_DEGREE * (degree.min(MOST_DEGREE) + 1)) as f64;
    let spacing_mm = mirror.full_outline().bounds().size().max_element() / across;
    let points = mirror.panels().into_iter().flat_map(|panel| {
        let rim = rims_of(&panel).concat();
        let places = match panel.outline {
            Outline::Rect(rect) => rows(rect, spacing_mm),
            Outline::Ring { inner, outer } => rings(inner, outer, spacing_mm),
        };
        let far = |point: &PlannedPoint| rim.iter().all(|p| p.distance(point.at) >= margin_mm);
        let points = places.into_iter().map(|q| touched(&panel, q));
        points.filter(far).collect::<Vec<_>>()
    });
    InspectionPlan { points: points.collect(), spacing_mm }
}

/// The rims of the mirror's panels, each a closed line, mm.
#[must_use]
pub fn rims(mirror: &Mirror) -> Vec<Vec<DVec3>> {
    let mut rims: Vec<Vec<DVec3>> = mirror.panels().iter().flat_map(rims_of).collect();
    rims.iter_mut().for_each(|rim| rim.extend(rim.first().copied()));
    rims
}

/// Places along each rim of a panel, mm.
fn rims_of(panel: &Mirror) -> Vec<Vec<DVec3>> {
    let on_mirror = |rim: Vec<DVec2>| rim.into_iter().map(|q| touched(panel, q).at).collect();
    panel.outline.rims(RIM_PLACES).into_iter().map(on_mirror).collect()
}

fn touched(mirror: &Mirror, q: DVec2) -> PlannedPoint {
    let point = mirror.at(q);
    let normal = mirror.normal(q, &point).normalize();
    PlannedPoint { at: mirror.position(q, &point), normal }
}

/// The middles of cells of a rectangle, line by line, every other line backwards.
fn rows(rect: Rect, spacing_mm: f64) -> Vec<DVec2> {
    let size = rect.size();
    let [columns, lines] = size.to_array().map(|side| (side / spacing_mm).ceil().max(1.0) as usize);
    let at = |column: usize, line: usize| {
        let share = DVec2::new(column as f64 + 0.5, line as f64 + 0.5);
        rect.min + size * share / DVec2::new(columns as f64, lines as f64)
    };
    let line = |line: usize| -> Vec<DVec2> {
        let there = (0..columns).map(|column| at(column, line));
        if line.is_multiple_of(2) { there.collect() } else { there.rev().collect() }
    };
    (0..lines).flat_map(line).collect()
}

/// Rings of points from outside in, those of a disc around its middle.
fn rings(inner: f64, outer: f64, spacing_mm: f64) -> Vec<DVec2> {
    let count = ((outer - inner) / spacing_mm).ceil().max(1.0) as usize;
    let step = (outer - inner) / count as f64;
    let ring = |k: usize| {
        let radius = outer - (k as f64 + 0.5) * step;
        let points = (TAU * radius / spacing_mm).ceil().max(3.0);
        (0..points as usize).map(move |j| {
            let turn = TAU * (j as f64 / points + GOLDEN * k as f64);
            DVec2::new(cos(turn), sin(turn)) * radius
        })
    };
    (0..count).flat_map(ring).collect()
}
