//! Parts that a coordinate measuring machine touches: the plan of its points, and form terms that are as uncertain as is said.

use crate::support::builds::{folder, morion, save, told};
use crate::support::draws::Draws;
use crate::support::{refused, shipped, shipped_text, times};
use morion::internals::align::{Pose, align_points};
use morion::internals::design::{Design, design};
use morion::internals::geom::DVec3;
use morion::internals::inspection::{FormFit, InspectionPlan, fit_form, plan_points, rims};
use morion::internals::num::random::RandomStream;
use morion::internals::profile::Profile;
use nalgebra::{DMatrix, DVector};
use serde_json::Value;
use std::path::Path;

const DEGREE: usize = 4;

fn planned(design: &Design) -> InspectionPlan {
    plan_points(&design.mirror, DEGREE, 1.2)
}

#[test]
fn points_lie_on_the_mirror_evenly_and_away_from_rims_ridges_and_steps() {
    for name in ["conquistador", "panoramic", "hyperbolic", "soccer", "driver", "four-views"] {
        let design = design(&shipped(name)).unwrap();
        let (mirror, plan) = (&design.mirror, planned(&design));
        assert!(plan.points.len() >= 40, "{name}: {}", plan.points.len());
        for (k, point) in plan.points.iter().enumerate() {
            let q = mirror.chart.coordinates(point.at).0;
            let local = mirror.at(q);
            assert!(mirror.position(q, &local).distance(point.at) < 1e-9, "{name} {k}");
            assert!(mirror.normal(q, &local).normalize().distance(point.normal) < 1e-9);
            let nearest = plan.points.iter().enumerate().filter(|(j, _)| *j != k);
            let nearest = nearest.map(|(_, other)| other.at.distance(point.at)).fold(1e9, f64::min);
            assert!(nearest > 0.3 * plan.spacing_mm, "{name} {k}: {nearest}");
        }
        // A larger margin leaves fewer, and one of the mirror's size none.
        let fewer = plan_points(mirror, DEGREE, 2.0 * plan.spacing_mm).points.len();
        assert!(fewer < plan.points.len(), "{name}: {fewer}");
        assert!(plan_points(mirror, DEGREE, 200.0).points.is_empty(), "{name}");
        let twice = plan_points(mirror, 2 * DEGREE, 1.2).points.len();
        assert!(twice > 2 * plan.points.len(), "{name}: {twice}");
    }
    // The ridge of a conquistador is a rim too.
    let design = design(&shipped("conquistador")).unwrap();
    assert!(planned(&design).points.iter().all(|point| point.at.y.abs() > 0.4));
}

/// A sheet shows no line between the rims of a ring.
#[test]
fn rims_of_a_ring_are_two_closed_lines() {
    let design = design(&shipped("conical")).unwrap();
    let rims = rims(&design.mirror);
    assert_eq!(rims.len(), 2);
    for rim in &rims {
        let radius = rim[0].truncate().length();
        assert!(rim.iter().all(|p| (p.truncate().length() - radius).abs() < 1e-9));
        let longest = rim.windows(2).map(|w| w[0].distance(w[1])).fold(0.0, f64::max);
        assert!(rim.first() == rim.last() && longest < 0.01 * radius, "{longest}");
    }
}

/// Low terms, one from peak to valley, in the order of the error sources: Legendre's over a rectangle, Noll's over a
/// disc, by their textbook forms.
fn terms(design: &Design, round: bool, at: DVec3) -> Vec<f64> {
    let half = 0.5 * design.mirror.full_outline().bounds().size();
    if !round {
        let [u, v] = [at.x / half.x, at.y / half.y];
        let two = |x: f64| 1.5 * x * x - 0.5;
        let three = |x: f64| 2.5 * x * x * x - 1.5 * x;
        let four = |x: f64| (35.0 * x * x * x * x - 30.0 * x * x + 3.0) / 8.0;
        let pairs = [(two(u), 1.5), (u * v, 2.0), (two(v), 1.5), (three(u), 2.0)];
        let more = [(two(u) * v, 2.0), (u * two(v), 2.0), (three(v), 2.0), (four(u), 10.0 / 7.0)];
        let all = pairs.into_iter().chain(more).chain([(two(u) * two(v), 1.5)]);
        return all.map(|(f, pv)| f / pv).collect();
    }
    let rim = design.mirror.position(
        morion::internals::geom::DVec2::new(half.x, 0.0),
        &design.mirror.at(morion::internals::geom::DVec2::new(half.x, 0.0)),
    );
    let [u, v] = [at.x / rim.x, at.y / rim.x];
    let r2 = u * u + v * v;
    let coma = 3.0 * r2 - 2.0;
    let spherical = 6.0 * r2 * r2 - 6.0 * r2 + 1.0;
    vec![
        (2.0 * r2 - 1.0) / 2.0,
        2.0 * u * v / 2.0,
        (u * u - v * v) / 2.0,
        coma * v / 2.0,
        coma * u / 2.0,
        (3.0 * u * u * v - v * v * v) / 2.0,
        (u * u * u - 3.0 * u * v * v) / 2.0,
        spherical / 1.5,
    ]
}

