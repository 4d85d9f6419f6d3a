//! Where things stand on the paper, and the scale that fits.

use crate::profile::{PaperSize, ViewArrangement};
use crate::sheet::{A3_MM, A4_MM};

/// A rectangle on the paper, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    pub left: f64,
    pub low: f64,
    pub right: f64,
    pub high: f64,
}

impl Area {
    const fn new([left, low]: [f64; 2], [right, high]: [f64; 2]) -> Self {
        Self { left, low, right, high }
    }

    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(super) fn height(&self) -> f64 {
        self.high - self.low
    }

    /// Its middle.
    pub(super) fn middle(&self) -> [f64; 2] {
        [0.5 * (self.left + self.right), 0.5 * (self.low + self.high)]
    }
}

/// A scale of ISO 5455: millimetres of paper to one of the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawingScale {
    paper: u32,
    part: u32,
}

impl DrawingScale {
    /// The factor from the part to the paper.
    #[must_use]
    pub fn factor(self) -> f64 {
        f64::from(self.paper) / f64::from(self.part)
    }

    /// The largest recommended scale up to a factor.
    fn up_to(factor: f64) -> Self {
        let decades = |k: u32| 10u32.pow(k);
        let mut last = Self { paper: 1, part: 500_000_000 };
        for decade in (0..=8).rev() {
            for part in [5, 2, 1].map(|first| first * decades(decade)) {
                let scale = Self { paper: 1, part };
                last = if scale.factor() <= factor { scale } else { last };
            }
        }
        for decade in 0..=3 {
            for paper in [2, 5, 10].map(|first| first * decades(decade)) {
                let scale = Self { paper, part: 1 };
                last = if scale.factor() <= factor { scale } else { last };
            }
        }
        last
    }
}

impl std::fmt::Display for DrawingScale {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.paper, self.part)
    }
}

/// Places of the parts of a drawing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PaperLayout {
    pub size_mm: [f64; 2],
    pub frame: Area,
    pub title: Area,
    /// What is said of the mirror.
    pub surface: Area,
    /// Excerpt of the sag table, and the holes.
    pub tables: Area,
    /// Notes.
    pub notes: Area,
    pub isometric: Area,
    /// The origin of the part's frame in the plan and in both sections.
    pub plan: [f64; 2],
    pub section_y0: [f64; 2],
    pub section_x0: [f64; 2],
    pub scale: DrawingScale,
}

/// Room for dimensions around the views: to the left, between both columns, to the right and between both rows, mm.
const LEFT: f64 = 32.0;
const BETWEEN: f64 = 40.0;
const RIGHT: f64 = 8.0;
const BETWEEN_ROWS: f64 = 40.0;
/// Room of the plan and of the section Y = 0 towards the paper's rim, mm.
const PLAN: f64 = 26.0;
const SECTION: f64 = 16.0;
/// Distances of the isometric view from the others, across and along the paper, where it has no place of its own, mm.
const CORNER: [f64; 2] = [28.0, 10.0];

