//! The meshing stage: `Mirror` + tolerances -> optical face with proven bounds.
//!
//! A quadratic model of the mirror and of its image (`needs`) says which lattice cell suits each
//! place (`cell`); a lattice of such cells is packed into the rim (`rim`, `pack`), triangulated by
//! spade and improved by the model (`plane`, `net`, `crowd`). This coarse mesh (`draft`), if it is seen
//! to lead somewhere (`doubt`), is cut into facets (`subdivide`), every one of which is proven over
//! its whole area (`proof`, `tight`); around those that fail corners are moved and edges flipped, by
//! what the mirror does at the corners (`corner`), and facets split where that does not do (`refine`).
//! At last the largest of the bounds are looked at again (`tighten`).
//!
//! All of that happens in the mirror's chart, where facets are flat too (`geom::Chart`). A symmetric
//! panel is meshed on one half or quarter, a folded mirror on one panel: displacements of the image
//! are the same in all of them.

mod bound;
mod budget;
mod coarse;
mod refine;
mod sizing;
#[cfg(test)]
mod tests;

pub use bound::error_bounder::{ErrorBound, ErrorBounder, SurfaceVertex};
pub use budget::{Budget, ClosureCount, MeshPlan};
pub use refine::probe::ImageSingularity;
pub use sizing::optimum::Optimum;

use crate::geom::{Chart, DVec2, Precision, Rect, TriMesh};
use crate::mirror::Mirror;
use crate::optics::ImagingTask;
use crate::parallel;
use bound::region::ImagingProblem;
use coarse::coarse_mesh::{CoarseCandidate, CoarseMesh};
use refine::repair::refine;
use refine::subdivide::subdivide;
use sizing::field::SizingField;
use std::collections::HashSet;
use thiserror::Error;

/// Most points of a coarse mesh, and of each of its sides: ten times what is aimed at.
const CROWDED: usize = 100_000;
/// Largest number of facets of the whole face: about 15 GB in all stages.
const MOST_FACETS: f64 = 4e7;

/// The errors that no facet may exceed; an absent one does not rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Distance between facet and mirror along the rays of the mirror's chart, mm.
    pub chord_mm: Option<f64>,
    /// Displacement of the image that flat facets cause, mm on the mirror.
    pub facet_mm: Option<f64>,
    /// Digits of the file for which they must hold.
    pub precision: Precision,
}

impl Limits {
    /// Whether `bound` is within both.
    #[must_use]
    pub fn hold(&self, bound: &ErrorBound) -> bool {
        self.chord_mm.is_none_or(|limit| bound.chord_mm <= limit)
            && self.facet_mm.is_none_or(|limit| bound.facet_mm <= limit)
    }

    /// Whether chord and facet errors that are reached may be within both.
    fn allow(&self, [chord, facet]: [f64; 2]) -> bool {
        self.chord_mm.is_none_or(|limit| chord <= limit)
            && self.facet_mm.is_none_or(|limit| facet <= limit)
    }
}

/// The meshed mirror: all panels, without skirt and base.
#[derive(Debug, Clone)]
pub struct Face {
    /// Facets in the part frame. In the chart of parallel rays X and Y are single-precision
    /// numbers.
    pub mesh: TriMesh,
    /// The first this many facets belong to the designed panel, the rest to its reflection.
    pub designed: usize,
    /// What holds on every facet, for the mesh as it is and rounded to single precision.
    pub bound: ErrorBound,
    /// How few triangles could do, by theory.
    pub optimum: Optimum,
}

