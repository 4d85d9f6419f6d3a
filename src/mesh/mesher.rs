//! Meshes and forecasts of all panels of a mirror.

use super::bound::error_bound::{ErrorBound, Limits};
use super::error::MeshError;
use super::face::{Face, FaceForecast};
use super::panel_mesher::PanelMesher;
use crate::geom::{Chart, TriMesh};
use crate::mirror::Mirror;
use crate::optics::ImagingTask;
use crate::parallel;
use std::borrow::Cow;

/// The smooth mirrors that a mirror consists of, and what each is to show: panels with steps between them, or the mirror
/// itself.
#[derive(Debug)]
pub(super) struct SmoothPanels<'a> {
    whole: &'a Mirror,
    panels: Vec<(Cow<'a, Mirror>, Option<Cow<'a, ImagingTask>>)>,
}

impl<'a> SmoothPanels<'a> {
    /// Those of `mirror`, which is to show `view`.
    pub(super) fn new(mirror: &'a Mirror, view: Option<&'a ImagingTask>) -> Self {
        let panels = if mirror.has_steps() {
            let of_panel =
                |(k, panel)| (Cow::Owned(panel), view.map(|view| Cow::Owned(view.of_panel(k))));
            mirror.panels().into_iter().enumerate().map(of_panel).collect()
        } else {
            vec![(Cow::Borrowed(mirror), view.map(Cow::Borrowed))]
        };
        Self { whole: mirror, panels }
    }
}

/// Meshes and forecasts for one imaging problem.
pub(super) struct Mesher<'a> {
    whole: &'a Mirror,
    panels: Vec<PanelMesher<'a>>,
}

impl<'a> Mesher<'a> {
    /// A mesher of the mirror of `panels`, which the camera of chart `camera` looks at.
    pub(super) fn new(panels: &'a SmoothPanels, camera: &Chart) -> Self {
        let mesher = |(panel, view): &'a (Cow<Mirror>, Option<Cow<ImagingTask>>)| {
            PanelMesher::new(panel, camera, view.as_deref())
        };
        Self { whole: panels.whole, panels: panels.panels.iter().map(mesher).collect() }
    }

    /// See [`mesh`](super::mesh).
    ///
    /// # Errors
    /// [`MeshError`] when there is no such mesh.
    pub(super) fn mesh(&mut self, limits: Limits) -> Result<Face, MeshError> {
        if let [panel] = &mut self.panels[..] {
            return panel.mesh(limits);
        }
        let faces = self.of_each(|panel| panel.mesh(limits))?;
        let bound = faces.iter().fold(ErrorBound::default(), |most, face| most.max(face.bound));
        let optimum = faces.iter().map(|face| face.optimum).sum();
        let designed = faces.iter().map(|face| face.mesh.triangles.len()).sum();
        let panels = TriMesh::side_by_side(faces.into_iter().map(|face| face.mesh.into_panels()));
        let mesh = self.whole.with_walls(panels)?;
        let precision = limits.precision;
        Ok(Face { mesh, designed, bound, optimum, precision, next_finer: None })
    }

    /// See [`forecast`](super::forecast).
    ///
    /// # Errors
    /// [`MeshError`] as far as it can be foreseen.
    pub(super) fn forecast(&mut self, limits: Limits) -> Result<FaceForecast, MeshError> {
        self.all(|panel| panel.forecast(limits))
    }

    /// The forecast from samples of the coarse meshes alone.
    ///
    /// # Errors
    /// [`MeshError`] as far as it can be foreseen.
    pub(super) fn estimate(&mut self, limits: Limits) -> Result<FaceForecast, MeshError> {
        self.all(|panel| panel.estimate(limits))
    }

    /// What `of` makes of every panel, in parallel, since the drawing of a coarse mesh uses one thread; the first panel's error, where
    /// several have one, after all of them.
    fn of_each<T: Send>(
        &mut self,
        of: impl Fn(&mut PanelMesher<'a>) -> Result<T, MeshError> + Sync,
    ) -> Result<Vec<T>, MeshError> {
        parallel::map_chunks_mut(&mut self.panels, 1, |_, panel| of(&mut panel[0]))
            .into_iter()
            .collect()
    }

    /// The forecasts of all panels together.
    fn all(
        &mut self,
        of: impl Fn(&mut PanelMesher<'a>) -> Result<FaceForecast, MeshError> + Sync,
    ) -> Result<FaceForecast, MeshError> {
        let panels = self.of_each(of)?;
        let [facets, rim] = [|f: &FaceForecast| f.facets, |f: &FaceForecast| f.rim]
            .map(|of| panels.iter().map(of).sum::<f64>());
        // A wall has as many facets as there are edges on both of its sides.
        let walls = rim * self.whole.inner_share();
        Ok(FaceForecast { facets: facets + walls, rim: rim - walls })
    }
}