/// A set of touched places with the columns of their motions and terms along the normals.
struct Touched {
    design: Design,
    plan: InspectionPlan,
    round: bool,
    motions: DMatrix<f64>,
    terms: DMatrix<f64>,
}

impl Touched {
    fn new(name: &str, round: bool) -> Self {
        let design = design(&shipped(name)).unwrap();
        let plan = planned(&design);
        let count = plan.points.len();
        let centre = plan.points.iter().map(|p| p.at).sum::<DVec3>() / count as f64;
        let square = |p: DVec3| (p - centre).length_squared();
        let squares: f64 = plan.points.iter().map(|p| square(p.at)).sum();
        let gyration = (squares / count as f64).sqrt();
        let motion = |k: usize, j: usize| {
            let point = &plan.points[k];
            let lever = (point.at - centre).cross(point.normal) / gyration;
            if j < 3 { point.normal[j] } else { lever[j - 3] }
        };
        let motions = DMatrix::from_fn(count, 6, motion);
        let heights: Vec<Vec<f64>> =
            plan.points.iter().map(|p| terms(&design, round, p.at)).collect();
        let term = |k: usize, j: usize| heights[k][j] * plan.points[k].normal.z;
        let terms = DMatrix::from_fn(count, heights[0].len(), term);
        Self { design, plan, round, motions, terms }
    }

    /// What is told of a form, mm: its terms once the best pose has taken what it can.
    fn beyond_pose(&self, form: &DVector<f64>) -> DVector<f64> {
        let made = &self.terms * form;
        let motions = self.motions.clone().svd(true, true);
        let least = 1e-3 * motions.singular_values.max();
        let moved = motions.solve(&made, least).unwrap();
        let rest = made - &self.motions * moved;
        self.terms.clone().svd(true, true).solve(&rest, 1e-9).unwrap()
    }

    /// The terms found of a part with this form, touched by a ball with noise, in some pose.
    fn found(&self, form: &DVector<f64>, noise_mm: f64, ball_mm: f64, run: u64) -> FormFit {
        let made = &self.terms * form;
        let stream = RandomStream { seed: 11, trial: run };
        let mut draws = Draws::new(run);
        let mut turn = || 0.1 * (2.0 * draws.unit() - 1.0);
        // A turn about the axis of a round mirror is not seen, and turns the form with it.
        let clocking = if self.round { 0.0 } else { turn() };
        let turn = DVec3::new(turn(), turn(), clocking);
        let pose = Pose::about(DVec3::ZERO, turn * 20.0, turn);
        let points: Vec<DVec3> = self
            .plan
            .points
            .iter()
            .enumerate()
            .map(|(k, point)| {
                let off = made[k] + noise_mm * stream.normals(0, k as u32)[0];
                pose.apply(point.at + (off + ball_mm) * point.normal)
            })
            .collect();
        let aligned = align_points(&self.design.mirror, &points, ball_mm).unwrap();
        fit_form(&self.design.mirror, &aligned).unwrap()
    }
}

