//! The Pareto front: the points that no other beats in every goal.

/// Which points are on the front. A point has a number for each goal, of which less is better; one with a NaN is on no
/// front and beats nothing.
pub(super) fn on_front(points: &[Vec<f64>]) -> Vec<bool> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|k| !points[*k].iter().any(|x| x.is_nan())).collect();
    let compare = |a: &usize, b: &usize| {
        let pairs = points[*a].iter().zip(&points[*b]);
        // (Both zeros are one.)
        let mut orders = pairs.map(|(a, b)| (a + 0.0).total_cmp(&(b + 0.0)));
        orders.find(|order| order.is_ne()).unwrap_or(a.cmp(b))
    };
    order.sort_by(compare);
    let mut is_on = vec![false; points.len()];
    // In this order no point is beaten by a later one.
    let mut front: Vec<usize> = Vec::new();
    for k in order {
        let own = &points[k];
        if own.is_empty() {
            continue;
        }
        // With two goals the last of the front is the best in the second.
        let rivals = if own.len() <= 2 { &front[front.len().saturating_sub(1)..] } else { &front };
        if !rivals.iter().any(|other| beats(&points[*other], own)) {
            is_on[k] = true;
            front.push(k);
        }
    }
    is_on
}

/// Whether `a` is nowhere worse than `b` and somewhere better.
fn beats(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// By the definition, point against point.
        #[test]
        fn the_front_is_what_nothing_beats(
            points in (1_usize..5).prop_flat_map(|goals| {
                let figure = prop_oneof![(0_i32..6).prop_map(f64::from), -1.0..1.0, Just(f64::NAN), Just(0.0), Just(-0.0)];
                proptest::collection::vec(proptest::collection::vec(figure, goals), 0..60)
            }),
        ) {
            let is_known = |k: usize| !points[k].iter().any(|x| x.is_nan());
            for (k, found) in on_front(&points).into_iter().enumerate() {
                let is_beaten = (0..points.len()).any(|other| {
                    let pairs = || points[other].iter().zip(&points[k]);
                    is_known(other) && pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
                });
                prop_assert_eq!(found, is_known(k) && !is_beaten, "{}", k);
            }
        }
    }

    #[test]
    fn without_a_goal_there_is_no_front() {
        assert_eq!(on_front(&[vec![], vec![]]), [false; 2]);
        assert_eq!(on_front(&[vec![2.0], vec![1.0], vec![1.0]]), [false, true, true]);
    }
}
