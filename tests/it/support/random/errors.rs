//! The errors of flat facets, from the mirror itself and with nothing of the proof: sampled, and
//! followed uphill.

use super::Case;
use morion::internals::geom::{Chart, DVec2, DVec3, Precision, turn};
use morion::internals::mesh::{ErrorBound, ErrorBounder, Face};
use morion::internals::mirror::Mirror;
use morion::internals::optics::ImagingTask;
use rayon::prelude::*;

/// What rounding in the samples themselves may add, as a share of the mirror's size.
const ULP: f64 = 1e-13;

/// Most facets that are looked at closely for being the worst.
const WORST: usize = 2000;

/// A mirror as its camera sees it.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    pub mirror: &'a Mirror,
    pub camera: &'a Chart,
    pub view: Option<&'a ImagingTask>,
}

impl Case {
    pub fn seen(&self) -> Seen<'_> {
        Seen { mirror: &self.mirror, camera: &self.camera, view: self.view.as_ref() }
    }
}

impl Seen<'_> {
    /// Chord and facet error (mm) at `weights` of the flat facet with the given corners.
    pub fn errors(&self, corners: [DVec3; 3], weights: [f64; 3]) -> [f64; 2] {
        let [a, b, c] = corners;
        let p = a * weights[0] + b * weights[1] + c * weights[2];
        let chart = &self.mirror.chart;
        let (q, _) = chart.coordinates(p);
        let own = self.mirror.surface.at(q);
        let chord = p.distance(self.mirror.position(q, &own));
        let Some(view) = self.view else { return [chord, 0.0] };
        let normal = (b - a).cross(c - a);
        let flat = -normal.truncate() / normal.z;
        let (image, under) = if self.camera == chart {
            (q, q)
        } else {
            let image = self.camera.coordinates(p).0;
            (
                image,
                self.mirror
                    .intersect_camera_ray(self.camera, image)
                    .expect("a mirror under the facet"),
            )
        };
        let shown = |at: DVec3, slope: DVec2| {
            let content = view.image_of_seen(self.camera, at.to_array(), slope.to_array(), image);
            DVec2::from_array(content)
        };
        let point = self.mirror.surface.at(under);
        let smooth = shown(self.mirror.position(under, &point), self.mirror.slope(under, &point));
        [chord, view.projection.image_distance(shown(p, flat), smooth)]
    }

    /// The largest of each error over a facet: at `n` steps a side, then by steps uphill from the
    /// best samples if `climb`.
    pub fn largest(&self, corners: [DVec3; 3], n: u32, climb: bool) -> [f64; 2] {
        let mut best = [(0.0, [1.0, 0.0, 0.0]); 2];
        let look = |weights: [f64; 3], best: &mut [(f64, [f64; 3]); 2]| {
            let errors = self.errors(corners, weights);
            for (best, error) in best.iter_mut().zip(errors) {
                assert!(error.is_finite(), "{corners:?} {weights:?}: {errors:?}");
                if error > best.0 {
                    *best = (error, weights);
                }
            }
        };
        for i in 0..=n {
            for j in 0..=n - i {
                look([i, j, n - i - j].map(|k| f64::from(k) / f64::from(n)), &mut best);
            }
        }
        if climb {
            for kind in 0..2 {
                let mut step = 0.5 / f64::from(n);
                while step > 2e-3 && best[kind].0 > 0.0 {
                    let (from, at) = best[kind];
                    for (up, down) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
                        let mut to = at;
                        let by = step.min(to[down]);
                        to[up] += by;
                        to[down] -= by;
                        if by > 0.0 {
                            look(to, &mut best);
                        }
                    }
                    if best[kind].0 <= from {
                        step *= 0.35;
                    }
                }
            }
        }
        best.map(|best| best.0)
    }

    /// Holds every facet of the designed panel to its own bound, if it is asked for, and to the
    /// face's; returns the largest errors found. `n` steps a side, uphill if `climb`.
    pub fn hold(
        &self,
        face: &Face,
        precision: Precision,
        own: bool,
        n: u32,
        climb: bool,
    ) -> Result<[f64; 2], String> {
        let bounder =
            own.then(|| ErrorBounder::new(self.mirror, self.camera, self.view, precision));
        let chart = &self.mirror.chart;
        let slack = ULP * self.mirror.outline.bounds().size().max_element() + 1e-13;
        let vertex = |bounder: &ErrorBounder, at: DVec3| {
            let q = chart.coordinates(at).0;
            let is_single = precision == Precision::Single && chart.vergence == 0.0;
            let q = if is_single { q.as_vec2().as_dvec2() } else { q };
            bounder.vertex_at(q)
        };
        let facet = |t: usize| {
            let exact = face.mesh.corners(t);
            let mut found = self.largest(exact, n, climb);
            if precision == Precision::Single {
                let rounded = self.largest(exact.map(|p| p.as_vec3().as_dvec3()), n, climb);
                found = [0, 1].map(|k| found[k].max(rounded[k]));
            }
            let mut bounds = vec![("face", face.bound)];
            if let Some(bounder) = &bounder {
                let corners = exact.map(|at| vertex(bounder, at));
                let [a, b, c] = corners.each_ref();
                assert!(turn(a.q, b.q, c.q) > 0.0);
                bounds.push(("own", bounder.bound([a, b, c])));
                if climb {
                    bounds.push(("tight", bounder.bound_tightly([a, b, c])));
                }
            }
            for (whose, ErrorBound { chord_mm, facet_mm, .. }) in bounds {
                // Slopes of facets have the rounding of heights over their size.
                let rough = slack * 4.0 / size(exact) * self.mirror.outline.bounds().size().x;
                let facet_held = self.view.is_none() || found[1] <= facet_mm + slack + rough;
                if !(found[0] <= chord_mm + slack && facet_held) {
                    return Err(format!(
                        "facet {t} {exact:?} has {found:?}, over its {whose} bound {chord_mm:e} {facet_mm:e}"
                    ));
                }
            }
            Ok(found)
        };
        let most = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|k| a[k].max(b[k]));
        let all: Vec<[f64; 2]> =
            (0..face.designed).into_par_iter().map(facet).collect::<Result<_, _>>()?;
        let found = all.iter().copied().fold([0.0; 2], most);
        if climb {
            return Ok(found);
        }
        // The worst facets are worth a closer look.
        let is_worst = |t: &usize| (0..2).any(|k| all[*t][k] > 0.85 * found[k]);
        let worst: Vec<usize> = (0..face.designed).filter(is_worst).take(WORST).collect();
        let closer = |&t: &usize| self.largest(face.mesh.corners(t), 3 * n, true);
        Ok(worst.par_iter().map(closer).reduce(|| found, most))
    }
}

fn size([a, b, c]: [DVec3; 3]) -> f64 {
    let area = (b - a).truncate().perp_dot((c - a).truncate());
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    area / longest
}
