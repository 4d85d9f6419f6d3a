//! Panels before a near target and under a camera that leans over them: as good as their views allow, and at their place.

use super::{QUARTERS, STACKED, designed, parsed, ray_error, text};
use crate::support::builds::folder;
use morion::internals::design::{Design, design};
use morion::internals::geom::{DVec2, DVec3, Rect};
use morion::internals::num::{cos, exp, radians, sin, tan};
use morion::internals::optics::reflect;
use morion::internals::pipeline::{Silent, build};
use morion::internals::results::{BuildReport, Verdict};

/// A panel's own optimum is the mirror of its view alone, under a camera whose frame is the panel: the same camera with
/// its principal point beside the frame, over a part whose middle is the panel's, as near to the pupil as that is raised to.
#[test]
fn each_panel_is_as_good_as_its_view_alone() {
    let leaning = "mount = { fold_deg = 30, towards_deg = 180 }\n";
    for (mount, target, panels) in [
        ("", None, &QUARTERS[..]),
        (leaning, None, &STACKED[..]),
        ("", Some(ROOM), &QUARTERS[..]),
        (leaning, Some(ROOM), &STACKED[..]),
    ] {
        let room = |middle: DVec3| target.map_or(String::new(), |room| sphere(room, middle));
        let text = text(panels, 12, "\"stl\"");
        let all = designed(&format!("{mount}{}{text}", room(DVec3::ZERO)));
        let reference = DVec3::Z * all.view.as_ref().unwrap().origin_mm;
        let pupil = all.camera.chart.pupil().unwrap() - reference;
        for (panel, part) in panels.iter().zip(all.mirror.panels()) {
            let (columns, rows, centre, hfov, roll) = panel;
            let size = [columns[1] - columns[0], rows[1] - rows[0]];
            let principal = [160.0 - f64::from(columns[0]), 120.0 - f64::from(rows[0])];
            let (part, focal) = (part.outline.bounds(), 160.0 / tan(radians(15.0)));
            let nearer = exp(-mean_height(&all, part) * all.camera.chart.vergence);
            let (middle, width) = (part.centre(), part.size() * nearer);
            let shift = -middle * nearer;
            let shift = format!("shift_mm = [{}, {}]", shift.x, shift.y);
            let raised = pupil + (middle.extend(0.0) - pupil) * nearer;
            let mount = match mount.split_once('}') {
                Some((lean, _)) => format!("{lean}, {shift} }}\n"),
                None => format!("mount.{shift}\n"),
            };
            let lone = designed(&format!(
                "camera.calibrated = {{ pixels = {size:?}, focal_px = [{focal}, {focal}], \
                 principal_px = {principal:?}, distortion = [0, 0, 0, 0], distance_mm = {} }}\n\
                 {mount}{}layout.rectangle = {{}}\nmethod.vector-field.degree = 12\n\
                 projection.perspective = {{ centre_deg = {centre:?}, hfov_deg = {hfov}, roll_deg = {roll}, \
                 mirrored = false }}\npart = {{ width_mm = {}, height_mm = {}, base_mm = 5 }}\nmesh.facet_px = 1\n\
                 export.formats = [\"stl\"]\n",
                150.0 * nearer,
                room(raised),
                width.x,
                width.y
            ));
            let whole = ([0, size[0]], [0, size[1]], *centre, *hfov, *roll);
            let [found, alone] = [ray_error(&all, panel), ray_error(&lone, &whole)];
            println!("{centre:?}: {found:.4} mrad, alone {alone:.4}");
            assert!((found / alone - 1.0).abs() < 0.01, "{centre:?}: {found} mrad, alone {alone}");
        }
    }
}

/// The mean height f over a panel, mm.
fn mean_height(design: &Design, part: Rect) -> f64 {
    let heights = (0..400).map(|k| {
        let share = DVec2::new(f64::from(k % 20) + 0.5, f64::from(k / 20) + 0.5) / 20.0;
        design.mirror.height(part.min + share * part.size())
    });
    heights.sum::<f64>() / 400.0
}

