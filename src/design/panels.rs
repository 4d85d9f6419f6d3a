//! Panels side by side: each is a mirror that is solved for alone, and all are raised or lowered to meet with
//! small steps that shadow little.
//!
//! Under a pinhole a mirror that shows what is far away may be scaled about the entrance pupil, which adds a constant to
//! its height f over the chart and changes nothing of what it shows. A panel's height is therefore free. Before a near target
//! it is as free, but the panel has to be solved for at its height, which its neighbours decide. Where two
//! panels meet, the wall between them lies in a plane through the pupil, so that the camera sees its edge alone.
//! Of panels that are each other's reflections one is solved for.

use super::cause::FailureCause;
use super::faceted_target;
use super::facts::{DesignFacts, DividingLineFacts};
use super::layout::{DesignProblem, is_symmetric, rectangle_of};
use super::panel_joint::PanelJoint;
use super::{MOST_ROUNDS, surface};
use crate::geom::{DVec2, DividingLine, Outline, Panels, Rect};
use crate::mirror::{HeightField, Mirror, PanelledSurface, Surface, TensorLegendre};
use crate::num::legendre::Series;
use crate::num::radians;
use crate::num::units::Mm;
use crate::optics::{
    Azimuthal, Camera, FramedView, ImagingTask, PanelledView, Projection, SampledMap, Target,
};
use crate::parallel;
use crate::profile::{Method, PanelSpec, PanelViewSpec, Profile};
use std::sync::Arc;

/// Change of a panel's height in the last round, as a share of the part's width: nanometres, which displace nothing near.
const HEIGHT_LEFT: f64 = 1e-7;
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
    let target = wanted[0].view.target().clone();
    let panels = PanelProblems { profile, camera, parts: &parts, views: &views, target: &target };
    let (sheets, all_facts) = panels.joined(&lines, method)?;
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
        target,
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

/// Planes of reflection: X = 0 (0), Y = 0 (1), and both.
const REFLECTIONS: [&[usize]; 3] = [&[0], &[1], &[0, 1]];

/// The problems of all panels.
struct PanelProblems<'a> {
    profile: &'a Profile,
    camera: Camera,
    parts: &'a Panels,
    views: &'a [FramedView],
    target: &'a Target,
}

