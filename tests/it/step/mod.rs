//! STEP files, read back by a reader of their own: closed bodies whose faces are the mirror's.
//!
//! Every file is left in the folder `step` of the tests' temporary folder, with the volume and the
//! number of faces it should have beside it, for `tests/outside/check_step.py`.

mod cases;
mod charted;
mod names;
mod pmi;
mod read_back;
mod reading;
mod shape;
mod strangers;
mod witness;

use crate::support::draws::Draws;
use crate::support::shipped;
use cases::{Case, cases, footprint, unmeshed};
use morion::internals::design::design;
use morion::internals::export::Label;
use morion::internals::export::step::{
    FitError, FittedMirror, StepSchema, fit_splines, write_step,
};
use morion::internals::geom::{
    BlindHole, Border, Chart, Contour, Counterbore, DVec2, DVec3, Hole, HoleBottom, Outline,
    PartFeatures,
};
use morion::internals::mirror::Mirror;
use morion::internals::profile::{Profile, SagGrid};
use reading::{Curve, File, Surface, Value, height};
use shape::{Travelled, distance, normal};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

const SHIPPED: [&str; 13] = [
    "area-proportional",
    "conformal",
    "conical",
    "conquistador",
    "cylinder",
    "equi-areal",
    "equiangular",
    "hyperbolic",
    "panoramic",
    "parabolic",
    "plane",
    "soccer",
    "tangent-proportional",
];

fn label(name: &str) -> Label {
    Label {
        profile: name.into(),
        sha256: "0123456789abcdef".repeat(4),
        tolerances: "chord 2 um asked, 1.9 um reached".into(),
        mounting: vec!["entrance pupil at Z 151.234 mm".into()],
    }
}

fn fitted(case: &Case) -> FittedMirror {
    fit_splines(&case.mirror).unwrap_or_else(|error| panic!("{}: {error}", case.name))
}

fn written(case: &Case, fit: &FittedMirror) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_step(&mut bytes, fit, case.features(), &StepSchema::Ap214, &label(&case.name)).unwrap();
    bytes
}

fn all() -> Vec<Case> {
    let shipped = SHIPPED.map(|name| {
        let mirror = design(&shipped(name)).unwrap().mirror;
        Case { name: name.into(), mirror, stock: None, blind: Vec::new() }
    });
    shipped.into_iter().chain(cases()).collect()
}

/// What the body should hold: the mirror on its foot, and the stock in closed form.
fn volume(case: &Case) -> f64 {
    let blind = case.blind.iter().map(|blind| hole_mm3(&blind.hole, blind.depth_mm, Some(blind)));
    let mirror = case.mirror.volume() - blind.sum::<f64>();
    let Some(stock) = &case.stock else { return mirror };
    let contour = match stock.contour {
        Contour::Circle { radius_mm: r } => PI * r * r,
        Contour::Rect { half, corner_mm: r } => 4.0 * half.x * half.y - (4.0 - PI) * r * r,
    };
    let holes = stock.holes.iter().map(|hole| hole_mm3(hole, stock.top_mm, None));
    let contour = stock.top_mm * contour - 2.0 * edge_mm3(stock);
    let cone = |d: &morion::internals::geom::Drilled| {
        PI * d.diameter_mm * d.diameter_mm * d.diameter_mm / 24.0
    };
    mirror + contour
        - stock.top_mm * footprint(&case.mirror, stock.top_mm)
        - holes.sum::<f64>()
        - stock.marks.iter().map(cone).sum::<f64>()
}

/// What one chamfer takes off the edge of a side: prisms, less what they share at mitres, a pyramid over a square, and rings at
/// round corners by Pappus' theorem.
fn edge_mm3(stock: &Border) -> f64 {
    let c = stock.edge_chamfer_mm;
    let ring = |r: f64| PI * (r - c / 3.0) * c * c;
    match stock.contour {
        Contour::Circle { radius_mm } => ring(radius_mm),
        Contour::Rect { half, corner_mm: 0.0 } => {
            2.0 * (half.x + half.y) * c * c - 4.0 / 3.0 * c * c * c
        }
        Contour::Rect { half, corner_mm: r } => 2.0 * (half.x + half.y - 2.0 * r) * c * c + ring(r),
    }
}

