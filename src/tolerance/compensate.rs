//! Adjustment of a system when it is put together or calibrated: the picture is shifted, turned
//! and magnified, the mirror tilted and moved, so that least squares of displacement remain.

use crate::num::max_or_nan;
use crate::tolerance_terms::Criterion;
use serde::{Serialize, Serializer};

/// One direction of adjustment.
#[derive(Debug, Clone, PartialEq)]
pub struct Adjustment {
    /// Its name.
    pub name: &'static str,
    /// The unit it is told in.
    pub unit: &'static str,
    /// Units in one step.
    pub per_step: f64,
    /// Displacement by one step: x and y of each sample, px.
    pub column: Vec<f64>,
}

/// Least-squares adjustment: the projection of displacements on what the adjustments cannot undo.
#[derive(Debug, Clone, Default)]
pub(super) struct Compensation {
    adjustments: Vec<Adjustment>,
    /// Orthonormal columns that span the adjustments.
    basis: Vec<Vec<f64>>,
    /// Upper triangle: column j of the adjustments is the sum of r[j][i] basis[i].
    r: Vec<Vec<f64>>,
}

/// Share of a column's length outside the span of the ones before it, below which it is left out.
const DEPENDENT: f64 = 1e-7;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Compensation {
    /// The projection by these adjustments, without those that the ones before them can do as well.
    #[must_use]
    pub(super) fn new(adjustments: Vec<Adjustment>) -> Self {
        let mut made = Self::default();
        for adjustment in adjustments {
            let mut rest = adjustment.column.clone();
            let mut row = vec![0.0; made.basis.len()];
            let size = dot(&rest, &rest).sqrt();
            // Twice: orthogonal to rounding.
            for _ in 0..2 {
                for (r, basis) in row.iter_mut().zip(&made.basis) {
                    let part = dot(&rest, basis);
                    *r += part;
                    rest.iter_mut().zip(basis).for_each(|(x, b)| *x -= part * b);
                }
            }
            let length = dot(&rest, &rest).sqrt();
            if !(length > DEPENDENT * size) {
                continue;
            }
            rest.iter_mut().for_each(|x| *x /= length);
            row.push(length);
            made.basis.push(rest);
            made.r.push(row);
            made.adjustments.push(adjustment);
        }
        made
    }

    /// The adjustments that are made.
    #[must_use]
    pub(super) fn adjustments(&self) -> &[Adjustment] {
        &self.adjustments
    }

    /// Takes out of `displacement` what adjustments mend, and says how far each was moved for it,
    /// in its unit.
    pub(super) fn apply(&self, displacement: &mut [f64]) -> Vec<f64> {
        let parts: Vec<f64> = self
            .basis
            .iter()
            .map(|basis| {
                let part = dot(displacement, basis);
                displacement.iter_mut().zip(basis).for_each(|(x, b)| *x -= part * b);
                part
            })
            .collect();
        let mut steps = parts;
        for k in (0..steps.len()).rev() {
            let later: f64 = (k + 1..steps.len()).map(|j| self.r[j][k] * steps[j]).sum();
            steps[k] = (steps[k] - later) / self.r[k][k];
        }
        // Against the error.
        steps.iter().zip(&self.adjustments).map(|(x, a)| -x * a.per_step).collect()
    }
}

/// RMS and P95 of a displacement over the samples, px. Infinite where a ray is lost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct DisplacementPx {
    /// Root of the mean square.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub rms_px: f64,
    /// 95th percentile over the samples.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub p95_px: f64,
}

/// A figure, or "lost" where rays are.
///
/// # Errors
/// Whatever the serializer returns.
pub(super) fn or_lost<S: Serializer>(figure: &f64, out: S) -> Result<S::Ok, S::Error> {
    if figure.is_finite() { out.serialize_f64(*figure) } else { out.serialize_str("lost") }
}

/// The JSON Schema of what [`or_lost`] writes.
#[cfg(test)]
pub(super) fn figure_or_lost(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({ "anyOf": [{ "type": "number" }, { "const": "lost" }] })
}

impl DisplacementPx {
    /// The figures of a system that loses rays.
    pub const LOST: Self = Self { rms_px: f64::INFINITY, p95_px: f64::INFINITY };

    /// Whether it loses none.
    #[must_use]
    pub fn kept(&self) -> bool {
        self.rms_px.is_finite()
    }

    /// The figures of a displacement, x and y of each sample; infinite where rays are lost.
    #[must_use]
    pub fn of(displacement: &[f64]) -> Self {
        let square = |d: &[f64]| d[0] * d[0] + d[1] * d[1];
        let mut squares: Vec<f64> = displacement.chunks_exact(2).map(square).collect();
        let rms_px = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        if !rms_px.is_finite() {
            return Self::LOST;
        }
        let rank = ((0.95 * squares.len() as f64).ceil() as usize).saturating_sub(1);
        let p95_px = squares.select_nth_unstable_by(rank, f64::total_cmp).1.sqrt();
        Self { rms_px, p95_px }
    }

    /// The figure of a criterion.
    #[must_use]
    pub fn by(&self, criterion: Criterion) -> f64 {
        match criterion {
            Criterion::Rms => self.rms_px,
            Criterion::P95 => self.p95_px,
        }
    }

    /// The larger of each figure.
    #[must_use]
    pub fn worst(self, other: Self) -> Self {
        let rms_px = max_or_nan(self.rms_px, other.rms_px);
        Self { rms_px, p95_px: max_or_nan(self.p95_px, other.p95_px) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adjustment(column: &[f64]) -> Adjustment {
        Adjustment { name: "one", unit: "px", per_step: 2.0, column: column.to_vec() }
    }

    #[test]
    fn least_squares_remain_and_the_steps_are_told() {
        let columns =
            [[1.0, 0.0, 1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.5, 2.0, 1.0, 4.0], [1.0; 6], [1.0; 6]];
        let made = Compensation::new(columns.iter().map(|c| adjustment(c)).collect());
        assert_eq!(made.adjustments().len(), 3);
        let rest = [1.0, 2.0, -1.0, -5.0, 3.0, 1.0];
        let mut field: Vec<f64> = (0..6)
            .map(|k| 3.0 * columns[0][k] - 2.0 * columns[1][k] + 0.25 * columns[2][k])
            .collect();
        let steps = made.apply(&mut field);
        assert!(field.iter().all(|x| x.abs() < 1e-14), "{field:?}");
        for (step, exact) in steps.iter().zip([-6.0, 4.0, -0.5]) {
            assert!((step - exact).abs() < 1e-13, "{steps:?}");
        }
        let mut field = rest;
        made.apply(&mut field);
        for column in columns {
            assert!(dot(&field, &column).abs() < 1e-13);
        }
    }

    #[test]
    fn figures_are_of_lengths_and_lost_rays_show() {
        let mut field: Vec<f64> =
            (1..=100).flat_map(|k| [0.6 * k as f64, -0.8 * k as f64]).collect();
        let found = DisplacementPx::of(&field);
        assert!((found.p95_px - 95.0).abs() < 1e-12);
        assert!((found.rms_px - 3383.5f64.sqrt()).abs() < 1e-12);
        field[7] = f64::NAN;
        assert_eq!(DisplacementPx::of(&field), DisplacementPx::LOST);
        let json = serde_json::to_string(&DisplacementPx::of(&field)).unwrap();
        assert_eq!(json, r#"{"rms_px":"lost","p95_px":"lost"}"#);
    }
}