/// Why no mesh within the limits could be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeshError {
    /// The limits ask for more facets than fit in memory.
    #[error(
        "the limits ask for about {facets:.2e} facets, over the {most:.0e} that fit in memory; \
         loosen chord_um or facet_px"
    )]
    TooMany {
        /// Estimated number of facets.
        facets: f64,
        /// Most that are made.
        most: f64,
    },
    /// Facets miss a limit that splitting them does not bring nearer, or that single precision is too
    /// coarse for.
    #[error(
        "at X {:.4} mm, Y {:.4} mm a facet of {size_mm:.1e} mm still has a bound of {} (chord) and \
         {} (image); {}", at.x, at.y, proven(bound.chord_mm), proven(bound.facet_mm), advised(*singularity)
    )]
    NotRefinable {
        /// Where.
        at: DVec2,
        /// Longest edge, mm.
        size_mm: f64,
        /// What could be proven there.
        bound: ErrorBound,
        /// Whether double precision would do better there.
        holds_in_double: bool,
        /// What makes errors of the image large there.
        singularity: Option<ImageSingularity>,
    },
    /// Rounding to single precision alone keeps facets from a limit.
    #[error(
        "single precision carries no better than {} at X {:.4} mm, Y {:.4} mm; loosen the limit",
        carried(*chord_mm, *facet_mm), at.x, at.y
    )]
    PrecisionLimit {
        /// Where.
        at: DVec2,
        /// The chord that it carries there, mm, if that limit cannot be kept.
        chord_mm: Option<f64>,
        /// The facet error that it carries there, mm, if that limit cannot be kept.
        facet_mm: Option<f64>,
    },
    /// No mesh of so few triangles.
    #[error(
        "max_triangles = {most} is too few: the coarsest mesh of this mirror comes to {least} \
         triangles; raise max_triangles to that"
    )]
    BudgetTooSmall {
        /// The number allowed.
        most: usize,
        /// The fewest that were reached.
        least: usize,
    },
    /// The slope may vanish: there the mirror looks along the axis, and no image point is near.
    #[error(
        "near X {:.4} mm, Y {:.4} mm the designed mirror may look straight along its axis, where \
         facet_px has no meaning; raise the degree, narrow the elevation range, or give chord_um \
         alone", at.x, at.y
    )]
    OnAxis {
        /// Where.
        at: DVec2,
    },
    /// The sizes of facets that the limits ask for are so unlike that a coarse mesh of them has no end.
    #[error(
        "near X {:.4} mm, Y {:.4} mm the limits ask for facets that are boundlessly smaller than \
         elsewhere; narrow the elevation range or keep it further from +-90 degrees, or give \
         chord_um alone", at.x, at.y
    )]
    SizeContrast {
        /// Where.
        at: DVec2,
    },
    /// spade refused a point.
    #[error("the point ({x}, {y}) cannot be triangulated: {reason}")]
    PointRejected {
        /// X, mm.
        x: f64,
        /// Y, mm.
        y: f64,
        /// spade's account.
        reason: String,
    },
}

/// What is to be done about a facet that splitting does not help.
fn advised(near: Option<ImageSingularity>) -> String {
    let loosen = "loosen chord_um or facet_px";
    near.map_or_else(|| loosen.to_owned(), |near| format!("{near}, or {loosen}"))
}

/// A bound in words.
fn proven(mm: f64) -> String {
    if mm.is_finite() { format!("{mm:.3e} mm") } else { "none".to_owned() }
}

/// Errors that are not kept, as words.
fn carried(chord_mm: Option<f64>, facet_mm: Option<f64>) -> String {
    let chord = chord_mm.map(|mm| format!("{mm:.3e} mm (chord)"));
    let facet = facet_mm.map(|mm| format!("{mm:.3e} mm (image)"));
    chord.into_iter().chain(facet).collect::<Vec<_>>().join(" and ")
}

/// Meshes `mirror` so that every facet keeps `limits` as the camera of chart `camera` sees it, whose
/// image must show `view`. The camera's chart is the mirror's, or the mirror's is that of parallel
/// rays (a given mirror under a pinhole). Without a view `facet_mm` of the face's bound is 0.
///
/// # Errors
/// [`MeshError`] when no such mesh exists in single precision or in memory.
///
/// # Panics
/// When `limits` ask for a facet error without a view.
pub fn mesh(
    mirror: &Mirror,
    camera: &Chart,
    view: Option<&ImagingTask>,
    limits: Limits,
) -> Result<Face, MeshError> {
    Mesher::new(mirror, camera, view).mesh(limits)
}

/// How large a mesh will be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshForecast {
    /// Facets of the optical face.
    pub facets: f64,
    /// Edges around it (and around its hole, if there is one).
    pub rim: f64,
}

/// Foresees the size of what [`mesh`] makes of the same arguments, without making it.
///
/// # Errors
/// [`MeshError`] as far as it can be foreseen.
///
/// # Panics
/// When `limits` ask for a facet error without a view.
pub fn forecast(
    mirror: &Mirror,
    camera: &Chart,
    view: Option<&ImagingTask>,
    limits: Limits,
) -> Result<MeshForecast, MeshError> {
    Mesher::new(mirror, camera, view).forecast(limits)
}

/// Meshes and foresees by several limits: what is known of the mirror is found out once.
struct Mesher<'a> {
    sight: ImagingProblem<'a>,
    needs: Option<SizingField>,
    prover: Option<ErrorBounder<'a>>,
}

impl<'a> Mesher<'a> {
    fn new(mirror: &'a Mirror, camera: &Chart, view: Option<&'a ImagingTask>) -> Self {
        Self { sight: ImagingProblem { mirror, camera: *camera, view }, needs: None, prover: None }
    }

    /// See [`mesh`].
    fn mesh(&mut self, limits: Limits) -> Result<Face, MeshError> {
        let ImagingProblem { mirror, camera, view } = self.sight;
        let made = || self.drafted(limits, |prover, draft| made(prover, draft, limits));
        // From a thread of the pool, the others are reached more quickly.
        let (made, optimum) = parallel::join(made, || Optimum::new(mirror, &camera, view));
        let (mut mesh, bound) = made?;
        let designed = mesh.triangles.len();
        if mirror.folded {
            mesh = mesh.with_reflection(1);
        }
        Ok(Face { mesh, designed, bound, optimum })
    }

