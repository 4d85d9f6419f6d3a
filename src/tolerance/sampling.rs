//! Sampling of the picture: pixels that stand for it, and polynomials of the mirror where they see it.

use super::footprint::Footprint;
use super::form_field::FormField;
use super::line_of_sight::LineOfSight;
use super::local_polynomial::{ExpansionSquare, Fitter, largest_difference, values};
use super::model::{
    BallCutter, FormBasis, OpticalSystem, PartPose, PerturbedState, PixelSample, TextureSite,
};
use super::texture::TextureShape;
use super::work_counts::{WorkCounts, WorkKind};
use crate::geom::{BicubicSpline, Chart, DVec2, DVec3, Outline, Rect};
use crate::mirror::Mirror;
use crate::num::{cos, sin};
use crate::optics::{Camera, ImagingTask};
use crate::parallel;
use std::cell::Cell;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Steps along a side of the mirror in which its rim is looked at.
const RIM: usize = 64;
/// The golden ratio less one: the fractions of its multiples lie as evenly as any.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Degrees of polynomials that are tried for the designed surface. One whose height, mm, or slope is
/// farther off than this is not used.
const DEGREES: [usize; 4] = [5, 7, 10, 14];
const SMOOTH: f64 = 1e-12;
/// Share of a square's side that is tried where no polynomial is near enough on the whole.
const SMALLER: f64 = 0.25;
/// Shares that are tried of squares that are to be wider, by every so many samples.
const WIDER: [f64; 4] = [1.0, 0.75, 0.5, 0.3];
const SOME: usize = 100;
/// Points that share `region` out evenly, each on a row (or circle) of its own, so that all rows are
/// seen, however few the points; across, they follow the multiples of the golden ratio. They are as
/// many as the Fibonacci number next to `count`: then no two come close.
fn lattice(region: &Outline, count: usize) -> impl Iterator<Item = DVec2> {
    let mut pair = [1usize, 2];
    while pair[1] < count {
        pair = [pair[1], pair[0] + pair[1]];
    }
    let points = if count - pair[0] < pair[1] - count { pair[0] } else { pair[1] };
    (0..points).map(move |k| {
        let along = (k as f64 + 0.5) / points as f64;
        let across = ((k as f64 + 0.5) * GOLDEN).fract();
        match *region {
            Outline::Rect(rect) => rect.min + rect.size() * DVec2::new(across, along),
            Outline::Ring { inner, outer } => {
                let square = inner * inner + along * (outer * outer - inner * inner);
                DVec2::new(cos(TAU * across), sin(TAU * across)) * square.sqrt()
            }
        }
    })
}

