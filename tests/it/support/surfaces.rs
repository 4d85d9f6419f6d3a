//! The surfaces on which the mesher is measured, and how many triangles it may spend on them.

use morion::internals::design::design;
use morion::internals::geom::{Chart, DVec2, Outline, Precision, Rect};
use morion::internals::mesh::{Face, Limits, MeshError, mesh};
use morion::internals::mirror::{Mirror, Surface, TensorLegendre};
use morion::internals::num::legendre::{Series, values};
use morion::internals::num::quadrature::gauss_legendre;
use morion::internals::num::{cos, sin};
use morion::internals::optics::ImagingTask;
use morion::internals::pipeline::load;
use morion::internals::profile::shipped;

/// Fewest triangles at which the economy is held to its targets.
pub const ENOUGH: f64 = 1e5;

/// Which error governs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    Chord,
    Facet,
}

impl Rule {
    pub fn name(self) -> &'static str {
        match self {
            Self::Chord => "chord",
            Self::Facet => "facet",
        }
    }

    /// The limit in `limit`'s unit that gives about `wanted` triangles where `limit` gives `found`.
    pub fn towards(self, limit: f64, found: f64, wanted: f64) -> f64 {
        match self {
            Self::Chord => limit * found / wanted,
            Self::Facet => limit * (found / wanted).sqrt(),
        }
    }
}

/// A surface with the error that governs its mesh.
#[derive(Debug, Clone)]
pub struct Case {
    pub name: &'static str,
    pub mirror: Mirror,
    pub camera: Chart,
    pub view: Option<ImagingTask>,
    pub rule: Rule,
    /// A usual limit, mm on the mirror.
    pub usual_mm: f64,
}

impl Case {
    /// The limit `limit_mm` of the error that governs, and none of the other.
    pub fn limits(&self, limit_mm: f64, precision: Precision) -> Limits {
        let governing = |rule| (self.rule == rule).then_some(limit_mm);
        Limits { chord_mm: governing(Rule::Chord), facet_mm: governing(Rule::Facet), precision }
    }

    pub fn mesh(&self, limit_mm: f64, precision: Precision) -> Result<Face, MeshError> {
        mesh(&self.mirror, &self.camera, self.view.as_ref(), self.limits(limit_mm, precision))
    }

    /// The least number of triangles for a limit; none where there is no bound.
    pub fn least(&self, face: &Face, limit_mm: f64) -> Option<f64> {
        match self.rule {
            Rule::Chord => face.optimum.chord(limit_mm),
            Rule::Facet => face.optimum.facet(limit_mm),
        }
    }

    /// Triangles over the least number for a limit.
    pub fn over(&self, face: &Face, limit_mm: f64) -> Option<f64> {
        self.least(face, limit_mm).map(|least| face.mesh.triangles.len() as f64 / least)
    }

    /// The mesh at the usual limit, or at the first finer one that needs `ENOUGH` triangles, for
    /// files in single precision; and that limit.
    pub fn enough(&self) -> Result<(f64, Face), MeshError> {
        let mut limit = self.usual_mm;
        loop {
            let face = self.mesh(limit, Precision::Single)?;
            let found = face.mesh.triangles.len() as f64;
            if found >= ENOUGH {
                return Ok((limit, face));
            }
            limit = self.rule.towards(limit, found, 1.1 * ENOUGH);
        }
    }
}

/// A surface given by a formula over |X|, |Y| <= `HALF_MM`.
pub struct Formula {
    pub name: &'static str,
    pub z: fn(f64, f64) -> f64,
    /// Of its Legendre series in X and in Y.
    pub degree: [usize; 2],
    pub even: [bool; 2],
    pub most: f64,
}

pub const HALF_MM: f64 = 50.0;

pub const FORMULAS: [Formula; 4] = [
    Formula {
        name: "bowl",
        z: |x, y| (x * x + y * y) / 1000.0,
        degree: [2, 2],
        even: [true, true],
        most: 1.20,
    },
    Formula {
        name: "saddle",
        z: |x, y| (x * x - y * y) / 1000.0,
        degree: [2, 2],
        even: [true, true],
        most: 1.20,
    },
    Formula {
        name: "bowl-16-to-1",
        z: |x, y| x * x / 250.0 + y * y / 4000.0,
        degree: [2, 2],
        even: [true, true],
        most: 1.20,
    },
    Formula {
        name: "mixed",
        z: |x, y| {
            x * x / 600.0 - y * y / 1500.0
                + 3e-6 * x * x * x
                + 2e-6 * x * y * y
                + 0.02 * sin(x / 8.0) * cos(y / 11.0)
        },
        degree: [19, 16],
        even: [false, true],
        most: 1.25,
    },
];