/// Known forms under known noise: nearly all terms are within three standard uncertainties, and the uncertainties are
/// neither too small nor too large.
#[test]
fn terms_are_as_uncertain_as_is_said() {
    let runs = times(12, 100) as u64;
    const NOISE_MM: f64 = 5e-4;
    for (name, round, ball_mm) in [("conquistador", false, 0.0), ("hyperbolic", true, 1.0)] {
        let touched = Touched::new(name, round);
        let count = touched.terms.ncols();
        let (mut within, mut squares, mut rest) = (0, 0.0, 0.0);
        for run in 0..runs {
            let mut draws = Draws::new(1000 + run);
            let form = DVector::from_fn(count, |_, _| 6e-3 * (draws.unit() - 0.5));
            let wanted = touched.beyond_pose(&form);
            let fit = touched.found(&form, NOISE_MM, ball_mm, run);
            // (Of some twenty thousand points under normal noise one may be called an outlier.)
            let out = fit.used.iter().filter(|used| !**used).count();
            assert!(out <= 1, "{name} {run}: {out}");
            for (term, wanted) in fit.terms.iter().zip(wanted.iter()) {
                let pull = (term.pv_mm - wanted) / term.uncertainty_mm;
                within += usize::from(pull.abs() < 3.0);
                squares += pull * pull;
            }
            rest += fit.rest_mm / NOISE_MM;
        }
        let tried = runs as usize * count;
        // Of a thousand normal numbers three are further off; of some hundred there may be none.
        let most = if tried > 700 { 0.9995 } else { 1.0 };
        let share = within as f64 / tried as f64;
        assert!((0.95..=most).contains(&share), "{name}: {share}");
        let spread = (squares / tried as f64).sqrt();
        assert!((0.88..1.12).contains(&spread), "{name}: {spread}");
        assert!((rest / runs as f64 - 1.0).abs() < 0.03, "{name}: {rest}");
    }
}

/// Without noise the terms are those of the form, to what is second order in it.
#[test]
fn a_form_without_noise_is_found() {
    for (name, round, ball_mm) in [("conquistador", false, 2.0), ("hyperbolic", true, 0.0)] {
        let touched = Touched::new(name, round);
        let form = DVector::from_fn(touched.terms.ncols(), |k, _| 1e-3 * (k as f64 - 3.0));
        let wanted = touched.beyond_pose(&form);
        for (term, wanted) in touched.found(&form, 0.0, ball_mm, 1).terms.iter().zip(wanted.iter())
        {
            assert!((term.pv_mm - wanted).abs() < 3e-6, "{name}: {term:?} {wanted}");
        }
    }
}

/// Centres of a ball on spheres, hollow and domed: on a sphere whose radius is the ball's larger or smaller.
#[test]
fn a_ball_is_compensated_along_the_normal() {
    for radius_mm in [50.0, -50.0_f64] {
        let text = format!(
            "camera.orthographic.pixels = [64, 48]\nmirror.polynomial.radius_mm = {radius_mm}\n\
             part = {{ width_mm = 40, height_mm = 30, base_mm = 5 }}\nmesh.chord_um = 5\n\
             export.formats = [\"stl\"]\n"
        );
        let profile = Profile::parse("ball", "ball.toml", text.as_bytes()).unwrap();
        let design = design(&profile).unwrap();
        let apex =
            design.mirror.position(Default::default(), &design.mirror.at(Default::default()));
        let centre = apex + DVec3::Z * radius_mm;
        let ball_mm = 1.5;
        let points: Vec<DVec3> = planned(&design)
            .points
            .iter()
            .map(|p| {
                let out = (p.at - centre).normalize();
                let reach = radius_mm.abs() - radius_mm.signum() * ball_mm;
                centre + out * reach
            })
            .collect();
        let found = align_points(&design.mirror, &points, ball_mm).unwrap();
        let off = found.residuals.iter().map(|r| r.unwrap().distance.abs()).fold(0.0, f64::max);
        assert!(off < 1e-8, "{radius_mm}: {off:e}");
        // A sphere shows no turn.
        assert_eq!(found.alignment.free.len(), 3);
        let plain = align_points(&design.mirror, &points, 0.0).unwrap();
        assert!(plain.alignment.rms_mm > 1e-3, "{}", plain.alignment.rms_mm);
    }
}

