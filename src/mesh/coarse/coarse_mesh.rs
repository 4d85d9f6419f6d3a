//! The draft of a mesh: a coarse one, each triangle of which will be cut into as many equal facets,
//! of the size at which the fewest will do.

use super::boundary_nodes::BoundaryNodes;
use super::delaunay;
use super::point_placement::PointPlacement;
use crate::geom::{DVec2, Rect};
use crate::mesh::bound::error_bounder::ErrorBounder;
use crate::mesh::refine::probe::{ProbeOutcome, RefinementProbe};
use crate::mesh::refine::repair_progress::most_from;
use crate::mesh::refine::triangulation::EditableTriangulation;
use crate::mesh::sizing::field::SizingField;
use crate::mesh::sizing::frame_field::{FrameField, LatticeKind};
use crate::mesh::{Limits, MOST_FACETS, MeshError};
use crate::mirror::Mirror;
use crate::parallel;

/// Coarse triangles of the meshed part, about: so many that few of them are at the rim, and that
/// curvature hardly changes within one.
const COARSE: f64 = 11_000.0;
/// From so many coarse triangles on half as many to the side are tried first.
const TRIAL: f64 = 6_000.0;
/// By how much too large the facets of a trial are found, whose cells are twice as strained.
const STRAINED: f64 = 1.015;
/// Share of the limits that facets of the model are first given.
const AIM: f64 = 0.985;
/// By how much the cost of a draft may exceed that of the best size for it.
const COSTLY: f64 = 1.03;
/// Drafts that are drawn anew at most: where all places are alike a little decides.
const REDRAWS: usize = 3;
/// What the repair of a facet that is hardly too large costs, in facets, when the size is chosen: the
/// time that it takes counts. (Where all places are alike, all facets fail together.)
const REPAIR: f64 = 3.0;
/// Facets that come of it.
const YIELD: f64 = 1.0;
/// Facets that are proven to find the size, at least half as many.
const SAMPLES: usize = 1200;
/// Facets that come of each, past which it is looked closer whether splitting does any good; the share
/// of facets that it makes worse from which on it does not; and how many more facets come of it, for
/// neighbours that are split along.
const DOUBTFUL: f64 = 1.3;
const HOPELESS: f64 = 0.01;
const ALONG: f64 = 1.2;
/// How many times as many facets as come of it are told of a draft whose facets are far too large.
const OVERRATED: f64 = 8.0;
/// Facets of which the proof takes seconds.
const MANY: f64 = 1e6;
/// Facets that come of each, up to which samples say how many; and so few facets in all that samples of
/// them say little.
const STEADY: f64 = 1.1;
const FEW: f64 = 10_000.0;
/// Facets by samples that are made all the same where samples are far from sure: it takes some seconds, for
/// samples may tell of three times as many as come of it.
const TOLD: f64 = 5e6;

/// By how much smaller than the model has them facets of a draft mostly come out right: squares
/// suffer where cells turn.
fn usual(kind: LatticeKind) -> f64 {
    match kind {
        LatticeKind::ImageSquares => 0.86,
        LatticeKind::Squares => 0.93,
        LatticeKind::Triangles | LatticeKind::ImageTriangles => 1.0,
    }
}

/// What a proof of some facets says of a draft's size.
#[derive(Debug, Clone, Copy, Default)]
struct GrowthEstimate {
    /// Facets that will be there after all repairs, for every one drawn.
    growth: f64,
    /// The same, when what repairs cost is counted.
    cost: f64,
    /// The factor on the cells at which that is least, and how little.
    scale: f64,
    least: f64,
}

impl GrowthEstimate {
    fn is_good(&self) -> bool {
        self.cost <= COSTLY * self.least
    }
}

/// The mean of what cells take along the axes.
fn mean(taken: DVec2) -> f64 {
    (taken.x * taken.y).sqrt()
}

/// A coarse mesh of the meshed part of a mirror.
pub struct CoarseMesh<'a> {
    /// The lattice it was drawn from.
    pub cells: FrameField<'a>,
    /// Its rim.
    pub rim: BoundaryNodes,
    /// Its triangles.
    pub net: EditableTriangulation<'a>,
    found: GrowthEstimate,
    samples: Vec<FacetSample>,
}

/// One facet of a draft.
struct FacetSample {
    corners: [DVec2; 3],
    /// By how much it must shrink to keep the limits,
    oversize: f64,
    /// and what became of it when it did, where that was tried.
    shrunk: Option<ProbeOutcome>,
}

/// The first draft of a mesh, on which no proof has been tried.
pub struct CoarseCandidate<'a> {
    /// The cells of the draft that is wanted.
    cells: FrameField<'a>,
    domain: Rect,
    copies: usize,
    first: CoarseMesh<'a>,
}

