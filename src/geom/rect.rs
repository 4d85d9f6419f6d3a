//! Axis-parallel rectangles in the (X, Y) plane.

use super::DVec2;

/// The closed rectangle between two corners, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Lower left corner.
    pub min: DVec2,
    /// Upper right corner.
    pub max: DVec2,
}

impl Rect {
    /// Width and height.
    #[must_use]
    pub fn size(&self) -> DVec2 {
        self.max - self.min
    }

    /// Centre.
    #[must_use]
    pub fn centre(&self) -> DVec2 {
        (self.min + self.max) * 0.5
    }

    /// Width times height, mm^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.size().x * self.size().y
    }

    /// The rectangle reflected in X = 0 (`axis` 0) or Y = 0 (1).
    #[must_use]
    pub fn reflected(&self, axis: usize) -> Self {
        let Self { mut min, mut max } = *self;
        (min[axis], max[axis]) = (-max[axis], -min[axis]);
        Self { min, max }
    }

    /// Whether `p` lies inside or on the rim.
    #[must_use]
    pub fn contains(&self, p: DVec2) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    /// The m + 1 rows of an even grid of (n + 1)(m + 1) points with both rims: each row's Y and its
    /// points, each with its trapezoidal weight (mm^2; the weights sum to the area).
    pub fn grid_rows(&self, n: usize, m: usize) -> impl Iterator<Item = (f64, Vec<(DVec2, f64)>)> {
        let (rect, cell) = (*self, self.area() / (n * m) as f64);
        let end = |k: usize, last: usize| if k == 0 || k == last { 0.5 } else { 1.0 };
        (0..=m).map(move |j| {
            let point = |i: usize| {
                let share = DVec2::new(i as f64 / n as f64, j as f64 / m as f64);
                (rect.min + rect.size() * share, cell * end(i, n) * end(j, m))
            };
            (rect.min.y + rect.size().y * (j as f64 / m as f64), (0..=n).map(point).collect())
        })
    }

    /// The points of [`Rect::grid_rows`], row after row.
    pub fn grid(&self, n: usize, m: usize) -> impl Iterator<Item = (DVec2, f64)> {
        self.grid_rows(n, m).flat_map(|(_, row)| row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_weights_sum_to_the_area_and_reach_the_corners() {
        let rect = Rect { min: DVec2::new(-1.0, 2.0), max: DVec2::new(3.0, 5.0) };
        let grid: Vec<_> = rect.grid(7, 4).collect();
        assert_eq!(grid.len(), 8 * 5);
        assert!((grid.iter().map(|g| g.1).sum::<f64>() - 12.0).abs() < 1e-12);
        assert_eq!((grid[0].0, grid[39].0), (rect.min, rect.max));
    }
}
