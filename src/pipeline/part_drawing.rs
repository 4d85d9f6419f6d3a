//! The drawing of a designed part: its figures, and the sheet that shows them.

use super::Error;
use super::form_study::{FormStudy, pmi_facts};
use super::inspect::InspectOptions;
use super::page_figures::coarse_solid;
use crate::design::Design;
use crate::drawing::{self, DrawnPart};
use crate::export::sag_heights;
use crate::geom::{Contour, DVec2, Drilled, Hole, NumberedHole, Outline, Precision, Rect};
use crate::inspection::{least_margin_mm, plan_points, rims};
use crate::mirror::{Form, Mirror};
use crate::num::rounding::{ceil_125, two_digits_below};
use crate::profile::{DrawingFormat, PaperSize, Profile};
use crate::results::{DrawingFacts, DrawnFeature};
use crate::sheet::Sheet;

/// Most steps of the sag table's excerpt along X, and along Y, by the room on the paper.
fn sag_steps(paper: PaperSize) -> [f64; 2] {
    match paper {
        PaperSize::A3 => [12.0, 10.0],
        PaperSize::A4 => [6.0, 6.0],
    }
}

/// The drawing of a part.
pub(super) struct PartDrawing {
    /// Its figures.
    pub facts: DrawingFacts,
    sheet: Sheet,
    /// Millimetres of the part to one of the sheet.
    enlargement: f64,
}

impl PartDrawing {
    /// Draws the part of `design`, whose mirror has this `form`.
    ///
    /// # Errors
    /// [`Error::Drawing`] when no closed part can be made of its mirror.
    pub(super) fn new(profile: &Profile, design: &Design, form: &Form) -> Result<Self, Error> {
        if let Some(tool) = &profile.part.forming {
            let form = tool.form.name();
            let reason = format!(
                "a drawing is of the part, and part.form is \"{form}\"; leave part.form out to draw what is formed"
            );
            return Err(Error::Drawing { profile: profile.name.clone(), reason });
        }
        let solid = coarse_solid(design, Precision::Double);
        let solid =
            solid.map_err(|reason| Error::Drawing { profile: profile.name.clone(), reason })?;
        let margin_mm = least_margin_mm(&design.mirror);
        let plan = plan_points(&design.mirror, InspectOptions::DEGREE, margin_mm);
        let inspected: Vec<DVec2> = plan.points.iter().map(|point| point.at.truncate()).collect();
        let facts = facts(profile, design, form, inspected.len());
        let part = DrawnPart::new(solid, design.datums(), circles(design), inspected);
        let sheet = drawing::drawn(profile, &facts, &part);
        let enlargement = 1.0 / drawing::scale(profile, facts.size_mm).factor();
        Ok(Self { facts, sheet, enlargement })
    }

    /// Its file in a format.
    pub(super) fn file(&self, profile: &Profile, format: DrawingFormat) -> Vec<u8> {
        match format {
            DrawingFormat::Pdf => self.sheet.pdf(&format!("Drawing of {}", profile.name)),
            DrawingFormat::Dxf => self.sheet.dxf(self.enlargement),
        }
    }
}

/// The figures of a drawing.
fn facts(profile: &Profile, design: &Design, form: &Form, inspected: usize) -> DrawingFacts {
    let size_mm = design.mounting.size_mm;
    let study = FormStudy::new(design);
    let slope = study.as_ref().and_then(FormStudy::slope_limit);
    let border = design.border.as_ref();
    let (is_round, corner) = match border.map(|border| border.contour) {
        Some(Contour::Circle { .. }) => (true, None),
        Some(Contour::Rect { corner_mm, .. }) => (false, Some(corner_mm)),
        None => (matches!(design.mirror.outline, Outline::Ring { .. }), None),
    };
    let (spec, mirror) = (&profile.drawing, plan_rectangle(&design.mirror));
    DrawingFacts {
        paper: spec.paper.name().to_owned(),
        projection: spec.arrangement.name().to_owned(),
        scale: drawing::scale(profile, size_mm).to_string(),
        size_mm,
        least_mm: design.plan_bounds().min.to_array(),
        mirror_mm: mirror.size().to_array(),
        mirror_least_mm: mirror.min.to_array(),
        lowest_mm: profile.part.base_mm,
        is_round,
        rim_mm: border.map(|border| border.top_mm),
        corner_radius_mm: corner.filter(|radius| *radius > 0.0),
        edge_chamfer_mm: border.map(|border| border.edge_chamfer_mm).filter(|leg| *leg > 0.0),
        shell_mm: design.cavity.as_ref().map(|cavity| cavity.wall_mm),
        features: features(design),
        sphere_radius_mm: form.sphere.radius_of_curvature_mm,
        sphere_departure_mm: form.sphere.departure.pv_mm,
        pmi: pmi_facts(design, study.as_ref().and_then(FormStudy::limit).as_ref()),
        slope_error_mrad: slope.map(two_digits_below),
        sag_mm: sag(&design.mirror, &mirror, sag_steps(spec.paper)),
        inspection_points: inspected,
        camera: format!("{}, {}", design.mounting.camera(), design.mounting.looks()),
    }
}

