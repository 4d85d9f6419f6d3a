//! Parts beyond the shipped ones: every outline, camera and kind of surface, and material around.

use crate::panels::arrangements;
use crate::support::builds::parsed;
use crate::support::{designed, profile, shipped};
use morion::internals::design::design;
use morion::internals::geom::{
    BlindHole, Border, Contour, Counterbore, DVec2, DVec3, Drilled, Hole, HoleBottom, HoleKind,
    MetricThread, Outline, PartFeatures,
};
use morion::internals::mirror::Mirror;
use morion::internals::profile::{Profile, SagGrid};
use std::f64::consts::PI;
use std::fmt::Write;

pub struct Case {
    pub name: String,
    pub mirror: Mirror,
    pub stock: Option<Border>,
    pub blind: Vec<BlindHole>,
}

impl Case {
    pub fn features(&self) -> PartFeatures<'_> {
        PartFeatures { border: self.stock.as_ref(), blind_holes: &self.blind, floor: None }
    }
}

/// A profile whose mesh does not matter.
pub fn unmeshed(text: &str) -> Profile {
    parsed(&format!("{text}mesh.chord_um = 20\nexport.formats = [\"stl\"]\n"))
}

const CAMERA: (&str, &str) = (
    "camera.orthographic.pixels = [640, 480]",
    "camera.pinhole = { pixels = [640, 480], focal_px = 1600, distance_mm = 150 }",
);
const FOLDED: (&str, &str) = ("layout.strip = {}", "layout.conquistador = {}");

/// Edits of the full-turn panorama.
const STRIPS: [(&str, &[(&str, &str)]); 8] = [
    ("uneven", &[("[-180, 180]", "[-170, 60]"), ("[-30, 30]", "[-10, 45]")]),
    ("valley", &[("layout.strip = {}", "layout.conquistador = { ridge = \"valley\" }")]),
    ("section", &[("layout.strip = {}", "layout.conquistador = { panel = \"section\" }")]),
    ("high", &[("[-30, 30]", "[-60, 60]"), ("cylindrical", "mercator")]),
    ("tiny", &[("width_mm = 60", "width_mm = 6"), ("degree = 12", "degree = 24")]),
    ("large", &[("width_mm = 60", "width_mm = 600")]),
    ("pinhole-strip", &[CAMERA, ("[-180, 180]", "[-80, 60]")]),
    ("pinhole-folded", &[CAMERA, FOLDED]),
];

/// Given mirrors: of a Legendre sheet, a conic, their sum.
const GIVEN: [(&str, &str); 6] = [
    (
        "polynomial",
        "mirror.polynomial = { terms = [[2, 0, -0.01], [1, 2, 2e-4], [0, 1, 0.1]] }\n\
        part = { width_mm = 60, height_mm = 45, base_mm = 5 }\n",
    ),
    (
        "tilted-disc",
        "mirror.polynomial = { terms = [[2, 0, -0.01], [1, 2, 2e-4], [0, 1, 0.1]] }\n\
        layout.disc = {}\npart = { width_mm = 60, base_mm = 5 }\n",
    ),
    (
        "conic-disc",
        "mirror.polynomial = { conic = -2.2, radius_mm = -60 }\n\
        layout.disc = {}\npart = { width_mm = 60, base_mm = 5 }\n",
    ),
    (
        "sum-disc",
        "mirror.polynomial = { conic = -2.2, radius_mm = -60, terms = [[3, 0, 1e-4]] }\n\
        layout.disc = {}\npart = { width_mm = 60, base_mm = 5 }\n",
    ),
    (
        "sum-annulus",
        "mirror.polynomial = { conic = -2.2, radius_mm = -60, terms = [[3, 0, 1e-4]] }\n\
        layout.annulus.inner_width_mm = 20\npart = { width_mm = 60, base_mm = 5 }\n",
    ),
    (
        "conic-annulus",
        "mirror.polynomial = { conic = -0.2, radius_mm = 60 }\n\
        layout.annulus.inner_width_mm = 20\npart = { width_mm = 60, base_mm = 5 }\n",
    ),
];

