//! The points of a study: which value of each axis every point has.

use crate::profile::AxisSpec;
use serde_json::Value as Json;

/// Points in the order of their numbers: the last axis of its own is counted through first.
pub(super) struct Grid<'a> {
    axes: &'a [AxisSpec],
    count: usize,
}

impl<'a> Grid<'a> {
    /// All points of `axes`.
    pub(super) fn new(axes: &'a [AxisSpec]) -> Self {
        let own = axes.iter().filter(|axis| axis.paired_with.is_none());
        Self { axes, count: own.map(|axis| axis.values.len()).product() }
    }

    /// Number of points.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Values of the axes, in their order, at a point.
    pub(super) fn values(&self, point: usize) -> Vec<&'a Json> {
        let (mut left, mut places) = (point, vec![0; self.axes.len()]);
        for (place, axis) in places.iter_mut().zip(self.axes).rev() {
            if axis.paired_with.is_none() {
                *place = left % axis.values.len();
                left /= axis.values.len();
            }
        }
        let value = |(axis, place): (&'a AxisSpec, &usize)| {
            let place = axis.paired_with.map_or(*place, |other| places[other]);
            &axis.values[place]
        };
        self.axes.iter().zip(&places).map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(values: &[i64], paired_with: Option<usize>) -> AxisSpec {
        AxisSpec {
            key: String::new(),
            path: Vec::new(),
            label: None,
            values: values.iter().map(|value| Json::from(*value)).collect(),
            is_logarithmic: false,
            paired_with,
            goal: None,
        }
    }

    #[test]
    fn points_are_those_of_nested_loops() {
        let axes = [
            axis(&[1, 2], None),
            axis(&[10, 20, 30], None),
            axis(&[-1, -2], Some(0)),
            axis(&[5, 6, 7, 8], None),
            axis(&[50, 60, 70, 80], Some(3)),
        ];
        let grid = Grid::new(&axes);
        let mut expected = Vec::new();
        for a in [1, 2] {
            for b in [10, 20, 30] {
                for c in [5, 6, 7, 8] {
                    expected.push([a, b, -a, c, 10 * c]);
                }
            }
        }
        assert_eq!(grid.count(), expected.len());
        for (k, expected) in expected.iter().enumerate() {
            let found: Vec<i64> = grid.values(k).iter().map(|v| v.as_i64().unwrap()).collect();
            assert_eq!(found, expected);
        }
    }
}