impl Formula {
    pub fn mirror(&self) -> Mirror {
        let at = |u: f64, v: f64| (self.z)(HALF_MM * u, HALF_MM * v);
        let series = series(self.degree, self.even, at);
        let (centre, half) = (DVec2::ZERO, DVec2::splat(HALF_MM));
        Mirror {
            surface: Surface::Tensor(TensorLegendre { series, centre, half, scale_mm: 1.0 }),
            chart: Chart::on_axis(0.0, 0.0),
            outline: Outline::Rect(Rect { min: -half, max: half }),
            folded: false,
            mirror_symmetric: self.even,
        }
    }
}

/// Legendre coefficients of `f` on the square [-1, 1]^2; of even functions exactly even ones.
fn series(degree: [usize; 2], even: [bool; 2], f: impl Fn(f64, f64) -> f64) -> Series {
    const NODES: usize = 40;
    let (nodes, weights) = gauss_legendre(NODES);
    let basis: Vec<_> = nodes.iter().map(|&x| values(NODES, x)).collect();
    let coefficient = |i: usize, j: usize| {
        if even[0] && i % 2 == 1 || even[1] && j % 2 == 1 {
            return 0.0;
        }
        let pairs = (0..NODES * NODES).map(|k| (k / NODES, k % NODES));
        let term = |(a, b): (usize, usize)| {
            weights[a] * weights[b] * f(nodes[a], nodes[b]) * basis[a][i] * basis[b][j]
        };
        pairs.map(term).sum::<f64>() * ((2 * i + 1) * (2 * j + 1)) as f64 / 4.0
    };
    Series::from_fn(degree[0] + 1, degree[1] + 1, coefficient)
}

/// The limit of the facet error for profiles that have none, pixels.
const USUAL_PX: f64 = 1.0;

/// A surface that has not been made yet, and the error that governs its mesh.
#[derive(Debug, Clone, Copy)]
pub struct Listed {
    /// Name of a formula or of a shipped profile.
    pub name: &'static str,
    pub rule: Rule,
    /// Most triangles over the least, with at least `ENOUGH` of them.
    pub most: Option<f64>,
}

impl Listed {
    /// The surface.
    pub fn case(self) -> Case {
        let Self { name, rule, .. } = self;
        let formula = FORMULAS.iter().find(|formula| formula.name == name);
        formula.map_or_else(
            || shipped_case(name, rule),
            |formula| {
                let mirror = formula.mirror();
                let camera = mirror.chart;
                Case { name, mirror, camera, view: None, rule, usual_mm: 1e-3 }
            },
        )
    }
}

/// A shipped profile's mirror, with its own limit of the governing error alone, or the usual one.
fn shipped_case(name: &'static str, rule: Rule) -> Case {
    let profile = load(name).unwrap_or_else(|error| panic!("{error}"));
    let design = design(&profile).unwrap_or_else(|error| panic!("{error}"));
    let usual_mm = match rule {
        Rule::Chord => 1e-3 * profile.mesh.chord_um().expect("a chord limit"),
        Rule::Facet => profile.mesh.facet_px().unwrap_or(USUAL_PX) * design.camera.pixel_mm,
    };
    let camera = design.camera.chart;
    Case { name, mirror: design.mirror, camera, view: design.view, rule, usual_mm }
}

/// All surfaces: the formulas and two shipped mirrors by their chord error, and every shipped mirror by its facet
/// error.
pub fn listed() -> Vec<Listed> {
    let chord = |(name, most)| Listed { name, rule: Rule::Chord, most: Some(most) };
    let formulas = FORMULAS.iter().map(|formula| (formula.name, formula.most));
    let by_chord = formulas.chain([("conquistador", 1.35), ("conformal", 1.26)]).map(chord);
    let targets = [("conquistador", 1.5), ("conformal", 1.5), ("panoramic", 1.55)];
    let by_facet = shipped().iter().map(|profile| {
        let most = targets.iter().find(|(name, _)| *name == profile.name).map(|(_, most)| *most);
        Listed { name: profile.name, rule: Rule::Facet, most }
    });
    by_chord.chain(by_facet).collect()
}
