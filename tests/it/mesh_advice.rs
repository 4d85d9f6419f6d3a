//! What refusals and warnings of meshes and files advise: numbers that can be written into a profile.

use crate::random_profiles::wanted::{self, Wanted};
use crate::support::builds::folder;
use crate::support::random::each;
use crate::support::times;
use morion::internals::pipeline::{Silent, build, dry_run};
use morion::internals::profile::Profile;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// From limits that nothing keeps to limits that everything does, and budgets likewise.
const LIMITS: [&str; 10] = [
    "facet_px = 1e-6",
    "facet_px = 0.01",
    "facet_px = 2",
    "facet_px = 1e3",
    "chord_um = 1e-6",
    "chord_um = 1e5",
    "chord_um = 1e-3\nfacet_px = 1e3",
    "max_triangles = 9",
    "max_triangles = 900",
    "max_triangles = 2000000000",
];
/// Meshes of more triangles are foreseen and not made.
const MOST: usize = 5_000;

/// The profile with other limits.
fn with_limits(text: &str, limits: &str) -> String {
    let first = text.find("[mesh]\n").expect("a table of limits") + "[mesh]\n".len();
    let end = text[first..].find("\n[").expect("another table") + first;
    format!("{}{limits}{}", &text[..first], &text[end..])
}

/// The first value in what is said that is no number to write: infinite, none, zero or negative.
fn no_value(said: &str) -> Option<&str> {
    let values = ["facet_px = ", "chord_um = ", "max_triangles = ", "width_mm = ", "base_mm = "]
        .into_iter()
        .flat_map(|key| said.split(key).skip(1))
        .map(|rest| rest.split([' ', ',', ';', '\n', '"']).next().unwrap_or(rest));
    let is_none = |value: &&str| {
        !value.trim_end_matches('.').parse::<f64>().is_ok_and(|x| x.is_finite() && x > 0.0)
    };
    let odd = |word: &&str| ["inf", "NaN", "nan", "-inf"].contains(word);
    let words = said.split(|c: char| c.is_whitespace() || ",;()".contains(c));
    values.filter(is_none).chain(words.filter(odd)).next()
}

#[test]
fn values_are_told_from_words() {
    assert_eq!(no_value("write facet_px = 1.5, or more"), None);
    assert_eq!(no_value("write facet_px = inf, or more"), Some("inf"));
    assert_eq!(no_value("write max_triangles = 0."), Some("0."));
    assert_eq!(no_value("a bound of NaN (chord)"), Some("NaN"));
}

#[test]
#[ignore = "long: .ci/nightly"]
fn no_advice_of_a_mesh_is_without_a_number() {
    let streams: Vec<u64> = (0..times(2, 100) as u64).collect();
    let said = each(&streams, |&stream| {
        let mut seed = [7; 32];
        seed[..8].copy_from_slice(&stream.to_le_bytes());
        let random = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
        let mut runner = TestRunner::new_with_rng(Config::default(), random);
        let mut said = Vec::new();
        for _ in 0..times(2, 4) {
            let tree = wanted::strategy().new_tree(&mut runner).expect("numbers");
            let Wanted { text, heights, .. } = tree.current();
            let texts = LIMITS.iter().map(|limits| with_limits(&text, limits));
            for text in texts.filter(|_| heights.is_none()) {
                let Ok(profile) = Profile::parse("p", "p.toml", text.as_bytes()) else { continue };
                let source = profile;
                let triangles = match dry_run(&source, &Silent) {
                    Err(error) => {
                        said.push((error.to_string(), text.clone()));
                        usize::MAX
                    }
                    Ok(prospect) => {
                        let warnings = prospect.warnings.into_iter();
                        said.extend(warnings.map(|warning| (warning, text.clone())));
                        prospect.mesh.map_or(usize::MAX, |mesh| mesh.triangles)
                    }
                };
                if triangles < MOST {
                    let folder = folder();
                    match build(&source, folder.path(), &Silent) {
                        Err(error) => said.push((error.to_string(), text.clone())),
                        Ok(report) => {
                            let all = report.warnings.into_iter();
                            let reasons = report.reasons.iter().map(|reason| reason.to_string());
                            said.extend(all.chain(reasons).map(|said| (said, text.clone())));
                        }
                    }
                }
            }
        }
        said
    });
    let said: Vec<_> = said.into_iter().flatten().collect();
    for (said, text) in &said {
        assert_eq!(no_value(said), None, "{said}\n{text}");
    }
    println!("{} refusals, reasons and warnings", said.len());
    assert!(said.len() > times(20, 1000), "{}", said.len());
}
