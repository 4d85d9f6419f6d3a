//! The errors of a perturbed system, and the pose that they give the part.

use crate::num::{Arithmetic, Lanes, Scalar};
use crate::tolerance_terms::Misalignment;

/// Errors of a perturbed system.
#[derive(Debug, Clone, PartialEq)]
pub struct PerturbedState<S> {
    /// Placement of mirror and camera.
    pub misalignment: Misalignment<S>,
    /// Amplitudes of the form errors, mm.
    pub form: Vec<f64>,
    /// Amplitudes of the waviness' cosine and sine, mm, if there is any.
    pub wave: Option<[f64; 2]>,
    /// Share of the measured form error, if there is any.
    pub map: Option<f64>,
    /// From tool track to track, mm, and where between two tracks the origin lies, in [0, 1), if
    /// there are any.
    pub tracks: Option<[f64; 2]>,
    /// Share of the light that flat terraces reflect, 0 to 1.
    pub terraced: f64,
}

impl<S: Scalar> PerturbedState<S> {
    /// The state without errors, of a system with so many form errors.
    pub fn perfect(forms: usize) -> Self {
        let zero = S::constant(0.0);
        Self {
            misalignment: Misalignment::from_fn(|_| zero),
            form: vec![0.0; forms],
            wave: None,
            map: None,
            tracks: None,
            terraced: 0.0,
        }
    }
}

impl PerturbedState<f64> {
    /// Whether mirror and rays are as designed.
    pub fn is_perfect(&self) -> bool {
        let none = |x: f64| x == 0.0;
        self.misalignment.values().into_iter().all(none)
            && self.form.iter().copied().all(none)
            && self.wave.into_iter().flatten().all(none)
            && self.map.is_none_or(none)
            && self.tracks.is_none()
            && none(self.terraced)
    }
}

/// Pose of the part in the world: grown by `scale`, turned by `turn`, then shifted.
#[derive(Debug, Clone)]
pub(crate) struct PartPose<S> {
    /// Rows of the rotation.
    turn: [[S; 3]; 3],
    /// Shift, mm.
    pub shift: [S; 3],
    /// Size against that of the designed part.
    pub scale: S,
}

impl<S: Scalar> PartPose<S> {
    /// The pose that a misalignment gives the part.
    pub(crate) fn new(misalignment: &Misalignment<S>) -> Self {
        let m = misalignment;
        let [x, y, z] = [m.tilt_x_rad, m.tilt_y_rad, m.clocking_rad];
        let (sx, cx, sy, cy, sz, cz) = (x.sin(), x.cos(), y.sin(), y.cos(), z.sin(), z.cos());
        // About X, then Y, then Z.
        let turn = [
            [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
            [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
            [-sy, cy * sx, cy * cx],
        ];
        Self { turn, shift: [m.shift_x_mm, m.shift_y_mm, m.shift_z_mm], scale: m.growth + 1.0 }
    }
}

impl<const L: usize> PartPose<Lanes<L>> {
    /// Several poses side by side.
    pub(crate) fn side_by_side(poses: [&PartPose<f64>; L]) -> Self {
        let of = |value: &dyn Fn(&PartPose<f64>) -> f64| Lanes(poses.map(value));
        Self {
            turn: [0, 1, 2].map(|i| [0, 1, 2].map(|j| of(&|pose| pose.turn[i][j]))),
            shift: [0, 1, 2].map(|k| of(&|pose| pose.shift[k])),
            scale: of(&|pose| pose.scale),
        }
    }
}

impl<S: Arithmetic> PartPose<S> {
    /// A direction of the part, in the world.
    pub(crate) fn to_world(&self, v: [S; 3]) -> [S; 3] {
        self.turn.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// A direction of the world, in the part.
    pub(crate) fn to_part(&self, v: [S; 3]) -> [S; 3] {
        let m = &self.turn;
        [0, 1, 2].map(|k| m[0][k] * v[0] + m[1][k] * v[1] + m[2][k] * v[2])
    }
}
