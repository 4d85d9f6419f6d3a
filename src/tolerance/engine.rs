//! From drawn errors to displacements of the picture, in full.

use super::compensate::{Adjustment, Compensation, Compensator, Criterion, DisplacementPx};
use super::error_source::{ErrorSource, Perturbation, TextureShape};
use super::form_field::{FormField, FormMeasure, slope_modes};
use super::linear::Linear;
use super::model::{OpticalSystem, PartPose, PerturbedState, PixelSample, placed};
use super::spread::{facets_displace, terraced};
use super::work_counts::{WorkCounts, WorkKind};
use crate::geom::{DVec2, Outline};
use crate::mirror::{BicubicSpline, Mirror};
use crate::num::random::RandomStream;
use crate::num::{cos, sin};
use crate::optics::{Camera, ImagingTask};
use serde::Serialize;
use std::f64::consts::{SQRT_2, TAU};

/// What displacements are measured from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reference {
    /// The picture that the system shows as designed.
    Design,
    /// The picture that the projection asks for.
    Projection,
}

/// What is asked.
#[derive(Debug, Clone)]
pub struct ToleranceSpec {
    /// What can be off.
    pub sources: Vec<ErrorSource>,
    /// What the limits of form errors are.
    pub form: FormMeasure,
    /// Shapes of the textures.
    pub texture: TextureShape,
    /// A measured form error, over X and Y of the part, mm.
    pub map: Option<BicubicSpline>,
    /// What is adjusted.
    pub compensators: Vec<Compensator>,
    /// Which figure counts.
    pub criterion: Criterion,
    /// Against what.
    pub reference: Reference,
    /// The most that it may be, px.
    pub budget_px: f64,
    /// The most that textures may blur within a pixel, px.
    pub budget_blur_px: f64,
    /// The share of parts that must keep the budget.
    pub target_yield: f64,
    /// About how many pixels stand for the picture.
    pub samples: usize,
}

/// One made system.
#[derive(Debug, Clone, PartialEq)]
pub struct PerturbedSystem {
    /// Its errors.
    pub state: PerturbedState<f64>,
    /// Radius of the disc over which facets displace pixels evenly, px.
    pub facets_px: f64,
    /// Where what differs from pixel to pixel comes from.
    pub stream: RandomStream,
}

/// A system with its errors, adjustments and derivatives.
#[derive(Debug, Clone)]
pub struct Engine {
    /// What is asked.
    pub spec: ToleranceSpec,
    pub(super) system: OpticalSystem,
    /// Standard deviations of the random slope's waves, whose amplitudes come after the other form
    /// errors'.
    pub(super) modes: Vec<f64>,
    pub(super) forms: Vec<Perturbation>,
    pub(super) linear: Linear,
    pub(super) compensation: Compensation,
    /// Displacement without errors: zero against the design.
    pub(super) base: Vec<f64>,
}

/// Polynomials stand for the mirror in a square around each sample's hit: at least and at most
/// these shares of the mirror.
const LEAST_REACH: f64 = 0.003;
const MOST_REACH: f64 = 0.02;
/// Standard deviations of the way, along both axes together, that it holds; the few that go farther
/// take their time.
const REACH_SIGMAS: f64 = 2.5;

impl Engine {
    /// Prepares `spec` for a mirror under a camera that shows a view; none where no pixel sees
    /// the target in it.
    #[must_use]
    pub fn new(
        mirror: &Mirror,
        camera: &Camera,
        view: &ImagingTask,
        spec: ToleranceSpec,
    ) -> Option<Self> {
        let (centre, half) = extent(mirror);
        let size = 2.0 * half[0].max(half[1]);
        let (mut forms, mut fields) = (Vec::new(), Vec::new());
        for source in &spec.sources {
            let field = match source.kind {
                Perturbation::Legendre(i, j) => FormField::legendre(i, j, centre, half, spec.form),
                Perturbation::Zernike(j) => FormField::zernike(j, half[0], spec.form),
                _ => continue,
            };
            forms.push(source.kind);
            fields.push(field);
        }
        let slope = spec.sources.iter().any(|source| source.kind == Perturbation::Slope);
        let length = spec.texture.slope_correlation_mm;
        let waves = if slope { slope_modes(length, size) } else { Vec::new() };
        let (waves, modes): (Vec<FormField>, Vec<f64>) = waves.into_iter().unzip();
        fields.extend(waves);
        let texture = spec.texture;
        let reach = reach(&spec.sources, &spec.texture, camera, size);
        let map = spec.map.clone();
        let parts = (mirror, camera, view);
        let system = OpticalSystem::new(parts, fields, &texture, map, spec.samples, reach);
        let pixel = camera.pixel_mm;
        let base = match spec.reference {
            Reference::Design => vec![0.0; 2 * system.samples.len()],
            Reference::Projection => {
                let off = system.samples.iter().map(|s| (s.content - s.point) / pixel);
                off.flat_map(|d: DVec2| d.to_array()).collect()
            }
        };
        let linear = Linear::new(&system, &spec, forms.len() + modes.len());
        let compensation = compensation(&system, &linear, &spec.compensators);
        let seen = !system.samples.is_empty();
        let made = Self { spec, system, modes, forms, linear, compensation, base };
        seen.then_some(made)
    }

