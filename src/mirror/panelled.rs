//! Surfaces side by side, each over a rectangle of its own, with steps between them.

use super::bounds::BoundCells;
use super::height_field::{HeightAndSlope, HeightField, HeightRow, Hessian};
use super::tensor_legendre::{TensorLegendre, TensorLegendreRow};
use crate::geom::{DVec2, DerivativeBounds, Outline, Panels, Rect};

/// A tensor series for each of the rectangles that tile a rectangle of the chart. On a line between panels it has the height
/// of one of them; derivatives and bounds are those within the panels.
#[derive(Debug, Clone)]
pub struct PanelledSurface {
    /// The rectangles.
    pub parts: Panels,
    /// The surface over each, which goes on beyond it.
    pub sheets: Vec<TensorLegendre>,
}

impl PanelledSurface {
    /// The panel of height `f` at `q`: of those that reach to within `off` of `q`, all in mm, the one of the nearest
    /// height.
    pub(super) fn nearest(&self, q: DVec2, f: f64, off: f64) -> usize {
        let reaches = |k: &usize| Outline::Rect(self.parts.0[*k]).distance_outside(q) <= off;
        let away = |k: usize| (self.sheets[k].height(q) - f).abs();
        let there = (0..self.sheets.len()).filter(reaches);
        there
            .reduce(|a, b| if away(b) < away(a) { b } else { a })
            .unwrap_or_else(|| self.parts.index_of(q))
    }
}

/// A panelled surface on one line of constant y.
#[derive(Debug, Clone)]
pub struct PanelledRow<'a> {
    surface: &'a PanelledSurface,
    y: f64,
    /// The panels on the line, each with its own line.
    panels: Vec<(usize, TensorLegendreRow)>,
}

impl HeightField for PanelledSurface {
    type Row<'a> = PanelledRow<'a>;

    fn row(&self, y: f64) -> PanelledRow<'_> {
        let on_line = |k: &usize| (self.parts.0[*k].min.y..=self.parts.0[*k].max.y).contains(&y);
        let panels = (0..self.sheets.len()).filter(on_line);
        PanelledRow {
            surface: self,
            y,
            panels: panels.map(|k| (k, self.sheets[k].row(y))).collect(),
        }
    }

    fn at(&self, q: DVec2) -> HeightAndSlope {
        self.sheets[self.parts.index_of(q)].at(q)
    }

    fn at_each<const N: usize>(&self, places: [DVec2; N]) -> [HeightAndSlope; N] {
        let panels = places.map(|q| self.parts.index_of(q));
        match panels.iter().all(|panel| *panel == panels[0]) {
            true => self.sheets[panels[0]].at_each(places),
            false => places.map(|q| self.at(q)),
        }
    }

    fn height(&self, q: DVec2) -> f64 {
        self.sheets[self.parts.index_of(q)].height(q)
    }

    fn hessian(&self, q: DVec2) -> Hessian {
        self.sheets[self.parts.index_of(q)].hessian(q)
    }

    fn at_with_hessian(&self, q: DVec2) -> (HeightAndSlope, Hessian) {
        self.sheets[self.parts.index_of(q)].at_with_hessian(q)
    }

    fn reflected(&self, axis: usize) -> Self {
        Self {
            parts: Panels(self.parts.0.iter().map(|part| part.reflected(axis)).collect()),
            sheets: self.sheets.iter().map(|sheet| sheet.reflected(axis)).collect(),
        }
    }

    fn cell_bounds(&self, cells: &BoundCells) -> Vec<DerivativeBounds> {
        let each: Vec<_> = self.sheets.iter().map(|sheet| sheet.cell_bounds(cells)).collect();
        let cell = |k: usize| {
            let [lo, hi] = cells.corners(k);
            let touches = |rect: &Rect| lo.cmple(rect.max).all() && hi.cmpge(rect.min).all();
            let touched = (0..each.len()).filter(|&panel| touches(&self.parts.0[panel]));
            let nearest = self.parts.index_of(0.5 * (lo + hi));
            touched.fold(each[nearest][k], |all, panel| all.union(each[panel][k]))
        };
        (0..cells.count * cells.count).map(cell).collect()
    }

    fn breaks(&self, axis: usize, lo: f64, hi: f64) -> Vec<f64> {
        self.parts.breaks(axis, lo, hi)
    }
}

impl HeightRow for PanelledRow<'_> {
    fn at(&self, x: f64) -> HeightAndSlope {
        let q = DVec2::new(x, self.y);
        let panel = self.surface.parts.index_of(q);
        match self.panels.iter().find(|(k, _)| *k == panel) {
            Some((_, row)) => row.at(x),
            None => self.surface.at(q),
        }
    }

    fn at_each<const N: usize>(&self, xs: [f64; N]) -> [HeightAndSlope; N] {
        let panels = xs.map(|x| self.surface.parts.index_of(DVec2::new(x, self.y)));
        match self.panels.iter().find(|(k, _)| panels.iter().all(|panel| panel == k)) {
            Some((_, row)) => row.at_each(xs),
            None => xs.map(|x| self.at(x)),
        }
    }
}
