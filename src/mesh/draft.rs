//! The draft of a mesh: a coarse one, each triangle of which will be cut into as many equal facets,
//! of the size at which the fewest will do.

use super::cell::Cells;
use super::needs::Needs;
use super::net::Net;
use super::pack::Packing;
use super::plane;
use super::proof::Prover;
use super::rim::Rim;
use super::{Limits, MOST_FACETS, MeshError};
use crate::geom::{DVec2, Precision, Rect};
use rayon::prelude::*;

/// Coarse triangles of the meshed part, about: so many that few of them are at the rim, and that
/// curvature hardly changes within one.
const COARSE: f64 = 16_000.0;
const TRIAL: f64 = 6_000.0;
/// By how much the chords of a trial, whose cells are twice as large and as strained, are too large.
const STRAINED: f64 = 1.02;
/// Share of the limits that facets of the model are first given.
const AIM: f64 = 0.985;
/// Shares of what the proof of some facets allows, between which a draft is kept as it is.
const FITS: [f64; 2] = [0.985, 1.02];
/// Share of facets from repairs, from which on a draft is drawn anew: where all places are alike, all
/// facets fail together.
const COSTLY: f64 = 0.25;
/// Facets that come of the repair of one that is hardly too large.
const REPAIR: f64 = 4.0;
/// Facets that are proven to find the size.
const SAMPLES: usize = 2000;

/// A coarse mesh of the meshed part of a mirror.
pub struct Draft<'a> {
    /// The lattice it was drawn from.
    pub cells: Cells<'a>,
    /// Its rim.
    pub rim: Rim,
    /// Its triangles.
    pub net: Net<'a>,
    /// Facets that come of repairs, as a share of all.
    over: f64,
}

impl<'a> Draft<'a> {
    /// A draft of the part `domain` of the prover's mirror, of which the face holds `copies`.
    pub fn new(
        prover: &Prover,
        needs: &'a Needs,
        domain: Rect,
        copies: usize,
        limits: Limits,
    ) -> Result<Self, MeshError> {
        let mirror = prover.mirror();
        needs.outlast_rounding(&mirror.outline)?;
        let mut cells = Cells::new(needs, &mirror.outline, AIM, COARSE);
        let facets = cells.count(&mirror.outline) * copies as f64;
        if !(facets <= MOST_FACETS) {
            return Err(MeshError::TooMany { facets, most: MOST_FACETS });
        }
        needs.outlast_tilting(&mirror.outline, |place| cells.sides(place))?;
        let draw = |cells: Cells<'a>| {
            let rim = Rim::new(mirror, domain, &cells);
            let packing = Packing::new(&cells, &rim).map_err(|at| MeshError::Pole { at })?;
            let net = plane::triangulate(packing, &rim, &cells)?;
            Ok::<_, MeshError>(Self { cells, rim, net, over: 0.0 })
        };
        let mut trial = cells.clone();
        if cells.count(&mirror.outline) > TRIAL {
            trial.coarsen(2);
        }
        let mut trial = draw(trial)?;
        let scale = trial.judge(prover, limits);
        if trial.cells.parts == cells.parts && scale > FITS[0] && scale < FITS[1] {
            return Ok(trial);
        }
        let scale = if needs.sees() { scale } else { scale * STRAINED };
        cells.rescale(scale * AIM);
        let mut draft = draw(cells.clone())?;
        let found = draft.judge(prover, limits);
        if found > FITS[0] && draft.over < COSTLY {
            return Ok(draft);
        }
        cells.rescale(found * scale * AIM);
        let mut better = draw(cells)?;
        better.judge(prover, limits);
        Ok(if better.facets() < draft.facets() { better } else { draft })
    }

    /// About how many facets come of it.
    pub fn facets(&self) -> f64 {
        let parts = self.cells.parts as f64;
        self.net.triangles.len() as f64 * parts * parts * (1.0 + self.over)
    }

    /// Proves one facet of each of some triangles; the factor on the cells with which the fewest
    /// facets come out.
    fn judge(&mut self, prover: &Prover, limits: Limits) -> f64 {
        let mut excess = self.sample(prover, limits);
        excess.sort_by(f64::total_cmp);
        let count = excess.len();
        // Repairing a facet costs as it is too large.
        let squares: Vec<f64> = excess.iter().map(|e| e * e).collect();
        let mut after = vec![0.0; count + 1];
        for k in (0..count).rev() {
            after[k] = after[k + 1] + squares[k];
        }
        let share = |sum: f64| REPAIR * sum / count as f64;
        self.over = share(after[excess.partition_point(|&e| e <= 1.0)]);
        // A facet that is to hold at last must be the smaller by its excess, and all others with it.
        let cost = |k: &usize| squares[*k] + share(after[k + 1]);
        let best = (excess.len() / 2..excess.len()).min_by(|a, b| cost(a).total_cmp(&cost(b)));
        best.map(|k| 1.0 / excess[k])
            .filter(|scale| scale.is_finite() && *scale > 0.0)
            .unwrap_or(1.0)
    }

    /// By how much the proof finds facets larger than they may be.
    fn sample(&self, prover: &Prover, limits: Limits) -> Vec<f64> {
        let step = self.net.triangles.len().div_ceil(SAMPLES);
        let share = 1.0 / self.cells.parts as f64;
        let round = rounding(prover, limits);
        let each = |t: &[u32; 3]| {
            let corners = t.map(|v| self.net.points[v as usize]);
            let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
            let vertices = corners.map(|p| {
                let q = round(centre + (p - centre) * share);
                prover.vertex(q, prover.mirror().surface.at(q))
            });
            let bound = prover.bound_roughly(vertices.each_ref(), &limits);
            let chord = limits.chord_mm.map_or(0.0, |limit| (bound.chord_mm / limit).sqrt());
            chord.max(limits.facet_mm.map_or(0.0, |limit| bound.facet_mm / limit))
        };
        self.net.triangles.par_iter().step_by(step).map(each).collect()
    }
}

/// Points as the file will have them: under parallel rays single-precision numbers, if that is its
/// precision.
pub fn rounding(prover: &Prover, limits: Limits) -> impl Fn(DVec2) -> DVec2 + Copy + use<> {
    let parallel = prover.mirror().chart.vergence == 0.0;
    let single = parallel && limits.precision == Precision::Single;
    move |q| if single { q.as_vec2().as_dvec2() } else { q }
}
