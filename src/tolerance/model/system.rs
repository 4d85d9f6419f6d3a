//! The designed system, and its surface in the frame of the part.

use super::super::form_field::FormField;
use super::super::work_counts::WorkCounter;
use super::ball_cutter::BallCutter;
use super::made_forms::FormBasis;
use super::sample::PixelSample;
use crate::geom::{BicubicSpline, Chart, DVec2, DVec3};
use crate::mirror::{Hessian, Mirror};
use crate::num::Scalar;
use crate::optics::{Camera, ImagingTask};
use std::sync::Arc;

/// Designed system with the samples that stand for its picture and the form errors that it can have.
#[derive(Debug, Clone)]
pub(crate) struct OpticalSystem {
    /// The camera, as designed.
    pub camera: Camera,
    /// Projection that the picture should show.
    pub view: ImagingTask,
    /// Places of the picture that stand for all of it, each for an area as large as the others'.
    pub samples: Vec<PixelSample>,
    /// Share of the picture of the mirror that they stand for: where they see the target.
    pub share: f64,
    /// The designed mirror.
    pub mirror: Mirror,
    /// Its panels, each of which goes on beyond the ridge.
    pub panels: Vec<Mirror>,
    /// Chart of heights over X and Y.
    pub sag: Chart,
    /// Half the frame's width, mm.
    pub half_width: f64,
    /// Largest distance from a sample's own hit, mm along X and along Y, to which its ray is followed.
    pub farthest: f64,
    /// Form errors of unit size.
    pub fields: Vec<FormField>,
    /// What they and the waviness are made of.
    pub basis: FormBasis,
    /// Wave vector of the waviness, 1/mm.
    pub wave: [f64; 2],
    /// The cutter that leaves the tracks.
    pub tool: BallCutter,
    /// Measured form error, over X and Y of the part, mm.
    pub map: Option<BicubicSpline>,
    /// Work of this system and of all that are made of it.
    pub counter: Arc<WorkCounter>,
}

impl OpticalSystem {
    /// The system with other samples.
    pub(crate) fn with(&self, samples: Vec<PixelSample>) -> Self {
        Self {
            view: self.view.clone(),
            samples,
            mirror: self.mirror.clone(),
            panels: self.panels.clone(),
            fields: self.fields.clone(),
            basis: self.basis.clone(),
            map: self.map.clone(),
            counter: Arc::clone(&self.counter),
            ..*self
        }
    }

    /// Z and slope of the designed surface of `mirror`, the whole one or a panel, at (X, Y) of the
    /// part, near the height `z_mm`, with derivatives as the mirror itself has them.
    pub(crate) fn designed<S: Scalar>(&self, mirror: &Mirror, at: [S; 2], z_mm: f64) -> [S; 3] {
        let q = DVec2::new(at[0].mid(), at[1].mid());
        let Some((place, point)) = mirror.point_on_camera_ray(&self.sag, q, z_mm) else {
            return [S::constant(f64::NAN); 3];
        };
        let slope = mirror.slope(place, &point);
        // What Newton's method left of the way to q.
        let found = mirror.position(place, &point);
        let z = found.z + slope.dot(q - found.truncate());
        let away = [at[0] - q.x, at[1] - q.y];
        if is_plain::<S>() {
            return [z, slope.x, slope.y].map(S::constant);
        }
        let Hessian { xx, xy, yy } = mirror.local_surface(place).hessian;
        [
            away[0] * slope.x + away[1] * slope.y + z,
            away[0] * xx + away[1] * xy + slope.x,
            away[0] * xy + away[1] * yy + slope.y,
        ]
    }

    /// Curvature of the tool's tracks at a place of the part, 1/mm; not a number off the mirror.
    pub(crate) fn groove(&self, mirror: &Mirror, at: DVec3) -> f64 {
        let local = mirror.local_surface_over(at.truncate(), at.z);
        local.map_or(f64::NAN, |local| self.tool.curvature(local.slope.to_array(), &local.hessian))
    }
}

/// Whether numbers of this kind carry no derivatives.
pub(super) fn is_plain<S>() -> bool {
    size_of::<S>() == size_of::<f64>()
}
