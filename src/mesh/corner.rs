//! What a net may know of its corners: where they are, or also what the mirror does there.

use super::needs::{Needs, Place};
use super::proof::Vertex;
use crate::geom::{DVec2, DVec3};
use glam::{DMat3, Vec3Swizzles};

/// What a net knows of a corner.
pub trait Corner: Copy {
    /// Whether every triangle is asked at its own place, lest flips go round in circles.
    const EACH: bool;

    /// Place in the mirror's chart, mm.
    fn q(&self) -> DVec2;

    /// By how much the errors of a triangle at `place` exceed what they may be, in areas.
    fn excess(needs: &Needs, place: &Place, triangle: [&Self; 3]) -> f64;

    /// About what corners a little beside it would be, of which `neighbours` tell enough.
    fn beside<'a>(&self, neighbours: impl Iterator<Item = &'a Self>) -> impl Fn(DVec2) -> Self
    where
        Self: 'a;
}

/// Where it is: errors are those of the quadratic model.
impl Corner for DVec2 {
    const EACH: bool = false;

    #[inline]
    fn q(&self) -> DVec2 {
        *self
    }

    #[inline]
    fn excess(needs: &Needs, place: &Place, [a, b, c]: [&Self; 3]) -> f64 {
        needs.excess(place, b - a, c - a)
    }

    fn beside<'a>(&self, _: impl Iterator<Item = &'a Self>) -> impl Fn(DVec2) -> Self {
        |q| q
    }
}

/// What the mirror does there: errors follow from it.
impl Corner for Vertex {
    const EACH: bool = true;

    #[inline]
    fn q(&self) -> DVec2 {
        self.q
    }

    #[inline]
    fn excess(needs: &Needs, place: &Place, triangle: [&Self; 3]) -> f64 {
        needs.excess_of(place, triangle)
    }

    fn beside<'a>(&self, neighbours: impl Iterator<Item = &'a Self>) -> impl Fn(DVec2) -> Self {
        // Least squares: the Hessian that turns ways to neighbours into changes of the gradient.
        let (mut ways, mut changes) = (DVec3::ZERO, DVec3::ZERO);
        for other in neighbours {
            let (d, g) = (other.q - self.q, other.gradient - self.gradient);
            ways += DVec3::new(d.x * d.x, d.x * d.y, d.y * d.y);
            changes += DVec3::new(d.x * g.x, d.x * g.y + d.y * g.x, d.y * g.y);
        }
        let DVec3 { x: xx, y: xy, z: yy } = ways;
        let normal = DMat3::from_cols_array(&[xx, xy, 0.0, xy, xx + yy, xy, 0.0, xy, yy]);
        let hessian = normal.inverse() * changes;
        let own = *self;
        move |q| {
            let d = q - own.q;
            let bend = DVec2::new(hessian.xy().dot(d), hessian.yz().dot(d));
            let h = own.h + (own.gradient + bend * 0.5).dot(d);
            Self { q, h, gradient: own.gradient + bend, ..own }
        }
    }
}
