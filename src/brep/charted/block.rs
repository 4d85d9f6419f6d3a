//! A few rows of a few rays, met with the pieces of a body that the chart shows there.

use super::newton::{
    HeightMap, History, MapForm, Met, ORDER, PolynomialMap, RationalMap, extrapolated, newton,
};
use super::tile::{Tile, TileForm};
use crate::brep::bicubic::{ROWS, RowLanes};
use crate::geom::{Chart, DVec2, DVec3};
use crate::num::Lanes;

/// Columns of a block.
pub(super) const COLUMNS: usize = 64;
/// Number of no face.
const NO_FACE: u32 = u32::MAX;

/// Where a ray meets a tile or a plane face: the highest such place so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// Height over the chart's plane, mm.
    pub up: f64,
    pub face: u32,
    /// Normal of any length.
    pub normal: DVec3,
}

/// Chart coordinates of some rays, and what they meet.
pub(super) struct Block {
    /// By column, X and Y of all rows; not numbers where there is no ray.
    rays: [[RowLanes; 2]; COLUMNS],
    /// The boxes around the rays of each column.
    boxes: [[DVec2; 2]; COLUMNS],
    /// Number of columns.
    pub columns: usize,
    /// The box around all.
    pub bounds: [DVec2; 2],
    /// What is found, as in [`Found`]: minus infinity and [`NO_FACE`] where nothing is.
    up: [RowLanes; COLUMNS],
    face: [[u32; ROWS]; COLUMNS],
    normal: [[RowLanes; 3]; COLUMNS],
    /// Number of rays that meet nothing.
    unmet: usize,
}

impl Block {
    /// A block of no rays.
    pub(super) const fn empty() -> Self {
        let zero = Lanes([0.0; ROWS]);
        Self {
            rays: [[zero; 2]; COLUMNS],
            boxes: [[DVec2::ZERO; 2]; COLUMNS],
            columns: 0,
            bounds: [DVec2::ZERO; 2],
            up: [zero; COLUMNS],
            face: [[NO_FACE; ROWS]; COLUMNS],
            normal: [[zero; 3]; COLUMNS],
            unmet: 0,
        }
    }

    /// Makes it the block of rows, from one column on, whose rays meet nothing.
    pub(super) fn begin(&mut self, rows: &[&[DVec2]], first: usize) {
        self.columns = (rows[0].len() - first).min(COLUMNS);
        self.bounds = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        self.unmet = 0;
        for column in 0..self.columns {
            let [mut lo, mut hi] = [DVec2::INFINITY, DVec2::NEG_INFINITY];
            let mut rays = [Lanes([f64::NAN; ROWS]); 2];
            for (k, row) in rows.iter().enumerate() {
                let q = row[first + column];
                (rays[0].0[k], rays[1].0[k]) = (q.x, q.y);
                // (NaN stays out.)
                (lo, hi) = (q.min(lo), q.max(hi));
                self.unmet += usize::from(!q.x.is_nan());
            }
            (self.rays[column], self.boxes[column]) = (rays, [lo, hi]);
            self.bounds = [lo.min(self.bounds[0]), hi.max(self.bounds[1])];
            self.up[column] = Lanes([f64::NEG_INFINITY; ROWS]);
            self.face[column] = [NO_FACE; ROWS];
        }
    }

    /// Chart coordinates of a ray.
    #[inline]
    pub(super) fn ray(&self, column: usize, row: usize) -> DVec2 {
        let [x, y] = &self.rays[column];
        DVec2::new(x.0[row], y.0[row])
    }

    /// What a ray meets; none where it meets nothing.
    #[inline]
    pub(super) fn found(&self, column: usize, row: usize) -> Option<Found> {
        let face = self.face[column][row];
        let normal = self.normal[column];
        let up = self.up[column].0[row];
        let normal = || DVec3::from_array(normal.map(|x| x.0[row]));
        (face != NO_FACE).then(|| Found { up, face, normal: normal() })
    }

    /// Keeps what a ray meets, in place of what was found before.
    pub(super) fn set(&mut self, column: usize, row: usize, found: &Found) {
        self.unmet -= usize::from(self.face[column][row] == NO_FACE);
        self.up[column].0[row] = found.up;
        self.face[column][row] = found.face;
        let normal = found.normal.to_array();
        self.normal[column].iter_mut().zip(normal).for_each(|(lanes, x)| lanes.0[row] = x);
    }

