//! Bounds are true and tight: no place of any facet, however it is looked for, is over the facet's
//! own bound or the face's, and the face's is within a tenth of the worst place found.

use crate::support::random::errors::Seen;
use crate::support::random::{Case, Kind, QUICK, SLOW, case, each};
use crate::support::{designed, limits, meshed, share, shipped, times};
use morion::internals::geom::Precision;
use morion::internals::mesh::{Face, Limits, mesh};
use morion::internals::profile::{MeshGoal, Shipped};

/// A face's bound over the largest error of it that is found, at most.
const LOOSE: f64 = 1.10;
/// Errors that are nothing, as a share of the mirror's size.
const NOTHING: f64 = 1e-10;

/// Bounds over errors found; 1 where there is nothing to find.
fn over(face: &Face, found: [f64; 2], seen: Seen) -> [f64; 2] {
    let least = NOTHING * seen.mirror.outline.bounds().size().max_element();
    let share = |bound: f64, found: f64| if bound <= least { 1.0 } else { bound / found };
    let facet = if seen.view.is_some() { share(face.bound.facet_mm, found[1]) } else { 1.0 };
    [share(face.bound.chord_mm, found[0]), facet]
}

/// Holds the face of `seen` to its bounds.
fn hold(what: &str, seen: Seen, face: &Face, limits: &Limits, n: u32, climb: bool) -> [f64; 2] {
    assert!(limits.hold(&face.bound), "{what}: {:?} over {limits:?}", face.bound);
    let found = seen.hold(face, limits.precision, true, n, climb);
    let found = found.unwrap_or_else(|wrong| panic!("{what}: {wrong}"));
    let over = over(face, found, seen);
    assert!(over.iter().all(|&over| over <= LOOSE), "{what}: bounds over errors {over:?}");
    over
}

#[test]
#[ignore = "long: .ci/nightly"]
fn bounds_of_shipped_profiles_are_true_and_tight() {
    let profiles = morion::internals::profile::shipped().iter().enumerate();
    for (k, Shipped { name, .. }) in share(6, 0, profiles) {
        let coarser = [(10.0, 10.0), (100.0, 100.0), (100.0, 12.0)];
        for (times_chord, times_facet) in share(3, k, coarser) {
            let mut profile = shipped(name);
            let goal = profile.mesh;
            let facet_px = goal.max_triangles().map_or(goal.facet_px(), |_| Some(1.0));
            profile.mesh = MeshGoal::limits(
                goal.chord_um().map(|um| um * times_chord),
                facet_px.map(|px| px * times_facet),
            );
            let design = designed(&profile);
            for precision in [Precision::Single, Precision::Double] {
                if precision == Precision::Double && times_facet < 100.0 {
                    continue;
                }
                let limits = Limits { precision, ..limits(&profile, &design) };
                let (mirror, camera) = (&design.mirror, &design.camera.chart);
                let view = design.view.as_ref();
                let what = format!("{name} x {times_chord} x {times_facet} {precision:?}");
                let face = mesh(mirror, camera, view, limits)
                    .unwrap_or_else(|error| panic!("{what}: {error}"));
                let climb = face.designed < 1500;
                let seen = Seen { mirror, camera, view };
                let over = hold(&what, seen, &face, &limits, 4, climb);
                println!("{what}: {} facets, {over:.3?}", face.mesh.triangles.len());
            }
        }
    }
}

#[test]
fn the_conquistador_keeps_its_bounds_on_every_facet() {
    let profile = shipped("conquistador");
    let design = designed(&profile);
    let face = meshed(&profile, &design).unwrap();
    let seen =
        Seen { mirror: &design.mirror, camera: &design.camera.chart, view: design.view.as_ref() };
    let over = hold("conquistador", seen, &face, &limits(&profile, &design), 2, false);
    println!("{} facets, {over:.3?}", face.mesh.triangles.len());
}

/// Random mirrors of `kinds`, `count` of each, held to their bounds.
fn hold_random(kinds: &[Kind], count: u64) {
    let all: Vec<(Kind, u64)> =
        kinds.iter().flat_map(|&kind| (0..count).map(move |seed| (kind, seed))).collect();
    let one = |&(kind, seed): &(Kind, u64)| {
        let what = format!("{kind:?} {seed}");
        let case: Case = case(kind, seed, [20.0, 800.0]);
        match case.mesh() {
            Ok(face) => {
                let limits = &case.limits;
                let climb = face.designed < 1500;
                // Errors of one facet may have many tops.
                let n = if face.designed < 600 { 9 } else { 4 };
                let over = hold(&what, case.seen(), &face, limits, n, climb);
                println!("{what}: {} facets {over:.3?}", face.mesh.triangles.len());
                Some(over)
            }
            Err(error) => {
                println!("{what}: {error}");
                None
            }
        }
    };
    let found = each(&all, one);
    let refused = found.iter().filter(|over| over.is_none()).count();
    assert!(refused <= 1 + all.len() / 50, "{refused} of {} have no mesh", all.len());
}

#[test]
#[ignore = "long: .ci/nightly"]
fn bounds_of_random_mirrors_are_true_and_tight() {
    hold_random(&QUICK, times(6, 40) as u64);
}

#[test]
#[ignore = "long: .ci/nightly"]
fn bounds_under_pinholes_and_near_targets_are_true_and_tight() {
    hold_random(&SLOW, times(2, 14) as u64);
}
