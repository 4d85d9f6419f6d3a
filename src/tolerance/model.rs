//! The picture of a perturbed system, exact, for plain numbers and with derivatives alike.
//!
//! A sensor pixel's ray through the camera with its errors is taken into the frame of the part,
//! which is shifted, turned and grown; there it meets the designed surface plus the form error (a
//! departure along Z over the part's X and Y), is reflected, and goes back into the world, where
//! the view says which image point the thing it meets belongs to.

mod ball_cutter;
mod surface_departure;

use super::error_source::TextureShape;
use super::footprint::Footprint;
use super::form_field::{FormField, ripple};
use super::local_polynomial::{ExpansionSquare, terms, value, values};
use super::sampling::FORM_TERMS;
use super::work_counts::{WorkCounter, WorkCounts, WorkKind};
use crate::geom::{Chart, DVec2, DVec3};
use crate::mirror::{BicubicSpline, Mirror};
use crate::num::{Dual, Scalar};
use crate::optics::{Camera, ImagingTask, stereographic};
use ball_cutter::BallCutter;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Numbers that say how mirror and camera are placed.
pub const PLACED: usize = 12;
/// Their order in a [`PerturbedState`]: shifts (mm), turns about X, Y and the axis (rad), growth;
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
pub struct PerturbedState<S> {
    /// See [`placed`].
    pub placed: [S; PLACED],
    /// Amplitudes of the form errors, mm.
    pub form: Vec<f64>,
    /// Amplitudes of the waviness' cosine and sine, mm, if there is any.
    pub wave: Option<[f64; 2]>,
    /// Share of the measured form error, if there is any.
    pub map: Option<f64>,
    /// From tool track to track, mm, and where between two tracks the origin lies, in [0, 1), if
    /// there are any.
    pub tracks: Option<[f64; 2]>,
    /// Share of the light that flat terraces reflect, 0 to 1.
    pub terraced: f64,
}

impl PerturbedState<f64> {
    /// Whether mirror and rays are as designed.
    pub fn is_perfect(&self) -> bool {
        let none = |x: f64| x == 0.0;
        self.placed.into_iter().all(none)
            && self.form.iter().copied().all(none)
            && self.wave.into_iter().flatten().all(none)
            && self.map.is_none_or(none)
            && self.tracks.is_none()
            && none(self.terraced)
    }
}

/// Part to world: turned by `turn`, after growth, then shifted.
#[derive(Debug, Clone)]
pub struct PartPose<S> {
    turn: [[S; 3]; 3],
    shift: [S; 3],
    scale: S,
}

impl<S: Scalar> PartPose<S> {
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

    pub(super) fn turned(&self, v: [S; 3]) -> [S; 3] {
        self.turn.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    pub(super) fn turned_back(&self, v: [S; 3]) -> [S; 3] {
        let m = &self.turn;
        [0, 1, 2].map(|k| m[0][k] * v[0] + m[1][k] * v[1] + m[2][k] * v[2])
    }
}

/// What textures look like where a pixel sees the mirror.
#[derive(Debug, Clone, Copy)]
pub struct TextureSite {
    /// Curvature that the tool's tracks have there, 1/mm.
    pub groove: f64,
    /// What the pixel sees of it: the mean of a texture over this.
    pub footprint: Footprint,
}

/// A pixel that sees the mirror, and the mirror there.
#[derive(Debug, Clone)]
pub struct PixelSample {
    /// Its image point, mm from the axis.
    pub point: DVec2,
    /// The image point where the content that it sees belongs, of the system as designed.
    pub content: DVec2,
    /// Which panel it sees.
    pub(super) panel: usize,
    pub(super) hit: DVec3,
    pub(super) slope: [f64; 2],
    pub(super) square: ExpansionSquare,
    pub(super) site: TextureSite,
    /// Height and slopes of the designed surface: degree and coefficients of polynomials, where
    /// these are it to rounding. (Derivatives of the height's would have its rounding magnified.)
    pub(super) base: Option<(usize, Vec<[f64; 3]>)>,
    /// Coefficients of the form errors, one after the other, all of [`OpticalSystem::form_degree`]; none
    /// where that is not enough.
    pub(super) form: Vec<f64>,
}

/// A designed system and how it can be off.
#[derive(Debug, Clone)]
pub struct OpticalSystem {
    /// The camera, as designed.
    pub camera: Camera,
    /// What the picture should show.
    pub view: ImagingTask,
    /// Places of the picture that stand for all of it, each for an area as large as the others'.
    pub samples: Vec<PixelSample>,
    /// Share of the picture of the mirror that they stand for: where they see the target.
    pub share: f64,
    pub(super) mirror: Mirror,
    /// Its panels, each of which goes on beyond the ridge.
    pub(super) panels: Vec<Mirror>,
    sag: Chart,
    half_width: f64,
    /// How far from its own hit, mm along X and along Y, a sample's ray is followed.
    farthest: f64,
    pub(super) fields: Vec<FormField>,
    pub(super) form_degree: usize,
    /// Wave vector of the waviness, 1/mm.
    wave: [f64; 2],
    tool: BallCutter,
    map: Option<BicubicSpline>,
    /// Of this system and all that are made of it.
    pub(super) counter: Arc<WorkCounter>,
}

/// Most steps of Newton's method, and a step, mm, after which the place is known to rounding.
const MOST_STEPS: usize = 40;
const LAST_STEP: f64 = 1e-8;

impl OpticalSystem {
    /// The system of `mirror`, `camera` and `view`, with about `count` samples spread evenly over
    /// the picture of the mirror; hits move by about `reach` mm. `fields` are the form errors.
    #[must_use]
    pub fn new(
        parts: (&Mirror, &Camera, &ImagingTask),
        fields: Vec<FormField>,
        texture: &TextureShape,
        map: Option<BicubicSpline>,
        count: usize,
        reach: f64,
    ) -> Self {
        let (mirror, camera, view) = (parts.0.clone(), *parts.1, parts.2.clone());
        let wave = TextureShape::way(texture.waviness_direction_deg)
            .map(|way| way * TAU / texture.waviness_period_mm);
        let tool = BallCutter {
            ball: texture.ball_radius_mm,
            way: TextureShape::way(texture.stepover_direction_deg),
        };
        let sag = Chart { vergence: 0.0, plane_mm: mirror.chart.plane_mm };
        let half_width = 0.5 * camera.pixel_mm * f64::from(camera.pixels[0]);
        let farthest = mirror.full_outline().bounds().size().max_element();
        let mut system = Self {
            camera,
            view,
            samples: Vec::new(),
            share: 0.0,
            panels: mirror.panels(),
            mirror,
            sag,
            half_width,
            farthest,
            fields,
            form_degree: 0,
            wave,
            tool,
            map,
            counter: Arc::default(),
        };
        (system.samples, system.share) = system.spread(count, reach);
        system.expand_forms();
        system
    }

