//! Panels side by side: what each shows, how they are joined, and what is made of them.

mod near_and_leaning;

use crate::support::builds::folder;
use crate::support::share;
use morion::internals::design::{Design, design};
use morion::internals::geom::{DVec2, DVec3, PartFeatures, Precision};
use morion::internals::mirror::{Mirror, Surface};
use morion::internals::num::{cos, radians, sin, tan};
use morion::internals::optics::reflect;
use morion::internals::pipeline::{
    Command, ReplayOptions, Silent, ToleranceOptions, Verify, VerifyOptions, build, load,
};
use morion::internals::profile::{Profile, shipped};
use morion::internals::results::{BuildReport, RayFault, ReasonKind, Verdict};
use morion::internals::solid::Solid;

/// A panel: columns, rows, centre, angle of view, turn.
type Panel = ([u32; 2], [u32; 2], [f64; 2], f64, f64);

/// The four quarters of the frame, each the right way up.
const QUARTERS: [Panel; 4] = [
    ([0, 160], [0, 120], [-45.0, 0.0], 60.0, 135.0),
    ([160, 320], [0, 120], [45.0, 0.0], 60.0, -135.0),
    ([0, 160], [120, 240], [-135.0, 0.0], 60.0, 45.0),
    ([160, 320], [120, 240], [135.0, 0.0], 60.0, -45.0),
];

/// The four quarters of the frame as of a plan: what lies behind is upside down.
const PLAN: [Panel; 4] = [
    ([0, 160], [0, 120], [-45.0, 0.0], 60.0, 135.0),
    ([160, 320], [0, 120], [45.0, 0.0], 60.0, -135.0),
    ([0, 160], [120, 240], [-135.0, 0.0], 60.0, -135.0),
    ([160, 320], [120, 240], [135.0, 0.0], 60.0, 135.0),
];

/// Ahead and behind over a view straight back.
const THREE: [Panel; 3] = [
    ([0, 160], [0, 120], [-20.0, 20.0], 40.0, 0.0),
    ([160, 320], [0, 120], [20.0, 20.0], 40.0, 0.0),
    ([0, 320], [120, 240], [0.0, 90.0], 50.0, 0.0),
];

/// Side by side, whose walls slant.
const COLUMNS: [Panel; 3] = [
    ([0, 100], [0, 240], [-90.0, 50.0], 16.0, 0.0),
    ([100, 230], [0, 240], [0.0, 70.0], 20.0, 0.0),
    ([230, 320], [0, 240], [90.0, 40.0], 14.0, 0.0),
];

/// Ahead, straight back and behind, one over the other.
const STACKED: [Panel; 3] = [
    ([0, 320], [0, 80], [0.0, 20.0], 80.0, 180.0),
    ([0, 320], [80, 160], [0.0, 90.0], 80.0, 0.0),
    ([0, 320], [160, 240], [180.0, 20.0], 80.0, 0.0),
];

/// No line goes across the frame.
const PINWHEEL: [Panel; 5] = [
    ([0, 200], [0, 80], [0.0, 45.0], 30.0, 0.0),
    ([200, 320], [0, 160], [90.0, 45.0], 20.0, 0.0),
    ([120, 320], [160, 240], [180.0, 45.0], 30.0, 0.0),
    ([0, 120], [80, 240], [-90.0, 45.0], 20.0, 0.0),
    ([120, 200], [80, 160], [0.0, 90.0], 12.0, 0.0),
];

/// Every arrangement, with a name, and one under a camera that leans.
pub fn arrangements() -> Vec<(&'static str, Profile)> {
    let names = ["quarters", "three", "columns", "pinwheel"].into_iter();
    let named = names.zip(layouts()).map(|(name, panels)| (name, text(panels, 8, "\"stl\"")));
    let leaning =
        format!("mount = {{ fold_deg = 30, towards_deg = 60 }}\n{}", text(&THREE, 8, "\"stl\""));
    named.chain([("leaning", leaning)]).map(|(name, text)| (name, parsed(&text))).collect()
}

/// A profile of three panels, of a small frame, with these formats of files.
pub fn small_panels(formats: &str) -> String {
    text(&THREE, 8, formats)
}

fn layouts() -> [&'static [Panel]; 4] {
    [&QUARTERS, &THREE, &COLUMNS, &PINWHEEL]
}