impl PaperLayout {
    /// The layout of the views of a part of this size whose least X and Y these are, mm, and the largest scale that fits.
    pub(super) fn new(
        paper: PaperSize,
        arrangement: ViewArrangement,
        size: [f64; 3],
        least: [f64; 2],
    ) -> Self {
        let (size_mm, frame, title, surface, tables, notes, views, isometric) = match paper {
            PaperSize::A3 => (
                A3_MM,
                Area::new([20.0, 10.0], [410.0, 287.0]),
                Area::new([230.0, 10.0], [410.0, 58.0]),
                Area::new([232.0, 60.0], [410.0, 106.0]),
                Area::new([23.0, 12.0], [228.0, 92.0]),
                Area::new([294.0, 108.0], [408.0, 172.0]),
                Area::new([20.0, 94.0], [290.0, 287.0]),
                Some(Area::new([294.0, 176.0], [408.0, 282.0])),
            ),
            PaperSize::A4 => (
                A4_MM,
                Area::new([20.0, 10.0], [200.0, 287.0]),
                Area::new([20.0, 10.0], [200.0, 58.0]),
                Area::new([128.0, 60.0], [199.0, 124.0]),
                Area::new([22.0, 60.0], [126.0, 124.0]),
                Area::new([22.0, 126.0], [198.0, 147.0]),
                Area::new([20.0, 148.0], [200.0, 287.0]),
                None,
            ),
        };
        let [x, y, z] = size;
        let across = views.width();
        let fits = [
            (across - LEFT - BETWEEN - RIGHT) / (x + z),
            (views.height() - PLAN - BETWEEN_ROWS - SECTION) / (y + z),
        ];
        let scale = DrawingScale::up_to(fits[0].min(fits[1]));
        let f = scale.factor();
        // What room is left goes between the views and around them.
        let spare_x = (across - LEFT - BETWEEN - RIGHT - (x + z) * f) / 3.0;
        let spare_y = (views.height() - PLAN - BETWEEN_ROWS - SECTION - (y + z) * f) / 3.0;
        let left = views.left + LEFT + spare_x;
        // The plan's lower edge, and that of the section Y = 0.
        let (plan_low, section_low) = match arrangement {
            ViewArrangement::FirstAngle => {
                let low = views.low + PLAN + spare_y;
                (low, low + y * f + BETWEEN_ROWS + spare_y)
            }
            ViewArrangement::ThirdAngle => {
                let low = views.low + SECTION + spare_y;
                (low + z * f + BETWEEN_ROWS + spare_y, low)
            }
        };
        let plan = [left - f * least[0], plan_low - f * least[1]];
        let beside = left + x * f + BETWEEN + spare_x;
        // The base is to the left in the first angle, to the right in the third; the corner is the one that no other view is in.
        let corner_left = left + x * f + CORNER[0];
        let (base, corner) = match arrangement {
            ViewArrangement::FirstAngle => {
                let low = plan_low + y * f + CORNER[1];
                (beside, Area::new([corner_left, low], [views.right, views.high]))
            }
            ViewArrangement::ThirdAngle => {
                let high = plan_low - CORNER[1];
                (beside + z * f, Area::new([corner_left, views.low], [views.right, high]))
            }
        };
        Self {
            size_mm,
            frame,
            title,
            surface,
            tables,
            notes,
            isometric: isometric.unwrap_or(corner),
            plan,
            section_y0: [plan[0], section_low],
            section_x0: [base, plan[1]],
            scale,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_those_of_the_standard() {
        let cases = [
            (1.0, "1:1"),
            (0.99, "1:2"),
            (0.2, "1:5"),
            (0.19, "1:10"),
            (2.7, "2:1"),
            (12.0, "10:1"),
            (1e-3, "1:1000"),
            (4.9e-4, "1:5000"),
        ];
        for (factor, words) in cases {
            assert_eq!(DrawingScale::up_to(factor).to_string(), words, "{factor}");
        }
    }

    #[test]
    fn views_lie_within_the_frame_at_the_largest_scale() {
        for paper in [PaperSize::A3, PaperSize::A4] {
            for arrangement in [ViewArrangement::FirstAngle, ViewArrangement::ThirdAngle] {
                for size in
                    [[60.0, 45.0, 12.0], [1.0, 1.0, 9.0], [1e6, 1e5, 1e6], [80.0, 80.0, 40.0]]
                {
                    let layout = PaperLayout::new(
                        paper,
                        arrangement,
                        size,
                        [-0.5 * size[0], -0.5 * size[1]],
                    );
                    let [x, y, z] = size.map(|mm| mm * layout.scale.factor());
                    let Area { left, right, high, .. } = layout.frame;
                    let [base, plan] = [layout.section_x0[0], layout.plan[0]];
                    let (from, to) = match arrangement {
                        ViewArrangement::FirstAngle => (base, base + z),
                        ViewArrangement::ThirdAngle => (base - z, base),
                    };
                    assert!(plan - 0.5 * x > left && plan + 0.5 * x < from && to < right);
                    let top = (layout.plan[1] + 0.5 * y).max(layout.section_y0[1] + z);
                    assert!(top < high && layout.plan[1] - 0.5 * y > layout.tables.high);
                    assert!(layout.section_y0[1] > layout.tables.high, "{layout:?}");
                }
            }
        }
    }
}
