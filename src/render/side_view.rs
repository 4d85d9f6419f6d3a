//! The side view: the part cut through its axis, and the rays at the ends of the picture.

use super::section::{AxialPlane, PartSection};
use super::smooth_sight::reflected;
use crate::design::Design;
use crate::geom::{DVec2, DVec3, Ray, TriMesh};
use crate::num::{asin, degrees};

/// A camera ray and its reflection, in the plane of a side view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewRay {
    /// Where it comes from, mm: the entrance pupil, or far above.
    pub from_mm: DVec2,
    /// Where it meets the mirror, mm.
    pub at_mm: DVec2,
    /// Direction in which it leaves, as it is seen in the plane.
    pub direction: DVec2,
    /// Elevation of that direction, degrees.
    pub elevation_deg: f64,
    /// Whether it is at an end of what the camera sees of the mirror there.
    pub is_extreme: bool,
}

/// A side view.
#[derive(Debug, Clone, PartialEq)]
pub struct SideView {
    /// The part cut by the plane.
    pub section: PartSection,
    /// Rays of the picture's middle line along the plane.
    pub rays: Vec<ViewRay>,
    /// The lens's entrance pupil, in the plane; none for a telecentric camera.
    pub pupil_mm: Option<DVec2>,
    /// Z of the mirror's mean height.
    pub mean_mm: f64,
}

/// Places on the picture's middle line that are tried.
const PLACES: u32 = 201;
/// Rays drawn of each stretch of the mirror.
const RAYS: usize = 5;

impl SideView {
    /// The side view of the part `mesh` of `design`, along the plane out of which the rays lean less.
    #[must_use]
    pub fn new(design: &Design, mesh: &TriMesh) -> Self {
        let lean = |plane: AxialPlane| {
            let seen = seen(design, plane);
            let seen = seen.iter().flatten();
            let off: f64 = seen.clone().map(|(_, ray)| plane.split(ray.direction).1.abs()).sum();
            off / seen.count().max(1) as f64
        };
        let plane = if lean(AxialPlane::X0) <= lean(AxialPlane::Y0) {
            AxialPlane::X0
        } else {
            AxialPlane::Y0
        };
        Self {
            section: PartSection::new(mesh, plane),
            rays: rays(design, plane),
            pupil_mm: pupil(design, plane),
            mean_mm: design.mounting.mean_mm,
        }
    }
}

/// The rays that leave the mirror at places of the picture's middle line along the plane, with their image points.
fn seen(design: &Design, plane: AxialPlane) -> Vec<Option<(DVec2, Ray)>> {
    let [columns, rows] = design.camera.pixels.map(f64::from);
    let place = |k: u32| {
        let share = (f64::from(k) + 0.5) / f64::from(PLACES);
        // Beside the middle, on which a ridge may lie.
        match plane {
            AxialPlane::X0 => design.camera.image_point(0.5 * columns + 0.25, share * rows),
            AxialPlane::Y0 => design.camera.image_point(share * columns, 0.5 * rows - 0.25),
        }
    };
    let points: Vec<DVec2> = (0..PLACES).map(place).collect();
    let rays = reflected(design, &points);
    points.into_iter().zip(rays).map(|(q, ray)| Some((q, ray?))).collect()
}

/// The entrance pupil as the plane shows it.
fn pupil(design: &Design, plane: AxialPlane) -> Option<DVec2> {
    design.mounting.pupil_mm.map(|at| plane.split(DVec3::from_array(at)).0)
}

fn rays(design: &Design, plane: AxialPlane) -> Vec<ViewRay> {
    let seen = seen(design, plane);
    let mut rays = Vec::new();
    for stretch in seen.chunk_by(|a, b| a.is_some() == b.is_some()) {
        let stretch: Vec<(DVec2, Ray)> = stretch.iter().copied().flatten().collect();
        let Some(last) = stretch.len().checked_sub(1) else { continue };
        for k in 0..RAYS {
            let (q, ray) = stretch[k * last / (RAYS - 1)];
            let arriving = design.camera.ray(q, 0.0);
            let (at_mm, _) = plane.split(ray.origin);
            let from_mm = match pupil(design, plane) {
                Some(pupil) => pupil,
                None => {
                    at_mm - plane.split(arriving.direction).0 * 1e3 * design.mounting.size_mm[2]
                }
            };
            let direction = plane.split(ray.direction).0;
            let elevation_deg = degrees(asin(ray.direction.z.clamp(-1.0, 1.0)));
            let is_extreme = k == 0 || k == RAYS - 1;
            rays.push(ViewRay { from_mm, at_mm, direction, elevation_deg, is_extreme });
        }
    }
    rays
}
