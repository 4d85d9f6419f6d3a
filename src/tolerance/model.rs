//! The picture of a perturbed system, exact, for plain numbers and with derivatives alike.
//!
//! A sensor pixel's ray through the camera with its errors is taken into the frame of the part,
//! which is shifted, turned and grown; there it meets the designed surface plus the form error (a
//! departure along Z over the part's X and Y), is reflected, and goes back into the world, where
//! the view says which image point the thing it meets belongs to.

use super::field::{Field, cusp};
use super::local::{Fitter, Square, Terms, value};
use super::source::Texture;
use crate::geom::{Chart, DVec2, DVec3};
use crate::mirror::{Mirror, Patches};
use crate::num::Scalar;
use crate::optics::{Camera, View, stereo};
use std::f64::consts::TAU;

/// Numbers that say how mirror and camera are placed.
pub const PLACED: usize = 12;
/// Their order in a [`State`]: shifts (mm), turns about X, Y and the axis (rad), growth;
/// magnification, telecentricity (rad at half the width), principal point (mm), distortion (at
/// half the width).
pub mod placed {
    #![allow(missing_docs)]
    pub const SHIFT: [usize; 3] = [0, 1, 2];
    pub const TURN: [usize; 3] = [3, 4, 5];
    pub const SCALE: usize = 6;
    pub const MAGNIFICATION: usize = 7;
    pub const TELECENTRICITY: usize = 8;
    pub const PRINCIPAL: [usize; 2] = [9, 10];
    pub const DISTORTION: usize = 11;
}

/// What a made system has of each error.
#[derive(Debug, Clone, PartialEq)]
pub struct State<S> {
    /// See [`placed`].
    pub placed: [S; PLACED],
    /// Amplitudes of the form errors, mm.
    pub form: Vec<S>,
    /// Amplitudes of the waviness' cosine and sine, mm, if there is any.
    pub wave: Option<[S; 2]>,
    /// Share of the measured form error, if there is any.
    pub map: Option<S>,
    /// From tool track to track, mm, and where between two tracks the origin lies, in [0, 1), if
    /// there are any.
    pub tracks: Option<[f64; 2]>,
}

/// Part to world: turned by `turn`, after growth, then shifted.
#[derive(Debug, Clone)]
pub struct Pose<S> {
    turn: [[S; 3]; 3],
    shift: [S; 3],
    scale: S,
}