impl<'a> CoarseCandidate<'a> {
    /// A trial for the part `domain` of `mirror`, of which the face holds `copies`.
    pub fn new(
        mirror: &Mirror,
        needs: &'a SizingField,
        domain: Rect,
        copies: usize,
    ) -> Result<Self, MeshError> {
        needs.outlast_rounding(mirror)?;
        let cells = FrameField::new(needs, &mirror.outline, AIM, COARSE);
        let count = cells.count(&mirror.outline);
        let facets = count * copies as f64;
        if !(facets <= MOST_FACETS) {
            return Err(MeshError::TooMany { facets, most: MOST_FACETS });
        }
        needs.outlast_tilting(&mirror.outline, |place| cells.sides(place))?;
        let (mut coarse, usual) = (cells.clone(), usual(cells.kind));
        if count > TRIAL {
            coarse.coarsen(2);
        } else if usual < 1.0 {
            coarse.rescale(AIM * usual);
        }
        let first = CoarseMesh::new(mirror, domain, coarse)?;
        Ok(Self { cells, domain, copies, first })
    }

    /// A draft of the size at which, as far as proofs of some facets tell, the fewest will do.
    pub fn judged(
        self,
        prover: &ErrorBounder,
        limits: Limits,
    ) -> Result<CoarseMesh<'a>, MeshError> {
        let Self { mut cells, domain, copies, first } = self;
        let draw = |cells: &FrameField<'a>| {
            Ok::<_, MeshError>(
                CoarseMesh::new(prover.mirror(), domain, cells.clone())?.judged(prover, limits),
            )
        };
        let first = first.judged(prover, limits);
        if first.cells.parts == cells.parts && first.found.is_good() {
            return first.undoubted(prover, limits, copies);
        }
        let strained = if first.cells.parts == cells.parts { 1.0 } else { STRAINED };
        let aim = mean(first.cells.taken()) * first.found.scale * strained;
        drop(first);
        cells.rescale(aim);
        let mut draft = draw(&cells)?;
        let mut found = draft.found;
        for _ in 0..REDRAWS {
            if found.is_good() {
                break;
            }
            let before = cells.taken();
            cells.rescale(mean(before) * found.scale);
            // Whole numbers of cells may leave no other size.
            if cells.taken().abs_diff_eq(before, 1e-9) {
                break;
            }
            let next = draw(&cells)?;
            found = next.found;
            if next.drawn() * next.found.cost < draft.drawn() * draft.found.cost {
                draft = next;
            }
        }
        draft.undoubted(prover, limits, copies)
    }
}

impl<'a> CoarseMesh<'a> {
    /// The part `domain` of `mirror` covered with `cells`.
    fn new(mirror: &Mirror, domain: Rect, cells: FrameField<'a>) -> Result<Self, MeshError> {
        let crowded = |at| MeshError::SizeContrast { at };
        let rim = BoundaryNodes::new(mirror, domain, &cells).map_err(crowded)?;
        let packing = PointPlacement::new(&cells, &rim).map_err(crowded)?;
        let net = delaunay::triangulate(packing, &rim, &cells)?;
        Ok(Self { cells, rim, net, found: GrowthEstimate::default(), samples: Vec::new() })
    }

    /// About how many facets come of it.
    pub fn facets(&self) -> f64 {
        self.drawn() * self.found.growth
    }

    /// Whether that is told by making them: by samples it is far from sure.
    pub fn is_told_by_making(&self, copies: usize) -> bool {
        let facets = self.facets() * copies as f64;
        facets <= FEW || (self.found.growth > STEADY && facets <= TOLD)
    }

    /// How many facets its triangles will be cut into.
    fn drawn(&self) -> f64 {
        let parts = self.cells.parts as f64;
        self.net.triangles.len() as f64 * parts * parts
    }

