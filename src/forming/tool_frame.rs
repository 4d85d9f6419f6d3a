//! The frame of a forming tool, and where its face and its walls are in it.

use super::parallel_surface::ParallelSurface;
use crate::geom::{DVec2, DVec3, Outline};
use crate::mirror::Mirror;
use crate::num::{radians, tan};
use crate::profile::{FormingSpec, ToolForm};

/// Steps along each side of the outline, which is curved under a pinhole: finer than a mesh's.
const STEPS: usize = 1024;
/// A corner of the outline, as a share of half its width: above what rounding to single precision moves a vertex by.
const CORNER: f64 = 1e-5;

/// The frame of a tool: lengths in mm of its own, unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolFrame {
    /// What is asked.
    pub spec: FormingSpec,
    /// Z of the plane in which its walls end.
    pub flange_mm: f64,
    /// The same in the part's frame.
    pub(super) foot_mm: f64,
}

impl ToolFrame {
    /// The surface of its face in the part's frame.
    #[must_use]
    pub fn surface<'m>(&self, mirror: &'m Mirror) -> ParallelSurface<'m> {
        ParallelSurface { mirror, offset_mm: self.spec.offset_mm() }
    }

    /// Its Z for a point of the part's frame, and its X and Y: larger by the growth, and of a mould turned about X.
    #[must_use]
    pub fn from_part(&self, p: DVec3) -> DVec3 {
        let p = self.spec.growth() * (p - DVec3::Z * self.foot_mm);
        self.turned(p) + DVec3::Z * self.flange_mm
    }

    /// The inverse of [`Self::from_part`].
    #[must_use]
    pub fn to_part(&self, v: DVec3) -> DVec3 {
        let p = self.turned(v - DVec3::Z * self.flange_mm);
        p / self.spec.growth() + DVec3::Z * self.foot_mm
    }

    /// The unit normal out of its material where the mirror beside its face has the unit normal `normal`.
    #[must_use]
    pub fn outward(&self, normal: DVec3) -> DVec3 {
        let turned = self.turned(normal);
        if self.is_hollow() { -turned } else { turned }
    }

    /// A mould is turned by half a turn about X.
    fn turned(&self, p: DVec3) -> DVec3 {
        match self.spec.form {
            ToolForm::Mandrel => p,
            ToolForm::Mould => DVec3::new(p.x, -p.y, -p.z),
        }
    }

    /// Whether its face is below the plane of its foot.
    #[must_use]
    pub fn is_hollow(&self) -> bool {
        self.spec.form == ToolForm::Mould
    }

    /// The foot of the walls below the place `p` of the face's edge, which is beside `q` in image coordinates of `mirror`:
    /// outwards by the draft, square to the sides of a rectangle, and to both at its corners.
    #[must_use]
    pub fn foot_below(&self, mirror: &Mirror, q: DVec2, p: DVec3) -> DVec2 {
        let way = match mirror.full_outline() {
            Outline::Ring { .. } => q.try_normalize().unwrap_or(DVec2::X),
            Outline::Rect(outline) => {
                let share = 2.0 * (q - outline.centre()) / outline.size();
                let far = share.abs().max_element();
                let on_side = |s: f64| if s.abs() >= far - CORNER { s.signum() } else { s / far };
                DVec2::new(on_side(share.x), on_side(share.y))
            }
        };
        let out = self.slant() * (p.z - self.flange_mm).abs();
        p.truncate() + out * self.turned(way.extend(0.0)).truncate()
    }

    /// Tangent of the draft.
    #[must_use]
    pub fn slant(&self) -> f64 {
        tan(radians(self.spec.draft_deg))
    }

    /// The rim of its face, each place with that of the mirror beside it in image coordinates: the outer rim, 0, or the inner
    /// one of a ring, 1.
    pub(super) fn rim(&self, mirror: &Mirror, number: usize) -> Vec<(DVec2, DVec3)> {
        let surface = self.surface(mirror);
        let rim = mirror.full_outline().rims(STEPS).into_iter().nth(number).unwrap_or_default();
        let at = |q: DVec2| self.from_part(surface.beside(&mirror.extended_surface(q)));
        rim.into_iter().map(|q| (q, at(q))).collect()
    }
}
