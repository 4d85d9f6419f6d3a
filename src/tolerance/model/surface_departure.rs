//! Departure of a made surface from the designed one, and its shortest period.

use super::super::footprint::Footprint;
use super::super::form_field::{FormField, add_scaled, period_mm, ripple};
use super::sample::{PixelSample, TextureSite};
use super::state::PerturbedState;
use super::system::OpticalSystem;
use crate::geom::{BicubicSpline, DVec2, DVec3};
use crate::mirror::HeightField;
use crate::num::Scalar;

impl OpticalSystem {
    /// Height and slopes, where `sample` sees the designed surface, of a unit of each form error,
    /// of the waviness' cosine and sine, and of the measured form error if there is one.
    pub(crate) fn form_units(&self, sample: &PixelSample) -> Vec<[f64; 3]> {
        let at = [sample.hit.x, sample.hit.y];
        let footprint = &sample.site.footprint;
        let forms = self.fields.iter().map(|field| {
            let seen = field.footprint_share(footprint);
            field.at(at).map(|x| seen * x)
        });
        let seen = footprint.ripple(self.wave);
        let waves = [[seen, 0.0], [0.0, seen]].map(|a| ripple(self.wave, a, at));
        forms.chain(waves).chain(self.map.as_ref().map(|map| map_error(map, at))).collect()
    }

    /// The sum of form errors of these amplitudes, of waves their mean over `footprint`.
    pub(crate) fn form_errors<S: Scalar>(
        &self,
        amplitudes: &[f64],
        footprint: &Footprint,
        at: [S; 2],
    ) -> [S; 3] {
        let mut sum = [S::constant(0.0); 3];
        let mut rest = amplitudes.iter().zip(&self.fields).peekable();
        while let Some((a, field)) = rest.next() {
            // A wave's cosine and sine follow each other.
            let sine = rest.next_if(|(_, next)| match (field, next) {
                (FormField::Cosine(k), FormField::Sine(same)) => k == same,
                _ => false,
            });
            let seen = || field.footprint_share(footprint);
            sum = match (field, sine) {
                (_, Some((b, _))) if *a == 0.0 && *b == 0.0 => sum,
                (FormField::Cosine(k), Some((b, _))) => {
                    add_scaled(sum, seen(), ripple(*k, [*a, *b], at))
                }
                _ if *a != 0.0 => add_scaled(sum, seen() * *a, field.at(at)),
                _ => sum,
            };
        }
        sum
    }

    /// `sum` and the waviness, the measured form error and the tool's tracks, height and slope, as
    /// they are on `site`.
    pub(crate) fn add_textures<S: Scalar>(
        &self,
        mut sum: [S; 3],
        state: &PerturbedState<S>,
        at: [S; 2],
        site: &TextureSite,
    ) -> [S; 3] {
        if let Some(wave) = state.wave {
            let seen = site.footprint.ripple(self.wave);
            sum = add_scaled(sum, seen, ripple(self.wave, wave, at));
        }
        self.add_map_and_tracks(sum, state, at, site)
    }

    /// The same without the waviness.
    #[inline]
    pub(crate) fn add_map_and_tracks<S: Scalar>(
        &self,
        mut sum: [S; 3],
        state: &PerturbedState<S>,
        at: [S; 2],
        site: &TextureSite,
    ) -> [S; 3] {
        if let (Some(map), Some(share)) = (&self.map, state.map) {
            sum = add_scaled(sum, share, map_error(map, at));
        }
        if let Some(tracks) = state.tracks {
            sum = add_scaled(sum, 1.0, self.tool.cusp(tracks, site, at));
        }
        sum
    }

    /// Height and slope of the tool's tracks where sample `k` sees the mirror as designed.
    pub(crate) fn tracks_at(&self, k: usize, tracks: [f64; 2]) -> [f64; 3] {
        let PixelSample { hit, site, .. } = &self.samples[k];
        self.tool.cusp(tracks, site, [hit.x, hit.y])
    }

    /// Whether a place of the part, before it is grown, is surely on the mirror.
    pub(crate) fn holds(&self, at: DVec3) -> bool {
        self.mirror.full_outline().aims(self.mirror.chart.coordinates(at).0)
    }

    /// Height and slope of the made surface over the designed one at a place of the part, before it
    /// is grown.
    pub(crate) fn departure(&self, state: &PerturbedState<f64>, place: DVec3) -> [f64; 3] {
        let at = place.truncate().to_array();
        let groove = if state.tracks.is_some() { self.groove(&self.mirror, place) } else { 0.0 };
        let footprint = Footprint::POINT;
        let forms = self.form_errors(&state.form, &footprint, at);
        self.add_textures(forms, state, at, &TextureSite { groove, footprint })
    }

    /// The shortest length, mm, over which this departure swings: a period, a distance of tracks or
    /// of a map's knots, half the mirror of a polynomial. None where there is no departure.
    pub(crate) fn shortest(&self, state: &PerturbedState<f64>) -> Option<f64> {
        let forms = state.form.iter().zip(&self.fields).filter(|(a, _)| **a != 0.0);
        let wave = state.wave.filter(|a| *a != [0.0; 2]).map(|_| period_mm(self.wave));
        let tracks = state.tracks.map(|[stepover, _]| stepover);
        let knots = self.map.iter().filter(|_| state.map.is_some_and(|share| share != 0.0));
        let knots = knots.flat_map(|map| map.knots().map(|knots| knots.step_mm));
        let forms = forms.map(|(_, field)| field.swing_mm());
        forms.chain(wave).chain(tracks).chain(knots).reduce(f64::min)
    }
}

/// The measured form error with derivatives.
fn map_error<S: Scalar>(map: &BicubicSpline, at: [S; 2]) -> [S; 3] {
    let q = DVec2::new(at[0].mid(), at[1].mid());
    let (point, bend) = (map.at(q), map.hessian(q));
    let away = [at[0] - q.x, at[1] - q.y];
    [
        away[0] * point.slope.x + away[1] * point.slope.y + point.f,
        away[0] * bend.xx + away[1] * bend.xy + point.slope.x,
        away[0] * bend.xy + away[1] * bend.yy + point.slope.y,
    ]
}