pub fn cases() -> Vec<Case> {
    let bare = |name: &str, mirror: Mirror| Case {
        name: name.into(),
        mirror,
        stock: None,
        blind: Vec::new(),
    };
    let mut cases = Vec::new();
    for (name, edits) in STRIPS {
        cases.push(bare(name, designed(&profile(edits)).mirror));
    }
    for (name, text) in GIVEN {
        let profile = unmeshed(&format!("camera.orthographic.pixels = [96, 96]\n{text}"));
        cases.push(bare(name, design(&profile).unwrap().mirror));
    }
    for (name, text) in [
        ("grid-rectangle", "part = { width_mm = 60, height_mm = 45, base_mm = 5 }\n"),
        ("grid-disc", "layout.disc = {}\npart = { width_mm = 60, base_mm = 5 }\n"),
    ] {
        let text = format!(
            "camera.orthographic.pixels = [96, 96]\nmirror.grid.file = \"sag.csv\"\n{text}"
        );
        let mirror = design(&Profile { heights: Some(wavy()), ..unmeshed(&text) }).unwrap().mirror;
        cases.push(bare(name, mirror));
    }
    let bands = "\
camera.pinhole = { pixels = [96, 96], focal_px = 150, distance_mm = 95 }
projection.table.polar_deg = [[0, 43.8], [0.2, 54.1], [0.34, 59.4], [0.44, 62.1], [0.65, 69.5], [0.78, 72.6], [1, 80.9]]
layout.annulus.inner_width_mm = 22
method.vector-field.degree = 36
part = { width_mm = 60, base_mm = 5 }
";
    cases.push(bare("bands", design(&unmeshed(bands)).unwrap().mirror));
    let stocked = [
        ("conquistador", Contour::Rect { half: DVec2::new(40.0, 32.0), corner_mm: 0.0 }, 0.75),
        ("panoramic", Contour::Rect { half: DVec2::new(41.0, 16.0), corner_mm: 6.0 }, 0.75),
        ("conformal", Contour::Circle { radius_mm: 48.0 }, 1.25),
        ("plane", Contour::Rect { half: DVec2::new(44.0, 40.0), corner_mm: 40.0 }, 0.5),
        ("equi-areal", Contour::Circle { radius_mm: 42.0 }, 0.0),
        ("conical", Contour::Rect { half: DVec2::splat(42.0), corner_mm: 5.0 }, 0.0),
    ];
    for (name, contour, edge_chamfer_mm) in stocked {
        let mirror = design(&shipped(name)).unwrap().mirror;
        let name = format!("{name}-stock");
        let stock = Border { edge_chamfer_mm, ..stock(contour) };
        cases.push(Case { name, mirror, stock: Some(stock), blind: Vec::new() });
    }
    let pinhole = designed(&profile(&[CAMERA, FOLDED])).mirror;
    let contour = Contour::Rect { half: DVec2::new(45.0, 35.0), corner_mm: 3.0 };
    cases.push(Case {
        name: "pinhole-folded-stock".into(),
        mirror: pinhole,
        stock: Some(stock(contour)),
        blind: Vec::new(),
    });
    for (name, profile) in arrangements() {
        cases.push(bare(name, design(&profile).unwrap().mirror));
    }
    let mirror = design(&arrangements()[0].1).unwrap().mirror;
    let half = DVec2::new(60.0, 48.0);
    let mut stock = stock(Contour::Rect { half, corner_mm: 6.0 });
    stock.holes = vec![Hole::plain(DVec2::new(54.0, 3.0), 4.2)];
    stock.marks = vec![Drilled { at: DVec2::new(-53.0, 6.0), diameter_mm: 1.0 }];
    let name = "quarters-stock".into();
    cases.push(Case { name, mirror, stock: Some(stock), blind: Vec::new() });
    cases.extend(drilled());
    cases
}

/// Blind holes of every kind below bare mirrors of every kind of surface, and bordered ones.
fn drilled() -> Vec<Case> {
    let bare = ["conquistador", "plane", "conical", "four-views"].map(|name| Case {
        name: format!("{name}-drilled"),
        mirror: design(&shipped(name)).unwrap().mirror,
        stock: None,
        blind: blind(),
    });
    let mut cases: Vec<Case> = bare.into();
    for name in ["conquistador", "conical"] {
        let mut stock = stock(Contour::Rect { half: DVec2::new(46.0, 42.0), corner_mm: 3.0 });
        let [screw, chamfered] = &mut stock.holes[..] else { panic!("two holes") };
        screw.counterbore = Some(Counterbore { diameter_mm: 7.0, depth_mm: 2.2 });
        screw.kind = HoleKind::Screw(MetricThread::M4);
        chamfered.chamfer_mm = 0.4;
        let mirror = design(&shipped(name)).unwrap().mirror;
        let name = format!("{name}-stock-drilled");
        cases.push(Case { name, mirror, stock: Some(stock), blind: blind() });
    }
    cases
}

