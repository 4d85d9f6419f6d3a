//! Refusals of the design: each names what is the matter, and what it advises works.

use crate::random_profiles::wanted::{self, Wanted};
use crate::support::random::each;
use crate::support::times;
use morion::internals::design::{DesignError, FailureCause, FitStage, LocalFailure, design};
use morion::internals::num::{radians, tan};
use morion::internals::profile::{Profile, SagGrid};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Profiles that are made by one stream of random numbers.
const STREAM: usize = 10;
/// Steps that a direction is followed for, each of twice the change.
const STEPS: u32 = 12;

/// A profile's text, and the heights that it names.
#[derive(Debug, Clone)]
struct Asked {
    text: String,
    heights: Option<String>,
}

impl Asked {
    /// The design's refusal; none where there is a design. Where the text is no profile any more,
    /// for what lies around the mirror, that is another matter.
    fn refused(&self) -> Result<Option<DesignError>, String> {
        let mut profile = match Profile::parse("p", "p.toml", self.text.as_bytes()) {
            Ok(profile) => profile,
            Err(complaints) => {
                let said = complaints.to_string();
                let around = said.matches("p.toml:").count() == said.matches(" part.").count();
                return if around { Ok(None) } else { Err(said) };
            }
        };
        let parsed = |text: &String| SagGrid::parse(text.as_bytes()).unwrap();
        profile.heights = self.heights.as_ref().map(parsed);
        Ok(design(&profile).err())
    }
}

/// Where the value of `key` is.
fn value_of(text: &str, key: &str) -> std::ops::Range<usize> {
    let sought = format!("{key} = ");
    let word = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    let named = |at: &usize| !text[..*at].ends_with(word);
    let at = text.match_indices(&sought).map(|(at, _)| at).find(named);
    let first = at.unwrap_or_else(|| panic!("no {key} in {text}")) + sought.len();
    let mut depth = 0;
    let end = text[first..].find(|c: char| {
        depth += i32::from(c == '[') - i32::from(c == ']');
        depth == 0 && ",}\n".contains(c)
    });
    let value = text[first..first + end.expect("an end")].trim_end();
    first..first + value.len()
}

fn set(text: &str, key: &str, value: &str) -> String {
    let mut text = text.to_owned();
    text.replace_range(value_of(&text, key), value);
    text
}

fn without(text: &str, key: &str) -> String {
    // A target in any pose is a table of its own.
    if key == "target" {
        return text.split_inclusive('\n').filter(|line| !line.starts_with("target.")).collect();
    }
    let value = value_of(text, key);
    let first = value.start - key.len() - " = ".len();
    let (before, after) = (&text[..first], &text[value.end..]);
    let (before, after) = match before.strip_suffix(", ") {
        Some(before) => (before, after),
        None => (before, after.strip_prefix(", ").unwrap_or(after)),
    };
    format!("{before}{after}")
}

/// The text with another table in this section, as `method.vector-field`.
fn take(text: &str, section: &str, name: &str) -> String {
    let first = text.find(&format!("{section}.")).expect("the section") + section.len() + 1;
    let length = text[first..].find(" = ").expect("a table");
    format!("{}{name}{}", &text[..first], &text[first + length..])
}

fn number(text: &str, key: &str) -> f64 {
    text[value_of(text, key)].parse().expect("a number")
}

/// What becomes of a profile that does as it is told; a direction is followed for `step` steps.
fn follow(asked: &Asked, advice: &str, step: u32) -> Asked {
    let Asked { text, heights } = asked;
    let far = f64::from(1u32 << step);
    let text = if let Some(key) = advice.strip_prefix("leave ").and_then(|a| a.strip_suffix(" out"))
    {
        without(text, key)
    } else if let Some((key, value)) = advice.strip_prefix("set ").and_then(|a| a.split_once(" = "))
    {
        set(text, key, value)
    } else if let Some((spot, to)) =
        advice.strip_prefix("move the ").and_then(|a| a.split_once(", to "))
    {
        let key = if spot.starts_with("hole") { "holes_mm" } else { "marks_mm" };
        set(text, key, &format!("[{to}]"))
    } else if advice == "take a larger radius_mm" {
        set(text, "radius_mm", &(far * number(text, "radius_mm")).to_string())
    } else if advice == "a conic closer to -1" {
        set(text, "conic", &((number(text, "conic") + 1.0) / far - 1.0).to_string())
    } else if advice == "give mirror.grid.file heights over all of it" {
        let wider = |line: &str| {
            let xyz: Vec<f64> = line.split(',').map(|x| x.parse().expect("a number")).collect();
            format!("{},{},{}\n", far * xyz[0], far * xyz[1], xyz[2])
        };
        let heights = heights.as_ref().map(|heights| heights.lines().map(wider).collect());
        return Asked { text: text.clone(), heights };
    } else if let Some((section, name)) =
        advice.strip_prefix("take ").and_then(|a| a.split_once('.'))
    {
        take(text, section, name)
    } else {
        panic!("advice that cannot be followed: {advice:?}");
    };
    Asked { text, heights: heights.clone() }
}

