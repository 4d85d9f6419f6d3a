//! Copies of our own parts as others would hand them over: moved, noisy, thinned out, with holes.

use crate::support::builds::parsed;
use crate::support::draws::Draws;
use crate::support::{designed, meshed};
use morion::internals::align::Pose;
use morion::internals::design::Design;
use morion::internals::geom::{DVec2, DVec3, Outline, Precision, TriMesh};
use morion::internals::num::{cos, log, radians, sin};
use morion::internals::solid::Solid;

impl Draws {
    /// Of the standard normal distribution (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * log(1.0 - self.unit())).sqrt();
        radius * cos(2.0 * std::f64::consts::PI * self.unit())
    }

    /// A direction.
    pub fn way(&mut self) -> DVec3 {
        let z = 2.0 * self.unit() - 1.0;
        let (angle, r) = (2.0 * std::f64::consts::PI * self.unit(), (1.0 - z * z).sqrt());
        DVec3::new(r * cos(angle), r * sin(angle), z)
    }

    /// A pose from which a part of this width has to be found: turned by so many degrees about the
    /// part's middle, and shifted by so large a share of the width.
    pub fn pose(&mut self, degrees: f64, shift: f64, width: f64) -> Pose {
        let middle = DVec3::Z * 0.25 * width;
        let to = middle + self.way() * shift * width;
        Pose::about(middle, to, self.way() * radians(degrees))
    }
}

/// What the parts have in common.
const COMMON: &str = "method.vector-field.degree = 10
mesh.facet_px = 6
export.formats = [\"obj\"]
part = { width_mm = 60, base_mm = 12 }
";

/// Layouts and cameras like those of the shipped profiles, on small sensors.
const PARTS: [(&str, &str); 5] = [
    (
        "conquistador",
        "camera.orthographic.pixels = [320, 240]
projection.cylindrical = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }
layout.conquistador.fill_frame = true
",
    ),
    (
        "panoramic",
        "camera.orthographic.pixels = [320, 240]
projection.cylindrical = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }
layout.strip = {}
",
    ),
    (
        "disc",
        "camera.orthographic.pixels = [240, 240]
projection.parabolic.outer_polar_deg = 100
layout.disc = {}
",
    ),
    (
        "pinhole disc",
        "camera.pinhole = { pixels = [240, 240], focal_px = 400, distance_mm = 100 }
projection.hyperbolic.outer_polar_deg = 110
layout.disc = {}
",
    ),
    (
        "pinhole strip",
        "camera.pinhole = { pixels = [320, 240], focal_px = 800, distance_mm = 150 }
projection.mercator = { azimuth_deg = [-90, 90], elevation_deg = [-20, 20] }
layout.strip = {}
",
    ),
];

/// The profile of one of the parts.
pub fn profile_text(name: &str) -> String {
    let (_, text) = PARTS.iter().find(|part| part.0 == name).expect("a part of that name");
    format!("{text}{COMMON}")
}

/// All parts.
pub fn shipped_like() -> Vec<Part> {
    PARTS.iter().map(|(name, _)| Part::new(name, &profile_text(name))).collect()
}

/// A designed part and its solid, in double precision: a mesh of a few hundred corners rounded to `f32` lies a nanometre off.
pub struct Part {
    pub name: &'static str,
    pub design: Design,
    pub solid: TriMesh,
    /// Facets of the optical face, which come first.
    pub optical: usize,
}

impl Part {
    pub fn new(name: &'static str, text: &str) -> Self {
        let profile = parsed(text);
        let design = designed(&profile);
        let face = meshed(&profile, &design).unwrap();
        let solid = Solid::from_face(&face.mesh, design.features(), Precision::Double).unwrap();
        Self { name, optical: solid.optical(), solid: solid.mesh().clone(), design }
    }

    pub fn conquistador() -> Self {
        Self::new("conquistador", &profile_text("conquistador"))
    }

    /// The part with a flat rim around the mirror.
    pub fn stocked(name: &'static str) -> Self {
        let rim = "base_mm = 12, border_mm = 8, rim_mm = 4";
        Self::new(name, &profile_text(name).replace("base_mm = 12", rim))
    }

    /// Whether a turn about the axis moves the mirror along itself.
    pub fn round(&self) -> bool {
        matches!(self.design.mirror.outline, Outline::Ring { .. })
    }

    pub fn width(&self) -> f64 {
        self.design.mirror.full_outline().bounds().size().max_element()
    }

    /// The optical face alone.
    pub fn face(&self) -> TriMesh {
        kept(&self.solid, |t| t < self.optical)
    }

