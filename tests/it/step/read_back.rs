//! STEP files read by the program's own reader: closed, as large as the part, and the mirror's surface along every ray.

use super::cases::stock;
use super::{Case, all, edge_mm3, fitted, volume, written};
use crate::support::{share, shipped};
use morion::internals::brep::{Body, StepError};
use morion::internals::design::design;
use morion::internals::geom::{Border, Contour, DVec2, Ray};

/// Share of the volume by which splines may be off: they follow mirrors within 1e-6 mm over some 10 mm of height.
const VOLUME: f64 = 1e-7;

#[test]
fn bodies_are_closed_as_large_as_the_part_and_met_by_rays_where_the_mirror_is() {
    for case in share(5, 0, all()) {
        let fit = fitted(&case);
        let body = Body::read(&written(&case, &fit));
        let body = body.unwrap_or_else(|error| panic!("{}: {error}", case.name));
        let facts = body.facts();
        let off = facts.volume_mm3 / volume(&case) - 1.0;
        assert!(off.abs() < VOLUME, "{}: {off:e} {facts:?}", case.name);
        assert!(facts.gap_mm <= 1.01e-7, "{}: {facts:?}", case.name);
        assert_eq!((facts.uncertainty_mm, facts.unit_mm), (1e-7, 1.0), "{}", case.name);
        let met = meet(&case, &body, fit.error_mm + 1e-9);
        assert!(met > 200, "{}: {met}", case.name);
    }
}

/// Around a circle, a rectangle with mitres and with cones, and one whose ends are half circles.
#[test]
fn bodies_with_chamfered_edges_have_the_volume_of_their_closed_form() {
    let mirror = design(&shipped("plane")).unwrap().mirror;
    let rect = |corner_mm| Contour::Rect { half: DVec2::new(44.0, 40.0), corner_mm };
    for contour in [Contour::Circle { radius_mm: 44.0 }, rect(0.0), rect(6.0), rect(40.0)] {
        let stock = Border { edge_chamfer_mm: 0.75, ..stock(contour) };
        let chamfers = 2.0 * edge_mm3(&stock);
        let (name, mirror) = (format!("{contour:?}"), mirror.clone());
        let case = Case { name, mirror, stock: Some(stock), blind: Vec::new() };
        let body = Body::read(&written(&case, &fitted(&case)));
        let body = body.unwrap_or_else(|error| panic!("{contour:?}: {error}"));
        let (facts, exact) = (body.facts(), volume(&case));
        let off = facts.volume_mm3 / exact - 1.0;
        println!("{contour:?}: off by {off:e}");
        assert!(off.abs() < VOLUME, "{contour:?}: {off:e} {facts:?}");
        assert!(chamfers > 1e4 * VOLUME * exact, "{contour:?}: {chamfers}");
    }
}

/// Number of rays that meet the body where the mirror is, to `limit` mm.
fn meet(case: &Case, body: &Body, limit: f64) -> usize {
    let mirror = &case.mirror;
    let outline = mirror.full_outline();
    let size = outline.bounds();
    let share = |k: u32| DVec2::new(f64::from(k % 20) + 0.37, f64::from(k / 20) + 0.41) / 20.0;
    let all = (0..400).map(|k| size.min + size.size() * share(k));
    let inside: Vec<DVec2> = all.filter(|&q| outline.aims(q)).collect();
    for (&q, place) in inside.iter().zip(mirror.eval_many(&inside)) {
        let (at, normal) = (mirror.position(q, &place), mirror.normal(q, &place).normalize());
        let along = mirror.chart.ray(q, 0.0).direction;
        let ray = Ray { origin: at - along * 50.0, direction: along };
        let hit = body.nearest_hit(&ray, 0.0, f64::INFINITY);
        let hit = hit.unwrap_or_else(|| panic!("{}: {q} is missed", case.name));
        let off = (ray.at(hit.t) - at).dot(normal).abs();
        assert!(off <= limit, "{} {q}: {off:e} of {limit:e}", case.name);
        assert!(hit.normal.distance(normal) < 1e-4, "{} {q}: {}", case.name, hit.normal);
    }
    inside.len()
}