/// The rows of a table of points: X, Y, Z and the normal.
fn rows(path: &Path) -> Vec<[f64; 6]> {
    let text = std::fs::read_to_string(path).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines
        .map(|line| {
            let mut numbers = line.split(',').map(|number| number.parse().unwrap_or(f64::NAN));
            std::array::from_fn(|_| numbers.next().unwrap())
        })
        .collect()
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn a_plan_is_measured_and_judged_in_every_format() {
    let folder = folder();
    let at = folder.path();
    let (code, said, _) = told(&morion(at, &["inspect", "conquistador"]));
    assert!(code == 0 && said.contains("A base, B side towards -Y, C side towards -X"), "{said}");
    let plan = at.join("out/conquistador");
    let report = json(&plan.join("inspection.json"));
    let table = rows(&plan.join("inspection.csv"));
    assert_eq!(report["points"], table.len());
    let zone = report["surface_profile_mm"].as_f64().unwrap();
    dmis(&plan.join("inspection.dmi"), &table, zone);
    // As planned, in every format; made with too much of a form.
    let verdict = |name: &str, options: &[&str]| -> (i32, Value) {
        let arguments =
            [&["verify", name, "--profile", "conquistador", "--align"], options].concat();
        let (code, _, errors) = told(&morion(at, &arguments));
        assert!(code < 2, "{errors}");
        (code, json(&at.join("out/conquistador-verify/report.json")))
    };
    let lines = |off: &dyn Fn(&[f64; 6]) -> f64, mark: &str| -> String {
        let line = |row: &[f64; 6]| {
            let [x, y, z] = [0, 1, 2].map(|k| row[k] + off(row) * row[k + 3]);
            format!("{x}{mark}{y}{mark}{z}\n")
        };
        table.iter().map(line).collect()
    };
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         end_header\n{}",
        table.len(),
        lines(&|_| 0.0, " ")
    );
    for (name, text) in [
        ("points.csv", lines(&|_| 0.0, ";")),
        ("points.xyz", lines(&|_| 0.0, "\t")),
        ("points.ply", ply),
        ("points.txt", format!("x y z\n{}", lines(&|_| 0.0, " "))),
    ] {
        std::fs::write(at.join(name), text).unwrap();
        let (code, report) = verdict(name, &[]);
        assert_eq!((code, &report["verdict"]), (0, &Value::from("pass")), "{name}");
        let form = &report["measured_form"];
        assert_eq!((&form["used"], &form["outside"]), (&table.len().into(), &0.into()), "{name}");
        let errors = form["pixel_error_px"]["rms"].as_f64().unwrap();
        let designed = report["design"]["pixel_error_px"]["rms"].as_f64().unwrap();
        assert!((errors / designed - 1.0).abs() < 0.01, "{name}: {errors} {designed}");
    }
    // Centres of a ball.
    std::fs::write(at.join("ball.csv"), lines(&|_| 1.5, ",")).unwrap();
    let (code, report) = verdict("ball.csv", &["--probe-mm", "1.5"]);
    assert_eq!((code, &report["measured_form"]["probe_mm"]), (0, &1.5.into()));
    assert!(report["form_error_um"]["pv"].as_f64().unwrap() < 0.01, "{report}");
    // Wrong touches on the base and in the air are of no mirror's form: as far as that the sheet's map would show nothing else.
    let base = "1,2,0\n-9,4,0\n12,-7,0\n0,9,90\n";
    std::fs::write(at.join("base.csv"), lines(&|_| 0.0, ",") + base).unwrap();
    let (code, report) = verdict("base.csv", &[]);
    assert_eq!((code, &report["measured_form"]["used"]), (0, &table.len().into()));
    assert_eq!(report["measured_form"]["points"], table.len() + 4);
    assert!(report["form_error_um"]["pv"].as_f64().unwrap() < 0.01, "{}", report["form_error_um"]);
    // Three times the zone of one term: it is found, and the picture does not pass.
    let bent = |row: &[f64; 6]| {
        let u = row[0] / 30.0;
        let four = (35.0 * u * u * u * u - 30.0 * u * u + 3.0) / 8.0 / (10.0 / 7.0);
        3.0 * zone * four * row[5]
    };
    std::fs::write(at.join("bent.csv"), lines(&bent, ",")).unwrap();
    let (code, report) = verdict("bent.csv", &[]);
    assert_eq!(code, 1, "{report}");
    let reasons = report["reasons"].to_string();
    assert!(reasons.contains("bent.csv: ") && reasons.contains("pixel error"), "{reasons}");
    let terms = report["measured_form"]["terms"].as_array().unwrap();
    let sheet = std::fs::read(at.join("out/conquistador-verify/inspection.pdf")).unwrap();
    let holds = |word: &str| sheet.windows(word.len()).any(|found| found == word.as_bytes());
    assert!(
        sheet.starts_with(b"%PDF-") && holds("(FAIL)") && holds("Legendre term of degree 4 in X")
    );
    for term in terms {
        // (Nothing has no sign.)
        let rounded = |key: &str| (1e3 * term[key].as_f64().unwrap()).round() / 1e3 + 0.0;
        let [um, uncertainty] = ["pv_um", "uncertainty_um"].map(rounded);
        assert!(holds(&format!("({um:.3})")) && holds(&format!("({uncertainty:.3})")), "{term}");
    }
    let term = terms.iter().find(|term| term["term"] == "legendre_40_um").unwrap();
    assert!(term["pv_um"].as_f64().unwrap() > 2000.0 * zone, "{term}");
}

