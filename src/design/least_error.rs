//! The least error that any single mirror has for a camera and a picture, before it is solved for.
//!
//! A mirror is one function f of the image point, and a picture asks for two slopes s at each. With the residual
//! r = grad f - s(q, f) and the twist of the field (the numerator of its curl, docs/theory.md T15), for every test function
//! phi that vanishes along the picture's sides
//!
//! integral of twist phi = -integral of r . psi,  psi = (phi_y + phi s_y,f, -phi_x - phi s_x,f)
//!
//! so that the mean square of J r, the residual carried to the picture, has a lower bound (docs/theory.md, T102). The
//! largest over a space of splines is a linear least-squares problem.

use super::basis::Basis;
use super::residual::{ImageResidual, RayResidual};
use super::residual_sample::{PointwiseResidual, ResidualSample, linearised};
use crate::geom::{DVec2, Rect};
use crate::mirror::Mirror;
use crate::num::degrees;
use crate::optics::{Camera, ImagingTask, Projection};
use crate::parallel;
use glam::DMat2;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Cells along each side of the picture: of the shipped pictures' bounds twice as many raise none by more than 1 %.
const CELLS: usize = 12;
/// Side of the squares that stand for a place's own error, in widths of the frame.
pub const SQUARE: f64 = 0.1;
/// Parts of the picture along each side of which the worst is told.
const PARTS: usize = 3;

/// The least error that any single mirror without steps has, to first order in the error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LeastError {
    /// Root mean square of the pixel error over the picture, pixels: that of every mirror is larger.
    pub pixel_rms_px: f64,
    /// Root mean square of the ray error over the picture, degrees: that of every mirror is larger.
    pub ray_rms_deg: f64,
    /// Where most of the curl is; absent where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst: Option<WorstPart>,
}

/// The ninth of the picture (a third of its width and height) that is the farthest from the slopes of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct WorstPart {
    /// Column and row of the ninth, from 0, from the picture's left and top.
    pub part: [usize; 2],
    /// Root mean square over it of the error that a square there of a tenth of the frame's width has for itself, pixels.
    pub own_px: f64,
    /// The same of the best ninth, pixels.
    pub best_px: f64,
}

impl WorstPart {
    /// The part in words.
    #[must_use]
    pub fn name(&self) -> &'static str {
        const NAMES: [[&str; PARTS]; PARTS] = [
            ["upper left", "top", "upper right"],
            ["left", "middle", "right"],
            ["lower left", "bottom", "lower right"],
        ];
        let [column, row] = self.part;
        NAMES[row.min(PARTS - 1)][column.min(PARTS - 1)]
    }
}

/// Sums over parts of the picture: area (mm^2) and integrals of squares.
#[derive(Default)]
struct Totals {
    area: f64,
    /// Of the image displacement, mm^2 mm^2.
    image: f64,
    /// Of the ray error, mm^2.
    ray: f64,
    /// Area and integral of the squares' own errors (mm^2 mm^2) of each part, row by row.
    parts: [[f64; 2]; PARTS * PARTS],
}

/// Pixels below which a least error is that of rounding and of quadrature.
const EXACT_PX: f64 = 1e-4;

impl LeastError {
    /// Whether a mirror without error exists.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        !(self.pixel_rms_px > EXACT_PX)
    }

    /// The least error for what `view` asks of `camera`, with the heights of `mirror`: where the world is far away they do
    /// not matter. None where the field has no value anywhere.
    #[must_use]
    pub fn of(mirror: &Mirror, camera: &Camera, view: &ImagingTask) -> Option<Self> {
        if let Projection::Radial { .. } = view.projection {
            // A law about the axis has the meridian T18.
            return Some(Self { pixel_rms_px: 0.0, ray_rms_deg: 0.0, worst: None });
        }
        let mut totals = Totals::default();
        for (k, panel) in mirror.panels().iter().enumerate() {
            // The second panel of a folded mirror is the first, reflected.
            if k == 0 || mirror.has_steps() {
                let view = view.of_panel(k);
                Problem { mirror: panel, camera, view: &view }.add_to(&mut totals);
            }
        }
        (totals.area > 0.0).then(|| totals.least(camera))
    }
}