fn text(panels: &[Panel], degree: usize, formats: &str) -> String {
    let panel = |(columns, rows, centre, hfov, roll): &Panel| {
        format!(
            "[[panel]]\ncolumns = {columns:?}\nrows = {rows:?}\ncentre_deg = {centre:?}\nhfov_deg = {hfov}\n\
             roll_deg = {roll}\nmirrored = false\n"
        )
    };
    let panels: String = panels.iter().map(panel).collect();
    format!(
        "camera.pinhole = {{ pixels = [320, 240], hfov_deg = 30, distance_mm = 150, pupil_mm = 0.8 }}\n\
         layout.rectangle = {{}}\nmethod.vector-field.degree = {degree}\n\
         part = {{ width_mm = 80.4, base_mm = 5 }}\nmesh.facet_px = 3\nexport.formats = [{formats}]\n\
         accept = {{ pixel_error_rms_px = 5, pixel_error_max_px = 20 }}\n{panels}"
    )
}

fn parsed(text: &str) -> Profile {
    Profile::parse("p", "p.toml", text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn designed(text: &str) -> Design {
    design(&parsed(text)).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A perspective view by vectors alone: to the front right and up in its picture, with straight lines straight. Not
/// mirrored, and turned by its azimuth and half a turn, it is the right way up.
#[test]
fn views_around_are_the_right_way_up() {
    let design = designed(&text(&QUARTERS, 4, "\"stl\""));
    let view = design.view.as_ref().unwrap();
    for (columns, rows, [azimuth, _], hfov, _) in QUARTERS {
        let [s, c] = [sin(radians(azimuth)), cos(radians(azimuth))];
        let (front, right) = (DVec3::new(s, c, 0.0), DVec3::new(c, -s, 0.0));
        let per_px = tan(radians(0.5 * hfov)) / 80.0;
        for k in 0..25 {
            let share = DVec2::new(f64::from(k % 5) + 0.5, f64::from(k / 5) + 0.5) / 5.0;
            let [x, y] = [(columns, share.x), (rows, share.y)]
                .map(|([from, to], share)| f64::from(from) + share * f64::from(to - from));
            let across =
                [(columns, x), (rows, y)].map(|([from, to], at)| at - 0.5 * f64::from(from + to));
            let wanted = front + per_px * (right * across[0] - DVec3::Z * across[1]);
            let found = view.direction_of(design.camera.image_point(x, y), DVec3::ZERO);
            assert!(
                (found - wanted.normalize()).length() < 1e-12,
                "{azimuth} at {x}, {y}: {found}"
            );
        }
    }
}

/// Panels that are each other's reflections are solved for once, and even ones by even functions: as those are that a billionth of a
/// degree keeps from it, each for itself.
#[test]
fn panels_are_the_same_whether_or_not_they_are_reflections_of_others() {
    let both = [DVec2::new(-1.0, 1.0), DVec2::new(1.0, -1.0)];
    for (panels, reflections) in
        [(&QUARTERS[..], &both[..1]), (&THREE, &both[..1]), (&STACKED, &both[..1]), (&PLAN, &both)]
    {
        let turned: Vec<Panel> =
            panels.iter().map(|&(a, b, c, d, roll)| (a, b, c, d, roll + 1e-9)).collect();
        let [own, turned] = [panels, &turned].map(|panels| designed(&text(panels, 10, "\"stl\"")));
        let bounds = own.mirror.outline.bounds();
        // (Walls of equal height may be on either side: a panel's height is free.)
        for k in 0..400 {
            let share = DVec2::new(f64::from(k % 20), f64::from(k / 20)) / 19.0;
            let q = bounds.min + share * bounds.size();
            let [a, b] = [&own, &turned].map(|design| design.mirror.at(q).slope);
            assert!((a - b).length() < 1e-8, "{panels:?} at {q}: {a} {b}");
            for &axes in reflections {
                let reflected = own.mirror.at(axes * q).slope;
                assert_eq!(axes * reflected, a, "{panels:?} at {q}");
            }
        }
    }
}

/// Base and height of the part are those of the panel that reaches lowest and of the one that reaches highest, wherever in the panel:
/// also along a line between panels, where samples of the mirror are those of one panel.
#[test]
fn the_part_is_as_high_as_its_highest_panel() {
    let small = [&QUARTERS[..], &THREE, &PLAN].map(|panels| text(panels, 8, "\"stl\""));
    let shipped = shipped().iter().find(|shipped| shipped.name == "four-views").unwrap();
    for text in small.iter().map(String::as_str).chain([shipped.text]) {
        let design = designed(text);
        let heights = design.mirror.panels().into_iter().flat_map(|panel| {
            let places: Vec<DVec2> =
                panel.outline.bounds().grid(400, 400).map(|(q, _)| q).collect();
            places.into_iter().map(move |q| panel.position(q, &panel.at(q)).z)
        });
        let [least, most] = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], z| {
            [least.min(z), most.max(z)]
        });
        let (base, top) = (design.profile.part.base_mm, design.mounting.size_mm[2]);
        assert!((0.0..1e-3).contains(&(least - base + 1e-9)), "{least} over a base of {base}");
        assert!((0.0..1e-3).contains(&(top - most + 1e-9)), "{most}, told as {top}");
    }
}

/// The root mean square of the ray error over a panel's picture, mrad, by the law of reflection.
fn ray_error(design: &Design, ([left, right], [top, bottom], ..): &Panel) -> f64 {
    let (camera, mirror) = (&design.camera, &design.mirror);
    let (view, pupil) = (design.view.as_ref().unwrap(), camera.chart.pupil().unwrap());
    let (mut sum, mut count) = (0.0, 0.0);
    for row in (2 * top + 1..2 * bottom).step_by(3) {
        for column in (2 * left + 1..2 * right).step_by(3) {
            let image = camera.image_point(0.5 * f64::from(column), 0.5 * f64::from(row));
            let q = camera.picture.chart_point(image);
            // (A frame that is seen obliquely is wider than the part on one side.)
            if !mirror.full_outline().contains(q) {
                continue;
            }
            let point = mirror.at(q);
            let at = mirror.position(q, &point);
            let seen = reflect((at - pupil).normalize(), mirror.normal(q, &point));
            let off = (seen - view.direction_of(image, at)).length();
            sum += off * off;
            count += 1.0;
        }
    }
    1e3 * f64::sqrt(sum / count)
}

/// The heights of both panels at places on the lines between panels, mm.
fn meetings(mirror: &Mirror) -> Vec<[f64; 2]> {
    let Surface::Panels(surface) = &mirror.surface else { panic!("one surface") };
    let mut steps = Vec::new();
    for line in surface.parts.dividing_lines() {
        for stretch in line.stretches(&surface.parts) {
            for k in 0..=100 {
                let [from, to] = stretch.ends;
                let q = line.place(from + (to - from) * f64::from(k) / 100.0);
                let panels = mirror.panels();
                steps.push(stretch.pair.map(|k| panels[k].height(q)));
            }
        }
    }
    steps
}

/// Walls are as high everywhere as facets need, closed bodies, and their volume is that of the design.
#[test]
#[ignore = "long: .ci/nightly"]
fn walls_close_the_part_in_every_arrangement() {
    for panels in layouts() {
        let coarse = text(panels, 8, "\"stl\"").replace("mesh.facet_px = 3", "mesh.chord_um = 5");
        let design = designed(&coarse);
        let steps = meetings(&design.mirror).into_iter().map(|[a, b]| (a - b).abs());
        let least = steps.fold(f64::INFINITY, f64::min);
        assert!((0.0999..=0.1 + 1e-9).contains(&least), "{panels:?}: a step of {least} mm");
        let face = design.mesh().unwrap();
        assert!(face.mesh.optical() < face.mesh.triangles.len());
        for precision in [Precision::Single, Precision::Double] {
            let solid = Solid::from_face(&face.mesh, PartFeatures::NONE, precision).unwrap();
            let check = solid.check();
            assert_eq!((check.euler, check.components), (2, 1), "{panels:?}");
            assert_eq!(solid.optical(), face.mesh.optical());
            let (found, exact) = (check.volume_mm3, design.volume());
            let explained = design.mirror.footprint(0.0) * face.bound.chord_mm;
            assert!((found - exact).abs() < 1.1 * explained, "{panels:?}: {found} {exact}");
            assert!((found - exact).abs() > 1e-9, "{panels:?}");
        }
    }
}

/// Lines between panels are straight on the part; through a lens of one radial coefficient they depart from the edges of
/// the profile by what its polynomial says, and every pixel shows what the panel that is seen there is to show.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_lens_bends_the_lines_between_panels_and_no_pixel_is_lost_to_it() {
    let ideal = text(&QUARTERS, 8, "\"stl\"");
    let (focal, principal, k1) = (160.0 / tan(radians(15.0)), [131.0, 117.0], -0.25);
    let pinhole = "camera.pinhole = { pixels = [320, 240], hfov_deg = 30, distance_mm = 150, pupil_mm = 0.8 }";
    let lens = format!(
        "camera.calibrated = {{ pixels = [320, 240], focal_px = [{focal}, {focal}], principal_px = {principal:?}, \
         distortion = [{k1}, 0, 0, 0], distance_mm = 150, pupil_mm = 0.8 }}"
    );
    assert!(ideal.contains(pinhole));
    let built = |text: &str| -> BuildReport {
        let folder = folder();
        build(&parsed(text), folder.path(), &Silent).unwrap()
    };
    let [bent, straight] = [built(&ideal.replace(pinhole, &lens)), built(&ideal)];
    assert_eq!(bent.verdict, Verdict::Pass, "{:?}", bent.reasons);
    assert!(straight.design.dividing_lines.is_none());
    let rms = |report: &BuildReport| report.trace[0].errors.pixel_error_px.unwrap().rms;
    assert!(rms(&bent) < 1.5 * rms(&straight), "{} {}", rms(&bent), rms(&straight));

    // By the polynomial of the lens: where it sees a point, and by bisection what it sees at a pixel.
    let bend = |p: DVec2| p * (1.0 + k1 * p.length_squared());
    let sight = |pixel: DVec2| {
        let wanted = (pixel - DVec2::from(principal) - 0.5) / focal;
        let (mut low, mut high) = (1.0, 1.2);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if bend(wanted * middle).length() < wanted.length() {
                low = middle
            } else {
                high = middle
            }
        }
        wanted * low
    };
    // The part, from the pupil: of an edge what is beside it counts.
    let half = designed(&ideal.replace(pinhole, &lens)).mirror.outline.bounds().max / 150.0;
    let departure = |axis: usize, [edge, length]: [f64; 2]| {
        let pixel =
            |along: f64| if axis == 0 { DVec2::new(edge, along) } else { DVec2::new(along, edge) };
        let seen = (0..=500).map(|k| sight(pixel(length * f64::from(k) / 500.0)));
        let on_part: Vec<DVec2> = seen.filter(|p| p[1 - axis].abs() <= half[1 - axis]).collect();
        let [low, high] =
            [f64::min, f64::max].map(|f| on_part.iter().map(|p| p[axis]).reduce(f).unwrap());
        let line = on_part.iter().map(|&p| {
            let mut at = p;
            at[axis] = 0.5 * (low + high);
            focal * bend(at)[axis] + principal[axis] + 0.5 - edge
        });
        line.map(f64::abs).fold(0.0, f64::max)
    };
    let exact = departure(0, [160.0, 240.0]).max(departure(1, [120.0, 320.0]));
    let found = bent.design.dividing_lines.as_ref().unwrap().departure_px;
    assert!(
        (found / exact - 1.0).abs() < 0.02 && exact > 0.05,
        "{found} px, by the polynomial {exact}"
    );
}

