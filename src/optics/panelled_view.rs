//! Views side by side in one picture.

use super::{FramedView, PictureMap};
use crate::geom::{DVec2, Panels};
use crate::num::Scalar;

/// A view for each panel of a mirror, over image points in mm. What parts them are lines of the part, which a lens bends in
/// the picture: an image point belongs to the panel that the camera sees there.
#[derive(Debug, Clone, PartialEq)]
pub struct PanelledView {
    /// The panels, mm of the chart.
    pub parts: Panels,
    /// From the chart to the picture.
    pub picture: PictureMap,
    /// The view of each.
    pub views: Vec<FramedView>,
}

impl PanelledView {
    /// Direction that image point `q` must see, as a stereographic coordinate.
    #[inline]
    pub fn direction_of<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        self.view_at(DVec2::new(q[0].mid(), q[1].mid())).direction_of(q)
    }

    /// The image point, in the view of `near`, that must see `sigma`.
    #[inline]
    pub fn image_of<S: Scalar>(&self, sigma: [S; 2], near: DVec2) -> [S; 2] {
        self.view_at(near).image_of(sigma, near)
    }

    /// Whether something is wanted of an image point.
    #[inline]
    #[must_use]
    pub fn wants(&self, image: DVec2) -> bool {
        self.view_at(image).wants(image)
    }

    /// The most radians of the world to a millimetre of the image, at a view's centre.
    #[must_use]
    pub fn radians_per_mm(&self) -> f64 {
        self.views.iter().fold(0.0, |most: f64, view| most.max(view.radians_per_mm()))
    }

    /// The panel of an image point.
    #[inline]
    #[must_use]
    pub fn panel_of(&self, image: DVec2) -> usize {
        self.parts.index_of(self.picture.chart_point(image))
    }

    fn view_at(&self, image: DVec2) -> &FramedView {
        &self.views[self.panel_of(image)]
    }
}