    /// The same with other samples, without polynomials of the form errors.
    pub(super) fn with(&self, samples: Vec<PixelSample>) -> Self {
        Self {
            view: self.view.clone(),
            samples,
            mirror: self.mirror.clone(),
            panels: self.panels.clone(),
            fields: self.fields.clone(),
            form_degree: 0,
            map: self.map.clone(),
            counter: Arc::clone(&self.counter),
            ..*self
        }
    }

    /// The state without errors.
    #[must_use]
    pub fn perfect<S: Scalar>(&self) -> PerturbedState<S> {
        let zero = S::constant(0.0);
        PerturbedState {
            placed: [zero; PLACED],
            form: vec![0.0; self.fields.len()],
            wave: None,
            map: None,
            tracks: None,
            terraced: 0.0,
        }
    }

    /// Z and slope of the designed surface of `mirror`, the whole one or a panel, at (X, Y) of the
    /// part, near the height `z_mm`, with derivatives as the mirror itself has them.
    pub(super) fn designed<S: Scalar>(&self, mirror: &Mirror, at: [S; 2], z_mm: f64) -> [S; 3] {
        let q = DVec2::new(at[0].mid(), at[1].mid());
        let Some(place) = mirror.intersect_camera_ray_near(&self.sag, q, z_mm) else {
            return [S::constant(f64::NAN); 3];
        };
        let point = mirror.row(place.y).at(place.x);
        let slope = mirror.slope(place, &point);
        // What Newton's method left of the way to q.
        let found = mirror.position(place, &point);
        let z = found.z + slope.dot(q - found.truncate());
        let away = [at[0] - q.x, at[1] - q.y];
        if is_plain::<S>() {
            return [z, slope.x, slope.y].map(S::constant);
        }
        let bend = self.bend(mirror, q, place, z_mm);
        let turned = |k: usize, slope: f64| away[0] * bend[k][0] + away[1] * bend[k][1] + slope;
        [away[0] * slope.x + away[1] * slope.y + z, turned(0, slope.x), turned(1, slope.y)]
    }

    /// The designed surface's second derivatives by X and Y at `q`, whose chart coordinates are
    /// `place`; by differences under a pinhole.
    fn bend(&self, mirror: &Mirror, q: DVec2, place: DVec2, z_mm: f64) -> [[f64; 2]; 2] {
        if mirror.chart.vergence == 0.0 {
            let flip = if mirror.reflects(place) { -1.0 } else { 1.0 };
            let bend = mirror.surface.hessian(DVec2::new(place.x, flip * place.y));
            return [[bend.xx, flip * bend.xy], [flip * bend.xy, bend.yy]];
        }
        const STEP: f64 = 1e-4;
        let slope = |at: DVec2| {
            let [_, x, y] = self.designed(mirror, at.to_array(), z_mm);
            DVec2::new(x, y)
        };
        [DVec2::X, DVec2::Y].map(|way| {
            let rise = slope(q + way * STEP) - slope(q - way * STEP);
            (rise / (2.0 * STEP)).to_array()
        })
    }

