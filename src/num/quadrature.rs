//! Gauss-Legendre quadrature on [-1, 1].

use super::cos;

/// Nodes (ascending) and weights of the `n`-point Gauss-Legendre rule on [-1, 1].
///
/// Exact for polynomials up to degree 2n - 1; nodes are exactly symmetric about 0. Newton's
/// method on the three-term recurrence: good to a few ulps for the n < 1000 used here, not meant
/// for larger rules.
#[must_use]
pub fn gauss_legendre(n: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut nodes, mut weights) = (vec![0.0; n], vec![0.0; n]);
    for i in 0..n.div_ceil(2) {
        let mut x = cos(std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5));
        let mut slope = 1.0;
        // Quadratic convergence from a guess good to 1/n^4: six steps reach rounding.
        for _ in 0..6 {
            let (mut p0, mut p1) = (1.0, x);
            for k in 2..=n {
                let k = k as f64;
                (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
            }
            slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
            x -= p1 / slope;
        }
        if n % 2 == 1 && i == n / 2 {
            x = 0.0;
        }
        let weight = 2.0 / ((1.0 - x * x) * slope * slope);
        (nodes[i], nodes[n - 1 - i]) = (-x, x);
        (weights[i], weights[n - 1 - i]) = (weight, weight);
    }
    (nodes, weights)
}

/// Nodes (ascending, both ends among them) and weights of the Clenshaw-Curtis rule with `n` + 1
/// points on [-1, 1].
///
/// Exact for polynomials up to degree n, and for smooth functions nearly as good as Gauss' rule.
/// All weights are positive; nodes are exactly symmetric about 0.
///
/// # Panics
/// When `n` is odd or zero.
#[must_use]
pub fn clenshaw_curtis(n: usize) -> (Vec<f64>, Vec<f64>) {
    assert!(n > 0 && n.is_multiple_of(2), "an even number of steps");
    let (mut nodes, mut weights) = (vec![0.0; n + 1], vec![0.0; n + 1]);
    let turn = |k: usize| cos(std::f64::consts::PI * (k % (2 * n)) as f64 / n as f64);
    for k in 0..=n / 2 {
        let mut sum = 1.0;
        for j in 1..=n / 2 {
            let share = if 2 * j == n { 1.0 } else { 2.0 };
            sum -= share * turn(2 * j * k) / (4 * j * j - 1) as f64;
        }
        let weight = if k == 0 { sum } else { 2.0 * sum } / n as f64;
        let node = if 2 * k == n { 0.0 } else { turn(k) };
        (nodes[k], nodes[n - k]) = (-node, node);
        (weights[k], weights[n - k]) = (weight, weight);
    }
    (nodes, weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_monomials_up_to_its_degree_exactly() {
        for n in [1, 2, 3, 8, 25, 40, 120] {
            let (nodes, weights) = gauss_legendre(n);
            for degree in (0..2 * n).step_by(2) {
                let sum: f64 = nodes
                    .iter()
                    .zip(&weights)
                    .map(|(x, w)| w * (0..degree).fold(1.0, |power, _| power * x))
                    .sum();
                let exact = 2.0 / (degree as f64 + 1.0);
                assert!(
                    (sum - exact).abs() < 4e-14 * exact.max(0.1),
                    "n {n} degree {degree}: {sum} for {exact}"
                );
            }
        }
    }

    #[test]
    fn misses_the_first_degree_beyond() {
        let (nodes, weights) = gauss_legendre(3);
        let sixth: f64 = nodes.iter().zip(&weights).map(|(x, w)| w * x * x * x * x * x * x).sum();
        assert!((sixth - 2.0 / 7.0).abs() > 1e-3);
    }

    #[test]
    fn clenshaw_curtis_is_exact_for_polynomials_and_has_both_ends() {
        for n in [2usize, 4, 10, 40, 200] {
            let (nodes, weights) = clenshaw_curtis(n);
            assert_eq!((nodes[0], nodes[n]), (-1.0, 1.0));
            assert!(nodes.is_sorted() && weights.iter().all(|w| *w > 0.0));
            for degree in 0..=n.min(30) {
                let sum: f64 = nodes
                    .iter()
                    .zip(&weights)
                    .map(|(x, w)| w * (0..degree).fold(1.0, |p, _| p * x))
                    .sum();
                let exact = if degree % 2 == 0 { 2.0 / (degree + 1) as f64 } else { 0.0 };
                assert!((sum - exact).abs() < 1e-14, "{n} {degree}");
            }
        }
    }
}