impl OpticalSystem {
    /// The system of `mirror`, `camera` and `view`, with about `count` samples spread evenly over
    /// the picture of the mirror; hits move by about `reach` mm. `fields` are the form errors.
    #[must_use]
    pub(super) fn new(
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
        let sag = Chart::on_axis(0.0, mirror.chart.plane_mm);
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
            basis: FormBasis::new(&fields, wave),
            fields,
            wave,
            tool,
            map,
            counter: Arc::default(),
        };
        (system.samples, system.share) = system.sample_picture(count, reach);
        system
    }

    /// Number of samples near whose hits polynomials are the designed surface.
    pub(super) fn expanded(&self) -> usize {
        self.samples.iter().filter(|sample| sample.base.is_some()).count()
    }

    /// About `count` samples, spread evenly over the picture of the mirror, but no closer than
    /// pixels, and the share of that picture where they see the target; hits move by about `reach` mm.
    fn sample_picture(&self, count: usize, reach: f64) -> (Vec<PixelSample>, f64) {
        let region = self.region();
        let places = |count: usize| -> Vec<DVec2> {
            lattice(&region, count).filter(|&q| self.sees(q).is_some()).collect()
        };
        // As many more as the region has more than the mirror.
        let share = places(count).len() as f64 / lattice(&region, count).count() as f64;
        let pixels = region.area() / (self.camera.pixel_mm * self.camera.pixel_mm);
        let count = (count as f64 / share).min(pixels).max(1.0) as usize;
        let fitters = DEGREES.map(Fitter::new);
        let sample = |&q: &DVec2| self.sample(&fitters, q, self.sees(q)?, reach);
        let places = places(count);
        let samples: Vec<PixelSample> = parallel::gather(places.len(), 1, |part| {
            places[part].iter().filter_map(sample).collect()
        });
        let share = samples.len() as f64 / places.len().max(1) as f64;
        (samples, share)
    }

    /// A region of the picture that has all of the mirror that is in the frame.
    fn region(&self) -> Outline {
        let half =
            0.5 * self.camera.pixel_mm * DVec2::from_array(self.camera.pixels.map(f64::from));
        let whole = self.mirror.full_outline();
        let own = self.mirror.chart == self.camera.chart && self.camera.picture.is_identity();
        let bounds = match whole {
            Outline::Ring { outer, .. } if own && outer <= half.min_element() => return whole,
            _ if own => whole.bounds(),
            _ => {
                // The rim is among the samples; between two of them it may reach a little farther.
                let image = |q: DVec2| {
                    let at = self.mirror.position(q, &self.mirror.row(q.y).at(q.x));
                    self.camera.image_at(at)
                };
                let seen = whole.samples(RIM).into_iter().flatten().map(|(q, _)| image(q));
                let none = Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
                let all =
                    seen.fold(none, |all, p| Rect { min: all.min.min(p), max: all.max.max(p) });
                let more = all.size() / RIM as f64;
                Rect { min: all.min - more, max: all.max + more }
            }
        };
        Outline::Rect(Rect { min: bounds.min.max(-half), max: bounds.max.min(half) })
    }

    /// The system with larger squares, for hits that move by about `reach` mm, where polynomials are the
    /// surface on them; none where they are not.
    pub(super) fn widened(&self, reach: f64) -> Option<Self> {
        let fitters = DEGREES.map(Fitter::new);
        let fitted = |fitters: &[Fitter], sample: &PixelSample, half: f64| {
            let square = ExpansionSquare { half, ..sample.square };
            let PixelSample { panel, hit, slope, .. } = *sample;
            self.fitted(fitters, panel, &square, (hit, slope)).map(|base| (square, base))
        };
        // Some tell of the others, of the degree too.
        let some = || self.samples.iter().step_by(SOME).filter(|s| s.base.is_some());
        let degree = |half: &f64| -> Option<usize> {
            let degrees: Option<Vec<usize>> =
                some().map(|sample| Some(fitted(&fitters, sample, *half)?.1.0)).collect();
            degrees?.into_iter().min()
        };
        let wider = |half: &f64| some().all(|sample| *half > sample.square.half);
        let mut halves = WIDER.map(|share| share * reach).into_iter().filter(wider);
        let (half, degree) = halves.find_map(|half| Some((half, degree(&half)?)))?;
        let lower = DEGREES.iter().filter(|lower| **lower < degree).count();
        let wider = |sample: &PixelSample| match fitted(&fitters[lower..], sample, half) {
            Some((square, base)) => PixelSample { square, base: Some(base), ..sample.clone() },
            None => sample.clone(),
        };
        Some(self.with(parallel::map_slice(&self.samples, 1, wider)))
    }

    /// The system with samples that see points.
    pub(super) fn pointwise(&self) -> Self {
        let mut made = self.clone();
        for sample in &mut made.samples {
            sample.site.footprint = Footprint::POINT;
            sample.seen = self.seen(&Footprint::POINT);
        }
        made
    }

    /// Shares of all waves that a pixel of this footprint sees.
    fn seen(&self, footprint: &Footprint) -> Vec<f64> {
        self.basis.wave_vectors().map(|vector| footprint.ripple(vector)).collect()
    }

    /// Chart coordinates of the mirror's point that the image point `q` sees; none of one of which nothing is wanted.
    pub(super) fn sees(&self, q: DVec2) -> Option<DVec2> {
        if !self.view.projection.wants(q) {
            return None;
        }
        let on_chart = self.camera.picture.chart_point(q);
        let place = self.mirror.intersect_camera_ray(&self.camera.chart, on_chart)?;
        self.mirror.full_outline().aims(place).then_some(place)
    }

    /// The number of the panel at `place` of the chart.
    fn panel(&self, place: DVec2) -> usize {
        self.mirror.panel_of(place)
    }

    /// Whether a place of the part, before it is grown, is on the panel that `sample` sees.
    pub(super) fn sees_own(&self, sample: &PixelSample, at: DVec3) -> bool {
        self.panel(self.mirror.chart.coordinates(at).0) == sample.panel
    }

    /// Degree and coefficients of the designed surface, near the plane through `hit` of this slope, on a
    /// square.
    fn fitted(
        &self,
        fitters: &[Fitter],
        panel: usize,
        square: &ExpansionSquare,
        (hit, slope): (DVec3, [f64; 2]),
    ) -> Option<(usize, Vec<[f64; 3]>)> {
        let calls = Cell::new(0);
        let designed = |at: [f64; 2]| {
            calls.set(calls.get() + 1);
            let z_mm = hit.z + slope[0] * (at[0] - hit.x) + slope[1] * (at[1] - hit.y);
            self.designed(&self.panels[panel], at, z_mm)
        };
        let found = fitters.iter().find_map(|fitter| {
            let c = fitter.fit(square, designed);
            let found = |at| values(fitter.degree(), &c, square, at);
            let smooth = largest_difference(square, found, designed) <= SMOOTH;
            smooth.then_some((fitter.degree(), c))
        });
        self.counter.count(WorkKind::Surface, [calls.get(), 0]);
        found
    }

    /// The sample at an image point, which sees `place` of the mirror, for systems without form errors and textures.
    fn bare_sample(&self, point: DVec2, place: DVec2) -> PixelSample {
        let at = self.mirror.at(place);
        let hit = self.mirror.position(place, &at);
        PixelSample {
            point,
            sight: LineOfSight::new(&self.camera, point),
            content: DVec2::ZERO,
            panel: self.panel(place),
            hit,
            slope: self.mirror.slope(place, &at).to_array(),
            square: ExpansionSquare { centre: [hit.x, hit.y], half: 0.0 },
            site: TextureSite { groove: 0.0, footprint: Footprint::POINT },
            base: None,
            seen: Vec::new(),
        }
    }

    /// The same for all systems.
    fn textured_sample(&self, point: DVec2, place: DVec2) -> PixelSample {
        let mut sample = self.bare_sample(point, place);
        let PixelSample { sight, panel, hit, slope, .. } = &sample;
        let footprint = Footprint::of(&self.camera, sight, *hit, *slope);
        let groove = self.groove(&self.panels[*panel], *hit);
        sample.seen = self.seen(&footprint);
        sample.site = TextureSite { groove, footprint };
        sample
    }

    /// The sample at an image point, if its ray meets the mirror or, beyond its rim, where its surface goes on; and whether that is the
    /// mirror.
    pub(super) fn sample_at(&self, point: DVec2, is_bare: bool) -> Option<(PixelSample, bool)> {
        let on_chart = self.camera.picture.chart_point(point);
        let place = self.mirror.intersect_camera_ray(&self.camera.chart, on_chart)?;
        let is_mirror = self.mirror.full_outline().aims(place);
        let sample = if is_bare {
            self.bare_sample(point, place)
        } else {
            self.textured_sample(point, place)
        };
        Some((sample, is_mirror))
    }

    fn sample(
        &self,
        fitters: &[Fitter],
        point: DVec2,
        place: DVec2,
        reach: f64,
    ) -> Option<PixelSample> {
        let mut sample = self.textured_sample(point, place);
        let PixelSample { panel, hit, slope, .. } = sample;
        let of = |half: f64| ExpansionSquare { half, ..sample.square };
        let fitted = [reach, SMALLER * reach].map(of).into_iter().find_map(|square| {
            let base = self.fitted(fitters, panel, &square, (hit, slope))?;
            Some((square, Some(base)))
        });
        (sample.square, sample.base) = fitted.unwrap_or((of(reach), None));
        let perfect = PerturbedState::<f64>::perfect(self.fields.len());
        let pose = PartPose::new(&perfect.misalignment);
        let mut work = WorkCounts::default();
        sample.content = DVec2::from_array(self.content(&sample, &pose, &perfect, &mut work));
        self.counter.add(work);
        sample.content.is_finite().then_some(sample)
    }
}