    /// Curvature of the tool's tracks at a place of the part, 1/mm; not a number off the mirror.
    pub(super) fn groove(&self, mirror: &Mirror, at: DVec3) -> f64 {
        let q = at.truncate();
        let Some(place) = mirror.intersect_camera_ray_near(&self.sag, q, at.z) else {
            return f64::NAN;
        };
        let slope = mirror.slope(place, &mirror.row(place.y).at(place.x));
        self.tool.curvature(slope.to_array(), self.bend(mirror, q, place, at.z))
    }

    /// The image point, mm, where the content belongs that the pixel of `sample` sees. Not finite
    /// where the ray is lost: it does not meet the surface, which goes on beyond the rim, within the
    /// mirror's size of where it does as designed, or terraces reflect most of the light.
    pub fn content<S: Scalar>(
        &self,
        sample: &PixelSample,
        pose: &PartPose<S>,
        state: &PerturbedState<S>,
        work: &mut WorkCounts,
    ) -> [S; 2] {
        work.count(WorkKind::Rays, [1, 0]);
        let mut sum = [0.0; FORM_TERMS];
        let count = terms(self.form_degree);
        if sample.form.is_empty() {
            let forms = |at: [S; 2]| self.forms(&state.form, &sample.site.footprint, at);
            let zeros = state.form.iter().filter(|a| **a == 0.0).count();
            work.count(WorkKind::Forms, [state.form.len() - zeros, zeros]);
            return self.seen(sample, pose, state, work, forms);
        }
        let sum = &mut sum[..count];
        // Four at a time: the sum is fetched less often.
        let (fours, rest) = state.form.as_chunks::<4>();
        let mut forms = sample.form.chunks_exact(4 * count);
        let mut avoided = 0;
        for (four @ [a, b, c, d], forms) in fours.iter().zip(&mut forms) {
            // Most errors alone have none.
            if *four == [0.0; 4] {
                avoided += 4;
                continue;
            }
            let (ab, cd) = forms.split_at(2 * count);
            let ((p, q), (r, s)) = (ab.split_at(count), cd.split_at(count));
            let columns = p.iter().zip(q).zip(r.iter().zip(s));
            for (sum, ((p, q), (r, s))) in sum.iter_mut().zip(columns) {
                *sum += (a * p + b * q) + (c * r + d * s);
            }
        }
        for (a, form) in rest.iter().zip(forms.remainder().chunks_exact(count)) {
            sum.iter_mut().zip(form).for_each(|(sum, c)| *sum += a * c);
        }
        work.count(WorkKind::Forms, [state.form.len() - avoided, avoided]);
        let (degree, sum) = (self.form_degree, &*sum);
        self.seen(sample, pose, state, work, |at| {
            if sample.square.holds(at) {
                value(degree, sum, &sample.square, at)
            } else {
                self.forms(&state.form, &sample.site.footprint, at)
            }
        })
    }

    /// How content moves, mm, with a height of 1 mm and a slope of 1 along X and along Y added to
    /// the designed surface where `sample` sees it: x and y of each.
    pub(super) fn by_form(&self, sample: &PixelSample, work: &mut WorkCounts) -> [[f64; 2]; 3] {
        let state = self.perfect::<Dual<3>>();
        let pose = PartPose::new(&state.placed);
        let plane = [0, 1, 2].map(|k| Dual::<3>::variable(0.0, k));
        work.count(WorkKind::Rays, [1, 0]);
        let [x, y] = self.seen(sample, &pose, &state, work, |at| {
            let [dx, dy] = [at[0] - sample.hit.x, at[1] - sample.hit.y];
            [plane[0] + plane[1] * dx + plane[2] * dy, plane[1], plane[2]]
        });
        [0, 1, 2].map(|k| [x.slope[k], y.slope[k]])
    }

    /// Height and slopes, where `sample` sees the designed surface, of a unit of each form error,
    /// of the waviness' cosine and sine, and of the measured form error if there is one.
    pub(super) fn form_units(&self, sample: &PixelSample) -> Vec<[f64; 3]> {
        let at = [sample.hit.x, sample.hit.y];
        let footprint = &sample.site.footprint;
        let forms = self.fields.iter().map(|field| {
            let seen = field.seen(footprint);
            field.at(at).map(|x| seen * x)
        });
        let seen = footprint.ripple(self.wave);
        let waves = [[seen, 0.0], [0.0, seen]].map(|a| ripple(self.wave, a, at));
        forms.chain(waves).chain(self.map.as_ref().map(|map| Self::mapped(map, at))).collect()
    }