/// Whether a profile that was refused for `error` is still refused for that.
fn still(error: &DesignError, now: &DesignError) -> bool {
    match (error, now) {
        (DesignError::Border { message, .. }, DesignError::Border { message: now, .. }) => {
            message.split_whitespace().next() == now.split_whitespace().next()
        }
        _ => std::mem::discriminant(error) == std::mem::discriminant(now),
    }
}

/// Follows each alternative that the refusal offers, and returns how many there are.
///
/// # Errors
/// What was followed in vain.
fn followed(asked: &Asked, error: &DesignError) -> Result<usize, String> {
    let said = error.to_string();
    let advice = said.rsplit("; ").next().expect("a part");
    let apart = if advice.contains(", or ") { ", or " } else { " or " };
    for alternative in advice.split(apart) {
        let mut vain = None;
        let helps = (1..=STEPS).any(|step| {
            let changes = alternative.split(" and ");
            let changed = changes.fold(asked.clone(), |asked, one| follow(&asked, one, step));
            match changed.refused() {
                Ok(None) => true,
                Ok(Some(now)) if !still(error, &now) => true,
                other => {
                    vain = Some(format!("{other:?} of {}", changed.text));
                    false
                }
            }
        });
        if !helps {
            return Err(format!("{said}\n{}\nin vain: {alternative}: {vain:?}", asked.text));
        }
    }
    Ok(advice.split(apart).count())
}

#[test]
#[ignore = "long: .ci/nightly"]
fn every_advice_of_a_refusal_works() {
    let streams: Vec<u64> = (0..times(6, 240) as u64).collect();
    let found = each(&streams, |&stream| {
        let mut seed = [0; 32];
        seed[..8].copy_from_slice(&stream.to_le_bytes());
        let random = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
        let mut runner = TestRunner::new_with_rng(Config::default(), random);
        let (mut made, mut found) = (0, Vec::new());
        while made < STREAM {
            let tree = wanted::strategy().new_tree(&mut runner).expect("numbers");
            let Wanted { text, heights, .. } = tree.current();
            if Profile::parse("p", "p.toml", text.as_bytes()).is_err() {
                continue;
            }
            made += 1;
            let asked = Asked { text, heights };
            let Some(error) = asked.refused().expect("a profile") else { continue };
            found.push(followed(&asked, &error));
        }
        found
    });
    let found: Vec<_> = found.into_iter().flatten().collect();
    let vain: Vec<&String> = found.iter().filter_map(|found| found.as_ref().err()).collect();
    let offered: usize = found.iter().flatten().sum();
    println!("{} refusals with {offered} alternatives, {} in vain", found.len(), vain.len());
    assert!(vain.is_empty(), "{vain:#?}");
    assert!(found.len() >= times(5, 300), "{} refusals", found.len());
}

/// The refusal of a profile with this camera, this picture and this method.
#[track_caller]
fn refusal(camera: &str, picture: &str, method: &str, width_mm: f64) -> DesignError {
    let text = format!(
        "camera.{camera}\n{picture}\n{method}\npart = {{ width_mm = {width_mm}, base_mm = 1 }}\n\
         mesh.chord_um = 5\nexport.formats = [\"stl\"]\n"
    );
    let asked = Asked { text, heights: None };
    let refused = asked.refused().expect("a profile");
    let error = refused.unwrap_or_else(|| panic!("no refusal of {}", asked.text));
    followed(&asked, &error).unwrap_or_else(|vain| panic!("{vain}"));
    error
}