/// Rows of a sag table are places of their panel, and its normals there show what the panel is to show.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_sag_table_names_the_panel_of_each_row() {
    let text = text(&COLUMNS, 8, "\"stl\"").replace(
        "export.formats = [\"stl\"]",
        "export = { formats = [\"obj\", \"csv\"], sag = { pitch_mm = 1.5, step_mm = 0.5 } }",
    );
    let profile = parsed(&text);
    let folder = folder();
    let report: BuildReport = build(&profile, folder.path(), &Silent).unwrap();
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let design = designed(&text);
    let (view, pupil) = (design.view.as_ref().unwrap(), design.camera.chart.pupil().unwrap());
    let written = std::fs::read_to_string(folder.path().join("p/sag.csv")).unwrap();
    let lines: Vec<&str> = written.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(lines[0], "X_mm,Y_mm,Z_mm,NX,NY,NZ,panel");
    assert!(written.contains("# panel 2: columns 100 to 230, rows 0 to 240\n"), "{written}");
    let mut counts = [0; 3];
    for line in &lines[1..] {
        let row: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        let (at, normal) = (DVec3::from_slice(&row[..3]), DVec3::from_slice(&row[3..6]));
        let panel = row[6] as usize - 1;
        counts[panel] += 1;
        // Along the camera's ray to its frame.
        let q = (at - pupil).truncate() / (pupil.z - at.z) * 150.0;
        let column = q.x / design.camera.pixel_mm + 160.0;
        // The part is a little wider than the frame.
        let [from, to] = COLUMNS[panel].0.map(f64::from);
        let [least, most] =
            [if from == 0.0 { -0.05 } else { from }, if to == 320.0 { 320.05 } else { to }];
        assert!((least - 1e-6..=most + 1e-6).contains(&column), "{line}: column {column}");
        let seen = reflect((at - pupil).normalize(), normal);
        // (Within the panel, whose edges belong to both neighbours.)
        let middle = 0.5 * (from + to);
        let image =
            design.camera.image_point(column.clamp(from, to), 120.0 - q.y / design.camera.pixel_mm);
        let inwards = DVec2::new((middle - column).signum() * 1e-9, 0.0);
        let off = (seen - view.direction_of(image + inwards, at)).length();
        assert!(off < 0.02, "{line}: {off} rad off");
    }
    // A place for each pitch and step of the plan.
    let found: f64 = counts.iter().map(|count| f64::from(*count)).sum();
    let area = f64::from(80) * 60.0;
    assert!((found / (area / 0.75) - 1.0).abs() < 0.1, "{counts:?}");
}

