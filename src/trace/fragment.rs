//! Fragments: pairs of a facet and a pixel that it may cover, packed.

/// First column and row of a block of pixels, and the negative of those after the last: the span of a
/// facet is the component-wise least of its corners' spans.
pub(super) type PixelSpan = [i16; 4];

/// A facet and a pixel whose centre it may cover, in one 64-bit word, which is written faster than its
/// parts.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Fragment(u64);

impl Fragment {
    /// Step from a pixel to the next in its row, and in its column.
    const RIGHT: u64 = 1;
    const DOWN: u64 = 1 << 16;

    /// The fragment of a facet in a pixel.
    #[inline]
    pub(super) fn new(facet: u32, column: u16, row: u16) -> Self {
        Self(u64::from(facet) << 32 | u64::from(row) << 16 | u64::from(column))
    }

    /// Facet, column and row.
    #[inline]
    pub(super) fn parts(self) -> (u32, u16, u16) {
        ((self.0 >> 32) as u32, self.0 as u16, (self.0 >> 16) as u16)
    }

    /// Fragments of a block of at most 2 x 2 pixels that begins here, row by row: the first `wide` times
    /// `high` of the four. (Sizes are too irregular for branches.)
    #[inline]
    pub(super) fn four(self, wide: usize) -> [Self; 4] {
        let second = if wide == 2 { Self::RIGHT } else { Self::DOWN };
        [0, second, Self::DOWN, Self::DOWN + Self::RIGHT].map(|by| Self(self.0 + by))
    }

    /// The fragment of the same facet so many columns and rows on.
    #[inline]
    pub(super) fn next(self, [columns, rows]: [usize; 2]) -> Self {
        Self(self.0 + columns as u64 * Self::RIGHT + rows as u64 * Self::DOWN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_run_row_by_row_up_to_the_last_ones() {
        let last = i16::MAX as u16;
        let first = Fragment::new(u32::MAX, last - 1, last - 1);
        for (wide, high) in [(1, 1), (2, 1), (1, 2), (2, 2)] {
            let all = (0..high).flat_map(|y| (0..wide).map(move |x| [x, y]));
            for ([x, y], spot) in all.zip(first.four(wide)) {
                let expected = (u32::MAX, last - 1 + x as u16, last - 1 + y as u16);
                assert_eq!(spot.parts(), expected, "{wide} x {high}");
                assert_eq!(first.next([x, y]).parts(), expected);
            }
        }
    }
}
