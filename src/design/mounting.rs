//! Mounting of the part: places of camera and target in the part's frame, and the size of the part.
//!
//! The part's frame has its origin on the base, on the camera's axis: X to the right in the picture,
//! Y towards the picture's upper edge, Z towards the camera. Of a camera beside that axis X and Y are what the
//! shortest turn carries these axes to. Elevations count towards +Z, and azimuths from +Y to +X.

use super::border;
use crate::geom::{Border, DVec3};
use crate::mirror::Mirror;
use crate::num::{acos, degrees};
use crate::optics::{Camera, ImagingTask, Target};
use serde::{Deserialize, Serialize};

/// Places and sizes in the part's frame, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Mounting {
    /// Entrance pupil of the lens; none for a telecentric camera.
    pub pupil_mm: Option<[f64; 3]>,
    /// Unit vector along which the camera looks; none where that is -Z and the camera is on the part's axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub looks_along: Option<[f64; 3]>,
    /// Origin of the target's azimuth and elevation; none for a world far away, and
    /// without a projection.
    pub target_origin_mm: Option<[f64; 3]>,
    /// Length of the part along each axis, its border included.
    pub size_mm: [f64; 3],
    /// Z of the mirror's mean height: at the geometric mean of the depths below the pupil over the
    /// picture, for a telecentric camera the mean of Z over the plan.
    pub mean_mm: f64,
    /// Unit vector towards elevation 90 degrees.
    pub up: [f64; 3],
}

impl Mounting {
    /// Of a part on its base whose mirror reaches up to `top_mm`.
    #[must_use]
    pub(super) fn new(
        mirror: &Mirror,
        camera: &Camera,
        view: Option<&ImagingTask>,
        border: Option<&Border>,
        top_mm: f64,
    ) -> Self {
        let on_axis = |z: f64| [0.0, 0.0, z];
        let size = border::plan_bounds(mirror, border).size();
        let origin = |view: &ImagingTask| match &view.target {
            Target::Infinity => None,
            Target::Cylinder { .. } | Target::Plane { .. } => Some(on_axis(view.origin_mm)),
            Target::Posed(target) => {
                Some((target.viewpoint_mm() + DVec3::Z * view.origin_mm).to_array())
            }
        };
        Self {
            pupil_mm: camera.chart.pupil().map(|pupil| pupil.to_array()),
            // (No negative zero.)
            looks_along: (!camera.picture.is_over_axis())
                .then(|| (-camera.axis()).to_array().map(|part| part + 0.0)),
            target_origin_mm: view.and_then(origin),
            size_mm: size.extend(top_mm).to_array(),
            mean_mm: mirror.mean_mm(&camera.chart),
            up: on_axis(1.0),
        }
    }

    /// Camera, size and target in words, the camera first.
    #[must_use]
    pub fn statements(&self) -> Vec<String> {
        vec![self.camera(), format!("part {}", self.size()), self.world()]
    }

    /// Place of the camera in words.
    #[must_use]
    pub fn camera(&self) -> String {
        match (self.pupil_mm, self.looks_along) {
            (Some([x, y, z]), Some(_)) => {
                format!("entrance pupil at X {x:.3}, Y {y:.3}, Z {z:.3} mm")
            }
            (Some([.., z]), None) => format!("entrance pupil at Z {z:.3} mm"),
            (None, _) => "telecentric camera".into(),
        }
    }

    /// Where the camera looks, and which way up, in words.
    #[must_use]
    pub fn looks(&self) -> String {
        let Some([x, y, z]) = self.looks_along else {
            return "on the axis, looking along -Z; the picture's top is +Y".into();
        };
        let tilt = degrees(acos((-z).clamp(-1.0, 1.0)));
        format!("looking along ({x:.6}, {y:.6}, {z:.6}), {tilt:.2} deg off the part's normal")
    }

    /// The part's size in words.
    #[must_use]
    pub fn size(&self) -> String {
        let [x, y, z] = self.size_mm;
        format!("{x:.2} x {y:.2} x {z:.2} mm")
    }

    /// Origin of directions in words.
    #[must_use]
    pub fn world(&self) -> String {
        let target = match self.target_origin_mm {
            Some([0.0, 0.0, z]) => format!("target's origin at Z {z:.3} mm"),
            Some([x, y, z]) => format!("viewpoint at X {x:.3}, Y {y:.3}, Z {z:.3} mm"),
            None => "target far away".into(),
        };
        format!("elevation 90 deg is +Z, azimuth 0 is +Y, 90 deg is +X; {target}")
    }
}