/// A threaded, a flat, a chamfered and a counterbored hole within 15 mm of the axis, less than 4 mm deep.
fn blind() -> Vec<BlindHole> {
    let hole = |x: f64, y: f64, diameter_mm: f64| Hole::plain(DVec2::new(x, y), diameter_mm);
    let threaded = Hole {
        kind: HoleKind::Thread { size: MetricThread::M2, depth_mm: Some(1.4) },
        ..hole(10.0, 2.0, 1.6)
    };
    let counterbore = Some(Counterbore { diameter_mm: 4.0, depth_mm: 1.2 });
    let dowel = Hole { kind: HoleKind::Dowel, chamfer_mm: 0.2, ..hole(1.0, -6.0, 2.0) };
    let stepped = Hole { counterbore, chamfer_mm: 0.3, ..hole(-3.0, 5.0, 1.5) };
    let drilled = |hole, depth_mm, bottom| BlindHole { hole, depth_mm, bottom };
    vec![
        drilled(threaded, 3.0, HoleBottom::DrillPoint),
        drilled(hole(-10.0, -2.0, 5.0), 2.0, HoleBottom::Flat),
        drilled(dowel, 2.5, HoleBottom::DrillPoint),
        drilled(stepped, 2.4, HoleBottom::DrillPoint),
    ]
}

/// Holes on the left and right of any mirror of 60 mm, and two marks.
pub fn stock(contour: Contour) -> Border {
    let drilled = |x: f64, y: f64, diameter_mm: f64| Drilled { at: DVec2::new(x, y), diameter_mm };
    Border {
        contour,
        top_mm: 3.5,
        edge_chamfer_mm: 0.0,
        holes: vec![
            Hole::plain(DVec2::new(36.0, 4.0), 4.2),
            Hole::plain(DVec2::new(-35.5, -3.0), 3.2),
        ],
        marks: vec![drilled(36.0, -6.0, 1.0), drilled(-35.0, 6.0, 2.0)],
        land: None,
    }
}

/// Heights that no polynomial of low degree has.
fn wavy() -> SagGrid {
    let mut text = String::new();
    for k in 0..61 * 61 {
        let (x, y) = (f64::from(k % 61) - 30.0, f64::from(k / 61) - 30.0);
        let z = 0.5 * morion::internals::num::sin(0.3 * x) * morion::internals::num::cos(0.25 * y)
            - 0.004 * x * y;
        writeln!(text, "{x},{y},{z}").unwrap();
    }
    SagGrid::parse(text.as_bytes()).unwrap()
}

/// The area that a mirror and its skirt hold of planes below `top_mm`, in the mean, mm^2.
pub fn footprint(mirror: &Mirror, top_mm: f64) -> f64 {
    if let (true, Some(pupil)) = (mirror.has_steps(), mirror.chart.pupil()) {
        // Simpson's rule is exact for a pyramid.
        let wide = |z: f64| (pupil.z - z) / (pupil.z - mirror.chart.plane_mm);
        let area = |z: f64| mirror.outline.area() * wide(z) * wide(z);
        return (area(0.0) + 4.0 * area(0.5 * top_mm) + area(top_mm)) / 6.0;
    }
    let place = |q: DVec2| -> DVec3 { mirror.position(q, &mirror.surface.at(q)) };
    match mirror.outline {
        Outline::Ring { outer, .. } => {
            let rho = if mirror.chart.vergence == 0.0 { outer } else { place(DVec2::X * outer).x };
            PI * rho * rho
        }
        Outline::Rect(panel) => {
            // The polygon of many points on the rim.
            const SIDE: usize = 20_000;
            let corners = [
                panel.min,
                DVec2::new(panel.max.x, panel.min.y),
                panel.max,
                DVec2::new(panel.min.x, panel.max.y),
            ];
            let at = |k: usize| {
                let (side, share) = (k / SIDE % 4, (k % SIDE) as f64 / SIDE as f64);
                place(corners[side].lerp(corners[(side + 1) % 4], share)).truncate()
            };
            let rim: Vec<DVec2> = (0..=4 * SIDE).map(at).collect();
            let panels = if mirror.folded { 2.0 } else { 1.0 };
            panels * rim.windows(2).map(|ends| 0.5 * ends[0].perp_dot(ends[1])).sum::<f64>()
        }
    }
}
