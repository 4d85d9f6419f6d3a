//! Shaded views of a part: from the camera, from the foot of the picture, and three quarters.

use crate::parallel;

use super::material::{Lighting, Material};
use super::picture::Picture;
use super::samples::SampleGrid;
use crate::design::Design;
use crate::geom::{DVec2, DVec3, Ray};
use crate::num::{cos, radians, sin};
use crate::trace::Scene;

/// Pixels of one view, across and down.
pub(super) const TILE: [u32; 2] = [480, 360];
/// Pixels of a still picture of the part, across and down.
const STILL_TILE: [u32; 2] = [400, 300];
/// Samples along each side of a pixel at edges.
const SAMPLES: u32 = 4;
/// The same of a still picture.
const STILL_SAMPLES: u32 = 2;
/// Share of a tile that the part fills at most.
const FILL: f64 = 0.92;
/// Where the eye is, degrees: to the right of the picture's foot, and over the base plane.
const EYES_DEG: [[f64; 2]; 3] = [[0.0, 90.0], [0.0, 14.0], [38.0, 34.0]];

/// An orthographic view from afar: unit vectors to the right, upwards and towards the viewer.
#[derive(Debug, Clone, Copy)]
pub(super) struct DistantView {
    /// To the right in the picture.
    pub right: DVec3,
    /// Up in it.
    pub up: DVec3,
    /// Towards the eye.
    pub towards: DVec3,
}

impl DistantView {
    /// An eye `turn_deg` to the right of the picture's foot and `rise_deg` over the base plane.
    #[must_use]
    pub(super) fn new([turn_deg, rise_deg]: [f64; 2]) -> Self {
        let [turn, rise] = [turn_deg, rise_deg].map(radians);
        let right = DVec3::new(cos(turn), sin(turn), 0.0);
        let towards = DVec3::new(sin(turn) * cos(rise), -cos(turn) * cos(rise), sin(rise));
        Self { right, up: towards.cross(right), towards }
    }

    /// A lamp above it on the left.
    #[must_use]
    pub(super) fn lights(&self) -> Lighting {
        let lamp = 0.62 * self.towards + 0.62 * self.up - 0.48 * self.right;
        Lighting { up: self.up, lamp: lamp.normalize() }
    }

    /// Where it sees `v`, mm to the right and up.
    #[must_use]
    pub(super) fn project(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.right), v.dot(self.up))
    }
}

/// Three views of the mesh side by side on white, all to one scale. Facets are flat; where `normal`
/// knows a normal at a place of the mesh, that is taken instead.
#[must_use]
pub fn shaded_views(scene: &Scene, normal: impl Fn(DVec3) -> Option<DVec3> + Sync) -> Picture {
    tiles(scene, &EYES_DEG, TILE, SAMPLES, &normal)
}

/// One view of the mesh, from three quarters, with flat facets.
#[must_use]
pub fn shaded_view(scene: &Scene) -> Picture {
    tiles(scene, &EYES_DEG[2..], STILL_TILE, STILL_SAMPLES, &|_| None)
}

/// A normal at a place of a mesh, where it is known.
type KnownNormal<'a> = &'a (dyn Fn(DVec3) -> Option<DVec3> + Sync);

/// Views by `eyes` side by side on white, all to one scale.
fn tiles(
    scene: &Scene,
    eyes: &[[f64; 2]],
    tile: [u32; 2],
    samples: u32,
    normal: KnownNormal,
) -> Picture {
    let eyes: Vec<DistantView> = eyes.iter().copied().map(DistantView::new).collect();
    let vertices = &scene.mesh().vertices;
    let span = |eye: &DistantView| {
        let nothing = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        vertices.iter().map(|&v| eye.project(v)).fold(nothing, |[lo, hi], p| [lo.min(p), hi.max(p)])
    };
    let spans: Vec<[DVec2; 2]> = eyes.iter().map(span).collect();
    let [columns, rows] = tile.map(f64::from);
    let fit = spans.iter().map(|[lo, hi]| {
        let size = (hi - lo).max(DVec2::splat(f64::MIN_POSITIVE));
        (columns / size.x).min(rows / size.y)
    });
    let pixels_per_mm = FILL * fit.fold(f64::INFINITY, f64::min);
    let reach =
        scene.mesh().bounds().map_or(1.0, |(lo, hi)| 2.0 * (lo.abs().max(hi.abs())).length());
    let matter = Material::new(0x9fb3c8, 0.35);
    let light = |x: f64, y: f64| {
        let tile = (x / columns) as usize;
        let (eye, [lo, hi]) = (&eyes[tile], spans[tile]);
        let aside = DVec2::new(x - columns * (tile as f64 + 0.5), 0.5 * rows - y) / pixels_per_mm;
        let at = 0.5 * (lo + hi) + aside;
        let origin = eye.right * at.x + eye.up * at.y + eye.towards * reach;
        let ray = Ray { origin, direction: -eye.towards };
        let Some(hit) = scene.nearest_hit(&ray) else { return [1.0; 3] };
        let facet = || scene.mesh().area_vector(hit.facet as usize).normalize_or(eye.towards);
        let outward = normal(ray.at(hit.t)).unwrap_or_else(facet);
        eye.lights().shade(&matter, outward, ray.direction, true)
    };
    let [width, height] = [tile[0] * eyes.len() as u32, tile[1]];
    let grid = SampleGrid { width, height, samples_per_side: samples, pixel_rad: 0.0 };
    let centre = |k| [k % width, k / width].map(|n| f64::from(n) + 0.5);
    let coarse = parallel::map((width * height) as usize, 1, |k| {
        let [x, y] = centre(k as u32);
        light(x, y)
    });
    Picture::refined(&grid, &coarse, light)
}

