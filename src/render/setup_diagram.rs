//! A projection's setup as a picture: the image plane, the mirror, and the cylinder around it.

use std::f64::consts::PI;

use crate::parallel;

use super::material::{Lighting, Material};
use super::picture::Picture;
use super::samples::SampleGrid;
use super::shaded_views::DistantView;
use super::solid_of_revolution::SolidOfRevolution;
use super::test_world::TestWorld;
use crate::geom::{DVec2, DVec3, Ray, Rect};
use crate::num::{cos, sin};
use crate::trace::Scene;

/// Columns and rows of the picture.
const PIXELS: [u32; 2] = [640, 480];
const SAMPLES: u32 = 4;
/// Where the eye is, degrees: to the right of the picture's foot, and over the base plane.
const EYE_DEG: [f64; 2] = [24.0, 24.0];
/// Share of the picture that is filled at most.
const FILL: f64 = 0.94;
/// Radius of the rays as drawn, as a share of the cylinder's.
const THICK: f64 = 0.006;

/// Contents of the diagram, in the part frame, mm.
pub struct SetupDiagram<'a> {
    /// The part.
    pub scene: &'a Scene,
    /// Rectangle of the image, which is drawn in the plane Z = `image_mm`, in X and Y.
    pub image: Rect,
    /// Where its plane is.
    pub image_mm: f64,
    /// Radius of the cylinder about the axis, on which the test world is painted.
    pub radius_mm: f64,
    /// Z of its foot, of its horizon and of its top.
    pub heights_mm: [f64; 3],
    /// Rays: from the image, by the mirror, to the cylinder.
    pub rays: Vec<[DVec3; 3]>,
}