impl<S: Scalar> Pose<S> {
    /// The pose that `placed` says.
    pub fn new(placed: &[S; PLACED]) -> Self {
        let [x, y, z] = placed::TURN.map(|k| placed[k]);
        let (sx, cx, sy, cy, sz, cz) = (x.sin(), x.cos(), y.sin(), y.cos(), z.sin(), z.cos());
        // About X, then Y, then Z.
        let turn = [
            [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
            [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
            [-sy, cy * sx, cy * cx],
        ];
        let shift = placed::SHIFT.map(|k| placed[k]);
        Self { turn, shift, scale: placed[placed::SCALE] + 1.0 }
    }

    fn turned(&self, v: [S; 3]) -> [S; 3] {
        self.turn.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    fn turned_back(&self, v: [S; 3]) -> [S; 3] {
        let m = &self.turn;
        [0, 1, 2].map(|k| m[0][k] * v[0] + m[1][k] * v[1] + m[2][k] * v[2])
    }
}

/// A pixel that sees the mirror, and the mirror there.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Its image point, mm from the axis.
    pub point: DVec2,
    /// The image point where the content that it sees belongs, of the system as designed.
    pub content: DVec2,
    hit: DVec3,
    slope: [f64; 2],
    square: Square,
    /// Whether the polynomials are the surface, to rounding.
    smooth: bool,
    base: Terms<f64>,
    form: Vec<Terms<f64>>,
}

impl Sample {
    /// The polynomial of the designed surface.
    pub(super) fn polynomial(&self) -> &Terms<f64> {
        &self.base
    }

    /// Half the side of the square that it holds on, mm.
    pub(super) fn half(&self) -> f64 {
        self.square.half
    }

    /// The same sample, of which the polynomial is taken even where it is not the surface to
    /// rounding.
    pub(super) fn by_polynomial(&self) -> Self {
        Self { smooth: true, form: Vec::new(), ..self.clone() }
    }
}

/// A designed system and how it can be off.
#[derive(Debug, Clone)]
pub struct System {
    /// The camera, as designed.
    pub camera: Camera,
    /// What the picture should show.
    pub view: View,
    /// Pixels that stand for the picture.
    pub samples: Vec<Sample>,
    mirror: Mirror,
    sag: Chart,
    half_width: f64,
    fields: Vec<Field>,
    wave: [Field; 2],
    tool: Tool,
    map: Option<Patches>,
}

#[derive(Debug, Clone, Copy)]
struct Tool {
    ball: f64,
    way: [f64; 2],
}

/// A polynomial that misses the surface by more than this share of the square's half side is not
/// used: slopes are within some ten times it.
const SMOOTH: f64 = 1e-12;
/// Rounding of heights, as a share of them.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Most steps of Newton's method, and a step, mm, after which the place is known to rounding.
const MOST_STEPS: usize = 40;
const LAST_STEP: f64 = 1e-8;

impl System {
    /// The system of `mirror`, `camera` and `view`, with about `count` samples spread evenly over
    /// the pixels that see the mirror; those are left out from which errors of `reach` mm lead over
    /// the rim or the ridge. `fields` are the form errors.
    #[must_use]
    pub fn new(
        parts: (&Mirror, &Camera, &View),
        fields: Vec<Field>,
        texture: &Texture,
        map: Option<Patches>,
        count: usize,
        reach: f64,
    ) -> Self {
        let (mirror, camera, view) = (parts.0.clone(), *parts.1, parts.2.clone());
        let k = Texture::way(texture.waviness_direction_deg)
            .map(|way| way * TAU / texture.waviness_period_mm);
        let tool = Tool {
            ball: texture.ball_radius_mm,
            way: Texture::way(texture.stepover_direction_deg),
        };
        let sag = Chart { vergence: 0.0, plane_mm: mirror.chart.plane_mm };
        let half_width = 0.5 * camera.pixel_mm * f64::from(camera.pixels[0]);
        let wave = [Field::Cosine(k), Field::Sine(k)];
        let samples = Vec::new();
        let mut system =
            Self { camera, view, samples, mirror, sag, half_width, fields, wave, tool, map };
        system.samples = system.spread(count, reach);
        system
    }

    /// The state without errors.
    #[must_use]
    pub fn perfect<S: Scalar>(&self) -> State<S> {
        let zero = S::constant(0.0);
        State {
            placed: [zero; PLACED],
            form: vec![zero; self.fields.len()],
            wave: None,
            map: None,
            tracks: None,
        }
    }

    /// Slope of the tool's tracks where sample `k` sees the mirror as designed.
    pub(super) fn track_slope(&self, k: usize, tracks: [f64; 2]) -> [f64; 2] {
        let hit = self.samples[k].hit;
        let [_, x, y] = self.tool.cusp(tracks, [hit.x, hit.y]);
        [x, y]
    }

    /// The direction in which tracks follow each other.
    pub(super) fn track_way(&self) -> [f64; 2] {
        self.tool.way
    }

    fn spread(&self, count: usize, reach: f64) -> Vec<Sample> {
        let [width, height] = self.camera.pixels.map(f64::from);
        let places = |spacing: f64| -> Vec<DVec2> {
            let line = |length: f64| -> Vec<f64> {
                let steps = (length / spacing).round().max(1.0);
                let centre = |k: usize| ((k as f64 + 0.5) / steps * length).floor() + 0.5;
                (0..steps as usize).map(centre).collect()
            };
            let (columns, rows) = (line(width), line(height));
            let row = |&y: &f64| {
                let columns = columns.iter();
                columns.map(move |&x| self.camera.image_point(x, y)).collect::<Vec<_>>()
            };
            rows.iter().flat_map(row).filter(|&q| self.sees(q, reach).is_some()).collect()
        };
        let even = |count: f64| (width * height / count).sqrt().max(1.0);
        let tried = even(count as f64);
        let share = places(tried).len() as f64 * tried * tried;
        let spacing = (share / count as f64).sqrt().max(1.0);
        let fitter = Fitter::default();
        places(spacing).into_iter().filter_map(|q| self.sample(&fitter, q, reach)).collect()
    }

    /// Where the image point `q` sees the mirror well inside its rim, as chart coordinates.
    fn sees(&self, q: DVec2, reach: f64) -> Option<DVec2> {
        let place = self.mirror.under(&self.camera.chart, q)?;
        let around = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y, DVec2::ZERO];
        let whole = self.mirror.whole();
        let inside = around.iter().all(|way| {
            let near = place + *way * reach;
            whole.aims(near) && self.mirror.reflects(near) == self.mirror.reflects(place)
        });
        inside.then_some(place)
    }

    fn sample(&self, fitter: &Fitter, point: DVec2, reach: f64) -> Option<Sample> {
        let place = self.sees(point, reach)?;
        let at = self.mirror.row(place.y).at(place.x);
        let hit = self.mirror.place(place, &at);
        let slope = self.mirror.slope(place, &at).to_array();
        let square = Square { centre: [hit.x, hit.y], half: reach };
        let height = |at: [f64; 2]| self.designed(at)[0];
        let base = fitter.fit(&square, height);
        let smooth =
            fitter.off(&base, &square, height) <= SMOOTH * reach + ROUNDING * hit.z.abs().max(1.0);
        let form = |field: &Field| fitter.fit(&square, |at| field.at(at)[0]);
        let form = self.fields.iter().map(form).collect();
        let content = DVec2::ZERO;
        let mut sample = Sample { point, content, hit, slope, square, smooth, base, form };
        let perfect = self.perfect::<f64>();
        let pose = Pose::new(&perfect.placed);
        sample.content = DVec2::from_array(self.content(&sample, &pose, &perfect));
        sample.content.is_finite().then_some(sample)
    }

    /// The designed surface's Z and slope at (X, Y) of the part, with derivatives as the mirror
    /// itself has them.
    fn designed<S: Scalar>(&self, at: [S; 2]) -> [S; 3] {
        let q = DVec2::new(at[0].centre(), at[1].centre());
        let Some(place) = self.mirror.under(&self.sag, q) else {
            return [S::constant(f64::NAN); 3];
        };
        let point = self.mirror.row(place.y).at(place.x);
        let z = self.mirror.place(place, &point).z;
        let slope = self.mirror.slope(place, &point);
        let away = [at[0] - q.x, at[1] - q.y];
        if is_plain::<S>() {
            return [z, slope.x, slope.y].map(S::constant);
        }
        let bend = self.bend(q, place);
        let turned = |k: usize, slope: f64| away[0] * bend[k][0] + away[1] * bend[k][1] + slope;
        [away[0] * slope.x + away[1] * slope.y + z, turned(0, slope.x), turned(1, slope.y)]
    }

    /// The designed surface's second derivatives by X and Y at `q`, whose chart coordinates are
    /// `place`; by differences under a pinhole.
    fn bend(&self, q: DVec2, place: DVec2) -> [[f64; 2]; 2] {
        if self.mirror.chart.vergence == 0.0 {
            let flip = if self.mirror.reflects(place) { -1.0 } else { 1.0 };
            let bend = self.mirror.surface.curvature(DVec2::new(place.x, flip * place.y));
            return [[bend.xx, flip * bend.xy], [flip * bend.xy, bend.yy]];
        }
        const STEP: f64 = 1e-4;
        let slope = |at: DVec2| {
            let [_, x, y] = self.designed(at.to_array());
            DVec2::new(x, y)
        };
        [DVec2::X, DVec2::Y].map(|way| {
            let rise = slope(q + way * STEP) - slope(q - way * STEP);
            (rise / (2.0 * STEP)).to_array()
        })
    }

    /// The measured form error with derivatives.
    fn mapped<S: Scalar>(map: &Patches, at: [S; 2]) -> [S; 3] {
        let q = DVec2::new(at[0].centre(), at[1].centre());
        let (point, bend) = (map.at(q), map.curvature(q));
        let away = [at[0] - q.x, at[1] - q.y];
        [
            away[0] * point.slope.x + away[1] * point.slope.y + point.f,
            away[0] * bend.xx + away[1] * bend.xy + point.slope.x,
            away[0] * bend.xy + away[1] * bend.yy + point.slope.y,
        ]
    }

    /// The image point, mm, where the content belongs that the pixel of `sample` sees. Not finite
    /// where the ray is lost.
    pub fn content<S: Scalar>(&self, sample: &Sample, pose: &Pose<S>, state: &State<S>) -> [S; 2] {
        let mut terms = sample.base.map(S::constant);
        for (a, form) in state.form.iter().zip(&sample.form).filter(|(a, _)| counts(**a)) {
            for (sum, c) in terms.iter_mut().zip(form) {
                *sum = *sum + *a * *c;
            }
        }
        self.seen(sample, pose, state, &terms)
    }

    /// The same of a designed surface and form error that are these polynomials near the sample.
    pub fn seen<S: Scalar>(
        &self,
        sample: &Sample,
        pose: &Pose<S>,
        state: &State<S>,
        terms: &Terms<S>,
    ) -> [S; 2] {
        let surface = |at: [S; 2]| {
            let near = sample.smooth && sample.square.holds(at);
            let mut sum = if near {
                value(terms, &sample.square, at)
            } else {
                let form = state.form.iter().zip(&self.fields).filter(|(a, _)| counts(**a));
                form.fold(self.designed(at), |sum, (a, field)| added(sum, *a, field.at(at)))
            };
            if let Some(wave) = &state.wave {
                for (a, field) in wave.iter().zip(&self.wave) {
                    sum = added(sum, *a, field.at(at));
                }
            }
            if let (Some(map), Some(share)) = (&self.map, state.map) {
                sum = added(sum, share, Self::mapped(map, at));
            }
            if let Some(tracks) = state.tracks {
                sum = added(sum, S::constant(1.0), self.tool.cusp(tracks, at));
            }
            sum
        };
        let (origin, along) = self.ray(sample, &state.placed);
        let from: [S; 3] = std::array::from_fn(|k| origin[k] - pose.shift[k]);
        let from = pose.turned_back(from).map(|x| x / pose.scale);
        let along = pose.turned_back(along);
        let Some((at, slope)) = meet(sample, from, along, surface) else {
            return [S::constant(f64::NAN); 2];
        };
        // d - n (2 d . n / n . n) with n = (-slope, 1).
        let normal = [-slope[0], -slope[1], S::constant(1.0)];
        let across = along[2] - along[0] * slope[0] - along[1] * slope[1];
        let twice = across * 2.0 / (slope[0].square() + slope[1].square() + 1.0);
        let leaving = pose.turned([0, 1, 2].map(|k| along[k] - normal[k] * twice));
        let at = pose.turned(at.map(|x| x * pose.scale));
        let at: [S; 3] = std::array::from_fn(|k| at[k] + pose.shift[k]);
        self.place(sample.point, at, leaving)
    }

    /// The camera's ray through the pixel: a point of it and its direction, of any length.
    fn ray<S: Scalar>(&self, sample: &Sample, placed: &[S; PLACED]) -> ([S; 3], [S; 3]) {
        let q = sample.point;
        let far = q.length_squared() / (self.half_width * self.half_width);
        let grown = placed[placed::MAGNIFICATION] + placed[placed::DISTORTION] * far + 1.0;
        let [px, py] = placed::PRINCIPAL.map(|k| placed[k]);
        let q_off = [grown * q.x + px, grown * q.y + py];
        let Chart { vergence: k, plane_mm } = self.camera.chart;
        let down = S::constant(-1.0);
        if k == 0.0 {
            let lean = placed[placed::TELECENTRICITY] / self.half_width;
            ([q_off[0], q_off[1], S::constant(plane_mm)], [lean * q.x, lean * q.y, down])
        } else {
            let zero = S::constant(0.0);
            ([zero, zero, S::constant(plane_mm + 1.0 / k)], [q_off[0] * k, q_off[1] * k, down])
        }
    }

    /// [`View::locate`] for all kinds of numbers.
    fn place<S: Scalar>(&self, near: DVec2, at: [S; 3], leaving: [S; 3]) -> [S; 2] {
        let flip = if self.view.reflects(near) { -1.0 } else { 1.0 };
        let from = [at[0], at[1] * flip, at[2] - self.view.origin_mm];
        let sigma = stereo::sigma([leaving[0], leaving[1] * flip, leaving[2]]);
        let seen = self.view.target.seen(from, sigma);
        let [x, y] = self.view.projection.locate(seen, DVec2::new(near.x, near.y * flip));
        [x, y * flip]
    }
}

impl Tool {
    fn cusp<S: Scalar>(&self, [stepover, phase]: [f64; 2], at: [S; 2]) -> [S; 3] {
        let across = at[0] * self.way[0] + at[1] * self.way[1];
        let track = (across.centre() / stepover + phase).round() - phase;
        let [height, slope] = cusp(self.ball, across - track * stepover);
        [height, slope * self.way[0], slope * self.way[1]]
    }
}

#[inline]
fn added<S: Scalar>(sum: [S; 3], a: S, [f, x, y]: [S; 3]) -> [S; 3] {
    [sum[0] + a * f, sum[1] + a * x, sum[2] + a * y]
}

/// Whether numbers of this kind carry no derivatives.
fn is_plain<S>() -> bool {
    size_of::<S>() == size_of::<f64>()
}

/// Whether an amplitude makes a difference: a zero may have a derivative.
fn counts<S: Scalar>(a: S) -> bool {
    a.centre() != 0.0 || !is_plain::<S>()
}

/// Where a line meets `surface`, and the slope there: Newton's method from the sample's own hit.
#[inline]
fn meet<S: Scalar>(
    sample: &Sample,
    from: [S; 3],
    along: [S; 3],
    surface: impl Fn([S; 2]) -> [S; 3],
) -> Option<([S; 3], [S; 2])> {
    let (hit, p) = (sample.hit, sample.slope);
    // The tangent plane there.
    let rate = along[2] - along[0] * p[0] - along[1] * p[1];
    let below = from[2] - hit.z - (from[0] - hit.x) * p[0] - (from[1] - hit.y) * p[1];
    let mut t = -below / rate;
    for _ in 0..MOST_STEPS {
        let [x, y, z] = [0, 1, 2].map(|k| from[k] + along[k] * t);
        let [f, f_x, f_y] = surface([x, y]);
        let step = (z - f) / (along[2] - along[0] * f_x - along[1] * f_y);
        t = t - step;
        if step.centre().abs() < LAST_STEP {
            let at = [0, 1, 2].map(|k| from[k] + along[k] * t);
            let [_, f_x, f_y] = surface([at[0], at[1]]);
            return Some((at, [f_x, f_y]));
        }
    }
    None
}