    /// The same, judged by the proof of one facet of each of some triangles.
    fn judged(mut self, prover: &ErrorBounder, limits: Limits) -> Self {
        let (doubt, facets) =
            (RefinementProbe::new(prover, limits), self.sampled().collect::<Vec<_>>());
        self.samples = parallel::map_slice(&facets, 1, |&corners| {
            let (oversize, shrunk) = doubt.oversize(corners);
            FacetSample { corners, oversize, shrunk }
        });
        let mut excess: Vec<f64> = self.samples.iter().map(|sample| sample.oversize).collect();
        excess.sort_by(f64::total_cmp);
        let count = excess.len();
        // Repairing a facet costs as it is too large.
        let squares: Vec<f64> = excess.iter().map(|e| e * e).collect();
        let mut after = vec![0.0; count + 1];
        for k in (0..count).rev() {
            after[k] = after[k + 1] + squares[k];
        }
        let share = |sum: f64| REPAIR * sum / count as f64;
        // A facet that is to hold at last must be the smaller by its excess, and all others with it.
        let least = |k: usize| squares[k] + share(after[k + 1]);
        let best = (count / 2..count).min_by(|&a, &b| least(a).total_cmp(&least(b)));
        let of = |k: usize| (1.0 / excess[k], least(k));
        let is_sound = |(scale, _): &(f64, f64)| scale.is_finite() && *scale > 0.0;
        let (scale, least) = best.map(of).filter(is_sound).unwrap_or((1.0, 1.0));
        let repaired = share(after[excess.partition_point(|&e| e <= 1.0)]);
        let growth = 1.0 + YIELD / REPAIR * repaired;
        self.found = GrowthEstimate { growth, cost: 1.0 + repaired, scale, least };
        self
    }

    /// The same, unless many of its facets would have to be split, and that is seen to do no good or
    /// to make too many of them.
    fn undoubted(
        mut self,
        prover: &ErrorBounder,
        limits: Limits,
        copies: usize,
    ) -> Result<Self, MeshError> {
        if self.found.growth <= DOUBTFUL {
            return Ok(self);
        }
        // Of few facets each will be asked soon enough.
        if limits.facet_mm.is_some() && self.drawn() > MANY {
            self.keeps_off_the_pole(prover)?;
        }
        let doubt = RefinementProbe::new(prover, limits);
        let shrink =
            |sample: &FacetSample| sample.shrunk.unwrap_or_else(|| doubt.shrink(sample.corners));
        let shrunk = parallel::map_slice(&self.samples, 1, shrink);
        let worst = |of: &dyn Fn(&ProbeOutcome) -> bool| {
            let found = self.samples.iter().zip(&shrunk).filter(|(_, shrunk)| of(shrunk));
            let excess =
                found.map(|(sample, _)| (doubt.excess(sample.corners, 1.0), sample.corners));
            excess.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, corners)| doubt.floor(corners))
        };
        let worsens = |shrunk: &ProbeOutcome| *shrunk == ProbeOutcome::Diverges;
        let worse = shrunk.iter().filter(|shrunk| worsens(shrunk)).count();
        if worse as f64 > HOPELESS * shrunk.len() as f64 {
            return Err(worst(&worsens).expect("there are some"));
        }
        // What is not settled is not counted.
        let parts = |shrunk: &ProbeOutcome| {
            if let ProbeOutcome::Converges(parts) = *shrunk { parts } else { 1.0 }
        };
        let growth = shrunk.iter().map(parts).sum::<f64>() / shrunk.len() as f64;
        self.found.growth = growth;
        let facets = self.drawn() * ALONG * growth * copies as f64;
        if facets > MOST_FACETS {
            return Err(MeshError::TooMany { facets, most: MOST_FACETS });
        }
        if self.facets() > OVERRATED * most_from(self.drawn() as usize) as f64 {
            return Err(worst(&|_| true).expect("there are facets"));
        }
        Ok(self)
    }

    /// Whether no facet is near places where the mirror may look along its axis.
    fn keeps_off_the_pole(&self, prover: &ErrorBounder) -> Result<(), MeshError> {
        let sees = |t: &[u32; 3]| {
            let mut parts = vec![(t.map(|v| self.net.points[v as usize]), 1)];
            while let Some(([a, b, c], size)) = parts.pop() {
                let vertices = [a, b, c].map(|q| prover.vertex(q, prover.mirror().surface.at(q)));
                if !prover.sees_the_pole(&vertices) {
                    continue;
                }
                if size >= self.cells.parts {
                    return Some(a);
                }
                let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
                let quarters = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
                parts.extend(quarters.map(|part| (part, 2 * size)));
            }
            None
        };
        let triangles = &self.net.triangles;
        let seen = parallel::gather(triangles.len(), 1, |part| {
            triangles[part].iter().find_map(sees).into_iter().collect()
        });
        match seen.into_iter().next() {
            Some(at) => Err(MeshError::OnAxis { at }),
            None => Ok(()),
        }
    }

    /// One facet of each of some triangles.
    fn sampled(&self) -> impl Iterator<Item = [DVec2; 3]> {
        let step = self.net.triangles.len().div_ceil(SAMPLES);
        let share = 1.0 / self.cells.parts as f64;
        self.net.triangles.iter().step_by(step).map(move |t| {
            let corners = t.map(|v| self.net.points[v as usize]);
            let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
            corners.map(|p| centre + (p - centre) * share)
        })
    }
}
