//! Meshes and forecasts of one smooth mirror by several limits: what is known of the mirror is found out once.

use super::bound::bound_table::TableResolution;
use super::bound::error_bound::{ErrorBound, Limits};
use super::bound::error_bounder::ErrorBounder;
use super::bound::imaging_problem::ImagingProblem;
use super::coarse::candidate::{CoarseCandidate, WantedCells};
use super::coarse::coarse_mesh::CoarseMesh;
use super::error::MeshError;
use super::face::{Face, FaceForecast};
use super::refine::facet_check::FacetCheck;
use super::refine::repair::refine;
use super::refine::repair_progress::FailureSpread;
use super::refine::subdivide::subdivide;
use super::sizing::field::SizingField;
use super::sizing::optimum::Optimum;
use crate::geom::{Chart, DVec2, FaceMesh, Rect, TriMesh};
use crate::mirror::Mirror;
use crate::optics::ImagingTask;
use crate::parallel;

/// Meshes and forecasts for one imaging problem.
pub(super) struct PanelMesher<'a> {
    problem: ImagingProblem<'a>,
    /// The sizing field of the last limits.
    sizing: Option<SizingField>,
    /// The bounder of the last precision and resolution.
    bounder: Option<ErrorBounder<'a>>,
    /// The last coarse mesh: a mesh often follows a forecast within the same limits.
    coarse: Option<KnownCoarseMesh>,
}

/// A coarse mesh, and what it was drawn for.
struct KnownCoarseMesh {
    limits: Limits,
    /// How far failures were taken to spread: no farther than they were seen to within the same limits.
    spread: FailureSpread,
    coarse: CoarseMesh,
}

impl<'a> PanelMesher<'a> {
    /// A mesher of `mirror`, which the camera of chart `camera` looks at to see `view`.
    pub(super) fn new(mirror: &'a Mirror, camera: &Chart, view: Option<&'a ImagingTask>) -> Self {
        Self {
            problem: ImagingProblem { mirror, camera: *camera, view },
            sizing: None,
            bounder: None,
            coarse: None,
        }
    }

    /// See [`mesh`](super::mesh).
    ///
    /// # Errors
    /// [`MeshError`] when there is no such mesh.
    pub(super) fn mesh(&mut self, limits: Limits) -> Result<Face, MeshError> {
        let ImagingProblem { mirror, camera, view } = self.problem;
        // From a thread of the pool, the others are reached more quickly.
        let (panel, optimum) =
            parallel::join(|| self.panel(limits), || Optimum::new(mirror, &camera, view));
        let (mut mesh, bound) = panel?;
        let designed = mesh.triangles.len();
        if mirror.folded {
            mesh = mesh.with_reflection(1);
        }
        let precision = limits.precision;
        let mesh = FaceMesh::smooth(mesh);
        Ok(Face { mesh, designed, bound, optimum, precision, next_finer: None })
    }

    /// See [`forecast`](super::forecast).
    ///
    /// # Errors
    /// [`MeshError`] as far as it can be foreseen.
    pub(super) fn forecast(&mut self, limits: Limits) -> Result<FaceForecast, MeshError> {
        let copies = copies(self.problem.mirror);
        let estimated = self.forecast_by(limits, |bounder, coarse| {
            let is_estimate = !coarse.must_be_made_to_count(copies);
            Ok(is_estimate.then(|| estimate(bounder.mirror(), coarse)))
        })?;
        match estimated {
            Some(forecast) => Ok(forecast),
            None => Ok(counted(self.problem.mirror, &self.panel(limits)?.0)),
        }
    }

    /// The mesh of the designed panel, and its bound.
    ///
    /// # Errors
    /// [`MeshError`] when there is no such mesh.
    fn panel(&mut self, limits: Limits) -> Result<(TriMesh, ErrorBound), MeshError> {
        let known = self.coarse.as_ref().filter(|known| known.limits == limits);
        let mut spread = known.map_or(FailureSpread::Local, |known| known.spread);
        loop {
            let made = self.with_coarse_mesh(limits, spread, |bounder, coarse| {
                panel(bounder, coarse, limits, spread)
            })?;
            match made {
                Some(panel) => return Ok(panel),
                None => spread = FailureSpread::Wide,
            }
        }
    }

    /// The forecast from samples of the coarse mesh alone.
    ///
    /// # Errors
    /// [`MeshError`] as far as it can be foreseen.
    pub(super) fn estimate(&mut self, limits: Limits) -> Result<FaceForecast, MeshError> {
        self.forecast_by(limits, |bounder, coarse| Ok(estimate(bounder.mirror(), coarse)))
    }

    fn forecast_by<T: Send>(
        &mut self,
        limits: Limits,
        by: impl FnOnce(&ErrorBounder, &CoarseMesh) -> Result<T, MeshError> + Send,
    ) -> Result<T, MeshError> {
        // From a thread of the pool, the others are reached more quickly.
        parallel::join(|| self.with_coarse_mesh(limits, FailureSpread::Local, by), || ()).0
    }

