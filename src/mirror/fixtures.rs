//! Small mirrors in closed form, for unit tests.

use super::{Mirror, Surface, TensorLegendre};
use crate::geom::{Chart, DVec2, Outline, Rect};
use crate::num::legendre::Series;

/// f = a x^2 + b x y + c y^2 over [-4, 4]^2, under a camera of this vergence.
pub fn quadric(terms: [f64; 3], vergence: f64) -> Mirror {
    sloping([0.0; 2], terms, vergence)
}

/// The same and d x + e y.
pub fn sloping([d, e]: [f64; 2], [a, b, c]: [f64; 3], vergence: f64) -> Mirror {
    let half = DVec2::splat(4.0);
    // x = 4 u, u^2 = (2 P2 + 1) / 3.
    let terms = [
        [16.0 * (a + c) / 3.0, 4.0 * e, 32.0 * c / 3.0],
        [4.0 * d, 16.0 * b, 0.0],
        [32.0 * a / 3.0, 0.0, 0.0],
    ];
    let series = Series::from_fn(3, 3, |i, j| terms[i][j]);
    Mirror {
        surface: Surface::Tensor(TensorLegendre {
            series,
            centre: DVec2::ZERO,
            half,
            scale_mm: 1.0,
        }),
        chart: Chart::on_axis(vergence, 7.0),
        outline: Outline::Rect(Rect { min: -half, max: half }),
        folded: false,
        mirror_symmetric: [false; 2],
    }
}

/// Z = 7 + |Y| tan of an angle over [-4, 4]^2: two panels and their valley.
pub fn roof(degrees: f64) -> Mirror {
    let steep = crate::num::tan(crate::num::radians(degrees));
    let (centre, half) = (DVec2::new(0.0, 2.0), DVec2::new(4.0, 2.0));
    let series = Series::from_fn(1, 2, |_, _| 2.0 * steep);
    Mirror {
        surface: Surface::Tensor(TensorLegendre { series, centre, half, scale_mm: 1.0 }),
        chart: Chart::on_axis(0.0, 7.0),
        outline: Outline::Rect(Rect { min: centre - half, max: centre + half }),
        folded: true,
        mirror_symmetric: [true, false],
    }
}