impl Totals {
    fn least(&self, camera: &Camera) -> LeastError {
        let rms = |[area, integral]: [f64; 2]| f64::sqrt(integral / area);
        let px = |integral: f64, area: f64| rms([area, integral]) / camera.pixel_mm;
        let known = self.parts.iter().enumerate().filter(|(_, [area, _])| *area > 0.0);
        let own = |(_, [area, integral]): &(usize, &[f64; 2])| px(*integral, *area);
        let by_own = |a: &(usize, &[f64; 2]), b: &(usize, &[f64; 2])| own(a).total_cmp(&own(b));
        let worst = known.clone().max_by(by_own).zip(known.min_by(by_own));
        let worst = worst.map(|(most, least)| WorstPart {
            part: [most.0 % PARTS, most.0 / PARTS],
            own_px: own(&most),
            best_px: own(&least),
        });
        LeastError {
            pixel_rms_px: px(self.image, self.area),
            ray_rms_deg: degrees(rms([self.area, self.ray])),
            worst: worst.filter(|worst| worst.own_px > 0.0),
        }
    }
}

/// The field of a picture at one image point of a mirror's height.
struct FieldSample {
    /// Chart coordinates, mm.
    q: DVec2,
    /// Height, mm.
    f: f64,
    /// The wanted slope.
    wanted: [f64; 2],
    /// The mirror's slope less that.
    residual: DVec2,
    /// Derivatives of the image point by `q`.
    picture: DMat2,
}

/// Rectangle over which test functions are splines.
#[derive(Clone, Copy, PartialEq)]
enum Domain {
    /// Of the picture, whose sides end it.
    Picture,
    /// Of the chart: the mirror's outline, whose image may be bent.
    Chart,
}

impl Domain {
    /// Derivatives of its coordinates by chart coordinates.
    fn by_chart(self, field: &FieldSample) -> DMat2 {
        match self {
            Self::Picture => field.picture,
            Self::Chart => DMat2::IDENTITY,
        }
    }

    /// Area of the picture over its own.
    fn density(self, field: &FieldSample) -> f64 {
        match self {
            Self::Picture => 1.0,
            Self::Chart => field.picture.determinant().abs(),
        }
    }
}

/// Panel of a mirror, and what it is to show.
struct Problem<'a> {
    mirror: &'a Mirror,
    camera: &'a Camera,
    view: &'a ImagingTask,
}

impl Problem<'_> {
    /// Rectangle that holds the part of the picture that the errors of a design are taken over, mm: the outline's where
    /// the frame does not end it.
    fn area(&self) -> (Domain, Rect) {
        let outline = self.mirror.outline.bounds();
        let (image, frame) = (self.camera.image_of(outline), self.camera.frame());
        let [min, max] = match self.view.is_framed() {
            true => [image.min.max(frame.min), image.max.min(frame.max)],
            false => [image.min, image.max],
        };
        let is_whole = min == image.min && max == image.max;
        match is_whole && self.mirror.chart == self.camera.chart {
            true => (Domain::Chart, outline),
            false => (Domain::Picture, Rect { min, max }),
        }
    }

    /// The field at an image point; none where nothing is wanted or no mirror is.
    fn field_at(&self, image: DVec2) -> Option<FieldSample> {
        let (chart, view) = (&self.camera.chart, self.view);
        let on_chart = self.camera.picture.chart_point(image);
        let (place, point) = self.mirror.point_on_camera_ray(chart, on_chart, chart.plane_mm)?;
        if !(view.projection.wants(image) && self.mirror.outline.aims(place)) {
            return None;
        }
        let (q, f) = chart.coordinates(self.mirror.position(place, &point));
        let wanted = view.field(chart, q.to_array(), f);
        let slope = self.mirror.slope(place, &point).to_array();
        let has = DVec2::from_array(chart.chart_slope(q.to_array(), slope));
        let picture = self.camera.picture.jacobian(q);
        let residual = has - DVec2::from_array(wanted);
        residual.is_finite().then_some(FieldSample { q, f, wanted, residual, picture })
    }

    /// Adds the panel's integrals.
    fn add_to(&self, totals: &mut Totals) {
        let (domain, area) = self.area();
        if !(area.size().min_element() > 0.0) {
            return;
        }
        let places = Basis::cells(area, CELLS);
        let image = |k: usize| match domain {
            Domain::Picture => places.at(k),
            Domain::Chart => self.camera.picture.image_point(places.at(k)),
        };
        let fields = parallel::map(places.len(), 64, |k| self.field_at(image(k)));
        let wanted: Vec<bool> = fields.iter().map(Option::is_some).collect();
        let basis = Basis::splines(area, CELLS, &wanted);
        let Self { camera, view, .. } = *self;
        let chart = &camera.chart;
        totals.image += bound((&basis, domain), &fields, &ImageResidual { chart, view });
        totals.ray += bound((&basis, domain), &fields, &RayResidual { chart, view });
        let frame = camera.frame();
        for (k, field) in fields.iter().enumerate() {
            let Some(field) = field else { continue };
            let weight = basis.weight(k) * domain.density(field);
            totals.area += weight;
            let share = (image(k) - frame.min) / frame.size();
            let third = |share: f64| ((share * PARTS as f64) as usize).min(PARTS - 1);
            let part = third(share.x) + PARTS * third(1.0 - share.y);
            let own = self.own_error_mm(field).unwrap_or(0.0);
            totals.parts[part][0] += weight;
            totals.parts[part][1] += weight * own * own;
        }
    }

    /// The error that a square of [`SQUARE`] of the frame's width around a place has for itself, mm in the picture: the
    /// bound by the test function sin sin of the square, with the field's derivatives of its middle.
    fn own_error_mm(&self, field: &FieldSample) -> Option<f64> {
        let Self { camera, view, .. } = *self;
        let chart = &camera.chart;
        let carry = Carry::of(field, Domain::Picture, &ImageResidual { chart, view })?;
        let twist = view.twist(chart, field.q, field.f) / field.picture.determinant();
        let inverse = carry.inverse_transposed;
        let size = inverse.x_axis.length_squared() + inverse.y_axis.length_squared();
        let side = SQUARE * camera.frame().size().x;
        let own = 8.0 / (PI * PI * PI) * side * twist.abs() / f64::sqrt(size);
        own.is_finite().then_some(own)
    }
}

