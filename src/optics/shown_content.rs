//! What image points are to show, and what reflected rays show: directions, and where in the picture those belong.

use super::{ImagingTask, Projection, Target, stereographic};
use crate::geom::{DVec2, DVec3};
use crate::num::Lanes;

/// Something in the world, and where in the picture it belongs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShownContent {
    /// Direction from the target's origin, as a stereographic coordinate of the designed panel.
    direction: [f64; 2],
    /// Image point, mm.
    pub image: DVec2,
}

/// A reflected ray.
#[derive(Debug, Clone, Copy)]
pub struct ReflectedRay {
    /// Where it leaves the mirror, mm; for targets at infinity anywhere.
    pub at: DVec3,
    /// Its unit direction.
    pub direction: DVec3,
    /// The image point of its camera ray, mm.
    pub near: DVec2,
    /// What image points of that column share ([`ImagingTask::turn`]).
    pub turn: [f64; 2],
}

/// Rays of which the content is found side by side.
const LANES: usize = 4;

impl ShownContent {
    /// Nothing.
    pub const NONE: Self = Self { direction: [0.0; 2], image: DVec2::ZERO };
}

impl ImagingTask {
    /// Whether what is seen in a direction is the same from everywhere.
    #[inline]
    #[must_use]
    pub fn is_at_infinity(&self) -> bool {
        matches!(self.target, Target::Infinity)
    }

    /// What an image point, on any panel, of which turn and rise are known must see.
    #[inline]
    #[must_use]
    pub fn wanted(&self, (image, turn): (DVec2, [f64; 2]), rise: f64) -> ShownContent {
        let direction = match &self.projection {
            Projection::Strip(_) => turn.map(|x| x * rise),
            other => other.direction_of((image * self.flip(image).truncate()).to_array()),
        };
        ShownContent { direction, image }
    }

    /// The unit direction in which content is seen from the mirror point `at` of its image point's panel.
    #[inline]
    #[must_use]
    pub fn direction_to(&self, content: &ShownContent, at: DVec3) -> DVec3 {
        let flip = self.flip(content.image);
        let from = self.relative((at * flip).to_array());
        flip * stereographic::direction(self.target.direction_at(from, content.direction))
    }

    /// The unit direction that image point `q`, on any panel, must see from the mirror point `at`.
    #[must_use]
    pub fn direction_of(&self, q: DVec2, at: DVec3) -> DVec3 {
        self.direction_to(&self.wanted((q, self.turn(q.x)), self.rise(q.y)), at)
    }

    /// What a ray shows that leaves `at` in the unit direction `direction`, on the panel of `near` or beyond its rim.
    #[must_use]
    pub fn shown(&self, at: DVec3, direction: DVec3, near: DVec2) -> ShownContent {
        self.shown_turned(at, direction, (near, self.turn(near.x)))
    }

    /// [`ImagingTask::shown`] near an image point of which the turn is known.
    #[must_use]
    pub fn shown_turned(
        &self,
        at: DVec3,
        direction: DVec3,
        (near, turn): (DVec2, [f64; 2]),
    ) -> ShownContent {
        let direction = self.seen_from(at, direction, near);
        ShownContent { direction, image: self.image_of_direction(direction, (near, turn)) }
    }

    /// What reflected rays near image points of one row show, each beside known content of its panel: what
    /// [`ImagingTask::shown_turned`] finds but for the last bits, in less time where the two are close. (Half a turn from
    /// `near` it goes on where that begins anew on the other side.)
    #[must_use]
    pub fn shown_beside(&self, rays: &[(ReflectedRay, ShownContent)]) -> Vec<ShownContent> {
        let seen = |(ray, _): &(ReflectedRay, ShownContent)| ShownContent {
            direction: self.seen_from(ray.at, ray.direction, ray.near),
            image: DVec2::NAN,
        };
        let mut shown: Vec<ShownContent> = rays.iter().map(seen).collect();
        let (some, rest) = shown.as_chunks_mut::<LANES>();
        let (rays_of_some, rays_of_rest) = rays.as_chunks::<LANES>();
        for (shown, rays) in some.iter_mut().zip(rays_of_some) {
            if !self.place_beside(shown, rays) {
                self.place_each(shown, rays);
            }
        }
        self.place_each(rest, rays_of_rest);
        shown
    }

    /// Finds the image points of directions, one by one.
    fn place_each(&self, shown: &mut [ShownContent], rays: &[(ReflectedRay, ShownContent)]) {
        for (shown, ray) in shown.iter_mut().zip(rays) {
            if !self.place_beside(std::array::from_mut(shown), &[*ray]) {
                let ReflectedRay { near, turn, .. } = ray.0;
                shown.image = self.image_of_direction(shown.direction, (near, turn));
            }
        }
    }

    /// Finds the image points of directions beside known ones, if all of them are close to those.
    pub(super) fn place_beside<const L: usize>(
        &self,
        shown: &mut [ShownContent; L],
        rays: &[(ReflectedRay, ShownContent); L],
    ) -> bool {
        let Projection::Strip(strip) = &self.projection else { return false };
        if !strip.law.has_steps() {
            return false;
        }
        let flip = rays.first().map_or(DVec2::ONE, |(ray, _)| self.flip(ray.near).truncate());
        let seen = Lanes::of_points(shown.each_ref().map(|content| content.direction));
        let known = Lanes::of_points(rays.each_ref().map(|(_, known)| known.direction));
        let image =
            Lanes::of_points(rays.each_ref().map(|(_, known)| (known.image * flip).to_array()));
        let Some([x, y]) = strip.images_beside(seen, (known, image)) else { return false };
        for (k, shown) in shown.iter_mut().enumerate() {
            shown.image = DVec2::new(x.0[k], y.0[k]) * flip;
        }
        true
    }

    /// The image point, on the panel of `near` or beyond its rim, where that belongs which a ray
    /// that leaves `at` in the unit direction `direction` shows.
    #[must_use]
    pub fn image_of(&self, at: DVec3, direction: DVec3, near: DVec2) -> DVec2 {
        self.shown(at, direction, near).image
    }

    /// The direction from the target's origin, of the designed panel, of what a ray shows on the panel of `near`.
    #[inline]
    fn seen_from(&self, at: DVec3, direction: DVec3, near: DVec2) -> [f64; 2] {
        let flip = self.flip(near);
        let from = self.relative((at * flip).to_array());
        self.target.direction_from_origin(from, stereographic::sigma((direction * flip).to_array()))
    }

    /// The image point, on the panel of `near`, where a direction of the designed panel belongs.
    fn image_of_direction(&self, direction: [f64; 2], (near, turn): (DVec2, [f64; 2])) -> DVec2 {
        let flip = self.flip(near).truncate();
        let place = match &self.projection {
            Projection::Strip(strip) => strip.image_of_turned(direction, near * flip, turn),
            other => other.image_of(direction, near * flip),
        };
        DVec2::from_array(place) * flip
    }
}
