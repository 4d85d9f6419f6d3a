//! Pieces of patches whose picture in a camera's chart is proven one to one: a ray meets one at most once, where
//! Newton's method leads from anywhere near (docs/theory.md, T121).

use crate::brep::bicubic::{Control, Net, Powers};
use crate::geom::{Chart, DVec2};

/// How far a piece is widened at each end, as a share of its range, before its picture is proven one to one.
pub(super) const WIDENED: f64 = 0.25;
/// How far the derivative may be from the identity, in the sum of a row: each of Newton's steps then leaves at most
/// 2 x 0.15 / (1 - 0.15), a third, of the distance.
const OFF_IDENTITY: f64 = 0.15;
/// Least view scale of a piece: nearer to the pinhole its picture grows without bound.
const LEAST_VIEW_SCALE: f64 = 1e-3;
/// Share of a coordinate by which boxes are enlarged: rounding is far below it.
const MARGIN: f64 = 1e-12;

/// A box in the chart, mm, and a height over its plane that nothing in it passes.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChartBox {
    pub lo: DVec2,
    pub hi: DVec2,
    pub top: f64,
}

impl ChartBox {
    /// The box around control points; `None` where one is behind the pinhole or near it.
    pub(super) fn around<'a>(
        controls: impl Iterator<Item = &'a Control>,
        chart: &Chart,
    ) -> Option<Self> {
        let (mut lo, mut hi) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut top = f64::NEG_INFINITY;
        for &[x, y, up, w] in controls {
            let scale = w - chart.vergence * up;
            if !(w > 0.0 && scale > LEAST_VIEW_SCALE * w) {
                return None;
            }
            let q = DVec2::new(x, y) / scale;
            (lo, hi, top) = (lo.min(q), hi.max(q), top.max(up / w));
        }
        let margin = MARGIN * (1.0 + lo.abs().max(hi.abs()).max_element());
        let (lo, hi) = (lo - DVec2::splat(margin), hi + DVec2::splat(margin));
        Some(Self { lo, hi, top: top + MARGIN * (1.0 + top.abs()) })
    }

    /// Whether two boxes have a place in common.
    #[inline]
    pub(super) fn meets(&self, lo: DVec2, hi: DVec2) -> bool {
        self.lo.x <= hi.x && self.hi.x >= lo.x && self.lo.y <= hi.y && self.hi.y >= lo.y
    }

    #[inline]
    pub(super) fn holds(&self, q: DVec2) -> bool {
        self.meets(q, q)
    }

    pub(super) fn size(&self) -> DVec2 {
        self.hi - self.lo
    }
}

/// What a piece's map is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TileForm {
    /// Heights over a rectangle, whose X goes along u alone and Y along v alone, evenly.
    Heights,
    /// Polynomials: weights are 1.
    Polynomial,
    /// Quotients of polynomials.
    Rational,
}

impl TileForm {
    pub(super) fn of(net: &Net, powers: &Powers) -> Self {
        match net.controls().all(|control| control[3] == 1.0) {
            true if powers.are_heights() => Self::Heights,
            true => Self::Polynomial,
            false => Self::Rational,
        }
    }
}

/// A piece of a patch.
#[derive(Debug, Clone)]
pub(super) struct Tile {
    /// Numbers of the face and of its patch.
    pub face: u32,
    pub patch: u32,
    /// Ranges of the patch's parameters, of those from 0 to 1.
    pub part: [[f64; 2]; 2],
    pub bounds: ChartBox,
    /// Whether its edges leave out some of it.
    pub trimmed: bool,
    /// Whether its normal is that of its derivatives, not the opposite.
    pub same: bool,
    pub form: TileForm,
    pub powers: Powers,
}

impl Tile {
    /// The patch's parameters at those of the tile.
    #[inline]
    pub(super) fn of_patch(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| {
            let [from, to] = self.part[k];
            from + (to - from) * place[k]
        })
    }
}

/// Whether a one to one picture shows the side of the derivatives' normal, or none is proven.
pub(super) fn proven_side(net: &Net, bounds: &ChartBox, chart: &Chart) -> Option<bool> {
    let (middle, half) = (0.5 * (bounds.lo + bounds.hi), 0.5 * bounds.size());
    let [along_u, along_v] = middle_derivatives(net, chart, middle);
    let det = along_u.perp_dot(along_v);
    if det == 0.0 || !det.is_finite() {
        return None;
    }
    // Rows of the inverse derivative at the middle.
    let rows = [DVec2::new(along_v.y, -along_v.x) / det, DVec2::new(-along_u.y, along_u.x) / det];
    let wide = net.over([[-WIDENED, 1.0 + WIDENED]; 2]);
    // (Derivatives by the widened range's own parameters are that much larger.)
    let share = 1.0 / (1.0 + 2.0 * WIDENED);
    let mut off = [DVec2::ZERO; 2];
    let [of_u, of_v] = wide.derivatives();
    let mut add = |axis: usize, [dx, dy, up, dw]: Control| {
        let scale = dw - chart.vergence * up;
        let d = (DVec2::new(dx, dy) - middle * scale) * share;
        let spread = half * (scale * share).abs();
        for (k, row) in rows.iter().enumerate() {
            let wanted = if k == axis { 1.0 } else { 0.0 };
            let away = (row.dot(d) - wanted).abs() + row.abs().dot(spread);
            off[axis][k] = off[axis][k].max(away);
        }
    };
    of_u.for_each(|d| add(0, d));
    of_v.for_each(|d| add(1, d));
    let sums = off[0] + off[1];
    (sums.max_element() <= OFF_IDENTITY).then_some(det > 0.0)
}

/// Derivatives at the middle of the map that is 0 where the chart shows `q`.
fn middle_derivatives(net: &Net, chart: &Chart, q: DVec2) -> [DVec2; 2] {
    let [x, y, up, w] = Powers::of(net).at_one([0.0; 2]);
    [1, 2].map(|k| {
        let scale = w[k] - chart.vergence * up[k];
        DVec2::new(x[k], y[k]) - q * scale
    })
}