/// The STEP file of a shipped mirror.
fn file(name: &str) -> String {
    let mirror = design(&shipped(name)).unwrap().mirror;
    let case = Case { name: name.into(), mirror, stock: None, blind: Vec::new() };
    String::from_utf8(written(&case, &fitted(&case))).unwrap()
}

/// The first line of an entity of this keyword.
fn line_of<'a>(text: &'a str, keyword: &str) -> &'a str {
    text.lines().find(|line| line.contains(&format!("={keyword}("))).unwrap()
}

fn refused(text: &str) -> StepError {
    match Body::read(text.as_bytes()) {
        Ok(body) => panic!("read: {:?}", body.facts()),
        Err(error) => error,
    }
}

#[test]
fn damaged_files_are_refused_by_line_and_entity() {
    let sound = file("panoramic");
    Body::read(sound.as_bytes()).unwrap();
    // Of each: a keyword, what of its first line is replaced by what, and words of the refusal.
    let damages = [
        ("ORIENTED_EDGE", ".T.)", ".F.)", "does not begin where the edge before it ends"),
        ("ADVANCED_FACE", ".T.)", ".F.)", "its edges run the wrong way round"),
        ("EDGE_CURVE", ".T.)", ".F.)", "its curve runs the other way"),
        ("EDGE_LOOP", "(#", "(#1,#", "APPLICATION_CONTEXT is no edge of a loop"),
        ("MANIFOLD_SOLID_BREP", ",#", ",#9999", "which is not there"),
        ("CLOSED_SHELL", "CLOSED_SHELL", "OPEN_SHELL", "OPEN_SHELL is no closed shell"),
        ("EDGE_LOOP", "EDGE_LOOP", "POLY_LOOP", "POLY_LOOP is no loop"),
        ("VERTEX_POINT", ",#", ",#1", "its curve passes a vertex at"),
    ];
    for (keyword, from, to, words) in damages {
        let line = line_of(&sound, keyword);
        assert!(line.contains(from), "{line}");
        let error = refused(&sound.replacen(line, &line.replacen(from, to, 1), 1));
        assert!(error.to_string().contains(words), "{keyword}: {error}");
        assert!(error.line > 0, "{keyword}: {error}");
    }
}

#[test]
fn a_shell_without_a_face_and_a_loop_without_an_edge_are_refused() {
    let sound = file("panoramic");
    let damages = [
        ("CLOSED_SHELL", "one face alone has this edge"),
        ("EDGE_LOOP", "does not end where it begins"),
    ];
    for (keyword, words) in damages {
        let line = line_of(&sound, keyword);
        let (head, list) = line.split_once(",(").unwrap();
        let (_, rest) = list.split_once(',').unwrap();
        let error = refused(&sound.replacen(line, &format!("{head},({rest}"), 1));
        assert!(error.to_string().contains(words), "{keyword}: {error}");
    }
}

#[test]
fn a_vertex_that_was_moved_is_refused() {
    let sound = file("panoramic");
    let vertices: Vec<&str> =
        sound.lines().filter(|line| line.contains("=VERTEX_POINT(")).collect();
    assert!(vertices.len() >= 8, "{vertices:?}");
    for vertex in vertices {
        let point = vertex.split_once(",").unwrap().1.trim_end_matches(");");
        let line = sound.lines().find(|line| line.starts_with(&format!("{point}="))).unwrap();
        let damaged = line.replacen(",(", ",(1", 1).replacen("(1-", "(-1", 1);
        let error = refused(&sound.replacen(line, &damaged, 1));
        assert!(error.to_string().contains("a vertex at"), "{error}");
    }
}

#[test]
fn a_file_that_was_cut_short_is_refused() {
    let sound = file("panoramic");
    for share in 1..20 {
        let error = refused(&sound[..sound.len() * share / 20]);
        assert!(error.line > 0, "{error}");
    }
}