/// Its cause.
#[track_caller]
fn cause(camera: &str, picture: &str, method: &str, width_mm: f64) -> FailureCause {
    match refusal(camera, picture, method, width_mm) {
        DesignError::Unsolved { cause, .. } => cause,
        error => panic!("{error}"),
    }
}

const FIELD: &str = "method.vector-field = { degree = 8 }";

/// Ten times as far, the horizon is where it was.
#[test]
fn a_filled_frame_past_the_horizon_is_named() {
    for far in [308.1, 3081.0] {
        let picture = format!(
            "projection.cylindrical = {{ azimuth_deg = [-180, 180], elevation_deg = [2, 20], \
             target_plane_mm = {far} }}\nlayout.strip = {{ fill_frame = true }}"
        );
        let found = cause("orthographic = { pixels = [7, 9] }", &picture, FIELD, 15.0);
        // Rows to a unit of the law are pixels across over a turn.
        let low = tan(radians(2.0)) + tan(radians(20.0));
        let exact = 4.5 - 0.5 * low * 7.0 / std::f64::consts::TAU;
        assert!(
            matches!(found, FailureCause::BeyondHorizon { rows } if (rows - exact).abs() < 1e-9),
            "{found}"
        );
    }
}

/// Whether a cause is the one that was expected.
type Told = fn(&FailureCause) -> bool;

/// Asserts of each camera, picture, method and width that the cause is the one it is.
#[track_caller]
fn told(cases: &[(&str, String, &str, f64, Told)]) {
    for (camera, picture, method, width_mm, told) in cases {
        let found = cause(camera, picture, method, *width_mm);
        assert!(told(&found), "{found}");
    }
}

/// These once were refused for "no convergence in 0 steps" or an error that "is not finite".
#[test]
fn directions_that_nothing_shows_are_named() {
    let parallel = "orthographic = { pixels = [13, 21] }";
    let turn = "azimuth_deg = [-180, 180]";
    let cases: [(&str, String, &str, f64, Told); 4] = [
        (
            "pinhole = { pixels = [6, 12], focal_px = 15.28, distance_mm = 19.81 }",
            "projection.conical = { outer_polar_deg = 90.78, target_plane_mm = -34.8 }\n\
             layout.annulus.inner_width_mm = 11.86"
                .into(),
            FIELD,
            17.64,
            |cause| {
                matches!(
                    cause,
                    FailureCause::At { failure: LocalFailure::WantedMissesPlane { .. }, .. }
                )
            },
        ),
        (
            parallel,
            format!(
                "projection.table = {{ {turn}, elevation_deg = [[8.225, -2], [8.6054, -2.856], \
                 [11.3524, -3.711]], target_plane_mm = -647 }}\nlayout.strip = {{}}"
            ),
            "method.fixed-surface = { degree = 5 }",
            40.0,
            |cause| {
                matches!(
                    cause,
                    FailureCause::At { failure: LocalFailure::SeenMissesPlane { .. }, .. }
                )
            },
        ),
        (
            parallel,
            format!(
                "projection.cylindrical = {{ {turn}, elevation_deg = [-8.767, 27.51] }}\n\
                 layout.strip = {{}}"
            ),
            "mirror.polynomial = { radius_mm = 5.496, conic = 0.6079 }",
            3.199,
            |cause| {
                matches!(cause, FailureCause::At { failure: LocalFailure::NotInImage { .. }, .. })
            },
        ),
        (
            "orthographic = { pixels = [24, 10] }",
            format!(
                "projection.equirectangular = {{ {turn}, elevation_deg = [-2.38, 2.236] }}\n\
                 layout.strip = {{}}"
            ),
            "method.fixed-surface = { degree = 1, minimax = true }",
            79.92,
            |cause| matches!(cause, FailureCause::At { failure: LocalFailure::NoAzimuth, .. }),
        ),
    ];
    told(&cases);
}

