//! The side view, to scale: camera, mirror and the rays at the ends of the picture.

use super::Figure;
use super::drawing::{Drawing, EDGE, PART};
use crate::geom::DVec2;
use crate::render::{PartSection, SideView, ViewRay};
use crate::report::plot::{Anchor, Ink, Stroke};

/// Width of the drawing, units of its letters.
const WIDTH: f64 = 440.0;
/// Heights of the part above which a camera is drawn at the upper edge.
const HIGHEST: f64 = 3.5;

/// The side view; none where the camera sees no mirror in that plane.
pub(in crate::report) fn side_view_figure(view: &SideView) -> Option<Figure> {
    let SideView { section: PartSection { edges, plane }, rays, pupil_mm, mean_mm } = view;
    let points = || edges.iter().flatten().copied();
    let [low, high] = points().map(|at| [at, at]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])?;
    let half = low.x.abs().max(high.x.abs());
    let is_near = |at: &DVec2| at.y < HIGHEST * 2.0 * half;
    let near = pupil_mm.filter(is_near);
    let far = f64::max(high.y + 0.8 * half, 2.0 * half);
    let top = near.map_or(far, |at| at.y.max(high.y));
    let aside = near.map_or(0.0, |at| at.x);
    let corners = [
        DVec2::new((-2.2 * half).min(aside - half), 0.0),
        DVec2::new((2.2 * half).max(aside + half), top),
    ];
    let mut drawing = Drawing::new(corners, WIDTH);
    drawing.lines(PART, edges.iter().map(<[DVec2; 2]>::as_slice));
    draw_rays(&mut drawing, rays, corners);
    draw_camera(&mut drawing, *pupil_mm, top, *mean_mm);
    draw_sizes(&mut drawing, [low, high], plane.along());
    let elevations = rays.iter().map(|ray| ray.elevation_deg);
    let ends = elevations.map(|e| [e, e]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])?;
    let camera = match pupil_mm {
        Some(at) => format!("the lens's entrance pupil at Z {:.2} mm above the base", at.y),
        None => "a telecentric lens, whose rays come parallel to the axis".into(),
    };
    let [least, most] = ends;
    Some(Figure {
        title: "Side view".into(),
        body: drawing.svg("Side view of camera, mirror and extreme rays, to scale"),
        caption: format!(
            "To scale, with {camera}. In this plane the picture shows elevations from {least:.1} to {most:.1} \
             deg; 90 deg is towards the camera."
        ),
    })
}

/// Rays from the camera to the mirror, and on to the drawing's edge with their elevations.
fn draw_rays(drawing: &mut Drawing, rays: &[ViewRay], [low, high]: [DVec2; 2]) {
    for ray in rays {
        let along = ray.direction;
        let to = |edge: f64, from: f64, step: f64| {
            let t = (edge - from) / step;
            if t > 0.0 { t } else { f64::INFINITY }
        };
        let at = ray.at_mm;
        let [x, y] = [
            to(low.x, at.x, along.x).min(to(high.x, at.x, along.x)),
            to(high.y, at.y, along.y).min(to(low.y, at.y, along.y)),
        ];
        let end = at + along * x.min(y);
        if !end.is_finite() {
            continue;
        }
        // From the camera as far down as the drawing goes.
        let share =
            if ray.from_mm.y > high.y { (high.y - at.y) / (ray.from_mm.y - at.y) } else { 1.0 };
        let from = at + (ray.from_mm - at) * share;
        let look = if ray.is_extreme { Stroke::solid } else { Stroke::dashed };
        drawing.lines(look(Ink::Red, 1.0), [&[from, at, end][..]]);
        if ray.is_extreme {
            let anchor = if end.x < 0.5 * (low.x + high.x) { Anchor::Start } else { Anchor::End };
            drawing.text(end, [0.0, -5.0], anchor, &format!("{:.1} deg", ray.elevation_deg));
        }
    }
}

fn draw_camera(drawing: &mut Drawing, pupil_mm: Option<DVec2>, top: f64, mean_mm: f64) {
    let size = drawing.mm(10.0);
    match pupil_mm {
        Some(at) if at.y <= top => {
            let corners = [[-1.0, 0.0], [1.0, 0.0], [1.5, 2.0], [-1.5, 2.0], [-1.0, 0.0]];
            let body = corners.map(|corner| at + DVec2::from_array(corner) * size);
            drawing.lines(EDGE, [&body[..]]);
            // Beside the axis rays leave to the right of it.
            match at.x {
                0.0 => drawing.text(at, [20.0, -8.0], Anchor::Start, "entrance pupil"),
                _ => drawing.text(at, [0.0, -26.0], Anchor::Middle, "entrance pupil"),
            }
            let beside = DVec2::new(-drawing.mm(30.0), 0.0);
            let text = format!("{:.1} mm", at.y - mean_mm);
            drawing.length([DVec2::new(at.x, mean_mm) + beside, at + beside], &text);
        }
        Some(at) => {
            let text =
                format!("entrance pupil {:.1} mm above the mirror's mean height", at.y - mean_mm);
            drawing.text(DVec2::new(0.0, top), [0.0, -16.0], Anchor::Middle, &text);
        }
        None => {
            let at = DVec2::new(0.0, top);
            drawing.text(at, [0.0, -16.0], Anchor::Middle, "telecentric lens");
        }
    }
}

fn draw_sizes(drawing: &mut Drawing, [low, high]: [DVec2; 2], along: &str) {
    let below = DVec2::new(0.0, -drawing.mm(18.0));
    let width = format!("{:.1} mm along {along}", high.x - low.x);
    drawing.length([DVec2::new(low.x, 0.0) + below, DVec2::new(high.x, 0.0) + below], &width);
    let beside = DVec2::new(high.x + drawing.mm(14.0), 0.0);
    drawing.length([beside, beside + DVec2::new(0.0, high.y)], &format!("{:.1} mm", high.y));
}
