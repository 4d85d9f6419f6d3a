//! Places of a smooth line one after the other, and the one to expect next.

use super::DVec2;

/// Places of a smooth line at even steps, from the last few of which the next follows.
#[derive(Debug, Clone, Default)]
pub(crate) struct EvenPlaces {
    /// The last one first, and how many there are.
    last: [DVec2; PLACES],
    count: usize,
}

/// Places that are kept: what the polynomial through six lacks of the next falls with the sixth power of the step, to less than a
/// search leaves where a turn, or a mirror's width, has some hundred steps.
const PLACES: usize = 6;
/// The next place over those before it, the last one first, by how many there are: the polynomial through all of them.
const NEXT: [&[f64]; PLACES] = [
    &[1.0],
    &[2.0, -1.0],
    &[3.0, -3.0, 1.0],
    &[4.0, -6.0, 4.0, -1.0],
    &[5.0, -10.0, 10.0, -5.0, 1.0],
    &[6.0, -15.0, 20.0, -15.0, 6.0, -1.0],
];

impl EvenPlaces {
    /// The place that is to be expected; none without one before it.
    pub(crate) fn expected(&self) -> Option<DVec2> {
        let shares = NEXT[self.count.checked_sub(1)?];
        Some(shares.iter().zip(self.last).map(|(share, at)| *share * at).sum())
    }

    /// Adds the place that was found; without one the line ends.
    pub(crate) fn add(&mut self, found: Option<DVec2>) {
        let Some(found) = found else { return *self = Self::default() };
        self.last.rotate_right(1);
        self.last[0] = found;
        self.count = (self.count + 1).min(PLACES);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_place_is_that_of_the_polynomial_through_those_before() {
        let at = |k: usize| {
            let t = k as f64 - 3.0;
            DVec2::new(t * t * t - 2.0 * t, 0.1 * t * t * t * t * t + t)
        };
        let mut places = EvenPlaces::default();
        assert_eq!(places.expected(), None);
        for k in 0..9 {
            places.add(Some(at(k)));
            if k + 1 >= PLACES {
                assert!((places.expected().unwrap() - at(k + 1)).length() < 1e-12, "{k}");
            }
        }
        places.add(None);
        places.add(Some(DVec2::ONE));
        assert_eq!(places.expected(), Some(DVec2::ONE));
        places.add(Some(DVec2::X));
        assert_eq!(places.expected(), Some(DVec2::new(1.0, -1.0)));
    }
}