/// Every point of the table is a feature of the program, measured and held to half the zone, in short lines.
fn dmis(path: &Path, table: &[[f64; 6]], zone: f64) {
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.lines().all(|line| line.len() <= 80 && line.is_ascii()), "{text}");
    let text = text.replace("$\n", "");
    assert!(text.starts_with("DMISMN/") && text.ends_with("ENDFIL\n"), "{text}");
    assert!(text.contains(&format!("T(MIRROR)=TOL/PROFP,-{0:.5},{0:.5}\n", 0.5 * zone)));
    let numbers = |line: &str| -> Vec<f64> {
        let list = line.split_once("CART,").unwrap().1;
        list.split(',').map(|number| number.trim().parse().unwrap()).collect()
    };
    let lines: Vec<&str> = text.lines().collect();
    let start = lines.iter().position(|line| line.starts_with("F(")).unwrap();
    let features: Vec<&[&str]> = lines[start..lines.len() - 1].chunks(5).collect();
    assert_eq!(features.len(), table.len());
    for (k, (feature, row)) in features.into_iter().zip(table).enumerate() {
        let name = format!("P{:05}", k + 1);
        assert!(feature[0].starts_with(&format!("F({name})=FEAT/POINT,CART,")), "{feature:?}");
        assert_eq!(feature[1], format!("MEAS/POINT,F({name}),1"));
        assert!(feature[2].starts_with("PTMEAS/CART,"));
        assert_eq!([feature[3], feature[4]], ["ENDMES", &format!("OUTPUT/FA({name}),TA(MIRROR)")]);
        assert_eq!(numbers(feature[0]), row);
        assert_eq!(numbers(feature[2]), row);
    }
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let folder = folder();
    let at = folder.path();
    save(at, shipped_text("conquistador"));
    for (name, text) in [
        ("few.csv", "0,5,20\n".repeat(4)),
        ("words.csv", "1,2,3\n4,five,6\n".into()),
        ("none.ply", "ply\nformat ascii 1.0\nend_header\n".into()),
        ("mesh.stl", "solid\n".into()),
    ] {
        std::fs::write(at.join(name), text).unwrap();
    }
    let verify = |name: &'static str, more: &[&'static str]| -> Vec<&'static str> {
        [&["verify", name, "--profile", "conquistador"], more].concat()
    };
    for (arguments, words) in [
        (
            verify("few.csv", &[]),
            "few.csv: a list of points is of a part that was measured; add --align",
        ),
        (verify("few.csv", &["--align"]), "few.csv: "),
        (verify("mesh.stl", &["--align", "--probe-mm", "1"]), "leave --probe-mm out"),
        (verify("few.csv", &["--align", "--probe-mm", "0"]), "--probe-mm"),
        (
            vec!["inspect", "conquistador", "--degree", "0"],
            "--degree must be a whole number from 1 to 40, found 0",
        ),
        (vec!["inspect", "conquistador", "--margin-mm", "inf"], "--margin-mm"),
        (
            vec!["inspect", "conquistador", "--margin-mm", "40"],
            "--margin-mm must be less than half",
        ),
    ] {
        refused(at, &arguments, &[words]);
    }
    // A list that cannot be read is a negative verdict, with its line.
    for (name, words) in
        [("words.csv", "line 2: Y must be a finite number"), ("none.ply", "not a readable PLY")]
    {
        let (code, said, _) = told(&morion(at, &verify(name, &["--align"])));
        assert!(code == 1 && said.contains(words), "{said}");
    }
}
