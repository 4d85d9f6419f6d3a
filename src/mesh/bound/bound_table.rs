//! A table of region bounds over the whole mirror, made beforehand and looked up for every facet.
//!
//! Where turning about the axis changes nothing, bounds on the X axis hold for the whole mirror, and intervals need to
//! extend along the radius only. Facets are turned to that axis, and its bounds are turned through the angle that the
//! facet takes.

use super::deviation::Triangle;
use super::imaging_problem::{ImagingProblem, is_outside};
use super::region::RegionBounds;
use super::tuning::TUNING;
use crate::geom::{DVec2, DerivativeBounds, Rect};
use crate::mirror::{BoundGrid, RadialLegendre, Rings, Surface, UnionBound};
use crate::optics::{ImagingTask, Projection};
use std::sync::OnceLock;

/// Region bounds and mirror bounds of one panel.
#[derive(Debug, Clone)]
pub(crate) enum BoundTable {
    /// Over boxes on a grid.
    Grid {
        /// Bounds of the mirror.
        bounds: BoundGrid<DerivativeBounds>,
        /// Bounds for facets.
        regions: BoundGrid<RegionBounds>,
        /// Distance around facets for which these are looked up, mm.
        margin: f64,
    },
    /// Over parts of the X axis of a round mirror.
    Axis {
        /// Bounds of the mirror.
        rings: Rings,
        /// Width of a part, mm.
        width: f64,
        /// Bounds for facets, filled in as they are asked for: by size of the facet, then by part; the last part is
        /// beyond the rim.
        regions: Vec<OnceLock<RegionBounds>>,
    },
}

/// Number of cells of a table to the side of one cell of the mirror's bound grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TableResolution(usize);

impl TableResolution {
    /// The one for a part of about so many facets.
    pub(crate) fn for_facets(problem: &ImagingProblem, facets: f64) -> Self {
        // (The formulas of directions lose little over whole cells, and round mirrors have no grid.)
        if problem.is_direction_only() || axisymmetric_surface(problem).is_some() {
            return Self(1);
        }
        Self(match TUNING.coarser_for_facets.contains(&facets) {
            true => TUNING.coarser_cells_per_grid_cell,
            false => TUNING.cells_per_grid_cell,
        })
    }

    /// The finest one.
    pub(crate) fn finest(problem: &ImagingProblem) -> Self {
        Self::for_facets(problem, f64::INFINITY)
    }
}

/// A facet, or a part of one, in the coordinates in which it is bounded.
#[derive(Debug)]
pub(crate) struct FacetFrame {
    /// Rotation about the axis that brought it there, as cosine and sine.
    pub turn: DVec2,
    /// The turned triangle.
    pub triangle: Triangle,
    /// Distance of its farthest corner from the axis, mm.
    farthest: f64,
    /// Cosine and sine of the largest angle between the X axis and a corner.
    angle: [f64; 2],
}

impl FacetFrame {
    /// Whether the content bounds of `region` hold for a facet with this gradient of h.
    #[inline]
    pub(crate) fn is_covered(&self, region: &RegionBounds, gradient: DVec2) -> bool {
        let g = self.turn.rotate(gradient);
        let [cos, sin] = self.angle;
        // All gradients that turning by up to the angle makes of it.
        let (short, beside) = (g * cos, DVec2::new(g.y, g.x).abs() * sin);
        let [least, most] = region.gradient_box;
        (g.min(short) - beside).cmpge(least).all() && (g.max(short) + beside).cmple(most).all()
    }
}

impl BoundTable {
    /// The table for the part `part` of the panel.
    pub(crate) fn new(problem: &ImagingProblem, part: Rect, resolution: TableResolution) -> Self {
        if let Some(round) = axisymmetric_surface(problem) {
            let width = round.radius[1] / TUNING.axis_columns as f64;
            let regions = vec![OnceLock::new(); TUNING.levels * (TUNING.axis_columns + 1)];
            return Self::Axis { rings: Rings::new(round), width, regions };
        }
        let bounds = problem.mirror.surface.bound_grid(part);
        let TableResolution(parts) = resolution;
        let regions = bounds.map(parts, |part, bounds| {
            if is_outside(&problem.mirror.outline, part) {
                RegionBounds::EMPTY
            } else if parts == 1 {
                problem.region_bounds(part, bounds, None)
            } else {
                problem.region_bounds(part, &problem.narrowed(bounds, part), None)
            }
        });
        Self::Grid { bounds, regions, margin: TUNING.table_margin * part.size().max_element() }
    }