    /// The same, ready for errors of these limits: polynomials hold where hits then go. None where
    /// that gains nothing.
    pub(super) fn widened(&self, sources: &[ErrorSource]) -> Option<Self> {
        let (_, half) = extent(&self.system.mirror);
        let size = 2.0 * half[0].max(half[1]);
        let reach = reach(sources, &self.spec.texture, &self.system.camera, size);
        let system = self.system.widened(reach)?;
        Some(Self {
            spec: self.spec.clone(),
            system,
            modes: self.modes.clone(),
            forms: self.forms.clone(),
            linear: self.linear.clone(),
            compensation: self.compensation.clone(),
            base: self.base.clone(),
        })
    }

    /// Wave vectors, 1/mm, of the random slope, and each one's share of its RMS.
    pub(super) fn waves(&self) -> Vec<([f64; 2], f64)> {
        let fields = self.system.fields[self.forms.len()..].iter().zip(&self.modes);
        let of = |(field, deviation): (&FormField, &f64)| match field {
            FormField::Cosine(k) => {
                let length = (k[0] * k[0] + k[1] * k[1]).sqrt();
                Some((*k, deviation * length))
            }
            _ => None,
        };
        fields.filter_map(of).collect()
    }

    /// The same with samples that see points of textures, as single rays do.
    #[must_use]
    pub fn pointwise(&self) -> Self {
        Self { system: self.system.pointwise(), ..self.clone() }
    }

