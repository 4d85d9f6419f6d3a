//! Random mirrors of every kind that a profile can ask for, the same for the same seed, and what
//! their meshes are held to.

pub mod errors;
pub mod shape;

use super::draws::Draws;
use morion::internals::geom::{BicubicSpline, Chart, DVec2, GridAxis, Outline, Precision, Rect};
use morion::internals::mesh::{Face, Limits, MeshError, mesh};
use morion::internals::mirror::{
    HeightField, Mirror, RadialLegendre, RadialTensorSum, Surface, TensorLegendre,
};
use morion::internals::num::legendre::Series;
use morion::internals::num::{cos, exp, log, radians, sin};
use morion::internals::optics::{
    ImagingTask, PictureMap, Projection, RadialLawKind, RimConditions, Strip, StripLaw, Target,
};
use rayon::ThreadPoolBuilder;
use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};

impl Draws {
    /// Of even odds in every octave.
    pub fn octaves(&mut self, [lo, hi]: [f64; 2]) -> f64 {
        exp(self.inside([log(lo), log(hi)]))
    }

    pub fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }
}

/// `f` of all items in their order. Each core takes whole items: of what small ones do, sharing out
/// the parts would be most of the work.
pub fn each<T: Sync, R: Send>(items: &[T], f: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(k) else { return done };
            done.push((k, f(item)));
        }
    };
    let core = || {
        let pool = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        pool.install(work)
    };
    let mut all: Vec<(usize, R)> = std::thread::scope(|scope| {
        let cores: Vec<_> = (0..cores).map(|_| scope.spawn(core)).collect();
        let join = |core: std::thread::ScopedJoinHandle<'_, Vec<(usize, R)>>| match core.join() {
            Ok(done) => done,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        cores.into_iter().flat_map(join).collect()
    });
    all.sort_by_key(|&(k, _)| k);
    all.into_iter().map(|(_, r)| r).collect()
}

/// A mirror to mesh, and within what.
#[derive(Debug, Clone)]
pub struct Case {
    pub mirror: Mirror,
    pub camera: Chart,
    pub view: Option<ImagingTask>,
    pub limits: Limits,
}

impl Case {
    pub fn mesh(&self) -> Result<Face, MeshError> {
        mesh(&self.mirror, &self.camera, self.view.as_ref(), self.limits)
    }
}

/// What kind of mirror a case has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A polynomial over a rectangle or a disc.
    Plain,
    /// The same, bent up to fifty times as much one way as across it.
    Anisotropic,
    /// A polynomial over a rectangle at least twenty times as long as wide.
    Narrow,
    /// No curvature at all, in one direction, or along a line.
    Flat,
    /// A function of the radius, on a disc or a ring.
    Round,
    /// The sum of both.
    Sum,
    /// A spline through heights on a grid.
    Grid,
    /// A panel and its reflection.
    Folded,
    /// Symmetric along one axis or both.
    Even,
    /// Designed for a pinhole.
    Pinhole,
    /// Given as heights, seen by a pinhole.
    Seen,
    /// In a cylinder or over a plane.
    Near,
}

/// Those whose proofs take no time.
pub const QUICK: [Kind; 9] = [
    Kind::Plain,
    Kind::Anisotropic,
    Kind::Narrow,
    Kind::Flat,
    Kind::Round,
    Kind::Sum,
    Kind::Grid,
    Kind::Folded,
    Kind::Even,
];

/// Those whose proofs look at places as well as directions.
pub const SLOW: [Kind; 3] = [Kind::Pinhole, Kind::Seen, Kind::Near];

/// A sheet's coefficients: slope, curvatures, and terms of higher degree of a given share.
struct Form {
    series: Series,
    /// Largest and least curvature, 1/mm.
    bend: [f64; 2],
}

/// A polynomial over a box of half sizes `half` that is even along the axes of `even`.
fn form(r: &mut Draws, half: DVec2, ratio: f64, wild: f64, lean: f64, even: [bool; 2]) -> Form {
    // Slopes change by less than 1/2 over the box.
    let most = r.octaves([0.05, 0.5]) / half.max_element();
    let (strong, weak) = (most * r.sign(), most / ratio * r.sign());
    let along_axes = even[0] || even[1] || r.chance(0.5);
    let angle = if along_axes { 0.5 * PI * f64::from(r.chance(0.5)) } else { r.inside([0.0, PI]) };
    let (c, s) = (cos(angle), sin(angle));
    let xx = strong * c * c + weak * s * s;
    let yy = strong * s * s + weak * c * c;
    let xy = if along_axes { 0.0 } else { (strong - weak) * s * c };
    let degree = 2 + (r.unit() * 4.0) as usize;
    let [x, y] = half.to_array();
    let series = Series::from_fn(degree + 1, degree + 1, |i, j| {
        let far = x.max(y);
        let powers = |x: f64, n: usize| (0..n).fold(1.0, |power, _| power * 0.5 * x / far);
        let size = most * far * far * powers(x, i) * powers(y, j);
        let odd = (even[0] && i % 2 == 1) || (even[1] && j % 2 == 1);
        let more = if odd || i + j < 3 || i + j > degree {
            0.0
        } else {
            wild * size * r.inside([-1.0, 1.0])
        };
        // x^2 = (2 P2 + 1) / 3.
        more + match (i, j) {
            (0, 1) if !even[1] => -lean * y,
            (1, 1) => xy * x * y,
            (2, 0) => xx * x * x / 3.0,
            (0, 2) => yy * y * y / 3.0,
            _ => 0.0,
        }
    });
    let more = 1.0 + 2.0 * wild;
    Form { series, bend: [most * more, most * more / ratio] }
}