    /// See [`forecast`].
    fn forecast(&mut self, limits: Limits) -> Result<MeshForecast, MeshError> {
        self.foresee(limits, |prover, draft| {
            let mirror = prover.mirror();
            if !draft.is_told_by_making(copies(mirror)) {
                return Ok(estimate(mirror, draft));
            }
            let panel = made(prover, draft, limits)?.0;
            let panels = if mirror.folded { 2.0 } else { 1.0 };
            let [facets, rim] = [panel.triangles.len(), rim(mirror, &panel)];
            Ok(MeshForecast { facets: panels * facets as f64, rim: panels * rim as f64 })
        })
    }

    /// What a forecast says when nothing is made for it.
    fn estimate(&mut self, limits: Limits) -> Result<MeshForecast, MeshError> {
        self.foresee(limits, |prover, draft| Ok(estimate(prover.mirror(), draft)))
    }

    fn foresee(
        &mut self,
        limits: Limits,
        by: impl FnOnce(&ErrorBounder, &CoarseMesh) -> Result<MeshForecast, MeshError> + Send,
    ) -> Result<MeshForecast, MeshError> {
        // From a thread of the pool, the others are reached more quickly.
        parallel::join(|| self.drafted(limits, by), || ()).0
    }

    /// What is made of the draft of a mesh.
    fn drafted<T>(
        &mut self,
        limits: Limits,
        make: impl FnOnce(&ErrorBounder, &CoarseMesh) -> Result<T, MeshError>,
    ) -> Result<T, MeshError> {
        let sight = self.sight;
        assert!(sight.view.is_some() || limits.facet_mm.is_none(), "a facet error needs a view");
        let domain = domain(sight.mirror);
        let known = self.needs.take().and_then(|needs| needs.under(limits));
        let needs = known.unwrap_or_else(|| SizingField::new(&sight, domain, limits));
        self.needs = Some(needs.clone());
        let known = self.prover.take().filter(|prover| prover.precision == limits.precision);
        // Neither keeps all threads busy.
        let (prover, trial) = parallel::join(
            || known.unwrap_or_else(|| ErrorBounder::over(domain, sight, limits.precision)),
            || CoarseCandidate::new(sight.mirror, &needs, domain, copies(sight.mirror)),
        );
        let prover = self.prover.insert(prover);
        let draft = trial?.judged(prover, limits)?;
        make(prover, &draft)
    }
}

/// The mesh of the designed panel that a draft comes to, and what is proven of it.
fn made(
    prover: &ErrorBounder,
    draft: &CoarseMesh,
    limits: Limits,
) -> Result<(TriMesh, ErrorBound), MeshError> {
    let mirror = prover.mirror();
    let (mut mesh, bound) = refine(prover, draft, subdivide(draft), copies(mirror), limits)?;
    for axis in [0, 1] {
        if mirror.mirror_symmetric[axis] {
            mesh = mesh.with_reflection(axis);
        }
    }
    Ok((mesh, bound))
}

/// The size of what a draft comes to, by samples of its facets.
fn estimate(mirror: &Mirror, draft: &CoarseMesh) -> MeshForecast {
    // Sides on which the part meets its reflection are inside the face.
    let seam = [mirror.mirror_symmetric[0], mirror.mirror_symmetric[1] || mirror.folded];
    let is_rim = |[a, b]: &[DVec2; 2]| !(0..2).any(|k| seam[k] && a[k] == 0.0 && b[k] == 0.0);
    let copies = copies(mirror);
    let sides = draft.net.sides().filter(is_rim).count() * draft.cells.parts * copies;
    MeshForecast { facets: draft.facets() * copies as f64, rim: sides as f64 }
}

/// The number of edges at the rim of a mirror's panel; those on which a folded mirror's two panels meet
/// are inside the face.
fn rim(mirror: &Mirror, panel: &TriMesh) -> usize {
    let mut open = HashSet::new();
    for &[a, b, c] in &panel.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if !open.remove(&(to, from)) {
                open.insert((from, to));
            }
        }
    }
    let is_fold = |v: u32| mirror.folded && panel.vertices[v as usize].y == 0.0;
    open.into_iter().filter(|&(a, b)| !(is_fold(a) && is_fold(b))).count()
}

/// How many times the face holds what is meshed.
fn copies(mirror: &Mirror) -> usize {
    let twice = [mirror.mirror_symmetric[0], mirror.mirror_symmetric[1], mirror.folded];
    1 << twice.iter().filter(|&&twice| twice).count()
}

/// The bounds of the part of the panel that is meshed: where x >= 0 or y >= 0 if the rest is its
/// mirror image.
fn domain(mirror: &Mirror) -> Rect {
    let Rect { mut min, max } = mirror.outline.bounds();
    for axis in [0, 1] {
        if mirror.mirror_symmetric[axis] {
            min[axis] = 0.0;
        }
    }
    Rect { min, max }
}