/// A hole's volume: a cylinder up to `end_mm`, a counterbore's ring, what chamfers cut off the edges, and a drill's point.
fn hole_mm3(hole: &Hole, end_mm: f64, blind: Option<&BlindHole>) -> f64 {
    let (r, c) = (0.5 * hole.diameter_mm, hole.chamfer_mm);
    // The ring between a cone of 45 degrees and the cylinder inside it: Pappus' theorem.
    let ring = |r: f64| 2.0 * PI * (r + c / 3.0) * (0.5 * c * c);
    let mut sum = PI * r * r * end_mm;
    let mut mouth = r;
    if let Some(Counterbore { diameter_mm, depth_mm }) = hole.counterbore {
        mouth = 0.5 * diameter_mm;
        sum += PI * (mouth * mouth - r * r) * depth_mm;
    }
    sum += ring(mouth);
    match blind {
        None => sum += ring(r),
        Some(BlindHole { bottom: HoleBottom::DrillPoint, .. }) => {
            let half_angle = 59.0 * PI / 180.0;
            sum += PI * r * r * r / morion::internals::num::tan(half_angle) / 3.0;
        }
        Some(_) => {}
    }
    sum
}

/// Faces of a hole.
fn hole_faces(hole: &Hole, is_blind: bool) -> usize {
    let chamfers = usize::from(hole.chamfer_mm > 0.0);
    let ends = if is_blind { chamfers + 1 } else { 2 * chamfers };
    1 + ends + 2 * usize::from(hole.counterbore.is_some())
}

/// Whether the mirror is written as a surface of revolution.
fn is_turned(fit: &FittedMirror) -> bool {
    fit.size()[1] == 1
}

/// Number of surfaces of the mirror.
fn panels(mirror: &Mirror) -> usize {
    match &mirror.surface {
        morion::internals::mirror::Surface::Panels(surface) => surface.sheets.len(),
        _ => 1 + usize::from(mirror.folded),
    }
}

/// Number of lines between panels with steps.
fn lines(mirror: &Mirror) -> usize {
    match &mirror.surface {
        morion::internals::mirror::Surface::Panels(surface) => surface.parts.dividing_lines().len(),
        _ => 0,
    }
}

/// Faces of the mirror and below, from what the part is.
fn faces(case: &Case) -> usize {
    let mirror = &case.mirror;
    let own = match mirror.outline {
        // Every line between panels has a wall, every side a skirt.
        Outline::Rect(_) if !mirror.folded => panels(mirror) + lines(mirror) + 4,
        Outline::Rect(_) => 2 + if mirror.chart.vergence == 0.0 { 4 } else { 6 },
        Outline::Ring { inner, .. } => 2 + usize::from(inner > 0.0),
    };
    let blind = case.blind.iter().map(|blind| hole_faces(&blind.hole, true));
    let own = own + blind.sum::<usize>();
    let Some(stock) = &case.stock else { return own + 1 };
    let holes = stock.holes.iter().map(|hole| hole_faces(hole, false));
    let rings = if stock.edge_chamfer_mm > 0.0 { 3 } else { 1 };
    own + 2 + rings * side_faces(stock) + holes.sum::<usize>() + stock.marks.len()
}