fn sheet(series: Series, rect: Rect) -> TensorLegendre {
    TensorLegendre { series, centre: rect.centre(), half: 0.5 * rect.size(), scale_mm: 1.0 }
}

/// Corners on the grid of single precision.
fn single(rect: Rect) -> Rect {
    let round = |p: DVec2| p.as_vec2().as_dvec2();
    Rect { min: round(rect.min), max: round(rect.max) }
}

/// Looking to the side, or all around: with what a slope changes the image by, mm.
fn looking(r: &mut Draws, outer: f64, target: Target, lean: bool) -> (ImagingTask, f64) {
    if lean {
        let laws = [
            StripLaw::Cylindrical,
            StripLaw::Mercator,
            StripLaw::Equirectangular,
            StripLaw::EqualArea,
        ];
        let (law, scale_mm) =
            (laws[(r.unit() * 4.0) as usize].clone(), r.inside([0.3, 1.0]) * outer);
        let projection = Projection::Strip(Strip { law, scale_mm, azimuth: 0.0, z: 0.0 });
        return (
            ImagingTask {
                projection,
                target,
                origin_mm: 20.0,
                fold: None,
                picture: PictureMap::default(),
            },
            scale_mm,
        );
    }
    let radius = [0.0, outer];
    // Has a derivative wherever a mirror looks.
    let rims =
        RimConditions { radius, psi: [0.0, radians(r.inside([60.0, 110.0]))], vergence: 0.0 };
    let projection = Projection::Radial { law: rims.law(RadialLawKind::Parabolic), radius };
    (
        ImagingTask {
            projection,
            target,
            origin_mm: 20.0,
            fold: None,
            picture: PictureMap::default(),
        },
        outer,
    )
}