#[test]
fn mirrors_that_leave_their_target_or_hide_their_rim_are_named() {
    let parallel = "orthographic = { pixels = [13, 21] }";
    let turn = "azimuth_deg = [-180, 180]";
    let cases: [(&str, String, &str, f64, Told); 3] = [
        (
            parallel,
            format!(
                "projection.cylindrical = {{ {turn}, elevation_deg = [-14.65, 9.212], \
                 target_radius_mm = 12 }}\nlayout.strip = {{ fill_frame = true }}"
            ),
            FIELD,
            20.0,
            |cause| {
                matches!(
                    cause,
                    FailureCause::At { failure: LocalFailure::OutsideCylinder { .. }, .. }
                )
            },
        ),
        (
            parallel,
            "projection.equiangular = { outer_polar_deg = 60, target_plane_mm = 0.5 }\n\
             layout.disc = {}"
                .into(),
            "mirror.polynomial = { radius_mm = -6, conic = -1 }",
            10.0,
            |cause| {
                matches!(cause, FailureCause::At { failure: LocalFailure::PastPlane { .. }, .. })
            },
        ),
        (
            "pinhole = { pixels = [15, 3], focal_px = 10.46, distance_mm = 6.967 }",
            "projection.equiangular = { inner_polar_deg = 95.91, outer_polar_deg = 144.9, \
             target_radius_mm = 111.9 }\nlayout.annulus.inner_width_mm = 3.929"
                .into(),
            "method.distribution = { degree = 8, minimax = false }",
            7.32,
            |cause| matches!(cause, FailureCause::OccludedRim { .. }),
        ),
    ];
    told(&cases);
}

#[test]
fn a_method_that_does_not_converge_gives_way_to_the_vector_field() {
    let picture = "projection.mercator = { azimuth_deg = [-180, 180], elevation_deg = [-3.128, 4.624] }\n\
                   layout.strip = { fill_frame = true }";
    let camera = "orthographic = { pixels = [8, 20] }";
    let found = cause(camera, picture, "method.fixed-surface = { degree = 6 }", 85.34);
    assert!(
        matches!(found, FailureCause::Fit { stage: FitStage::Method, degree: 6, .. }),
        "{found}"
    );
}

#[test]
fn a_mirror_that_turns_its_back_says_where() {
    let picture = "projection.mercator = { azimuth_deg = [-180, 180], elevation_deg = [-23.15, -4.472], \
                   target_radius_mm = 1.2 }\nlayout.conquistador = { panel = \"section\", ridge = \
                   \"valley\", fill_frame = false }";
    let camera = "pinhole = { pixels = [2, 16], hfov_deg = 88.8, distance_mm = 2.2 }";
    let found =
        cause(camera, picture, "method.distribution = { degree = 9, minimax = false }", 2.375);
    assert!(matches!(found, FailureCause::BackFacing { .. }), "{found}");
}

/// Those of a thousand random profiles whose refusal took longest: what is found out about them is
/// counted in designs.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_refusal_takes_few_designs() {
    let table = "azimuth_deg = [-39.23, 39.23], elevation_deg = [[1.423, 29.55], [16.453, 28.43], \
                 [33.883, 27.31]]";
    let ring = "inner_polar_deg = 66.06, outer_polar_deg = 137.3, target_radius_mm = 52.1";
    for (camera, picture, method, width_mm, most) in [
        (
            "pinhole = { pixels = [1, 3], hfov_deg = 45.4, distance_mm = 78.13 }",
            format!("projection.table = {{ {table} }}\nlayout.strip = {{}}"),
            "method.vector-field = { degree = 8, minimax = true }",
            40.4,
            16,
        ),
        (
            "orthographic = { pixels = [13, 24] }",
            "projection.best = { azimuth_deg = [-1.6745, 1.6745], elevation_deg = [-13.45, 54.97], \
             target_radius_mm = 4.688 }\nlayout.strip = {}"
                .into(),
            "method.vector-field = { degree = 5 }",
            5.008,
            8,
        ),
        (
            "pinhole = { pixels = [20, 23], focal_px = 317.9, distance_mm = 589.9 }",
            format!(
                "projection.area-proportional = {{ {ring} }}\nlayout.annulus.inner_width_mm = 25.44"
            ),
            "mirror.polynomial = { radius_mm = -179.6, conic = -1.392, terms = [[0, 3, 1.319e-6]] }",
            74.63,
            8,
        ),
    ] {
        let error = refusal(camera, &picture, method, width_mm);
        let DesignError::Unsolved { remedy, .. } = &error else { panic!("{error}") };
        assert!(!remedy.alternatives.is_empty(), "{error}");
        assert!((1..=most).contains(&remedy.trials), "{}: {error}", remedy.trials);
    }
}