/// A round room about the mirror: its centre, from the mirror's middle, and its radius, mm.
const ROOM: (DVec3, f64) = (DVec3::new(40.0, -30.0, 200.0), 700.0);

/// The room as a target of a mirror whose middle is at `middle`, as it looks from the origin.
fn sphere((centre, radius): (DVec3, f64), middle: DVec3) -> String {
    let [DVec3 { x, y, z }, from] = [centre, DVec3::ZERO].map(|at| at - middle);
    format!(
        "target.sphere = {{ centre_mm = [{x}, {y}, {z}], radius_mm = {radius}, viewpoint_mm = {:?} }}\n",
        from.to_array()
    )
}

/// Where a ray from `at`, inside, meets the room.
fn on_wall((centre, radius): (DVec3, f64), at: DVec3, direction: DVec3) -> DVec3 {
    let from = at - centre;
    let along = from.dot(direction);
    let root = f64::sqrt(along * along + radius * radius - from.length_squared());
    at + direction * (root - along)
}

/// Panels whose heights their neighbours decide show a near wall at its place: rays meet it where directions from the
/// mirror's middle do. A mirror for what is far away is as far off as it is large.
#[test]
fn raised_panels_show_a_near_wall_at_its_place() {
    let off_mm = |design: &Design| {
        let (view, camera) = (design.view.as_ref().unwrap(), &design.camera);
        let pupil = camera.chart.pupil().unwrap();
        let (mut sum, mut count) = (0.0, 0.0);
        for (columns, rows, [azimuth, elevation], hfov, roll) in STACKED {
            let [(s, c), (e_s, e_c), (r_s, r_c)] =
                [azimuth, elevation, roll].map(|deg| (sin(radians(deg)), cos(radians(deg))));
            let front = DVec3::new(s * e_c, c * e_c, e_s);
            // The picture's right and up, before its turn, are carried from the axis to the view's centre on the shortest way.
            let carried = |way: DVec3| {
                let about = DVec3::Z.cross(front).try_normalize().unwrap_or(DVec3::X);
                let (turn_s, turn_c) = (e_c, e_s);
                way * turn_c + about.cross(way) * turn_s + about * (about.dot(way) * (1.0 - turn_c))
            };
            let per_px = tan(radians(0.5 * hfov)) / (0.5 * f64::from(columns[1] - columns[0]));
            for row in (rows[0]..rows[1]).step_by(7) {
                for column in (columns[0]..columns[1]).step_by(11) {
                    let pixel = [f64::from(column) + 0.5, f64::from(row) + 0.5];
                    let x = pixel[0] - 0.5 * f64::from(columns[0] + columns[1]);
                    let y = 0.5 * f64::from(rows[0] + rows[1]) - pixel[1];
                    let (x, y) = (-(x * r_c - y * r_s) * per_px, (x * r_s + y * r_c) * per_px);
                    let wanted = front + carried(DVec3::X) * x + carried(DVec3::Y) * y;
                    let q = camera.picture.chart_point(camera.image_point(pixel[0], pixel[1]));
                    let point = design.mirror.at(q);
                    let at = design.mirror.position(q, &point);
                    let seen = reflect((at - pupil).normalize(), design.mirror.normal(q, &point));
                    let from_middle = at - DVec3::Z * view.origin_mm;
                    let met = on_wall(ROOM, from_middle, seen);
                    let wanted = on_wall(ROOM, DVec3::ZERO, wanted.normalize());
                    sum += (met - wanted).length_squared();
                    count += 1.0;
                }
            }
        }
        f64::sqrt(sum / count)
    };
    let text = text(&STACKED, 12, "\"stl\"");
    let near = off_mm(&designed(&format!("{}{text}", sphere(ROOM, DVec3::ZERO))));
    let far = off_mm(&designed(&text));
    println!("{near:.2} mm, of a mirror for far away {far:.2} mm");
    // What the views alone leave, 4 mrad in the mean, is 3 mm.
    assert!(near < 4.0 && far > 20.0, "{near} mm, of a mirror for far away {far} mm");
}