    /// The least height of what rays meet; minus infinity while one meets nothing.
    pub(super) fn lowest(&self) -> f64 {
        if self.unmet > 0 {
            return f64::NEG_INFINITY;
        }
        let all = self.up[..self.columns].iter().zip(&self.face).flat_map(|(up, face)| {
            up.0.iter().zip(face).filter(|(_, face)| **face != NO_FACE).map(|(up, _)| *up)
        });
        all.fold(f64::INFINITY, f64::min)
    }

    /// Meets all rays with a tile; `is_own` tells whether parameters of its patch belong to the face.
    pub(super) fn meet(
        &mut self,
        tile: &Tile,
        chart: &Chart,
        is_own: &mut dyn FnMut([f64; 2], DVec3) -> bool,
    ) {
        match tile.form {
            TileForm::Heights if chart.vergence == 0.0 => {
                self.meet_by(tile, chart, is_own, |_, q| Met::over(&tile.powers, q));
            }
            TileForm::Heights => self.meet_form::<HeightMap>(tile, chart, is_own),
            TileForm::Polynomial => self.meet_form::<PolynomialMap>(tile, chart, is_own),
            TileForm::Rational => self.meet_form::<RationalMap>(tile, chart, is_own),
        }
    }

    /// Meets rays with a tile by Newton's method from where those of the columns before met it.
    fn meet_form<F: MapForm>(
        &mut self,
        tile: &Tile,
        chart: &Chart,
        is_own: &mut dyn FnMut([f64; 2], DVec3) -> bool,
    ) {
        let mut before: History = [[Lanes([0.0; ROWS]); 2]; ORDER];
        let (mut known, mut last) = (0, 0);
        self.meet_by(tile, chart, is_own, |column, q| {
            known = if column == last + 1 { known } else { 0 };
            let met = newton::<F>(tile, chart, q, extrapolated(&before, known));
            before.copy_within(0..ORDER - 1, 1);
            before[0] = met.at;
            (known, last) = ((known + 1).min(ORDER), column);
            met
        });
    }

    /// Meets rays with a tile where the rays of columns near it meet the widened tile.
    #[inline(always)]
    fn meet_by(
        &mut self,
        tile: &Tile,
        chart: &Chart,
        is_own: &mut dyn FnMut([f64; 2], DVec3) -> bool,
        mut met: impl FnMut(usize, [RowLanes; 2]) -> Met,
    ) {
        for column in 0..self.columns {
            let [lo, hi] = self.boxes[column];
            if !tile.bounds.meets(lo, hi) {
                continue;
            }
            let met = met(column, self.rays[column]);
            let mut is_met = met.is_above(&self.up[column]);
            if tile.trimmed {
                let met_rows = is_met.iter_mut().enumerate().filter(|(_, is_met)| **is_met);
                for (row, is_met) in met_rows {
                    let of_patch = tile.of_patch(met.place(row));
                    let up = met.up.0[row];
                    let at = self.ray(column, row) * (1.0 - chart.vergence * up) + chart.lean * up;
                    *is_met = is_own(of_patch, at.extend(up + chart.plane_mm));
                }
            }
            self.keep(column, tile, chart, (&is_met, &met));
        }
    }

    /// Keeps what the rays of a column meet of a tile.
    #[inline(always)]
    fn keep(
        &mut self,
        column: usize,
        tile: &Tile,
        chart: &Chart,
        (is_met, met): (&[bool; ROWS], &Met),
    ) {
        let [x, y, z] = met.normal;
        let sign = if tile.same { 1.0 } else { -1.0 };
        let z = z - (x * chart.lean.x + y * chart.lean.y);
        let normal = [x * sign, y * sign, z * sign];
        let (up, face) = (&mut self.up[column], &mut self.face[column]);
        for n in 0..ROWS {
            self.unmet -= usize::from(is_met[n] & (face[n] == NO_FACE));
            face[n] = if is_met[n] { tile.face } else { face[n] };
            up.0[n] = if is_met[n] { met.up.0[n] } else { up.0[n] };
        }
        for (kept, new) in self.normal[column].iter_mut().zip(normal) {
            for ((kept, new), is_met) in kept.0.iter_mut().zip(new.0).zip(is_met) {
                *kept = if *is_met { new } else { *kept };
            }
        }
    }
}