/// The lower bound of the integral of |J r|^2 over the picture, mm^2 times the square of the unit of `carried`, to first
/// order, where J carries a slope error to what `carried` measures.
fn bound(
    (basis, domain): (&Basis, Domain),
    fields: &[Option<FieldSample>],
    carried: &impl PointwiseResidual<2>,
) -> f64 {
    if basis.unknowns() == 0 {
        return 0.0;
    }
    let row = |(k, field): (usize, &Option<FieldSample>)| {
        Some((k, basis.weight(k), dual_sample(field.as_ref()?, domain, carried)?))
    };
    let samples: Vec<_> = fields.iter().enumerate().filter_map(row).collect();
    let all: f64 = samples.iter().map(|(_, weight, sample)| weight * sample.square()).sum();
    (all - linearised(basis, &samples).residual_squared()).max(0.0)
}

/// The errors that squares of [`SQUARE`] of the frame's width around image points have for themselves whatever the rest
/// of the mirror does, pixels; none where nothing is wanted or no mirror is.
#[must_use]
pub fn own_errors_px(
    mirror: &Mirror,
    camera: &Camera,
    view: &ImagingTask,
    images: &[DVec2],
) -> Vec<Option<f64>> {
    let panels = mirror.panels();
    let views: Vec<ImagingTask> = (0..panels.len()).map(|k| view.of_panel(k)).collect();
    let own = |image: &DVec2| {
        let panel = view.panel_of(*image);
        // A reflected panel has the errors of the designed one.
        let is_reflected = view.reflects(*image);
        let image = if is_reflected { DVec2::new(image.x, -image.y) } else { *image };
        let of = if is_reflected { 0 } else { panel };
        let problem = Problem { mirror: &panels[of], camera, view: &views[of] };
        let field = problem.field_at(image)?;
        Some(problem.own_error_mm(&field)? / camera.pixel_mm)
    };
    images.iter().map(own).collect()
}

/// How a slope error along the axes of a domain is carried to what is measured.
struct Carry {
    /// J^-T, J along the domain's axes.
    inverse_transposed: DMat2,
    /// J along the chart's axes.
    along_chart: DMat2,
    /// Derivative of the wanted slope by the height, along the domain's axes, 1/mm.
    wanted_by_height: DVec2,
}

impl Carry {
    /// At the wanted slope; none where that is not differentiable.
    fn of(
        field: &FieldSample,
        domain: Domain,
        carried: &impl PointwiseResidual<2>,
    ) -> Option<Self> {
        let [x, y] = field.wanted;
        let ResidualSample { by: [a, b], .. } =
            ResidualSample::new(carried, field.q, [field.f, x, y]);
        let along_chart = DMat2::from_cols_array(&[a[1], b[1], a[2], b[2]]);
        let inverse = (along_chart * domain.by_chart(field).transpose()).inverse();
        let wanted_by_height = -(inverse * DVec2::new(a[0], b[0]));
        let inverse_transposed = inverse.transpose();
        let is_known = inverse_transposed.is_finite() && wanted_by_height.is_finite();
        is_known.then_some(Self { inverse_transposed, along_chart, wanted_by_height })
    }
}