impl SetupDiagram<'_> {
    /// Draws it, the front half of the cylinder cut away; `shown` is the direction that an image point
    /// shows, if any.
    #[must_use]
    pub fn picture(&self, shown: impl Fn(DVec2) -> Option<DVec3> + Sync) -> Picture {
        let eye = DistantView::new(EYE_DEG);
        let world = TestWorld::new();
        let [lo, hi] = self.span(&eye);
        let [columns, rows] = PIXELS.map(f64::from);
        let per_mm = FILL * (columns / (hi - lo).x).min(rows / (hi - lo).y);
        let tubes = self.tubes();
        let reach = 4.0 * (hi - lo).length();
        let footprint = 1.0 / (per_mm * self.radius_mm);
        let light = |x: f64, y: f64| {
            let aside = DVec2::new(x - 0.5 * columns, 0.5 * rows - y) / per_mm;
            let at = 0.5 * (lo + hi) + aside;
            let origin = eye.right * at.x + eye.up * at.y + eye.towards * reach;
            let ray = Ray { origin, direction: -eye.towards };
            self.light(
                &eye.lights(),
                &ray,
                &tubes,
                |direction| world.colour(direction, footprint),
                &shown,
            )
        };
        let [width, height] = PIXELS;
        let grid = SampleGrid { width, height, samples_per_side: SAMPLES, pixel_rad: footprint };
        let centre = |k| [k % width, k / width].map(|n: u32| f64::from(n) + 0.5);
        let coarse = parallel::map((width * height) as usize, 1, |k| {
            let [x, y] = centre(k as u32);
            light(x, y)
        });
        Picture::refined(&grid, &coarse, light)
    }

    fn light(
        &self,
        lights: &Lighting,
        ray: &Ray,
        tubes: &[SolidOfRevolution],
        painted: impl Fn(DVec3) -> [f32; 3],
        shown: impl Fn(DVec2) -> Option<DVec3>,
    ) -> [f32; 3] {
        let mut end = f64::INFINITY;
        let mut light = [1.0; 3];
        if let Some((t, direction)) = self.wall(ray) {
            (end, light) = (t, painted(direction));
        }
        let t = (self.image_mm - ray.origin.z) / ray.direction.z;
        let q = ray.at(t).truncate();
        if t < end && self.image.contains(q) {
            (end, light) = (t, shown(q).map_or([0.3; 3], &painted));
        }
        if let Some(hit) = self.scene.nearest_hit(ray).filter(|hit| hit.t < end) {
            let normal = self.scene.mesh().area_vector(hit.facet as usize).normalize_or(DVec3::Z);
            end = hit.t;
            light = lights.shade(&Material::new(0x9fb3c8, 0.35), normal, ray.direction, true);
        }
        for tube in tubes {
            if let Some(contact) = tube.intersect(ray, end) {
                end = contact.t;
                light = lights.shade(
                    &Material::new(0xd03a20, 0.2),
                    contact.normal,
                    ray.direction,
                    true,
                );
            }
        }
        light
    }

    /// Where `ray` meets the inside of the cylinder's back half, and in which direction from the middle
    /// of its horizon that is.
    fn wall(&self, ray: &Ray) -> Option<(f64, DVec3)> {
        let (o, d) = (ray.origin.truncate(), ray.direction.truncate());
        let (a, b) = (d.length_squared(), o.dot(d));
        let root = b * b - a * (o.length_squared() - self.radius_mm * self.radius_mm);
        // The farther of two.
        let t = (root.sqrt() - b) / a;
        let at = ray.at(t);
        let [foot, horizon, top] = self.heights_mm;
        let inside = root > 0.0 && (foot..=top).contains(&at.z);
        inside.then(|| (t, (at - DVec3::Z * horizon).normalize()))
    }

    fn tubes(&self) -> Vec<SolidOfRevolution> {
        let thick = THICK * self.radius_mm;
        let tube = |from: DVec3, to: DVec3| {
            let length = (to - from).length();
            let outline = vec![vec![[thick, 0.0], [thick, length]]];
            (length > 0.0).then(|| SolidOfRevolution::new(from, (to - from) / length, &outline))
        };
        let both =
            |[image, mirror, wall]: &[DVec3; 3]| [tube(*image, *mirror), tube(*mirror, *wall)];
        self.rays.iter().flat_map(both).flatten().collect()
    }

    /// The corner points of all that the eye sees.
    fn span(&self, eye: &DistantView) -> [DVec2; 2] {
        let mut points = Vec::new();
        for k in 0..=64 {
            let angle = PI * f64::from(k) / 64.0;
            let away = (eye.right * cos(angle)).truncate()
                - (eye.towards.truncate().normalize() * sin(angle));
            let rim = |z: f64| (away * self.radius_mm).extend(z);
            points.extend([rim(self.heights_mm[0]), rim(self.heights_mm[2])]);
        }
        let Rect { min, max } = self.image;
        for corner in [min, DVec2::new(min.x, max.y), DVec2::new(max.x, min.y), max] {
            points.push(corner.extend(self.image_mm));
        }
        points.extend(&self.scene.mesh().vertices);
        let nothing = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let wider = |[lo, hi]: [DVec2; 2], p: DVec2| [lo.min(p), hi.max(p)];
        points.into_iter().map(|v| eye.project(v)).fold(nothing, wider)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::TriMesh;

    fn setup(scene: &Scene) -> SetupDiagram<'_> {
        let rays = vec![[DVec3::new(0.0, 0.0, 30.0), DVec3::ZERO, DVec3::new(0.0, 20.0, 0.0)]];
        SetupDiagram {
            scene,
            image: Rect { min: DVec2::new(-5.0, -2.0), max: DVec2::new(5.0, 2.0) },
            image_mm: 30.0,
            radius_mm: 20.0,
            heights_mm: [-8.0, 1.0, 9.0],
            rays,
        }
    }

    #[test]
    fn the_wall_is_met_inside_and_behind_the_axis() {
        let scene = Scene::new(TriMesh::default());
        let setup = setup(&scene);
        let eye = DistantView::new(EYE_DEG);
        let back = -eye.towards.truncate().normalize() * 20.0;
        for z in [-7.9, 0.0, 8.9] {
            let at = back.extend(z);
            let ray = Ray { origin: at + eye.towards * 500.0, direction: -eye.towards };
            let (t, direction) = setup.wall(&ray).unwrap();
            assert!((t - 500.0).abs() < 1e-9);
            assert!((direction - (at - DVec3::Z).normalize()).length() < 1e-12);
        }
        for z in [-8.1, 9.1] {
            let ray = Ray { origin: back.extend(z) + eye.towards * 500.0, direction: -eye.towards };
            assert!(setup.wall(&ray).is_none());
        }
    }

    #[test]
    fn image_wall_and_rays_are_in_the_picture() {
        let scene = Scene::new(TriMesh::default());
        let setup = setup(&scene);
        let picture = setup.picture(|_| None);
        let count =
            |pick: fn(&[u8]) -> bool| picture.rgb.chunks_exact(3).filter(|code| pick(code)).count();
        let grey = count(|code| code == [149; 3]);
        let red = count(|code| code[0] / 2 > code[1].max(40));
        let white = count(|code| code == [255; 3]);
        // 10 x 4 mm seen at 24 degrees, and two rods 0.24 mm thick, 12.7 pixels to the millimetre.
        assert!(
            (2000..3000).contains(&grey) && red > 500 && white > 100_000,
            "{grey} {red} {white}"
        );
        assert!(grey + red + white < 300_000);
    }
}