    /// The triangle with the given corners in the coordinates in which it is bounded.
    #[inline]
    pub(crate) fn frame(&self, corners: [DVec2; 3]) -> FacetFrame {
        let Self::Axis { .. } = self else {
            let triangle = Triangle::new(corners);
            return FacetFrame { turn: DVec2::X, triangle, farthest: 0.0, angle: [1.0, 0.0] };
        };
        let middle = corners[0] + corners[1] + corners[2];
        let turn = middle.try_normalize().map_or(DVec2::X, |p| DVec2::new(p.x, -p.y));
        let corners = corners.map(|q| turn.rotate(q));
        let triangle = Triangle::new(corners);
        let farthest = corners.map(DVec2::length_squared).into_iter().fold(0.0, f64::max).sqrt();
        let tangent = corners.map(|q| (q.y / q.x).abs()).into_iter().fold(0.0, f64::max);
        // Beyond this tangent the squares below would lose the angle to rounding.
        const STEEPEST: f64 = 1e8;
        let angle = if triangle.bounding_box[0].x > 0.0 && tangent < STEEPEST {
            let cos = 1.0 / (1.0 + tangent * tangent).sqrt();
            [cos, tangent * cos]
        } else {
            [-1.0, 1.0]
        };
        FacetFrame { turn, triangle, farthest, angle }
    }

    /// Distance around a triangle for which its bounds hold, mm.
    #[inline]
    pub(crate) fn margin(&self) -> f64 {
        match self {
            Self::Grid { margin, .. } => *margin,
            Self::Axis { width, .. } => TUNING.table_margin * TUNING.axis_columns as f64 * width,
        }
    }

    /// Whether the table is along an axis: second derivatives in it are closer than those over the box of one facet.
    pub(crate) fn is_axial(&self) -> bool {
        matches!(self, Self::Axis { .. })
    }

    /// The bounds for a triangle that is (a part of) a facet of the given diameter (mm), and for places around it up to
    /// `beside` mm beyond the margin.
    #[inline]
    pub(crate) fn region(
        &self,
        problem: &ImagingProblem,
        frame: &FacetFrame,
        diameter: f64,
        beside: f64,
    ) -> RegionBounds {
        let margin = self.margin() + beside;
        let (rings, width, regions) = match self {
            Self::Grid { regions, .. } => {
                let [lo, hi] = frame.triangle.bounding_box;
                return regions.over(lo - margin, hi + margin);
            }
            Self::Axis { rings, width, regions } => (rings, *width, regions),
        };
        let columns = TUNING.axis_columns;
        let margin = margin / width;
        let wanted = diameter / width + margin;
        let last_level = TUNING.levels - 1;
        let level =
            (0..last_level).find(|&level| wanted <= level_size(level)).unwrap_or(last_level);
        let [first, last] =
            [frame.triangle.bounding_box[0].x / width - margin, frame.farthest / width + margin]
                .map(|column| (column.max(0.0) as usize).min(columns));
        let known = |part: usize| {
            let make = || axis_region(problem, rings, width, part, level_size(level) * width);
            *regions[level * (columns + 1) + part].get_or_init(make)
        };
        (first + 1..=last).fold(known(first), |all, k| all.union(known(k))).turned(frame.angle)
    }

    /// Bounds of the mirror in a box of the coordinates in which triangles are bounded.
    pub(crate) fn mirror_bounds(&self, [lo, hi]: [DVec2; 2]) -> DerivativeBounds {
        match self {
            Self::Grid { bounds, .. } => bounds.over(lo, hi),
            Self::Axis { rings, .. } => rings.bounds(lo, hi),
        }
    }
}

/// Bounds for facets of at most `size` mm that begin on part `part` of the X axis.
fn axis_region(
    problem: &ImagingProblem,
    rings: &Rings,
    width: f64,
    part: usize,
    size: f64,
) -> RegionBounds {
    let x = part as f64 * width;
    let part = [DVec2::new(x, 0.0), DVec2::new(x + width, 0.0)];
    if is_outside(&problem.mirror.outline, part) {
        return RegionBounds::EMPTY;
    }
    let bounds = problem.narrowed(&rings.bounds(part[0], part[1]), part);
    let wide = [part[0] - size, part[1] + size];
    let around = problem.narrowed(&rings.bounds(wide[0], wide[1]), wide);
    problem.region_bounds(part, &bounds, Some(&around))
}

/// The largest facet diameter of a level, in parts.
fn level_size(level: usize) -> f64 {
    TUNING.finest_level * (1u32 << level) as f64
}

/// The surface, if turning about the axis changes neither it nor what the image must show.
fn axisymmetric_surface<'a>(problem: &ImagingProblem<'a>) -> Option<&'a RadialLegendre> {
    let radial = |view: &ImagingTask| matches!(view.projection, Projection::Radial { .. });
    match &problem.mirror.surface {
        Surface::Radial(round) if problem.view.is_none_or(radial) => Some(round),
        _ => None,
    }
}