/// Faces of the part's side.
fn side_faces(stock: &Border) -> usize {
    match stock.contour {
        Contour::Circle { .. } => 1,
        Contour::Rect { corner_mm: 0.0, .. } => 4,
        Contour::Rect { half, corner_mm } => {
            8 - 2 * [half.x, half.y].iter().filter(|&&h| h == corner_mm).count()
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn bodies_are_closed_and_their_edges_lie_on_their_faces() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("step");
    std::fs::create_dir_all(&folder).unwrap();
    for case in all() {
        let bytes = written(&case, &fitted(&case));
        let path = folder.join(format!("{}.step", case.name));
        std::fs::write(&path, &bytes).unwrap();
        let (volume, faces) = (volume(&case), faces(&case));
        let wanted = format!("{{\"volume_mm3\": {volume}, \"faces\": {faces}}}\n");
        std::fs::write(path.with_extension("step.json"), wanted).unwrap();
        let file = File::parse(&bytes);
        assert_eq!(file.all("ADVANCED_FACE").len(), faces, "{}", case.name);
        holds_together(&case.name, &file);
        names::check(&case, &file);
    }
}

/// Every edge is used twice, once each way; loops run from vertex to vertex; edges lie on both
/// their faces and on their parameter curves.
fn holds_together(name: &str, file: &File) {
    for (_, arguments) in file.data.values() {
        resolved(file, arguments);
    }
    for (keyword, count) in [
        ("MANIFOLD_SOLID_BREP", 1),
        ("CLOSED_SHELL", 1),
        ("PRODUCT", 1),
        ("PRODUCT_DEFINITION", 1),
        ("SHAPE_DEFINITION_REPRESENTATION", 1),
        ("ADVANCED_BREP_SHAPE_REPRESENTATION", 1),
        ("PRODUCT_RELATED_PRODUCT_CATEGORY", 1),
        ("APPLICATION_PROTOCOL_DEFINITION", 1),
    ] {
        assert_eq!(file.all(keyword).len(), count, "{name}: {keyword}");
    }
    let shell = file.get(file.all("CLOSED_SHELL")[0], "CLOSED_SHELL")[1].list().to_vec();
    assert_eq!(shell.len(), file.all("ADVANCED_FACE").len());
    let mut uses: BTreeMap<u32, Vec<bool>> = BTreeMap::new();
    let mut bases = 0;
    for face in shell {
        let face = file.get(face.id(), "ADVANCED_FACE");
        let surface = file.surface(face[2].id());
        let bounds = face[1].list();
        let outer = |b: &&Value| file.data[&b.id()].0 == "FACE_OUTER_BOUND";
        assert_eq!(bounds.iter().filter(outer).count(), 1);
        let sense = if face[3].is(".T.") { 1.0 } else { -1.0 };
        for bound in bounds {
            let mut rim = Vec::new();
            let (word, bound) = &file.data[&bound.id()];
            assert!(bound[2].is(".T."));
            let edges = file.get(bound[1].id(), "EDGE_LOOP")[1].list();
            let mut ends = Vec::new();
            let mut around = Vec::new();
            for edge in edges {
                let way = file.get(edge.id(), "ORIENTED_EDGE");
                let (id, forward) = (way[3].id(), way[4].is(".T."));
                uses.entry(id).or_default().push(forward);
                let edge = file.get(id, "EDGE_CURVE");
                assert!(edge[4].is(".T."));
                let vertices = [edge[1].id(), edge[2].id()];
                let points = vertices.map(|v| file.vertex(v));
                let curve = file.curve(edge[3].id());
                let places = curve.between(points, 53);
                assert!((places[0] - points[0]).length() < 1e-9);
                assert!((places[53] - points[1]).length() < 1e-9);
                for &p in &places {
                    let off = distance(&surface, p);
                    assert!(off < 1e-7, "{name}: an edge is {off:e} mm off its face at {p}");
                }
                let mut way = places.clone();
                if !forward {
                    way.reverse();
                }
                around.extend(way);
                let middle = places[26];
                let along = (places[27] - places[25]) * if forward { 1.0 } else { -1.0 };
                let out = normal(&surface, middle) * sense;
                let left = out.cross(along).normalize();
                if out.z.abs() == 1.0 && places.iter().all(|p| p.z == 0.0) {
                    assert_eq!(out, DVec3::NEG_Z, "{name}: the base");
                    bases += 1;
                }
                rim.push(Travelled { id, left, upright: out.z.abs() < 1e-9, places });
                ends.push(if forward { vertices } else { [vertices[1], vertices[0]] });
            }
            if let (true, Surface::Plane { normal, .. }) = (word == "FACE_OUTER_BOUND", &surface) {
                let area = area_vector(&around).dot(*normal * sense);
                assert!(area > 0.0, "{name}: a plane's loop runs wrongly");
            } else if word == "FACE_OUTER_BOUND" {
                for edge in 0..rim.len() {
                    assert!(
                        shape::keeps_left(&rim, edge),
                        "{name}: edge #{} runs wrongly",
                        rim[edge].id
                    );
                }
            }
            for (k, [_, to]) in ends.iter().enumerate() {
                assert_eq!(*to, ends[(k + 1) % ends.len()][0], "{name}: a loop is not closed");
            }
        }
    }
    assert!(bases > 0, "{name}: no base");
    assert_eq!(uses.len(), file.all("EDGE_CURVE").len());
    for (edge, mut ways) in uses {
        ways.sort_unstable();
        assert_eq!(ways, [false, true], "{name}: edge #{edge}");
    }
    for id in file.all("PCURVE") {
        let curve = file.get(id, "PCURVE");
        let shown = file.get(curve[2].id(), "DEFINITIONAL_REPRESENTATION");
        let circle = file.get(shown[1].list()[0].id(), "CIRCLE");
        let owner = file
            .data
            .values()
            .find(|(word, a)| word == "SURFACE_CURVE" && a[2].list().contains(&Value::Ref(id)));
        let Curve::Spline { axis, points } = file.curve(owner.unwrap().1[1].id()) else {
            panic!("no spline")
        };
        let surface = file.surface(curve[1].id());
        for k in 0..997 {
            let angle = 2.0 * PI * f64::from(k) / 997.0;
            let way =
                DVec2::new(morion::internals::num::cos(angle), morion::internals::num::sin(angle));
            let off = surface.at(way * circle[2].number()) - height(&axis, &points, angle);
            assert!(off.length() < 1e-7, "{name}: {off} at {angle}");
        }
    }
}

/// The area that a closed line goes around, along the normal about which it is anticlockwise.
fn area_vector(line: &[DVec3]) -> DVec3 {
    let next = line.iter().cycle().skip(1);
    line.iter().zip(next).map(|(a, b)| 0.5 * (*a - line[0]).cross(*b - line[0])).sum()
}

fn resolved(file: &File, values: &[Value]) {
    for value in values {
        match value {
            Value::Ref(id) => assert!(file.data.contains_key(id), "#{id} is missing"),
            Value::List(values) | Value::Typed(_, values) => resolved(file, values),
            _ => {}
        }
    }
}

/// How far the point is from the mirror, along its normal; none beyond the outline.
fn from_mirror(mirror: &Mirror, p: DVec3) -> Option<f64> {
    let (mut q, _) = mirror.chart.coordinates(p);
    if let Outline::Rect(_) = mirror.outline {
        let Outline::Rect(whole) = mirror.full_outline() else { panic!("no rectangle") };
        // Rounding may have put the rim a little outside.
        assert!((q - q.clamp(whole.min, whole.max)).length() < 4e-9, "{q}");
        q = q.clamp(whole.min, whole.max);
    } else if !mirror.outline.contains(q) {
        return None;
    }
    let panel = mirror.has_steps().then(|| mirror.panels().swap_remove(mirror.panel_at(p)));
    let point = panel.as_ref().unwrap_or(mirror).row(q.y).at(q.x);
    let normal = mirror.normal(q, &point).normalize();
    Some((mirror.position(q, &point) - p).dot(normal).abs())
}

#[test]
#[ignore = "long: .ci/nightly"]
fn faces_are_the_mirror_to_what_is_said() {
    for case in all() {
        let fit = fitted(&case);
        assert!(fit.error_mm <= 2e-6, "{}: {:e}", case.name, fit.error_mm);
        let bytes = written(&case, &fit);
        let file = File::parse(&bytes);
        let said = format!("splines within {:.2} nm of the design", fit.error_mm * 1e6);
        assert!(file.header.contains(&said));
        let mut draws = Draws::new(7);
        let mut worst = 0.0f64;
        let mut found = 0;
        for face in file.all("ADVANCED_FACE") {
            match file.surface(file.get(face, "ADVANCED_FACE")[2].id()) {
                Surface::Turned { axis, points } => {
                    found += 1;
                    let [inner, outer] = axis.ends();
                    for _ in 0..4000 {
                        let p = height(&axis, &points, inner + (outer - inner) * draws.unit());
                        let turn = 2.0 * PI * draws.unit();
                        let way = DVec2::new(
                            morion::internals::num::cos(turn),
                            morion::internals::num::sin(turn),
                        );
                        let off = from_mirror(&case.mirror, (way * p.x).extend(p.z));
                        worst = worst.max(off.unwrap_or(0.0));
                    }
                }
                surface @ Surface::Spline { .. } => {
                    let Surface::Spline { axes, .. } = &surface else { panic!() };
                    if axes[0].degree == 1 || axes[1].degree == 1 {
                        continue;
                    }
                    assert_eq!(axes.each_ref().map(|axis| axis.degree), [3, 3]);
                    found += 1;
                    let [u, v] = axes.each_ref().map(reading::Axis::ends);
                    let mut inside = 0;
                    for _ in 0..4000 {
                        let q = DVec2::new(
                            u[0] + (u[1] - u[0]) * draws.unit(),
                            v[0] + (v[1] - v[0]) * draws.unit(),
                        );
                        if let Outline::Ring { .. } = case.mirror.outline {
                            // Beyond the rim there is no mirror.
                            if q.length() > footprint(&case.mirror, 0.0).sqrt() / PI.sqrt() {
                                continue;
                            }
                        }
                        if let Some(off) = from_mirror(&case.mirror, surface.at(q)) {
                            inside += 1;
                            worst = worst.max(off);
                        }
                    }
                    assert!(inside > 2400);
                }
                _ => {}
            }
        }
        assert_eq!(found, panels(&case.mirror), "{}", case.name);
        // What is said is measured at corresponding points, so it is rather more.
        let limit = 1.05 * fit.error_mm + 2e-10;
        assert!(worst <= limit, "{}: {worst:e} mm, {:e} said", case.name, fit.error_mm);
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn shipped_mirrors_take_few_bytes() {
    for case in all().into_iter().take(SHIPPED.len()) {
        let fit = fitted(&case);
        let bytes = written(&case, &fit);
        assert!(bytes.len() <= 300_000, "{}: {} bytes", case.name, bytes.len());
        let annulus = matches!(case.mirror.outline, Outline::Ring { inner, .. } if inner > 0.0);
        // Over a square these discs would take too many control points.
        let turned = annulus || ["equi-areal", "soccer"].contains(&case.name.as_str());
        assert_eq!(is_turned(&fit), turned, "{}", case.name);
    }
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    for name in ["conquistador", "plane", "conical"] {
        let mirror = design(&shipped(name)).unwrap().mirror;
        let case = Case { name: name.into(), mirror, stock: None, blind: Vec::new() };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| written(&case, &fitted(&case)))
        };
        let first = on(1);
        assert!(first == on(1) && first == on(3), "{name}");
    }
}

#[test]
fn the_header_survives_any_name() {
    let mirror = design(&shipped("parabolic")).unwrap().mirror;
    let fit = fit_splines(&mirror).unwrap();
    let name = format!("it's a\\b\n*/ENDSEC; \u{e9} {}", "long ".repeat(99));
    let mut bytes = Vec::new();
    write_step(&mut bytes, &fit, PartFeatures::NONE, &StepSchema::Ap214, &label(&name)).unwrap();
    let file = File::parse(&bytes);
    assert!(file.header.contains("it''s a\\\\b?*/ENDSEC; ? long "));
    assert!(file.header.contains("FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));"));
    // No time: the same input gives the same bytes.
    assert!(file.header.contains(",'',(''),('')"), "{}", file.header);
    for told in ["sha256 0123456789abcdef", "millimetres; chord 2 um asked, 1.9 um reached"] {
        assert!(file.header.contains(told), "{told}");
    }
    let Value::Text(product) = &file.get(file.all("PRODUCT")[0], "PRODUCT")[0] else { panic!() };
    assert!(product.len() < 300 && product.starts_with("it's a\\\\b?"), "{product}");
}

/// Heights on a grid as a profile reads them.
fn heights(count: usize, reach: f64, mut f: impl FnMut(DVec2) -> f64) -> SagGrid {
    let at = |k: usize| reach * (2.0 * k as f64 / (count - 1) as f64 - 1.0);
    let mut text = String::new();
    for k in 0..count * count {
        let q = DVec2::new(at(k % count), at(k / count));
        writeln!(text, "{},{},{}", q.x, q.y, f(q)).unwrap();
    }
    SagGrid::parse(text.as_bytes()).unwrap()
}

const GRID: &str = "camera.orthographic.pixels = [96, 96]\nmirror.grid.file = \"sag.csv\"\n\
                    part = { width_mm = 60, height_mm = 45, base_mm = 5 }\n";

/// The profile of a mirror through `heights`.
fn given(heights: &SagGrid) -> Profile {
    Profile { heights: Some(heights.clone()), ..unmeshed(GRID) }
}

#[test]
fn a_rough_grid_is_met_on_its_own_knots_and_a_smooth_one_on_fewer() {
    let mut draws = Draws::new(3);
    let rough = heights(41, 30.0, |_| draws.unit());
    let found = fit_splines(&design(&given(&rough)).unwrap().mirror).unwrap();
    // Forty steps across 60 mm, of which 45 mm are thirty; and three more coefficients.
    assert_eq!(found.size(), [43, 33]);
    assert!(found.error_mm < 1e-9);
    let smooth = heights(241, 30.0, |q| -0.01 * q.length_squared());
    let found = fit_splines(&design(&given(&smooth)).unwrap().mirror).unwrap();
    assert!(found.size().iter().all(|&n| n < 20) && found.error_mm < 2e-6, "{:?}", found.size());
}

#[test]
fn what_no_reasonable_spline_meets_is_refused_with_what_was_reached() {
    let mut draws = Draws::new(5);
    let rough = heights(601, 30.0, |_| 0.01 * draws.unit());
    let mirror = design(&given(&rough)).unwrap().mirror;
    match fit_splines(&mirror) {
        Err(FitError::Rough { reached_mm, spans: [400, 400] }) => {
            assert!((1e-4..1e-2).contains(&reached_mm), "{reached_mm}");
        }
        other => panic!("{:?}", other.map(|fit| fit.size())),
    }
}

#[test]
fn a_round_mirror_that_hangs_over_is_refused() {
    // Seen from near by, the rim of a steep bowl lies under what is further in.
    let mirror = design(&shipped("hyperbolic")).unwrap().mirror;
    let near = Mirror { chart: Chart { vergence: 0.06, ..mirror.chart }, ..mirror };
    assert_eq!(fit_splines(&near).err(), Some(FitError::Overhang));
}