/// The rectangle around the mirror in the plan, mm.
fn plan_rectangle(mirror: &Mirror) -> Rect {
    let none = Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
    let places = rims(mirror).into_iter().flatten().map(|p| p.truncate());
    places.fold(none, |Rect { min, max }, p| Rect { min: min.min(p), max: max.max(p) })
}

/// Holes, marks and drains, with their numbers.
fn features(design: &Design) -> Vec<DrawnFeature> {
    let hole = |hole: NumberedHole| {
        // (A plain diameter has a column of its own.)
        let (diameter_mm, what) = (hole.hole.diameter_mm, hole.remarks());
        let (name, at_mm) = (DrawnFeature::hole_name(hole.number), hole.at().to_array());
        DrawnFeature { name, at_mm, diameter_mm, what }
    };
    let mark = |(k, mark): (usize, &Drilled)| DrawnFeature {
        name: format!("M{}", k + 1),
        at_mm: mark.at.to_array(),
        diameter_mm: mark.diameter_mm,
        what: format!("dimple 90\u{b0} x {}", mark.radius()),
    };
    let marks = design.border.iter().flat_map(|border| border.marks.iter());
    let drain = |(k, drain): (usize, &Hole)| DrawnFeature {
        name: format!("D{}", k + 1),
        at_mm: drain.at.to_array(),
        diameter_mm: drain.diameter_mm,
        what: "drain, base to cavity".to_owned(),
    };
    let drains = design.cavity.iter().flat_map(|cavity| &cavity.floor.drains);
    let holes = design.features().holes().map(hole);
    holes.chain(marks.enumerate().map(mark)).chain(drains.enumerate().map(drain)).collect()
}

/// Circles in the plan of the part, seen or hidden.
fn circles(design: &Design) -> Vec<(DVec2, f64)> {
    let mirror = &design.mirror;
    let mut circles = Vec::new();
    if let Outline::Ring { inner, outer } = mirror.outline {
        for rim in [inner, outer].into_iter().filter(|rim| *rim > 0.0) {
            let q = DVec2::new(rim, 0.0);
            circles.push((DVec2::ZERO, mirror.position(q, &mirror.at(q)).truncate().length()));
        }
    }
    if let Some(border) = &design.border {
        for contour in [border.contour, border.flat_contour()] {
            if let Contour::Circle { radius_mm } = contour {
                circles.push((DVec2::ZERO, radius_mm));
            }
        }
        circles.dedup();
        circles.extend(border.marks.iter().map(|mark| (mark.at, mark.radius())));
    }
    let drains = design.cavity.iter().flat_map(|cavity| &cavity.floor.drains);
    circles.extend(drains.map(|drain| (drain.at, drain.radius())));
    for hole in design.features().holes() {
        let mut radii: Vec<f64> = hole.meridian.points().iter().map(|point| point.x).collect();
        radii.sort_by(f64::total_cmp);
        radii.dedup();
        circles.extend(radii.into_iter().filter(|r| *r > 0.0).map(|radius| (hole.at(), radius)));
    }
    circles
}

/// Places of the mirror in `rectangle` over a grid of round coordinates, of which the axis is one.
fn sag(mirror: &Mirror, rectangle: &Rect, [across, along]: [f64; 2]) -> Vec<[f64; 3]> {
    let size = rectangle.size();
    // (Sizes are found to rounding.)
    let step = ceil_125((1.0 - 1e-9) * (size.x / across).max(size.y / along));
    let numbers = |from: f64, to: f64| {
        let beyond = 1e-9 * (to - from);
        let [first, last] = [((from - beyond) / step).ceil(), ((to + beyond) / step).floor()];
        (first as i64..=last as i64).map(move |k| k as f64 * step)
    };
    let Rect { min, max } = *rectangle;
    let row = |y: f64| numbers(min.x, max.x).map(move |x| DVec2::new(x, y));
    let places: Vec<DVec2> = numbers(min.y, max.y).flat_map(row).collect();
    let heights = sag_heights(mirror, &places);
    let found = places.iter().zip(heights).filter_map(|(p, z)| Some([p.x, p.y, z?]));
    found.collect()
}
