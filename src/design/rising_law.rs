//! Laws of a strip that rise by construction: z(m) is the integral of exp(g) for a polynomial g of the isometric
//! latitude m.

use crate::num::quadrature::gauss_legendre;
use crate::num::{exp, legendre};
use crate::optics::TabulatedLaw;

/// Rows where the curl is sampled.
pub(super) const ROWS: usize = 24;
/// Points of the table of a law that is found.
const TABLE_POINTS: usize = 129;

/// One row of the panel where the curl is sampled.
pub(super) struct LatitudeNode {
    /// Isometric latitude m.
    pub m: f64,
    /// Weight of the row in an integral over m.
    pub weight: f64,
    /// P_0, P_1, ... here.
    pub basis: Vec<f64>,
    /// Weights of the rows in the integral over m from the lowest latitude to here.
    pub sums: Vec<f64>,
}

/// Gauss' nodes over the isometric latitudes, one for each row of samples.
pub(super) struct LatitudeNodes {
    /// The two latitudes.
    pub ends: [f64; 2],
    /// The rows, from the lowest latitude on.
    pub rows: Vec<LatitudeNode>,
}

/// Values of a law at the rows.
pub(super) struct LawSamples {
    /// dz/dm.
    pub stretch: Vec<f64>,
    /// z, from 0.
    pub z: Vec<f64>,
    /// z at the highest latitude.
    pub height: f64,
}

impl LatitudeNodes {
    /// Nodes between two isometric latitudes.
    pub(super) fn new(ends: [f64; 2]) -> Self {
        let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
        let (nodes, weights) = gauss_legendre(ROWS);
        let row = |(&t, w): (&f64, f64)| LatitudeNode {
            m: middle + half * t,
            weight: half * w,
            basis: legendre::values(ROWS, t),
            sums: Vec::new(),
        };
        let mut rows = Self { ends, rows: nodes.iter().zip(weights).map(row).collect() };
        for (k, &t) in nodes.iter().enumerate() {
            rows.rows[k].sums = rows.sums(t);
        }
        rows
    }

    /// Weights of the rows in the integral of a polynomial over m from the lowest latitude to `t`
    /// of [-1, 1]: the polynomial's Legendre coefficients by quadrature, and the integral of P_k,
    /// (P_{k+1} - P_{k-1}) / (2k+1).
    fn sums(&self, t: f64) -> Vec<f64> {
        let p = legendre::values(ROWS, t);
        let part = |k: usize| p[k + 1] - if k == 0 { -1.0 } else { p[k - 1] };
        let sum = |row: &LatitudeNode| (0..ROWS).map(|k| row.basis[k] * part(k)).sum::<f64>();
        self.rows.iter().map(|row| 0.5 * row.weight * sum(row)).collect()
    }

    /// The law of `g` at the rows.
    pub(super) fn shape(&self, g: &[f64]) -> LawSamples {
        let stretch: Vec<f64> = self.rows.iter().map(|row| exp(dot(g, &row.basis))).collect();
        let z = self.rows.iter().map(|row| dot(&row.sums, &stretch)).collect();
        let height = self.rows.iter().zip(&stretch).map(|(row, e)| row.weight * e).sum();
        LawSamples { stretch, z, height }
    }

    /// The law of `g` as a table, from z = 0, and its height.
    pub(super) fn table(&self, g: &[f64]) -> Option<(TabulatedLaw, f64)> {
        let stretch = self.shape(g).stretch;
        let share = |k: usize| k as f64 / (TABLE_POINTS - 1) as f64;
        let z: Vec<f64> =
            (0..TABLE_POINTS).map(|k| dot(&self.sums(2.0 * share(k) - 1.0), &stretch)).collect();
        let [low, high] = self.ends;
        let m: Vec<f64> =
            (0..TABLE_POINTS).map(|k| low * (1.0 - share(k)) + high * share(k)).collect();
        Some((TabulatedLaw::from_latitudes(&z, &m)?, z[TABLE_POINTS - 1] - z[0]))
    }
}

/// The sum of the products of as many terms as both have.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
