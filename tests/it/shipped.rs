//! Every shipped profile builds, and passes.

use crate::support::shipped_builds;
use morion::internals::profile::shipped;
use morion::internals::results::Verdict;

/// What a shipped mirror's report must say, beside the verdict.
fn passes(name: &str) {
    let report = shipped_builds::report(name);
    assert_eq!(report.verdict, Verdict::Pass, "{name}: {:?}", report.reasons);
    let (mesh, solid) = (report.mesh.unwrap(), report.solid.unwrap());
    println!("{name}: {} triangles, over the optimum {:?}", mesh.triangles, mesh.over_optimum);
    // A cone bends in one direction alone, where the theory has no bound; a budget is no limit to be the
    // optimum of.
    let over = mesh.over_optimum.facet;
    assert_eq!(over.is_none(), name == "conical" || mesh.max_triangles.is_some());
    assert!(over.is_none_or(|over| over >= 1.0), "{name}: {over:?} of the least");
    assert_eq!((solid.check.euler, solid.check.components), (2, 1), "{name}");
    for trace in &report.trace {
        assert_eq!((trace.hit, trace.missed, trace.shadowed), (trace.rays, 0, 0), "{name}");
        let errors = trace.errors.facet_error_px.unwrap();
        if trace.file == "mirror.step" {
            assert!(errors.max < 0.02, "{name}: {errors:?}");
            continue;
        }
        // A limit is used up; a budget's bound is its strictest facet's.
        let least = if mesh.max_triangles.is_none() { 0.8 } else { 0.5 };
        let used = errors.max / mesh.facet_px.bound;
        assert!(used <= 1.0 && used > least, "{name}: {errors:?}");
    }
    // A mirror that exists has no error of its own, and its problem no curl.
    let laws = [
        "panoramic",
        "conquistador",
        "webcam",
        "machine-vision",
        "pi-hq",
        "side-view",
        "driver",
        "calibrated",
        "dome",
        "four-views",
    ];
    let exact = !laws.contains(&name);
    let (pixel, curl) = (report.design.pixel_error_px.unwrap(), report.design.curl.unwrap());
    // What a polynomial of degree 40 leaves of a law that bends at the entries of its table.
    let bends = name == "soccer";
    assert_eq!(exact && !bends, pixel.max < 1e-6, "{name}: {pixel:?}");
    assert!(!bends || pixel.max < 0.05, "{name}: {pixel:?}");
    assert_eq!(exact, curl.max < 1e-12, "{name}: {curl:?}");
}

#[test]
fn every_shipped_profile_passes() {
    for profile in shipped() {
        passes(profile.name);
    }
}