/// The witness reads the files, and every vertex is on its panel or its wall.
#[test]
fn files_of_panels_pass_and_show_their_views() {
    for panels in share(2, 1, [&QUARTERS[..], &COLUMNS[..]]) {
        let text = text(panels, 10, "\"stl\", \"obj\", \"3mf\", \"glb\"");
        let folder = folder();
        let report: BuildReport = build(&parsed(&text), folder.path(), &Silent).unwrap();
        assert_eq!(report.verdict, Verdict::Pass, "{panels:?}: {:?}", report.reasons);
        for trace in &report.trace {
            assert_eq!((trace.hit, trace.missed, trace.shadowed), (trace.rays, 0, 0));
            let facet = trace.errors.facet_error_px.unwrap();
            assert!(facet.max > 2.1 && facet.max <= 3.0, "{facet:?}");
        }
    }
}

/// Four views of 60 degrees around show 240 degrees of the horizon, and what lies between them is no one's.
#[test]
#[ignore = "long: .ci/nightly"]
fn what_lies_between_two_views_is_not_called_covered() {
    let folder = folder();
    let profile = parsed(&text(&QUARTERS, 12, "\"stl\""));
    let coverage = morion::frame(&profile, folder.path()).unwrap().coverage;
    // At the corners of its picture a perspective view of 60 degrees shows as wide a turn.
    assert!((coverage.azimuth_deg - 240.0).abs() < 8.0, "{}", coverage.azimuth_deg);
    assert_eq!(coverage.gaps_deg.len(), 4, "{:?}", coverage.gaps_deg);
}

