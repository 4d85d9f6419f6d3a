//! Panels side by side: each is a mirror that is solved for alone, and all are raised or lowered to meet with
//! small steps that shadow little.
//!
//! Under a pinhole a mirror that shows what is far away may be scaled about the entrance pupil, which adds a constant to
//! its height f over the chart and changes nothing of what it shows. A panel's height is therefore free. Where two
//! panels meet, the wall between them lies in a plane through the pupil, so that the camera sees its edge alone.

use super::cause::FailureCause;
use super::facts::{DesignFacts, DividingLineFacts};
use super::layout::{DesignProblem, rectangle_of};
use super::panel_joint::PanelJoint;
use super::surface;
use crate::geom::{DVec2, DividingLine, Outline, Panels, Rect};
use crate::mirror::{Mirror, PanelledSurface, Surface, TensorLegendre};
use crate::num::legendre::Series;
use crate::num::radians;
use crate::num::units::Mm;
use crate::optics::{
    Azimuthal, Camera, FramedView, ImagingTask, PanelledView, Projection, SampledMap, Target,
};
use crate::profile::{Method, PanelSpec, PanelViewSpec, Profile};
use std::sync::Arc;

/// Places along a line between panels at which its picture is compared with the edge that it stands for.
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
    let raised = PanelJoint::new(&camera.chart, &parts, &lines, &sheets)
        .heights()
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