/// J^-T psi as a function of (phi, phi_x, phi_y), less J r: the least squares over phi leave what is not bounded. Both carry
/// the root of the picture's area over the domain's, the one divided by it and the other multiplied.
fn dual_sample(
    field: &FieldSample,
    domain: Domain,
    carried: &impl PointwiseResidual<2>,
) -> Option<ResidualSample<2>> {
    let Carry { inverse_transposed: inverse, along_chart, wanted_by_height: by } =
        Carry::of(field, domain, carried)?;
    let root = f64::sqrt(domain.density(field));
    let r = root * (along_chart * field.residual);
    let columns = [inverse * DVec2::new(by.y, -by.x), -inverse.y_axis, inverse.x_axis];
    let by = [0, 1].map(|k| columns.map(|column| column[k] / root));
    Some(ResidualSample { r: r.to_array(), by })
}

#[cfg(test)]
mod tests {
    use super::super::basis::NodeSet;
    use super::super::solve::{SolverOptions, solve};
    use super::*;
    use crate::num::Scalar;

    /// grad F less the field (-y, x) / 2 + (f, -f / 2) `by_height`, whose curl over the plane is 1.
    struct Turning {
        by_height: f64,
    }

    impl PointwiseResidual<2> for Turning {
        fn at<S: Scalar>(&self, q: DVec2, f: S, [x, y]: [S; 2]) -> [S; 2] {
            let k = self.by_height;
            [x - f * k + 0.5 * q.y, y + f * (0.5 * k) - 0.5 * q.x]
        }
    }

    fn least(area: Rect, cells: usize, field: &Turning) -> f64 {
        let places = Basis::cells(area, cells);
        let sample = |k: usize| {
            let q = places.at(k);
            let wanted = [-0.5 * q.y, 0.5 * q.x];
            let (f, picture, residual) = (0.0, DMat2::IDENTITY, -DVec2::from_array(wanted));
            Some(FieldSample { q, f, wanted, residual, picture })
        };
        let fields: Vec<_> = (0..places.len()).map(sample).collect();
        let basis = Basis::splines(area, cells, &vec![true; fields.len()]);
        bound((&basis, Domain::Picture), &fields, field)
    }

    fn rectangle(width: f64, height: f64) -> Rect {
        Rect { min: DVec2::new(1.0, -2.0), max: DVec2::new(1.0 + width, height - 2.0) }
    }

    /// The bound is that of the torsion of a bar of that section: a quarter of its torsion constant (S. Timoshenko and
    /// J. N. Goodier, Theory of Elasticity, section 109: 0.1406 a^4 of a square, 0.229 a^3 b of one twice as long).
    #[test]
    fn a_field_that_turns_evenly_is_the_torsion_of_a_bar() {
        let torsion = |width: f64, height: f64| {
            let (a, b) = (width.min(height), width.max(height));
            let fifth = |x: f64| x * x * x * x * x;
            let term = |n: i32| {
                let n = f64::from(2 * n + 1);
                let e = crate::num::exp(-n * PI * b / a);
                (1.0 - e) / (1.0 + e) / fifth(n)
            };
            let sum: f64 = (0..40).map(term).sum();
            a * a * a * b / 3.0 * (1.0 - 192.0 * a / (fifth(PI) * b) * sum)
        };
        assert!((torsion(1.0, 1.0) - 0.140_577).abs() < 1e-6);
        for [width, height] in [[2.0, 2.0], [2.0, 4.0], [5.0, 3.0]] {
            let exact = 0.25 * torsion(width, height);
            let off = [3, 6, 12].map(|cells| {
                1.0 - least(rectangle(width, height), cells, &Turning { by_height: 0.0 }) / exact
            });
            println!("{width} x {height}: {off:?}");
            assert!(off.iter().all(|off| *off > 0.0), "{off:?}");
            assert!(off[2] < 1e-4, "{off:?}");
            // Splines of degree 2 have an error of the fourth order in the energy.
            assert!(off[0] / off[1] > 10.0 && off[1] / off[2] > 10.0, "{off:?}");
        }
    }

    /// The least integral over polynomials of rising degree comes down to the bound, before near targets too, whose field
    /// depends on the height.
    #[test]
    fn the_bound_and_the_least_squares_meet() {
        for by_height in [0.0, 0.3, -0.8] {
            let field = Turning { by_height };
            let area = rectangle(2.0, 3.0);
            let lower = least(area, 24, &field);
            let upper = [6, 16].map(|degree| {
                let basis = Basis::rectangle(area, [false; 2], degree, NodeSet::Quadrature);
                solve(&basis, &field, &SolverOptions::default()).unwrap().integral
            });
            println!("{by_height}: {lower} {upper:?}");
            assert!(lower < upper[1] && upper[1] < upper[0], "{by_height}: {lower} {upper:?}");
        }
    }
}
