//! Things in the order of their numbers.

/// Sorts `items` by a number of each, the least first, in the total order of IEEE 754; those of one number stay in their order.
///
/// What is compiled for every kind of item is its moves alone: a comparison sort of its own would be ten times as large.
pub fn sort_by_number<T>(items: &mut [T], number: impl Fn(&T) -> f64) {
    let mut order = order_of(&items.iter().map(number).collect::<Vec<f64>>());
    // Cycle by cycle: place k takes what was at order[k].
    for start in 0..items.len() {
        let mut to = start;
        while order[to] != start {
            let from = std::mem::replace(&mut order[to], to);
            items.swap(to, from);
            to = from;
        }
        order[to] = to;
    }
}

/// Numbers of the places of `numbers`, by the order of what is there.
fn order_of(numbers: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_by(|&a, &b| numbers[a].total_cmp(&numbers[b]));
    order
}

#[cfg(test)]
mod tests {
    use super::sort_by_number;
    use crate::num::sample::Draws;

    #[test]
    fn items_are_sorted_as_by_a_stable_sort_of_their_own() {
        let mut draws = Draws::new(7);
        for n in 0..60 {
            let mut items: Vec<(f64, usize)> =
                (0..n).map(|k| ((draws.unit() * 9.0).floor() - 4.0, k)).collect();
            items.extend([(f64::NAN, n), (-0.0, n + 1), (0.0, n + 2), (f64::NEG_INFINITY, n + 3)]);
            for sign in [1.0, -1.0] {
                let mut wanted = items.clone();
                wanted.sort_by(|a, b| (sign * a.0).total_cmp(&(sign * b.0)));
                let mut found = items.clone();
                sort_by_number(&mut found, |item| sign * item.0);
                let bits = |all: &[(f64, usize)]| -> Vec<_> {
                    all.iter().map(|item| (item.0.to_bits(), item.1)).collect()
                };
                assert_eq!(bits(&found), bits(&wanted));
            }
        }
    }
}
