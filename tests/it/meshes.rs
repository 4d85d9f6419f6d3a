//! Random mirrors of every kind: each has a sound mesh within its limits, or is
//! refused for a reason.

use crate::support::random::{Case, Kind, QUICK, SLOW, case, each};
use crate::support::times;
use morion::internals::mesh::MeshError;
use std::collections::BTreeMap;

/// How a case went.
#[derive(Debug)]
enum Outcome {
    Sound(usize),
    Refused(&'static str),
    Wrong(String),
}

fn outcome(case: &Case) -> Outcome {
    let face = match case.mesh() {
        Ok(face) => face,
        Err(MeshError::TooMany { .. }) => return Outcome::Refused("too many facets"),
        Err(MeshError::NotRefinable { .. } | MeshError::PrecisionLimit { .. }) => {
            return Outcome::Refused("limits under what digits allow");
        }
        Err(MeshError::OnAxis { .. } | MeshError::SizeContrast { .. }) => {
            return Outcome::Refused("a look along the axis");
        }
        Err(
            error @ (MeshError::PointRejected { .. }
            | MeshError::BudgetTooSmall { .. }
            | MeshError::Wall(_)),
        ) => {
            return Outcome::Wrong(error.to_string());
        }
    };
    if !case.limits.hold(&face.bound) {
        return Outcome::Wrong(format!("{:?} over {:?}", face.bound, case.limits));
    }
    let n = if face.designed < 100 { 3 } else { 2 };
    let held = case.seen().hold(&face, case.limits.precision, false, n, false);
    match case.hold_shape(&face).and(held) {
        Ok(_) => Outcome::Sound(face.mesh.triangles.len()),
        Err(wrong) => Outcome::Wrong(wrong),
    }
}

/// The `cases`: all that go wrong, and the numbers of what is refused.
fn all(cases: &[(Kind, u64)]) {
    let go = |&(kind, seed): &(Kind, u64)| (kind, seed, outcome(&case(kind, seed, FACETS)));
    let (mut made, mut refused, mut wrong) = (0, BTreeMap::new(), Vec::new());
    for (kind, seed, outcome) in each(cases, go) {
        match outcome {
            Outcome::Sound(facets) => made += facets,
            Outcome::Refused(why) => {
                println!("{kind:?} {seed}: {why}");
                *refused.entry((format!("{kind:?}"), why)).or_insert(0) += 1;
            }
            Outcome::Wrong(what) => wrong.push(format!("{kind:?} {seed}: {what}")),
        }
    }
    println!("{} mirrors, {made} facets, refused {refused:?}", cases.len());
    assert!(wrong.is_empty(), "{} are wrong:\n{}", wrong.len(), wrong.join("\n"));
    let count: usize = refused.values().sum();
    assert!(count * 200 <= cases.len(), "{count} of {} are refused: {refused:?}", cases.len());
}

/// Facets that limits ask for, about.
const FACETS: [f64; 2] = [10.0, 200.0];

fn numbered(kind: Kind, count: u64) -> impl Iterator<Item = (Kind, u64)> {
    (1000..1000 + count).map(move |seed| (kind, seed))
}

/// About `count` cases of every kind.
fn some(count: u64) -> Vec<(Kind, u64)> {
    // Round rims alone are some hundred facets, and pinholes take long to prepare.
    let quick = QUICK.into_iter().flat_map(|kind| {
        let is_round = matches!(kind, Kind::Round | Kind::Sum);
        numbered(kind, if is_round { count / 3 } else { count })
    });
    quick.chain(SLOW.into_iter().flat_map(|kind| numbered(kind, count / 40))).collect()
}

#[test]
#[ignore = "long: .ci/nightly"]
fn random_meshes_are_sound() {
    all(&some(times(12, 160) as u64));
}

/// Of the ten thousand only every four hundredth, but for a thorough run.
#[test]
fn ten_thousand_random_meshes_are_sound() {
    let cases = some(1300);
    assert!(cases.len() >= 10_000, "{}", cases.len());
    let share: Vec<(Kind, u64)> = cases.into_iter().step_by(times(400, 1)).collect();
    all(&share);
}

/// Mirrors that were hard to mesh, each with its kind, its number, the facets asked for and whether
/// it has a mesh at all. (A change of what a number stands for changes these cases.)
const CORPUS: [(&str, Kind, u64, [f64; 2], bool); 7] = [
    ("a ring's waves ask for many facets", Kind::Round, 1012, FACETS, true),
    ("a ring, bounds far over the errors of its few facets", Kind::Round, 1750, FACETS, true),
    ("a wavy disc", Kind::Sum, 1038, FACETS, true),
    ("a disc of which no quick bound is near", Kind::Sum, 1001, FACETS, true),
    ("splits of one place, round after round", Kind::Plain, 1004, FACETS, true),
    ("bent fifty times as much one way", Kind::Anisotropic, 15, [20.0, 800.0], true),
    ("a mirror that looks along the axis of its cylinder", Kind::Near, 5, [20.0, 800.0], false),
];

#[test]
fn hard_mirrors_are_meshed_or_refused() {
    for (name, kind, seed, facets, is_sound) in CORPUS {
        match outcome(&case(kind, seed, facets)) {
            Outcome::Sound(_) => {}
            Outcome::Refused(_) if !is_sound => {}
            other => panic!("{name} ({kind:?} {seed}): {other:?}"),
        }
    }
}
