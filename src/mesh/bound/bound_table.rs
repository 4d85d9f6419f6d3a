//! What the proof knows of the whole mirror beforehand, and looks up for every facet.
//!
//! Where turning about the axis changes nothing, what is known on the X axis is known of the whole
//! mirror, and intervals need only to extend along the radius. Facets are turned to that axis, and
//! what is known there is turned through the angle that the facet takes.

use super::deviation::Triangle;
use super::region::{ImagingProblem, RegionBounds, beyond};
use crate::geom::{DVec2, Rect};
use crate::mirror::{BoundGrid, DerivativeBounds, RadialLegendre, Rings, Surface, UnionBound};
use crate::optics::{ImagingTask, Projection};
use std::sync::OnceLock;

/// Parts of the radius of a round mirror.
const COLUMNS: usize = 192;
/// Sizes of the facets for which each is asked: the least in parts, and how often it is doubled,
/// which is beyond the mirror's diameter.
const LEAST: f64 = 0.125;
const LEVELS: usize = 13;
/// By how much, in shares of the mirror's size, facets are taken to be larger than they are.
const MARGIN: f64 = 1e-6;

/// What is known.
#[derive(Debug, Clone)]
pub enum BoundTable {
    /// Of boxes on a grid.
    Grid {
        /// Of the mirror.
        bounds: BoundGrid<DerivativeBounds>,
        /// Of facets.
        regions: BoundGrid<RegionBounds>,
        /// How far beside facets that is looked up, mm.
        margin: f64,
    },
    /// Of parts of the X axis.
    Axis {
        /// Of the mirror.
        rings: Rings,
        /// Width of a part, mm.
        width: f64,
        /// Of facets, as far as it has been asked for: by size, then by part; the last part is
        /// beyond the rim.
        regions: Vec<OnceLock<RegionBounds>>,
    },
}

/// A facet, or a part of one, where it is looked at.
#[derive(Debug)]
pub struct FacetFrame {
    /// The turn that brought it there.
    pub turn: DVec2,
    /// It.
    pub triangle: Triangle,
    /// Its farthest corner from the axis, mm.
    far: f64,
    /// Cosine and sine of the angle between the X axis and its corners, at most.
    angle: [f64; 2],
}

impl FacetFrame {
    /// Whether what is known of `region` holds for a facet with this gradient of h.
    #[inline]
    pub fn is_known(&self, region: &RegionBounds, gradient: DVec2) -> bool {
        let g = self.turn.rotate(gradient);
        let [cos, sin] = self.angle;
        // All that turning may make of it.
        let (short, beside) = (g * cos, DVec2::new(g.y, g.x).abs() * sin);
        let [least, most] = region.gradient;
        (g.min(short) - beside).cmpge(least).all() && (g.max(short) + beside).cmple(most).all()
    }
}

impl BoundTable {
    /// What is known of the part `part` of the panel.
    pub fn new(sight: &ImagingProblem, part: Rect) -> Self {
        if let Some(round) = round(sight) {
            let width = round.radius[1] / COLUMNS as f64;
            let regions = vec![OnceLock::new(); LEVELS * (COLUMNS + 1)];
            return Self::Axis { rings: Rings::new(round), width, regions };
        }
        let bounds = sight.mirror.surface.bound_grid(part);
        let parts = sight.parts();
        let regions = bounds.map(parts, |part, bounds| {
            if beyond(&sight.mirror.outline, part) {
                RegionBounds::NOTHING
            } else if parts == 1 {
                sight.region(part, bounds, None)
            } else {
                sight.region(part, &sight.narrow(bounds, part), None)
            }
        });
        Self::Grid { bounds, regions, margin: MARGIN * part.size().max_element() }
    }