/// The designed mirror's unit normal at a place of its optical face.
#[must_use]
pub(crate) fn optical_normal(design: &Design, at: DVec3) -> Option<DVec3> {
    let mirror = &design.mirror;
    let (place, height) = mirror.chart.coordinates(at);
    let point = mirror.row(place.y).at(place.x);
    let near = 1e-3 * mirror.outline.bounds().size().max_element();
    let on_face = mirror.full_outline().contains(place) && (height - point.f).abs() < near;
    on_face.then(|| mirror.normal(place, &point).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::TriMesh;

    /// A box from -w to w.
    fn block(w: DVec3) -> TriMesh {
        let corner = |k: u32| {
            let sign = |bit: u32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
            DVec3::new(sign(0), sign(1), sign(2)) * w
        };
        let quad = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        let sides =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        TriMesh {
            vertices: (0..8).map(corner).collect(),
            triangles: sides.into_iter().flat_map(quad).collect(),
        }
    }

    #[test]
    fn a_block_fills_its_tiles_to_one_scale() {
        let scene = Scene::new(block(DVec3::new(20.0, 5.0, 3.0)));
        let picture = shaded_views(&scene, |_| None);
        let width = picture.width as usize;
        let white = |x: usize, y: usize| picture.rgb[3 * (y * width + x)..][..3] == [255; 3];
        // In the front view and the low one its 40 mm fill the width.
        let expected = 0.5 * FILL * f64::from(TILE[0]);
        for (tile, height) in [(0, 10.0), (1, 10.0 * sin(radians(14.0)) + 6.0 * cos(radians(14.0)))]
        {
            let (x0, y0) = (tile * 480 + 240, 180);
            let right = (0..240).take_while(|k| !white(x0 + k, y0)).count() as f64;
            let up = (0..180).take_while(|k| !white(x0, y0 - k)).count() as f64;
            let down = (0..180).take_while(|k| !white(x0, y0 + k)).count() as f64;
            let scale = 2.0 * expected / 40.0;
            assert!((right - expected).abs() <= 1.0, "{tile}: {right} {expected}");
            assert!((up + down - height * scale).abs() <= 3.0, "{tile}: {up} {down} {height}");
        }
    }

    #[test]
    fn faces_of_a_block_have_one_colour_each_and_given_normals_another() {
        let scene = Scene::new(block(DVec3::splat(5.0)));
        let flat = shaded_views(&scene, |_| None);
        let leaning = shaded_views(&scene, |_| Some(DVec3::new(-0.6, 0.0, 0.8)));
        let at = |picture: &Picture, x: u32, y: u32| {
            let start = 3 * (y * picture.width + x) as usize;
            picture.rgb[start..start + 3].to_vec()
        };
        assert_eq!(at(&flat, 240, 180), at(&flat, 200, 150));
        assert_ne!(at(&flat, 240, 180), at(&leaning, 240, 180));
        // Top, front and side of the three-quarter view differ.
        let x = 960 + 240;
        let colours: Vec<_> =
            [(x, 110), (x - 60, 220), (x + 90, 220)].map(|(x, y)| at(&flat, x, y)).to_vec();
        assert!(colours[0] != colours[1] && colours[1] != colours[2] && colours[0] != colours[2]);
    }
}
