//! Mirrors that can be evaluated: sag, slope, curvature, and bounds of them.
//!
//! A mirror is one designed [`Sheet`] over a rectangle of the part, and, when it is folded, the
//! sheet's reflection in the ridge line Y = 0. Sag is Z in the part frame, mm.

mod bounds;
mod sheet;

pub use bounds::{CellBounds, Cells, Union};
pub use sheet::{Curvature, Point, Sheet, SheetRow};

use crate::geom::{DVec2, DVec3, Rect};

/// A designed mirror in the part frame.
#[derive(Debug, Clone)]
pub struct Mirror {
    /// The designed panel's surface.
    pub sheet: Sheet,
    /// The designed panel's rectangle, mm; corners are single-precision numbers.
    pub panel: Rect,
    /// Whether the panel's reflection in the plane Y = 0, along which it then has an edge, is part
    /// of the mirror.
    pub folded: bool,
    /// Whether the sheet is even in X and the panel symmetric, to the last bit.
    pub even_x: bool,
}

impl Mirror {
    /// The outline of all panels.
    #[must_use]
    pub fn outline(&self) -> Rect {
        if !self.folded {
            return self.panel;
        }
        let reach = self.panel.min.y.abs().max(self.panel.max.y.abs());
        Rect { min: DVec2::new(self.panel.min.x, -reach), max: DVec2::new(self.panel.max.x, reach) }
    }

    /// Whether `q` is on the reflected panel (the ridge belongs to the designed one).
    #[inline]
    #[must_use]
    pub fn reflects(&self, q: DVec2) -> bool {
        self.folded && !(self.panel.min.y <= q.y && q.y <= self.panel.max.y)
    }

    /// Sag and slope on the line of constant `y`, for many values of X. The line through the
    /// ridge takes the designed panel's slope.
    #[must_use]
    pub fn row(&self, y: f64) -> MirrorRow {
        let reflected = self.reflects(DVec2::new(self.panel.min.x, y));
        let sheet = self.sheet.row(if reflected { -y } else { y });
        MirrorRow { sheet, reflected }
    }

    /// Volume between the mirror and the base plane Z = 0, mm^3: the integral of the sag.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let panel = self.sheet.integral(self.panel);
        if self.folded { 2.0 * panel } else { panel }
    }
}

/// A mirror on one line of constant Y.
#[derive(Debug, Clone)]
pub struct MirrorRow {
    sheet: SheetRow,
    reflected: bool,
}

impl MirrorRow {
    /// Sag and slope at `x`.
    #[inline]
    #[must_use]
    pub fn at(&self, x: f64) -> Point {
        let mut point = self.sheet.at(x);
        if self.reflected {
            point.slope.y = -point.slope.y;
        }
        point
    }
}

impl Point {
    /// A normal towards the camera, not of unit length: (-Z_X, -Z_Y, 1).
    #[inline]
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        (-self.slope).extend(1.0)
    }
}