/// The mirror of `kind` numbered `seed`, within limits that ask for about `facets` facets.
pub fn case(kind: Kind, seed: u64, facets: [f64; 2]) -> Case {
    let mut random = Draws::new(seed ^ ((kind as u64) << 40));
    let r = &mut random;
    let size = r.octaves([3.0, 120.0]);
    let is_round = match kind {
        Kind::Round | Kind::Sum => true,
        Kind::Plain | Kind::Anisotropic | Kind::Grid | Kind::Near | Kind::Seen => r.chance(0.3),
        _ => false,
    };
    let aspect =
        if kind == Kind::Narrow { r.octaves([20.0, 400.0]) } else { r.octaves([1.0, 4.0]) };
    let half = match (is_round, r.chance(0.5)) {
        (true, _) => DVec2::splat(size),
        (_, true) => DVec2::new(size, size / aspect),
        (_, false) => DVec2::new(size / aspect, size),
    };
    let mut even = [false; 2];
    match kind {
        Kind::Even => {
            even = [[true, false], [false, true], [true, true]][(r.unit() * 3.0) as usize]
        }
        Kind::Folded => even[0] = r.chance(0.5),
        _ => {}
    }
    let centre = match kind {
        _ if is_round || even == [true; 2] => DVec2::ZERO,
        Kind::Folded => DVec2::new(0.0, half.y * r.sign()),
        _ => half * DVec2::new(r.inside([-1.0, 1.0]), r.inside([-1.0, 1.0])),
    };
    let place = |k: usize| if even[k] { 0.0 } else { centre[k] };
    let centre = DVec2::new(place(0), place(1));
    let rect = single(Rect { min: centre - half, max: centre + half });
    let is_pinhole = kind == Kind::Pinhole;
    let vergence = r.octaves([0.05, 0.4]) / (centre.abs() + half).max_element();
    let chart = Chart::on_axis(if is_pinhole { vergence } else { 0.0 }, 20.0);

    let ratio = match kind {
        Kind::Anisotropic => r.octaves([5.0, 50.0]),
        Kind::Flat => 1e12,
        _ => r.octaves([1.0, 5.0]),
    };
    let wild = match kind {
        Kind::Flat => 0.0,
        Kind::Anisotropic => r.octaves([1e-3, 0.1]) / ratio,
        _ => r.octaves([1e-3, 3.0]),
    };
    let leans = !is_round && even == [false; 2] && kind != Kind::Flat;
    let lean = if leans { 0.9 } else { 0.0 };
    // A slope of 0 looks along the axis, where a strip has no place.
    let wild = if leans { wild.min(0.3) } else { wild };
    let mut of = form(r, 0.5 * rect.size(), ratio, wild, lean, even);
    if kind == Kind::Flat && r.chance(0.3) {
        let tilt = r.inside([-1.0, 1.0]) * size;
        of = Form {
            series: Series::from_fn(2, 1, |i, _| if i == 1 { tilt } else { 0.0 }),
            bend: [0.0; 2],
        };
    }
    let inner = if r.chance(0.5) { 0.0 } else { size * r.inside([0.05, 0.9]) };
    let outline = if is_round {
        let inner = if matches!(kind, Kind::Round | Kind::Sum) { inner } else { 0.0 };
        Outline::Ring { inner, outer: size }
    } else {
        Outline::Rect(rect)
    };
    let round = |r: &mut Draws, inner: f64| {
        let bend = r.octaves([0.1, 0.8]) / size * r.sign();
        let more = [0; 4].map(|_| 0.1 * r.inside([-1.0, 1.0]));
        // Of r^2 on a disc, of r on a ring.
        let (first, rest) = if inner == 0.0 {
            (0.25 * bend * size * size, 0.25 * bend * size * size)
        } else {
            let wide = 0.5 * (size - inner);
            (0.5 * bend * (size + inner) * wide, bend * wide * wide)
        };
        let series = Series::from_fn(6, 1, |i, _| match i {
            0 => 0.0,
            1 => first,
            _ => rest * more[i - 2],
        });
        (RadialLegendre::new(series, [inner, size], 1.0), 8.0 * bend.abs())
    };
    let (surface, bend) = match kind {
        Kind::Round => {
            let (round, bend) = round(r, inner);
            even = [true; 2];
            (Surface::Radial(round), [bend; 2])
        }
        Kind::Sum => {
            let (round, bend) = round(r, 0.0);
            (
                Surface::Sum(RadialTensorSum { radial: round, tensor: sheet(of.series, rect) }),
                [bend + of.bend[0], bend],
            )
        }
        Kind::Grid => {
            let plain = sheet(of.series, rect);
            let count = [0; 2].map(|_| 4 + (r.unit() * 20.0) as usize);
            let slack = 1e-3 * half;
            let knots = [0, 1].map(|k| GridAxis {
                first_mm: (rect.min - slack)[k],
                step_mm: (rect.size() + 2.0 * slack)[k] / (count[k] - 1) as f64,
                count: count[k],
            });
            let node = |k: usize| {
                let at = |a: GridAxis, k: usize| a.at(k);
                plain.at(DVec2::new(at(knots[0], k % count[0]), at(knots[1], k / count[0]))).f
            };
            let values: Vec<f64> = (0..count[0] * count[1]).map(node).collect();
            let patches = BicubicSpline::new(knots[0], knots[1], &values).expect("a grid");
            (Surface::Spline(patches), of.bend)
        }
        _ => (Surface::Tensor(sheet(of.series, rect)), of.bend),
    };
    let folded = kind == Kind::Folded;
    let mirror = Mirror { surface, chart, outline, folded, mirror_symmetric: even };

    let target = match kind {
        Kind::Near => Target::Cylinder { radius_mm: 400.0 + 2.0 * size },
        _ => Target::Infinity,
    };
    let (view, per_slope) = looking(r, size, target, lean != 0.0);
    let camera = match kind {
        Kind::Seen => Chart { vergence, ..chart },
        _ => chart,
    };
    // What about so many facets keep.
    let area = outline.area() / r.octaves(facets);
    let chord = 0.3 * (bend[0] * bend[1]).sqrt().max(0.1 * bend[0]).max(1e-6 / size) * area;
    let facet = 0.8 * per_slope * (bend[0].max(1e-6 / size) * area.sqrt());
    let rule = r.unit();
    let sees = kind != Kind::Flat && (rule > 0.4 || SLOW.contains(&kind));
    let limits = Limits {
        chord_mm: (rule < 0.7 || !sees).then_some(chord.max(1e-5 * size)),
        facet_mm: (sees && rule > 0.4).then_some(facet),
        precision: if r.chance(0.2) { Precision::Double } else { Precision::Single },
    };
    Case { mirror, camera, view: sees.then_some(view), limits }
}