/// Panels before a wall that is nearly as near as they are large: their heights settle.
#[test]
fn a_wall_as_near_as_the_mirror_is_large_is_shown() {
    let close = (DVec3::new(0.0, 0.0, 60.0), 140.0);
    let text = text(&STACKED, 12, "\"stl\"");
    let design = designed(&format!("{}{text}", sphere(close, DVec3::ZERO)));
    for panel in &STACKED {
        let off = ray_error(&design, panel);
        assert!(off < 30.0, "{panel:?}: {off} mrad");
    }
}

/// The part under a camera that leans, or stands beside it, leans along its rays: its walls close it in every format, with an
/// edge and a hole around it too, and its size is the one that is told.
#[test]
fn parts_lean_with_their_camera() {
    let leaning = "mount = { fold_deg = 30, towards_deg = 180 }\n";
    let beside = "mount.shift_mm = [12, -7]\n";
    let around = "border_mm = 12, holes_mm = [[0, 53, 3.2]]";
    for (mount, part) in [(leaning, ""), (beside, ""), (leaning, around)] {
        let text = text(&STACKED, 8, "\"stl\", \"obj\", \"3mf\", \"step\"")
            .replace("mesh.facet_px = 3", "mesh.chord_um = 8")
            .replace("base_mm = 5 }", &format!("base_mm = 8, {part} }}").replace(", }", " }"));
        let profile = parsed(&format!("{mount}{text}"));
        let folder = folder();
        let report: BuildReport = build(&profile, folder.path(), &Silent).unwrap();
        assert_eq!(report.verdict, Verdict::Pass, "{mount}{part}: {:?}", report.reasons);
        let file = std::fs::read_to_string(folder.path().join("p/mirror.obj")).unwrap();
        let places = file.lines().filter_map(|line| line.strip_prefix("v ")).map(|line| {
            let at: Vec<f64> = line.split(' ').map(|x| x.parse().unwrap()).collect();
            DVec3::from_slice(&at[..3])
        });
        let ends = places
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[lo, hi], at| [lo.min(at), hi.max(at)]);
        let size = DVec3::from_array(design(&profile).unwrap().mounting.size_mm);
        assert!(
            (ends[1] - ends[0] - size).abs().max_element() < 0.02,
            "{mount}{part}: {ends:?} {size}"
        );
    }
}

/// Lines between panels are parallel to the part's sides, and run together in the picture of a camera that leans along them;
/// by its rays and the plane of the part.
#[test]
fn lines_run_together_under_a_camera_that_leans_along_them() {
    let departure = |towards: f64| {
        let mount = format!("mount = {{ fold_deg = 30, towards_deg = {towards} }}\n");
        let design = designed(&format!("{mount}{}", text(&STACKED, 4, "\"stl\"")));
        design.facts.dividing_lines.expect("a leaning camera").departure_px
    };
    for towards in [0.0, 180.0] {
        assert!(departure(towards) < 1e-9, "{towards}");
    }
    let (focal, lean) = (160.0 / tan(radians(15.0)), radians(15.0));
    // The pupil is 150 mm along its axis from the part's middle; the part is 80.4 mm wide along the lean.
    let on_part = |x: f64, y: f64| {
        let ray =
            DVec3::new(x * cos(lean) - focal * sin(lean), y, -x * sin(lean) - focal * cos(lean));
        DVec3::new(sin(lean), 0.0, cos(lean)) * 150.0 + ray * (150.0 * cos(lean) / -ray.z)
    };
    let row = 40.0;
    let all = (0..=640).map(|k| on_part(0.5 * f64::from(k) - 160.0, row));
    let at: Vec<f64> = all.filter(|at| at.x.abs() <= 40.2).map(|at| at.y).collect();
    assert!(at.len() < 640, "the frame is wider than the part on one side");
    let [low, high] = [f64::min, f64::max].map(|f| at.iter().copied().reduce(f).unwrap());
    let rows = at.iter().map(|at| row * 0.5 * (low + high) / at - row);
    let exact = rows.map(f64::abs).fold(0.0, f64::max);
    let found = departure(90.0);
    assert!((found / exact - 1.0).abs() < 0.02 && exact > 1.0, "{found} px, by the rays {exact}");
}