/// A copy is measured, trials are made and a trial's part is traced; what knows one smooth surface alone refuses panels.
#[test]
#[ignore = "long: .ci/nightly"]
fn commands_know_panels_or_refuse_them() {
    let folder = folder();
    let path = folder.path().join("p.toml");
    std::fs::write(&path, text(&QUARTERS, 8, "\"stl\"")).unwrap();
    let profile = load(path.to_str().unwrap()).unwrap();
    let out = folder.path().join("out");
    build(&profile, &out, &Silent).unwrap();
    let (copy, options) =
        (out.join("p/mirror.stl"), VerifyOptions { align: true, ..VerifyOptions::default() });
    let verify = Verify { path: &copy, options };
    let (found, _) = verify.in_memory(&profile, &Silent).unwrap();
    assert_eq!(found.verdict, Verdict::Pass, "{:?}", found.reasons);

    let trials = ToleranceOptions { range: 0..20, ..ToleranceOptions::default() };
    let report = trials.publish(&profile, &out, &Silent).unwrap();
    assert_eq!(report.study.trials, 20);
    let without = ["stepover_mm", "slope_mrad", "waviness_um"].map(String::from);
    let replay = ReplayOptions { trial: 3, seed: trials.seed, without: &without };
    let replay = replay.publish(&profile, &out, &Silent).unwrap();
    assert_eq!(replay.verdict, Verdict::Pass, "{:?}", replay.reasons);

    // Pages offer what there is.
    let page = |name: &str| std::fs::read_to_string(out.join("p").join(name)).unwrap();
    for name in ["report.html", "tolerance.html"] {
        assert!(
            page(name).contains("frame p</code>") && !page(name).contains("machining"),
            "{name}"
        );
    }
    let machining = morion::machining(&profile, &out).unwrap_err().to_string();
    assert!(machining.contains("a mirror of panels has walls"), "{machining}");
    let photo = out.join("p/preview.png");
    let unwrapped = morion::unwrap(&profile, &photo, &out).unwrap_err().to_string();
    assert!(unwrapped.contains("a picture of panels is no panorama"), "{unwrapped}");
}