impl PanelProblems<'_> {
    /// The surfaces of all panels, raised to meet, and the figures of each. Before a near target they are solved for anew
    /// until their heights stay, in the order of the first round.
    ///
    /// # Errors
    /// [`FailureCause`] as of [`solved`].
    fn joined(
        &self,
        lines: &[DividingLine],
        method: &Method,
    ) -> Result<(Vec<TensorLegendre>, Vec<DesignFacts>), FailureCause> {
        let mut raised_mm = vec![0.0; self.parts.0.len()];
        let mut order: Option<Vec<usize>> = None;
        let mut last_step_mm = f64::NAN;
        for _ in 0..MOST_ROUNDS {
            let (sheets, facts) = self.sheets(&raised_mm, method)?;
            let joint = PanelJoint::new(&self.camera.chart, self.parts, lines, &sheets);
            let raised = order.as_ref().map_or_else(|| joint.best(), |order| joint.raised(order));
            let raised = raised.ok_or(FailureCause::NotFinite { what: "step between panels" })?;
            let steps = raised.by.iter().zip(&raised_mm).map(|(to, from)| (to - from).abs());
            last_step_mm = steps.fold(0.0, f64::max);
            let is_far = *self.target == Target::Infinity;
            if is_far || last_step_mm <= HEIGHT_LEFT * self.profile.part.width_mm {
                let raise = |(sheet, by): (&TensorLegendre, &f64)| raise(sheet, *by);
                return Ok((sheets.iter().zip(&raised.by).map(raise).collect(), facts));
            }
            (raised_mm, order) = (raised.by, Some(raised.order));
        }
        Err(FailureCause::NotSelfConsistent { rounds: MOST_ROUNDS, last_step_mm })
    }

    /// The surfaces of all panels, as of [`PanelProblems::sheet`], and their figures.
    ///
    /// # Errors
    /// [`FailureCause`] when a panel has no answer.
    fn sheets(
        &self,
        raised_mm: &[f64],
        method: &Method,
    ) -> Result<(Vec<TensorLegendre>, Vec<DesignFacts>), FailureCause> {
        let count = self.parts.0.len();
        let originals: Vec<_> = (0..count).map(|k| self.original(k, raised_mm)).collect();
        let solved = parallel::map(count, 1, |k| {
            let is_own = originals[k].0 == k;
            is_own.then(|| self.sheet(k, raised_mm[k], method)).transpose()
        });
        let solved = solved.into_iter().collect::<Result<Vec<_>, _>>()?;
        let panel = |&(original, axes): &(usize, &[usize])| {
            let (sheet, facts) = solved[original].as_ref().expect("originals are solved for");
            let sheet = axes.iter().fold(sheet.clone(), |sheet, &axis| sheet.reflected(axis));
            (sheet, facts.clone())
        };
        Ok(originals.iter().map(panel).unzip())
    }

    /// The first panel of which panel `k` is the reflection in these planes: itself in none.
    fn original(&self, k: usize, raised_mm: &[f64]) -> (usize, &'static [usize]) {
        let is_far = *self.target == Target::Infinity;
        let found = (0..k).filter(|&j| is_far || raised_mm[j] == raised_mm[k]).find_map(|j| {
            let found = REFLECTIONS.into_iter().find(|axes| self.are_reflections([j, k], axes));
            found.map(|axes| (j, axes))
        });
        found.unwrap_or((k, &[]))
    }

    /// Whether two panels, and all around them, are each other's reflections in these planes.
    fn are_reflections(&self, [j, k]: [usize; 2], axes: &[usize]) -> bool {
        let part = axes.iter().fold(self.parts.0[j], |part, &axis| part.reflected(axis));
        let view = axes.iter().try_fold(self.views[j].clone(), |view, &axis| view.reflected(axis));
        part == self.parts.0[k]
            && view.as_ref() == Some(&self.views[k])
            && axes.iter().all(|&axis| is_symmetric(&self.camera, self.target, axis))
    }

    /// The surface of panel `k` as it is about the reference plane, where it is to be raised by `raised_mm`, and its figures.
    /// Raising it scales it about the entrance pupil, as lowering it scales the target.
    fn sheet(
        &self,
        k: usize,
        raised_mm: f64,
        method: &Method,
    ) -> Result<(TensorLegendre, DesignFacts), FailureCause> {
        let chart = &self.camera.chart;
        let target = match (self.target, chart.pupil()) {
            (Target::Posed(target), Some(pupil)) => {
                let [there, here] =
                    [0.0, raised_mm].map(|f| (chart.point(DVec2::ZERO, f) - pupil).length());
                Target::Posed(target.scaled_about(pupil, there / here))
            }
            (target, _) => target.clone(),
        };
        let view = self.views[k].clone();
        let problem = DesignProblem::framed(self.camera, self.parts.0[k], view, target);
        faceted_target::check(self.profile, &problem)?;
        let (mirror, facts) = surface::solved(&problem, method)?;
        let Surface::Tensor(sheet) = mirror.surface else {
            unreachable!("a rectangle's mirror is a tensor series")
        };
        Ok((sheet, facts))
    }
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
        end.map_or_else(|| camera.line_at(axis, edge, area), |(_, at)| at)
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

/// How far lines between panels are from the edges that they stand for, in the picture of a lens that bends them, or of a camera
/// that leans over the part.
fn dividing_lines(
    camera: &Camera,
    wanted: &[PanelSpec],
    lines: &[DividingLine],
) -> Option<DividingLineFacts> {
    if !camera.picture.is_distorted() && camera.picture.is_over_axis() {
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