    /// Number of pixels that stand for the picture.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.system.samples.len()
    }

    /// Share of the picture of the mirror that the samples stand for: where they see the target.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.system.share
    }

    /// Numbers that differ between systems: what each sample sees as designed, and units of the form
    /// errors and the measured one there.
    #[must_use]
    pub fn marks(&self) -> Vec<f64> {
        let of = |sample: &PixelSample| {
            let units = self.system.form_units(sample).into_iter().flatten();
            sample.content.to_array().into_iter().chain(units).collect::<Vec<f64>>()
        };
        self.system.samples.iter().flat_map(of).collect()
    }

    /// Number of them near whose hits polynomials stand for the mirror: trials do not evaluate the
    /// mirror itself there.
    #[must_use]
    pub fn expanded(&self) -> usize {
        self.system.expanded()
    }

    /// The work of this engine, and of those made of it, since it was last asked for.
    #[must_use]
    pub fn worked(&self) -> WorkCounts {
        self.system.counter.take()
    }

    /// Image points of these pixels, and where the content belongs that they see as designed, mm.
    pub fn places(&self) -> impl Iterator<Item = (DVec2, DVec2)> {
        self.system.samples.iter().map(|sample| (sample.point, sample.content))
    }

    /// Displacement of the designed picture against the projection.
    #[must_use]
    pub fn nominal(&self) -> DisplacementPx {
        let pixel = self.system.camera.pixel_mm;
        let off = self.system.samples.iter().map(|s| (s.content - s.point) / pixel);
        DisplacementPx::of(&off.flat_map(|d: DVec2| d.to_array()).collect::<Vec<f64>>())
    }

    /// What is adjusted.
    #[must_use]
    pub fn adjustments(&self) -> &[Adjustment] {
        self.compensation.adjustments()
    }

    /// The system that `values`, each in its source's unit, make; `stream` gives the patterns.
    pub fn make(&self, values: &[(Perturbation, f64)], stream: RandomStream) -> PerturbedSystem {
        let mut state = self.system.perfect::<f64>();
        let mut facets_px = 0.0;
        for &(kind, value) in values {
            let phase = || stream.pair(kind.stream(), 1)[0];
            match kind {
                Perturbation::Slope => {
                    let slope = 1e-3 * value;
                    let first = self.forms.len();
                    for (m, pair) in self.modes.chunks(2).enumerate() {
                        let normals = stream.normals(kind.stream(), 1 + m as u32);
                        for (k, (deviation, normal)) in pair.iter().zip(normals).enumerate() {
                            state.form[first + 2 * m + k] = slope * deviation * normal;
                        }
                    }
                }
                Perturbation::Waviness => {
                    let (a, phase) = (0.5e-3 * value, TAU * phase());
                    state.wave = Some([a * cos(phase), -a * sin(phase)]);
                }
                Perturbation::Stepover if value != 0.0 => {
                    state.tracks = Some([value.abs(), phase()])
                }
                Perturbation::Stepover => {}
                // Evenly over a disc, the mean square is half of its radius'.
                Perturbation::Facets => facets_px = SQRT_2 * facets_displace(value),
                Perturbation::Layers => {
                    state.terraced = terraced(value, self.spec.texture.wavelength_nm);
                }
                Perturbation::Map => state.map = Some(value),
                Perturbation::Legendre(..) | Perturbation::Zernike(_) => {
                    if let Some(k) = self.forms.iter().position(|form| *form == kind) {
                        state.form[k] += 1e-3 * value;
                    }
                }
                kind => {
                    if let Some((k, unit)) = self.placed(kind) {
                        state.placed[k] += unit * value;
                    }
                }
            }
        }
        PerturbedSystem { state, facets_px, stream }
    }

    fn placed(&self, kind: Perturbation) -> Option<(usize, f64)> {
        let pixel = self.system.camera.pixel_mm;
        placed_by(kind, pixel, &self.spec.texture)
    }

    /// The errors of a trial, each in its source's unit.
    #[must_use]
    pub fn draw(&self, sources: &[ErrorSource], stream: &RandomStream) -> Vec<(Perturbation, f64)> {
        sources.iter().map(|source| (source.kind, source.draw(stream))).collect()
    }

    /// Displacements, px, x and y of each sample, of several made systems.
    #[must_use]
    pub fn displacements(&self, made: &[PerturbedSystem]) -> Vec<Vec<f64>> {
        let poses: Vec<PartPose<f64>> =
            made.iter().map(|m| PartPose::new(&m.state.placed)).collect();
        let per = 1.0 / self.system.camera.pixel_mm;
        let mut all: Vec<Vec<f64>> = made.iter().map(|_| self.base.clone()).collect();
        let is_perfect: Vec<bool> = made.iter().map(|m| m.state.is_perfect()).collect();
        let mut work = WorkCounts::default();
        // Sample by sample: what belongs to one stays in the cache.
        for (k, sample) in self.system.samples.iter().enumerate() {
            let systems = made.iter().zip(&poses).zip(&is_perfect);
            for (((made, pose), is_perfect), out) in systems.zip(&mut all) {
                let noise = made.noise(k);
                let mut moved = [0.0; 2];
                if *is_perfect {
                    work.count(WorkKind::Rays, [0, 1]);
                } else {
                    let content = self.system.content(sample, pose, &made.state, &mut work);
                    moved = [content[0] - sample.content.x, content[1] - sample.content.y];
                }
                out[2 * k] += moved[0] * per + noise[0];
                out[2 * k + 1] += moved[1] * per + noise[1];
            }
        }
        self.system.counter.add(work);
        all
    }

    /// Figures before and after adjustment, and how far each adjustment was moved: none is where rays
    /// are lost.
    #[must_use]
    pub fn compensate(
        &self,
        mut displacement: Vec<f64>,
    ) -> (DisplacementPx, DisplacementPx, Vec<f64>) {
        let before = DisplacementPx::of(&displacement);
        if !before.kept() {
            return (DisplacementPx::LOST, DisplacementPx::LOST, Vec::new());
        }
        let steps = self.compensation.apply(&mut displacement);
        let after = if steps.is_empty() { before } else { DisplacementPx::of(&displacement) };
        (before, after, steps)
    }
}

impl PerturbedSystem {
    /// What facets displace sample `k` by, px: evenly over a disc, by rejection from the square.
    #[inline]
    pub(super) fn noise(&self, k: usize) -> [f64; 2] {
        if self.facets_px == 0.0 {
            return [0.0; 2];
        }
        let place = |attempt: u32| {
            let draw = 1 + k as u32 + (attempt << 24);
            let [u, v] =
                self.stream.pair(Perturbation::Facets.stream(), draw).map(|u| 2.0 * u - 1.0);
            (u * u + v * v < 1.0).then_some([u, v])
        };
        let [u, v] = (0..128).find_map(place).unwrap_or_default();
        [self.facets_px * u, self.facets_px * v]
    }
}