/// Ahead, the floor under an upturned camera, and behind, in any order down the frame.
fn stacked(order: [usize; 3]) -> String {
    let views = [([0.0, 20.0], 180.0), ([0.0, 90.0], 0.0), ([180.0, 20.0], 0.0)];
    let panel = |(k, view): (usize, usize)| -> Panel {
        let (from, (centre, roll)) = (80 * k as u32, views[view]);
        ([0, 320], [from, from + 80], centre, 80.0, roll)
    };
    let panels: Vec<Panel> = order.into_iter().enumerate().map(panel).collect();
    text(&panels, 12, "\"stl\"")
}

/// Panels are joined so that walls shadow little: with the smallest walls 320 pixels of these views were in shadow with the
/// floor in the middle, and 6379 with the floor over both.
#[test]
fn front_floor_and_rear_fill_the_frame() {
    for (order, most) in [([0, 1, 2], 0), ([1, 0, 2], 1800)] {
        let folder = folder();
        let report = build(&parsed(&stacked(order)), folder.path(), &Silent).unwrap();
        assert_eq!(report.verdict, Verdict::Pass, "{order:?}: {:?}", report.reasons);
        let lost = report.frame.unwrap().lost;
        assert!(lost.shadow <= most, "{order:?}: {lost:?}");
        assert_eq!(lost.counts().iter().sum::<usize>(), lost.shadow, "{order:?}: {lost:?}");
    }
}

/// Where walls shadow more than 3 % of the rays, the reason names a share of the frame that, written down, is kept by every file.
#[test]
fn what_walls_shadow_beyond_a_few_rays_is_accepted_by_name() {
    let text = stacked([2, 0, 1]).replace("\"stl\"", "\"stl\", \"step\"");
    let reasons = |text: &str| build(&parsed(text), folder().path(), &Silent).unwrap().reasons;
    let refused = reasons(&text);
    let ReasonKind::Rays(RayFault::Shadowed { count, rays, allowed, by_rim: 0 }) = refused[0].kind
    else {
        panic!("{refused:?}")
    };
    assert_eq!((rays, allowed), (76_800, 2304));
    assert!((20_000..24_000).contains(&count), "{count}");
    let way_out = refused[0].way_out.as_ref().expect("a way out");
    let (_, share) = way_out.split_once("write frame_filled = ").expect("a key");
    let share = share.split_once(" in [accept]").expect("its table").0;
    let accepting = |share: &str| {
        reasons(&text.replace("accept = { ", &format!("accept = {{ frame_filled = {share}, ")))
    };
    assert_eq!(accepting(share), []);
    // No more than there is: a thousandth more is refused, for the frame.
    let more = (share.parse::<f64>().unwrap() + 1e-3).to_string();
    let refused = accepting(&more);
    let ReasonKind::Picture(fault) = &refused[0].kind else { panic!("{refused:?}") };
    assert!(fault.to_string().contains("are in the part's own shadow"), "{fault}");
    assert!(refused[0].to_string().contains(&format!("frame_filled = {share}")), "{}", refused[0]);
}

#[test]
fn the_shipped_four_views_are_a_profile_of_panels() {
    let found = shipped().iter().find(|shipped| shipped.name == "four-views").unwrap();
    assert!(designed(found.text).mirror.has_steps());
}
