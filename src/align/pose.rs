//! Rigid motions, with the same bits on every machine.

use crate::geom::DVec3;
use crate::num::{atan2, cos, sin};
use glam::{DMat3, DQuat};

/// The motion p -> rotation p + shift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// A unit quaternion.
    pub rotation: DQuat,
    /// mm.
    pub shift: DVec3,
}

impl Pose {
    /// No motion at all.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, shift: DVec3::ZERO };

    /// A turn about an axis through `centre`, which goes to `to`. `turn` has the axis' direction and
    /// the angle's length, radians.
    #[must_use]
    pub fn about(centre: DVec3, to: DVec3, turn: DVec3) -> Self {
        let angle = turn.length();
        let axis = if angle > 0.0 { turn / angle } else { DVec3::ZERO };
        let v = axis * sin(0.5 * angle);
        let rotation = DQuat::from_xyzw(v.x, v.y, v.z, cos(0.5 * angle)).normalize();
        Self { rotation, shift: to - rotation * centre }
    }

    /// This motion, and then `next`.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        Self {
            rotation: (next.rotation * self.rotation).normalize(),
            shift: next.rotation * self.shift + next.shift,
        }
    }

    /// The motion that undoes this one.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { rotation, shift: -(rotation * self.shift) }
    }

    /// The rotation as a matrix.
    #[must_use]
    pub fn matrix(&self) -> DMat3 {
        DMat3::from_quat(self.rotation)
    }

    /// Where a place goes, mm.
    #[must_use]
    pub fn apply(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.shift
    }

    /// The rotation as a vector along its axis, as long as its angle, radians.
    #[must_use]
    pub fn rotation_vector(&self) -> DVec3 {
        let DQuat { x, y, z, w } = self.rotation;
        let v = DVec3::new(x, y, z) * if w < 0.0 { -1.0 } else { 1.0 };
        let sine = v.length();
        // 2 atan(s/c) / s tends to 2 / c.
        let scale = if sine > 1e-9 { 2.0 * atan2(sine, w.abs()) / sine } else { 2.0 };
        v * scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_compose_and_are_undone() {
        let a = Pose::about(DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 2.0, 2.5), DVec3::X * 0.3);
        let b = Pose::about(DVec3::Y, DVec3::Z, DVec3::new(0.1, -0.2, 2.0));
        let p = DVec3::new(-7.0, 5.0, 11.0);
        assert!((a.then(&b).apply(p) - b.apply(a.apply(p))).length() < 1e-14);
        assert!((b.then(&b.inverse()).apply(p) - p).length() < 1e-14);
        assert!((a.matrix() * p + a.shift - a.apply(p)).length() < 1e-14);
        assert!((a.apply(DVec3::new(1.0, 2.0, 3.0)) - DVec3::new(2.0, 2.0, 2.5)).length() < 1e-15);
        assert!((b.rotation_vector() - DVec3::new(0.1, -0.2, 2.0)).length() < 1e-14);
        // A quarter turn about Z takes X to Y.
        let quarter = Pose::about(DVec3::ZERO, DVec3::ZERO, DVec3::Z * std::f64::consts::FRAC_PI_2);
        assert!((quarter.apply(DVec3::X) - DVec3::Y).length() < 1e-15);
        assert!((Pose::about(p, p, DVec3::Z * 1e-12).rotation_vector().z - 1e-12).abs() < 1e-24);
    }
}