    /// The triangle with the given corners where it is looked at.
    #[inline]
    pub fn local(&self, corners: [DVec2; 3]) -> FacetFrame {
        let Self::Axis { .. } = self else {
            let triangle = Triangle::new(corners);
            return FacetFrame { turn: DVec2::X, triangle, far: 0.0, angle: [1.0, 0.0] };
        };
        let middle = corners[0] + corners[1] + corners[2];
        let turn = middle.try_normalize().map_or(DVec2::X, |p| DVec2::new(p.x, -p.y));
        let corners = corners.map(|q| turn.rotate(q));
        let triangle = Triangle::new(corners);
        let far = corners.map(DVec2::length_squared).into_iter().fold(0.0, f64::max).sqrt();
        let tangent = corners.map(|q| (q.y / q.x).abs()).into_iter().fold(0.0, f64::max);
        const STEEP: f64 = 1e8;
        let angle = if triangle.reach[0].x > 0.0 && tangent < STEEP {
            let cos = 1.0 / (1.0 + tangent * tangent).sqrt();
            [cos, tangent * cos]
        } else {
            [-1.0, 1.0]
        };
        FacetFrame { turn, triangle, far, angle }
    }

    /// How far beside a triangle what is known of it holds, mm.
    #[inline]
    pub fn margin(&self) -> f64 {
        match self {
            Self::Grid { margin, .. } => *margin,
            Self::Axis { width, .. } => MARGIN * COLUMNS as f64 * width,
        }
    }

    /// Whether second derivatives are known better than a look at a facet tells.
    pub fn is_fine(&self) -> bool {
        matches!(self, Self::Axis { .. })
    }

    /// What is known of a triangle that is (a part of) a facet of the given diameter, and of places
    /// as far beside it as `beside`.
    #[inline]
    pub fn region(
        &self,
        sight: &ImagingProblem,
        local: &FacetFrame,
        diameter: f64,
        beside: f64,
    ) -> RegionBounds {
        let margin = self.margin() + beside;
        let (rings, width, regions) = match self {
            Self::Grid { regions, .. } => {
                let [lo, hi] = local.triangle.reach;
                return regions.over(lo - margin, hi + margin);
            }
            Self::Axis { rings, width, regions } => (rings, *width, regions),
        };
        let margin = margin / width;
        let wanted = diameter / width + margin;
        let level = (0..LEVELS - 1).find(|&level| wanted <= size(level)).unwrap_or(LEVELS - 1);
        let [first, last] =
            [local.triangle.reach[0].x / width - margin, local.far / width + margin]
                .map(|column| (column.max(0.0) as usize).min(COLUMNS));
        let known = |part: usize| {
            let make = || ring(sight, rings, width, part, size(level) * width);
            *regions[level * (COLUMNS + 1) + part].get_or_init(make)
        };
        (first + 1..=last).fold(known(first), |all, k| all.union(known(k))).turned(local.angle)
    }

    /// What is known of the mirror in a box where triangles are looked at.
    pub fn bounds(&self, [lo, hi]: [DVec2; 2]) -> DerivativeBounds {
        match self {
            Self::Grid { bounds, .. } => bounds.over(lo, hi),
            Self::Axis { rings, .. } => rings.bounds(lo, hi),
        }
    }
}

/// What is known of facets of at most some size that begin on part `part` of the X axis.
fn ring(sight: &ImagingProblem, rings: &Rings, width: f64, part: usize, size: f64) -> RegionBounds {
    let x = part as f64 * width;
    let part = [DVec2::new(x, 0.0), DVec2::new(x + width, 0.0)];
    if beyond(&sight.mirror.outline, part) {
        return RegionBounds::NOTHING;
    }
    let bounds = sight.narrow(&rings.bounds(part[0], part[1]), part);
    let wide = [part[0] - size, part[1] + size];
    let around = sight.narrow(&rings.bounds(wide[0], wide[1]), wide);
    sight.region(part, &bounds, Some(&around))
}

/// The largest facets of a level, in widths.
fn size(level: usize) -> f64 {
    LEAST * (1u32 << level) as f64
}

/// The surface, if turning about the axis changes neither it nor what the image must show.
fn round<'a>(sight: &ImagingProblem<'a>) -> Option<&'a RadialLegendre> {
    let radial = |view: &ImagingTask| matches!(view.projection, Projection::Radial { .. });
    match &sight.mirror.surface {
        Surface::Radial(round) if sight.view.is_none_or(radial) => Some(round),
        _ => None,
    }
}
