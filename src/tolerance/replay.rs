//! One trial again: the surface that a file of it must have, and what a file shows through the
//! camera of that trial.

use super::compensate::DisplacementPx;
use super::engine::Engine;
use super::model::{OpticalSystem, PartPose, PixelSample};
use super::perturbed_system::PerturbedSystem;
use crate::geom::{DVec2, DVec3, Ray};
use crate::mirror::Mirror;
use crate::num::max_or_nan;
use crate::num::random::RandomStream;
use crate::num::stats::{Summary, or_null};
use crate::optics::reflect;
use crate::parallel;
use crate::tolerance_terms::Perturbation;
use crate::trace::{Outcome, Scene};
use serde::Serialize;

/// How far errors of form may take a vertex beyond the line between two panels, as a share of the mirror's size.
const BEYOND: f64 = 1e-3;

/// Displacement of the picture, px, as made and after adjustment.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Displacement {
    /// Figures as made.
    pub as_made: DisplacementPx,
    /// Figures after adjustment.
    pub adjusted: DisplacementPx,
}

/// Displacement that a file of a made part shows, by the camera's ray of each sample, its nearest facet
/// and the reflection by that.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Witnessed {
    /// Rays.
    pub rays: usize,
    /// Of these, reflected by the optical face.
    pub hit: usize,
    /// Of those that hit, meeting the part again: taken as if it were not in the way, as in the
    /// trials.
    pub shadowed: usize,
    /// Led over the mirror's rim by the errors: taken as if the made surface went on there, as in
    /// the trials.
    pub beyond: usize,
    /// Not reflected by the optical face, where the made surface is.
    pub lost: usize,
    /// The displacements' figures.
    pub displacement: Displacement,
    /// Displacement by the facets' own slopes, px: reflection by the facet against that by the made
    /// surface at the same place. None when no ray hits.
    #[serde(serialize_with = "or_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub facet_error_px: Option<Summary>,
}

/// Rotation and shift from the part to the world: world = R part + t.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RigidTransform {
    /// Rows of the rotation matrix R.
    pub turn: [[f64; 3]; 3],
    /// The shift t, mm.
    pub shift_mm: [f64; 3],
}

impl Engine {
    /// The errors of a trial, each in its source's unit.
    #[must_use]
    pub fn drawn(&self, seed: u64, index: u64) -> Vec<(Perturbation, f64)> {
        self.draw(&self.spec.sources, &RandomStream { seed, trial: index })
    }

    /// The system of a trial without some of its errors; the others are as they are with them.
    #[must_use]
    pub fn replayed(&self, seed: u64, index: u64, without: &[Perturbation]) -> PerturbedSystem {
        let mut values = self.drawn(seed, index);
        values.retain(|(kind, _)| !without.contains(kind));
        self.make(&values, RandomStream { seed, trial: index })
    }

    /// Figures of a made system.
    #[must_use]
    pub fn displacement_of(&self, made: &PerturbedSystem) -> Displacement {
        self.figures_of(self.displacements(std::slice::from_ref(made)).remove(0))
    }

    fn figures_of(&self, displacement: Vec<f64>) -> Displacement {
        let (as_made, adjusted, _) = self.compensate(displacement);
        Displacement { as_made, adjusted }
    }

    /// Height of the made surface over the designed one at a place of the part, mm, before the
    /// part is grown.
    #[must_use]
    pub fn departure(&self, made: &PerturbedSystem, at: DVec3) -> f64 {
        self.system.departure(&made.state, at)[0]
    }

    /// The shortest length, mm, over which that swings; none where there is no departure.
    #[must_use]
    pub fn shortest(&self, made: &PerturbedSystem) -> Option<f64> {
        self.system.shortest(&made.state)
    }

    /// Size of a made part against the designed one, about the origin.
    #[must_use]
    pub fn growth(&self, made: &PerturbedSystem) -> f64 {
        1.0 + made.state.misalignment.growth
    }

