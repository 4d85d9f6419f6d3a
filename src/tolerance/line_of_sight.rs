//! Where a pixel looks: its ray in chart coordinates.

use crate::geom::DVec2;
use crate::optics::Camera;
use glam::DMat2;

/// Line of sight of an image point: the ray's chart coordinates, and how they follow the image point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LineOfSight {
    /// Chart coordinates, mm.
    pub on_chart: DVec2,
    /// Their derivatives along the picture's axes.
    pub along: DMat2,
}

impl LineOfSight {
    /// That of the image point `point`.
    pub(crate) fn new(camera: &Camera, point: DVec2) -> Self {
        let on_chart = camera.picture.chart_point(point);
        Self { on_chart, along: camera.picture.jacobian(on_chart).inverse() }
    }
}
