//! Which pixels stand for the picture, and polynomials of the mirror where they see it.

use super::local::{Fitter, Square, off, terms, value, values};
use super::model::{Pose, Sample, System};
use super::tally::{Piece, Tally};
use crate::geom::DVec2;
use crate::parallel;
use std::cell::Cell;

/// Degrees of polynomials that are tried for the designed surface. One whose height, mm, or slope is
/// farther off than this is not used.
const DEGREES: [usize; 4] = [5, 7, 10, 14];
const SMOOTH: f64 = 1e-12;
/// Where none is near enough on a square, this share of its side is tried.
const SMALLER: f64 = 0.25;
/// Shares that are tried of squares that are to be wider, by every so many samples.
const WIDER: [f64; 4] = [1.0, 0.75, 0.5, 0.3];
const SOME: usize = 100;
/// As [`SMOOTH`], for form errors of 1 mm; made ones have micrometres, the waves of a random slope
/// fractions of them.
const FORM_DEGREES: [usize; 6] = [4, 5, 6, 7, 8, 10];
/// Most terms of form errors.
pub const FORM_TERMS: usize = terms(FORM_DEGREES[5]);
const SMOOTH_FORM: f64 = 5e-9;

impl System {
    /// Number of samples near whose hits polynomials are the designed surface and the form errors.
    pub(super) fn expanded(&self) -> usize {
        let smooth = |sample: &&Sample| sample.base.is_some() && self.form_degree > 0;
        self.samples.iter().filter(smooth).count()
    }

    /// About `count` samples, spread evenly, away from the rim by `margin` mm; hits move by about
    /// `reach` mm.
    pub(super) fn spread(&self, count: usize, [margin, reach]: [f64; 2]) -> Vec<Sample> {
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
            rows.iter().flat_map(row).filter(|&q| self.sees(q, margin).is_some()).collect()
        };
        let even = |count: f64| (width * height / count).sqrt().max(1.0);
        let tried = even(count as f64);
        let share = places(tried).len() as f64 * tried * tried;
        let spacing = (share / count as f64).sqrt().max(1.0);
        let fitters = DEGREES.map(Fitter::new);
        let sample = |&q: &DVec2| self.sample(&fitters, q, self.sees(q, margin)?, reach);
        let places = places(spacing);
        parallel::gather(places.len(), 1, |part| places[part].iter().filter_map(sample).collect())
    }

    /// The same with larger squares, for hits that move by about `reach` mm, where polynomials are the
    /// surface on them; none where they are not.
    pub(super) fn widened(&self, reach: f64) -> Option<Self> {
        let fitters = DEGREES.map(Fitter::new);
        let fitted = |sample: &Sample, half: f64| {
            let square = Square { half, ..sample.square };
            self.fitted(&fitters, &square).map(|base| (square, base))
        };
        // Some tell of the others.
        let some = || self.samples.iter().step_by(SOME).filter(|s| s.base.is_some());
        let all_fit = |half: f64| some().all(|sample| fitted(sample, half).is_some());
        let wider = |half: &f64| some().all(|sample| *half > sample.square.half);
        let halves = WIDER.map(|share| share * reach).into_iter().filter(wider);
        let half = halves.into_iter().find(|half| all_fit(*half))?;
        // (Without a copy of the form errors' many coefficients.)
        let wider = |sample: &Sample| {
            let &Sample { point, content, hit, slope, groove, .. } = sample;
            let (square, base) = match fitted(sample, half) {
                Some((square, base)) => (square, Some(base)),
                None => (sample.square, sample.base.clone()),
            };
            Sample { point, content, hit, slope, square, groove, base, form: Vec::new() }
        };
        let mut wide = self.with(parallel::map_slice(&self.samples, 1, wider));
        wide.expand_forms();
        // Rather none so wide than none at all.
        (wide.form_degree > 0).then_some(wide)
    }

    /// Gives the samples polynomials of the form errors, of one degree for all.
    pub(super) fn expand_forms(&mut self) {
        let fields = &self.fields;
        let expanded = |sample: &Sample, fitter: &Fitter| -> Option<Vec<f64>> {
            let mut all = Vec::new();
            for field in fields {
                let c = fitter.fit(&sample.square, |at| [field.at(at)[0]]).concat();
                let found = |at| value(fitter.degree(), &c, &sample.square, at);
                if !(off(&sample.square, found, |at| field.at(at)) <= SMOOTH_FORM) {
                    return None;
                }
                all.extend(c);
            }
            Some(all)
        };
        for degree in FORM_DEGREES {
            let fitter = Fitter::new(degree);
            // The first sample tells of most degrees that they are too low.
            if self.samples.first().is_some_and(|sample| expanded(sample, &fitter).is_none()) {
                continue;
            }
            let expanded = |k: usize| expanded(&self.samples[k], &fitter);
            if let Some(all) = parallel::try_map(self.samples.len(), 1, expanded) {
                self.samples.iter_mut().zip(all).for_each(|(sample, form)| sample.form = form);
                self.form_degree = degree;
                return;
            }
        }
    }

    /// Where the image point `q` sees the mirror well inside its rim, as chart coordinates.
    fn sees(&self, q: DVec2, margin: f64) -> Option<DVec2> {
        let place = self.mirror.under(&self.camera.chart, q)?;
        let around = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y, DVec2::ZERO];
        let whole = self.mirror.whole();
        let inside = around.iter().all(|way| {
            let near = place + *way * margin;
            whole.aims(near) && self.mirror.reflects(near) == self.mirror.reflects(place)
        });
        inside.then_some(place)
    }

    /// Degree and coefficients of the designed surface on a square.
    fn fitted(&self, fitters: &[Fitter], square: &Square) -> Option<(usize, Vec<[f64; 3]>)> {
        let calls = Cell::new(0);
        let designed = |at| {
            calls.set(calls.get() + 1);
            self.designed(at)
        };
        let found = fitters.iter().find_map(|fitter| {
            let c = fitter.fit(square, designed);
            let found = |at| values(fitter.degree(), &c, square, at);
            let smooth = off(square, found, designed) <= SMOOTH;
            smooth.then_some((fitter.degree(), c))
        });
        self.counter.count(Piece::Surface, [calls.get(), 0]);
        found
    }

    fn sample(&self, fitters: &[Fitter], point: DVec2, place: DVec2, reach: f64) -> Option<Sample> {
        let at = self.mirror.row(place.y).at(place.x);
        let hit = self.mirror.place(place, &at);
        let slope = self.mirror.slope(place, &at).to_array();
        let of = |half: f64| Square { centre: [hit.x, hit.y], half };
        let fitted = [reach, SMALLER * reach].map(of).into_iter().find_map(|square| {
            let base = self.fitted(fitters, &square)?;
            Some((square, Some(base)))
        });
        let (square, base) = fitted.unwrap_or((of(reach), None));
        let content = DVec2::ZERO;
        let (groove, form) = (self.groove(hit.truncate()), Vec::new());
        let mut sample = Sample { point, content, hit, slope, square, groove, base, form };
        let perfect = self.perfect::<f64>();
        let pose = Pose::new(&perfect.placed);
        let mut tally = Tally::default();
        sample.content = DVec2::from_array(self.content(&sample, &pose, &perfect, &mut tally));
        self.counter.add(tally);
        sample.content.is_finite().then_some(sample)
    }
}