    /// Pose of the part in the world.
    #[must_use]
    pub fn placing(&self, made: &PerturbedSystem) -> RigidTransform {
        let pose = PartPose::new(&made.state.misalignment);
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| pose.to_world(e));
        let turn = [0, 1, 2].map(|row| columns.map(|column| column[row]));
        RigidTransform { turn, shift_mm: pose.shift }
    }

    /// The mirror as designed, without steps near a panel.
    fn designed_near(&self, panel: usize) -> &Mirror {
        let OpticalSystem { mirror, panels, .. } = &self.system;
        if mirror.has_steps() { &panels[panel] } else { mirror }
    }

    /// The made surface of `design`, Z and slope, under a place of the grown part that is near it.
    fn surface(&self, made: &PerturbedSystem, design: &Mirror, at: DVec3) -> [f64; 3] {
        let growth = self.growth(made);
        let at = at / growth;
        let design = self.system.designed(design, at.truncate().to_array(), at.z);
        let more = self.system.departure(&made.state, at);
        [growth * (design[0] + more[0]), design[1] + more[1], design[2] + more[2]]
    }

    /// The largest distance along Z, mm, of `vertices` of a file from the made surface.
    #[must_use]
    pub fn off_surface(&self, made: &PerturbedSystem, vertices: &[DVec3]) -> f64 {
        let OpticalSystem { mirror, panels, .. } = &self.system;
        let growth = self.growth(made);
        let off_of = |design: &Mirror, v: DVec3| (v.z - self.surface(made, design, v)[0]).abs();
        let off = |v: &DVec3| {
            if !mirror.has_steps() {
                return off_of(mirror, *v);
            }
            // Errors take the rim of a panel beyond its line.
            let q = mirror.chart.coordinates(*v / growth).0;
            let beyond = BEYOND * mirror.outline.bounds().size().max_element();
            let near = panels.iter().filter(|panel| panel.outline.distance_outside(q) <= beyond);
            near.map(|panel| off_of(panel, *v)).reduce(f64::min).unwrap_or(f64::NAN)
        };
        parallel::map_slice(vertices, 1, off).into_iter().fold(0.0, max_or_nan)
    }

    /// Whether a ray in the frame of the grown part, aimed by `sample`, meets the made surface on the
    /// mirror: Newton's method.
    fn meets(&self, made: &PerturbedSystem, sample: &PixelSample, ray: &Ray) -> bool {
        const MOST_STEPS: usize = 40;
        let design = self.designed_near(sample.panel);
        let mut t = (sample.hit.z - ray.origin.z) / ray.direction.z;
        for _ in 0..MOST_STEPS {
            let at = ray.at(t);
            let [z, x, y] = self.surface(made, design, at);
            let rate = ray.direction.z - ray.direction.x * x - ray.direction.y * y;
            let step = (at.z - z) / rate;
            t -= step;
            if step.abs() < 1e-9 {
                return self.system.holds(ray.at(t) / self.growth(made));
            }
        }
        false
    }

    /// Traces a file's mesh, whose first `optical` facets have the surface and the size of a made
    /// part, in its place and under its camera.
    #[must_use]
    pub fn witness(&self, made: &PerturbedSystem, scene: &Scene, optical: usize) -> Witnessed {
        let pose = PartPose::new(&made.state.misalignment);
        let shift = DVec3::from_array(self.placing(made).shift_mm);
        let out = |v: DVec3| DVec3::from_array(pose.to_world(v.to_array()));
        let back = |v: DVec3| DVec3::from_array(pose.to_part(v.to_array()));
        let pixel = self.system.camera.pixel_mm;
        // Parallel rays begin above the part.
        let parallel = self.system.camera.chart.vergence == 0.0;
        let above = scene.bounds().map_or(0.0, |(lo, hi)| (hi - lo).length() + hi.length());
        let above = if parallel { above } else { 0.0 };
        let smooth = self.displacements(std::slice::from_ref(made)).remove(0);
        let look_through = |k: usize| {
            let sample = &self.system.samples[k];
            let (origin, along) = self.system.ray(sample, &made.state.misalignment);
            let direction = back(DVec3::from_array(along)).normalize();
            let origin = back(DVec3::from_array(origin) - shift) - direction * above;
            let ray = Ray { origin, direction };
            let traced = scene.trace(&ray);
            let reflected = matches!(traced.outcome, Outcome::Hit | Outcome::Shadowed(_));
            let beyond = (RayOutcome::Beyond, [smooth[2 * k], smooth[2 * k + 1]], None);
            if !(reflected && (traced.facet as usize) < optical) {
                let lost = (RayOutcome::Lost, [f64::NAN; 2], None);
                return if self.meets(made, sample, &ray) { lost } else { beyond };
            }
            // Errors led it over the ridge: of its own panel it sees nothing.
            let at = traced.hit_point(&ray);
            if !self.system.sees_own(sample, at / self.growth(made)) {
                return beyond;
            }
            let world = (out(at) + shift).to_array();
            let content = |leaving: DVec3| {
                let leaving = out(leaving).to_array();
                DVec2::from_array(self.system.image_of_reflected(sample.point, world, leaving))
            };
            let [_, x, y] = self.surface(made, self.designed_near(sample.panel), at);
            let by_surface = content(reflect(direction, DVec3::new(-x, -y, 1.0)));
            let by_facet = content(traced.direction);
            let base = DVec2::new(self.base[2 * k], self.base[2 * k + 1]);
            let moved = base + (by_facet - sample.content) / pixel;
            let end =
                if traced.outcome == Outcome::Hit { RayOutcome::Hit } else { RayOutcome::Shadowed };
            (end, moved.to_array(), Some((by_facet - by_surface).length() / pixel))
        };
        let seen: Vec<_> = parallel::map(self.samples(), 1, look_through);
        let count = |end: RayOutcome| seen.iter().filter(|s| s.0 == end).count();
        let shadowed = count(RayOutcome::Shadowed);
        Witnessed {
            rays: seen.len(),
            hit: count(RayOutcome::Hit) + shadowed,
            shadowed,
            beyond: count(RayOutcome::Beyond),
            lost: count(RayOutcome::Lost),
            displacement: self.figures_of(seen.iter().flat_map(|s| s.1).collect()),
            facet_error_px: Summary::of(seen.iter().filter_map(|s| s.2).collect()),
        }
    }
}

/// Outcome of one ray through a file's mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RayOutcome {
    /// Reflected by the optical face.
    Hit,
    /// Reflected by it, and meeting the part again.
    Shadowed,
    /// Led over the mirror's rim by the errors.
    Beyond,
    /// Not reflected where the made surface is.
    Lost,
}