    /// The same content, with form errors that are `form`.
    fn seen<S: Scalar>(
        &self,
        sample: &PixelSample,
        pose: &PartPose<S>,
        state: &PerturbedState<S>,
        work: &mut WorkCounts,
        form: impl Fn([S; 2]) -> [S; 3],
    ) -> [S; 2] {
        let surface = |at: [S; 2]| {
            let designed = match &sample.base {
                Some((degree, c)) if sample.square.holds(at) => {
                    work.count(WorkKind::Surface, [0, 1]);
                    values(*degree, c, &sample.square, at)
                }
                _ => {
                    work.count(WorkKind::Surface, [1, 0]);
                    self.designed(&self.panels[sample.panel], at, sample.hit.z)
                }
            };
            self.textured(added(designed, 1.0, form(at)), state, at, &sample.site)
        };
        // Most of the light goes where flat tops send it: there is no picture.
        if state.terraced > 0.5 {
            return [S::constant(f64::NAN); 2];
        }
        let (origin, along) = self.ray(sample, &state.placed);
        let from: [S; 3] = std::array::from_fn(|k| origin[k] - pose.shift[k]);
        let from = pose.turned_back(from).map(|x| x / pose.scale);
        let along = pose.turned_back(along);
        let Some((at, slope)) = meet(sample, self.farthest, (from, along), surface) else {
            return [S::constant(f64::NAN); 2];
        };
        // Of terraces the flat tops reflect.
        let slope = slope.map(|p| p * (1.0 - state.terraced));
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
    pub(super) fn ray<S: Scalar>(
        &self,
        sample: &PixelSample,
        placed: &[S; PLACED],
    ) -> ([S; 3], [S; 3]) {
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

    /// [`ImagingTask::locate`] for all kinds of numbers.
    pub(super) fn place<S: Scalar>(&self, near: DVec2, at: [S; 3], leaving: [S; 3]) -> [S; 2] {
        let flip = if self.view.reflects(near) { -1.0 } else { 1.0 };
        let from = [at[0], at[1] * flip, at[2] - self.view.origin_mm];
        let sigma = stereographic::sigma([leaving[0], leaving[1] * flip, leaving[2]]);
        let seen = self.view.target.direction_from_origin(from, sigma);
        let [x, y] = self.view.projection.image_of(seen, DVec2::new(near.x, near.y * flip));
        [x, y * flip]
    }
}

#[inline]
fn added<S: Scalar>(sum: [S; 3], a: f64, [f, x, y]: [S; 3]) -> [S; 3] {
    [sum[0] + f * a, sum[1] + x * a, sum[2] + y * a]
}

/// Whether numbers of this kind carry no derivatives.
fn is_plain<S>() -> bool {
    size_of::<S>() == size_of::<f64>()
}

/// Where a line meets `surface`, and the slope there: Newton's method from the sample's own hit, no
/// farther from that than `farthest`.
#[inline]
fn meet<S: Scalar>(
    sample: &PixelSample,
    farthest: f64,
    (from, along): ([S; 3], [S; 3]),
    mut surface: impl FnMut([S; 2]) -> [S; 3],
) -> Option<([S; 3], [S; 2])> {
    let (hit, p) = (sample.hit, sample.slope);
    // The tangent plane there.
    let rate = along[2] - along[0] * p[0] - along[1] * p[1];
    let below = from[2] - hit.z - (from[0] - hit.x) * p[0] - (from[1] - hit.y) * p[1];
    let mut t = -below / rate;
    // The step before and the slope before it.
    let mut last: Option<(S, [S; 2])> = None;
    for _ in 0..MOST_STEPS {
        let [x, y, z] = [0, 1, 2].map(|k| from[k] + along[k] * t);
        // Nor is what is not a number near.
        let near = |x: S, hit: f64| (x.mid() - hit).abs() <= farthest;
        if !(near(x, hit.x) && near(y, hit.y)) {
            return None;
        }
        let [f, f_x, f_y] = surface([x, y]);
        let step = (z - f) / (along[2] - along[0] * f_x - along[1] * f_y);
        t = t - step;
        if step.mid().abs() < LAST_STEP {
            let at = [0, 1, 2].map(|k| from[k] + along[k] * t);
            if let (true, Some((before, [p, q]))) = (is_plain::<S>(), last) {
                // So short a step changes the slope as the one before did.
                let more: S = step / before;
                return Some((at, [f_x + (f_x - p) * more, f_y + (f_y - q) * more]));
            }
            let [_, f_x, f_y] = surface([at[0], at[1]]);
            return Some((at, [f_x, f_y]));
        }
        last = Some((step, [f_x, f_y]));
    }
    None
}