    /// The face as a scanner would have it: an even grid with `n` steps along its longer side, from
    /// rim to rim, and no vertex but on the mirror.
    pub fn scan(&self, n: usize) -> TriMesh {
        let mirror = &self.design.mirror;
        let outline = mirror.full_outline();
        let bounds = outline.bounds();
        let step = bounds.size().max_element() / n as f64;
        // Even numbers: a fold in the middle is an edge of facets.
        let [columns, rows] = (0.5 * bounds.size() / step).round().max(DVec2::ONE).to_array();
        let [columns, rows] = [2 * columns as usize, 2 * rows as usize];
        let size = bounds.size() / DVec2::new(columns as f64, rows as f64);
        let mut mesh = TriMesh::default();
        let mut inside = Vec::new();
        for k in 0..(columns + 1) * (rows + 1) {
            let (i, j) = (k % (columns + 1), k / (columns + 1));
            let q = (bounds.min + size * DVec2::new(i as f64, j as f64)).min(bounds.max);
            inside.push(outline.contains(q));
            let q = if let Outline::Ring { outer, .. } = outline {
                q.clamp_length_max(outer)
            } else {
                q
            };
            mesh.vertices.push(mirror.position(q, &mirror.row(q.y).at(q.x)));
        }
        for k in 0..columns * rows {
            let a = k / columns * (columns + 1) + k % columns;
            let corners = [a, a + 1, a + columns + 2, a + columns + 1];
            if corners.iter().all(|&v| inside[v]) {
                let [a, b, c, d] = corners.map(|v| v as u32);
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        kept(&mesh, |_| true)
    }
}

/// The facets that `keep` accepts, with the vertices that they use.
pub fn kept(mesh: &TriMesh, keep: impl Fn(usize) -> bool) -> TriMesh {
    let mut names = vec![u32::MAX; mesh.vertices.len()];
    let mut out = TriMesh::default();
    for t in (0..mesh.triangles.len()).filter(|&t| keep(t)) {
        let triangle = mesh.triangles[t].map(|v| {
            let name = &mut names[v as usize];
            if *name == u32::MAX {
                *name = out.vertices.len() as u32;
                out.vertices.push(mesh.vertices[v as usize]);
            }
            *name
        });
        out.triangles.push(triangle);
    }
    out
}

/// The mesh after a motion.
pub fn moved(mesh: &TriMesh, pose: &Pose) -> TriMesh {
    let vertices = mesh.vertices.iter().map(|&v| pose.apply(v)).collect();
    TriMesh { vertices, triangles: mesh.triangles.clone() }
}

/// The mesh with round holes of this radius about vertices drawn at random.
pub fn holed(mesh: &TriMesh, holes: usize, radius: f64, draws: &mut Draws) -> TriMesh {
    let count = mesh.vertices.len() as f64;
    let centres: Vec<DVec3> =
        (0..holes).map(|_| mesh.vertices[(draws.unit() * count) as usize]).collect();
    let whole = |t: usize| {
        let near = |v: &DVec3| centres.iter().any(|c| (*c - *v).length() < radius);
        !mesh.corners(t).iter().any(near)
    };
    kept(mesh, whole)
}

/// The mesh with all vertices in each cube of this side drawn together into their first.
pub fn decimated(mesh: &TriMesh, side: f64) -> TriMesh {
    let mut first = std::collections::BTreeMap::new();
    let names: Vec<u32> = (0u32..)
        .zip(&mesh.vertices)
        .map(|(k, v)| *first.entry((*v / side).floor().to_array().map(|x| x as i64)).or_insert(k))
        .collect();
    let triangles: Vec<[u32; 3]> = mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| names[v as usize]))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    kept(&TriMesh { vertices: mesh.vertices.clone(), triangles }, |_| true)
}

/// Moves every vertex by normal noise along each axis.
pub fn noisy(mesh: &mut TriMesh, sigma: f64, draws: &mut Draws) {
    for v in &mut mesh.vertices {
        *v += DVec3::new(draws.normal(), draws.normal(), draws.normal()) * sigma;
    }
}

/// Moves one vertex in twenty by up to `most` mm in any direction; how many those are.
pub fn spiked(mesh: &mut TriMesh, most: f64, draws: &mut Draws) -> usize {
    let mut count = 0;
    for k in 0..mesh.vertices.len() {
        if draws.unit() < 0.05 {
            mesh.vertices[k] += draws.way() * most * draws.unit();
            count += 1;
        }
    }
    count
}