    /// The result of `make` for the bounder and the coarse mesh of `limits`, where failures spread so far.
    fn with_coarse_mesh<T>(
        &mut self,
        limits: Limits,
        spread: FailureSpread,
        make: impl FnOnce(&ErrorBounder, &CoarseMesh) -> Result<T, MeshError>,
    ) -> Result<T, MeshError> {
        let is_wanted = |known: &KnownCoarseMesh| known.limits == limits && known.spread == spread;
        let known = match self.coarse.take().filter(is_wanted) {
            Some(known) => known,
            None => KnownCoarseMesh { limits, spread, coarse: self.draw(limits, spread)? },
        };
        let bounder = self.bounder.as_ref().expect("what draws a mesh bounds its facets");
        let made = make(bounder, &known.coarse);
        self.coarse = Some(known);
        made
    }

    /// Draws the coarse mesh of `limits` where failures spread so far, with the bounder of their precision.
    fn draw(&mut self, limits: Limits, spread: FailureSpread) -> Result<CoarseMesh, MeshError> {
        let problem = self.problem;
        assert!(problem.view.is_some() || limits.facet_mm.is_none(), "a facet error needs a view");
        let domain = domain(problem.mirror);
        let known = self.sizing.take().and_then(|sizing| sizing.with_limits(limits));
        let sizing = known.unwrap_or_else(|| SizingField::new(&problem, domain, limits));
        let sizing = self.sizing.insert(sizing);
        let cells = WantedCells::new(problem.mirror, sizing, domain, copies(problem.mirror))?;
        let precision = limits.precision;
        let resolution = TableResolution::for_facets(&problem, cells.facets());
        let suits =
            |known: &ErrorBounder| known.precision == precision && known.resolution == resolution;
        let known = self.bounder.take().filter(suits);
        let make = || ErrorBounder::for_part(domain, problem, precision, resolution);
        let bounder = || known.unwrap_or_else(make);
        let candidate = || CoarseCandidate::new(problem.mirror, cells);
        // Neither keeps all threads busy.
        let (bounder, candidate) = parallel::join(bounder, candidate);
        let bounder = self.bounder.insert(bounder);
        candidate?.choose_size(bounder, limits, spread)
    }
}

/// The mesh of the designed panel that comes of a coarse mesh, and its bound; none where failures spread farther than
/// `spread`.
fn panel(
    bounder: &ErrorBounder,
    coarse: &CoarseMesh,
    limits: Limits,
    spread: FailureSpread,
) -> Result<Option<(TriMesh, ErrorBound)>, MeshError> {
    let mirror = bounder.mirror();
    let CoarseMesh { frames, arcs, net, .. } = coarse;
    let fine = subdivide(net, arcs, frames.parts);
    let check = FacetCheck { bounder, limits };
    let refined = refine(&check, frames, arcs, fine, copies(mirror), spread)?;
    let Some((mut mesh, bound)) = refined else { return Ok(None) };
    for axis in [0, 1] {
        if mirror.mirror_symmetric[axis] {
            mesh = mesh.with_reflection(axis);
        }
    }
    Ok(Some((mesh, bound)))
}

/// The size of the face whose designed panel is `panel`.
fn counted(mirror: &Mirror, panel: &TriMesh) -> FaceForecast {
    let panels = if mirror.folded { 2.0 } else { 1.0 };
    let [facets, rim] = [panel.triangles.len(), rim_edges(mirror, panel)];
    FaceForecast { facets: panels * facets as f64, rim: panels * rim as f64 }
}

/// The size of the mesh that comes of a coarse mesh, by samples of its facets.
fn estimate(mirror: &Mirror, coarse: &CoarseMesh) -> FaceForecast {
    // Sides on which the part meets its reflection are inside the face.
    let seam = [mirror.mirror_symmetric[0], mirror.mirror_symmetric[1] || mirror.folded];
    let is_rim = |[a, b]: &[DVec2; 2]| !(0..2).any(|k| seam[k] && a[k] == 0.0 && b[k] == 0.0);
    let copies = copies(mirror);
    let edges = coarse.net.boundary_edges().filter(is_rim).count() * coarse.frames.parts * copies;
    FaceForecast { facets: coarse.facets() * copies as f64, rim: edges as f64 }
}

/// The number of edges at the rim of a mirror's panel; those on which a folded mirror's two panels meet are inside the
/// face.
fn rim_edges(mirror: &Mirror, panel: &TriMesh) -> usize {
    let is_fold = |v: u32| mirror.folded && panel.vertices[v as usize].y == 0.0;
    panel.open_edges().into_iter().filter(|&(a, b)| !(is_fold(a) && is_fold(b))).count()
}

/// Number of copies of the meshed part in the face.
fn copies(mirror: &Mirror) -> usize {
    let twice = [mirror.mirror_symmetric[0], mirror.mirror_symmetric[1], mirror.folded];
    1 << twice.iter().filter(|&&twice| twice).count()
}

/// The bounds of the part of the panel that is meshed: x >= 0 or y >= 0 where the rest is its mirror image.
fn domain(mirror: &Mirror) -> Rect {
    let Rect { mut min, max } = mirror.outline.bounds();
    for axis in [0, 1] {
        if mirror.mirror_symmetric[axis] {
            min[axis] = 0.0;
        }
    }
    Rect { min, max }
}