/// Which of the placing numbers a kind changes, and by how much for one of its unit.
pub(super) fn placed_by(
    kind: Perturbation,
    pixel_mm: f64,
    texture: &TextureShape,
) -> Option<(usize, f64)> {
    let (um, mrad, ppm) = (1e-3, 1e-3, 1e-6);
    Some(match kind {
        Perturbation::DecentreX => (placed::SHIFT[0], um),
        Perturbation::DecentreY => (placed::SHIFT[1], um),
        Perturbation::Despace => (placed::SHIFT[2], um),
        Perturbation::TiltX => (placed::TURN[0], mrad),
        Perturbation::TiltY => (placed::TURN[1], mrad),
        Perturbation::Clocking => (placed::TURN[2], mrad),
        Perturbation::Scale => (placed::SCALE, ppm),
        Perturbation::Temperature => (placed::SCALE, texture.cte_ppm_per_k * ppm),
        Perturbation::Magnification => (placed::MAGNIFICATION, ppm),
        Perturbation::Telecentricity => (placed::TELECENTRICITY, mrad),
        Perturbation::PrincipalX => (placed::PRINCIPAL[0], pixel_mm),
        Perturbation::PrincipalY => (placed::PRINCIPAL[1], pixel_mm),
        Perturbation::Distortion => (placed::DISTORTION, ppm),
        _ => return None,
    })
}

/// Middle and half sides, mm, of the rectangle around the mirror in X and Y of the part.
#[must_use]
pub fn extent(mirror: &Mirror) -> ([f64; 2], [f64; 2]) {
    let bounds = mirror.full_outline().bounds();
    let rim = match mirror.outline {
        Outline::Ring { outer, .. } => vec![DVec2::new(outer, 0.0)],
        Outline::Rect(_) => {
            let middle = bounds.centre();
            let xs = [bounds.min.x, middle.x, bounds.max.x];
            let ys = [bounds.min.y, middle.y, bounds.max.y];
            xs.iter().flat_map(|&x| ys.map(|y| DVec2::new(x, y))).collect()
        }
    };
    let places: Vec<DVec2> =
        rim.into_iter().map(|q| mirror.position(q, &mirror.row(q.y).at(q.x)).truncate()).collect();
    if let ([rim], Outline::Ring { .. }) = (places.as_slice(), mirror.outline) {
        return ([0.0; 2], [rim.x; 2]);
    }
    let lo = places.iter().fold(DVec2::INFINITY, |a, b| a.min(*b));
    let hi = places.iter().fold(DVec2::NEG_INFINITY, |a, b| a.max(*b));
    ((0.5 * (lo + hi)).to_array(), (0.5 * (hi - lo)).to_array())
}

/// How far, mm, hits move over the mirror, roughly.
fn reach(sources: &[ErrorSource], texture: &TextureShape, camera: &Camera, size: f64) -> f64 {
    let mut square = 0.0;
    for source in sources {
        let Some((k, unit)) = placed_by(source.kind, camera.pixel_mm, texture) else {
            continue;
        };
        let lever = match k {
            k if k < 2 || placed::PRINCIPAL.contains(&k) => 1.0,
            k if k == placed::SHIFT[2] => 0.5,
            _ => 0.5 * size,
        };
        let far = source.limit * unit * lever;
        square += far * far * source.distribution.mean_square();
    }
    (REACH_SIGMAS * f64::sqrt(square)).clamp(LEAST_REACH * size, MOST_REACH * size)
}

fn compensation(system: &OpticalSystem, linear: &Linear, asked: &[Compensator]) -> Compensation {
    let pixel = system.camera.pixel_mm;
    let column = |of: &dyn Fn(DVec2) -> [f64; 2]| -> Vec<f64> {
        system.samples.iter().flat_map(|s| of(s.point / pixel)).collect()
    };
    let placed = |k: usize| linear.placed(k).to_vec();
    let mut all = Vec::new();
    let mut add = |name, unit, per_step, column| {
        all.push(Adjustment { name, unit, per_step, column });
    };
    for compensator in asked {
        match compensator {
            Compensator::Shift => {
                add("shift x", "px", 1.0, column(&|_| [1.0, 0.0]));
                add("shift y", "px", 1.0, column(&|_| [0.0, 1.0]));
            }
            Compensator::Rotation => add("rotation", "mrad", 1e3, column(&|q| [-q.y, q.x])),
            Compensator::Magnification => {
                add("magnification", "ppm", 1e6, column(&|q| q.to_array()));
            }
            Compensator::Tilt => {
                add("tilt x", "mrad", 1e3, placed(placed::TURN[0]));
                add("tilt y", "mrad", 1e3, placed(placed::TURN[1]));
            }
            Compensator::Despace => add("despace", "um", 1e3, placed(placed::SHIFT[2])),
        }
    }
    Compensation::new(all)
}
