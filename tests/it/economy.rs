//! How many triangles a tolerance costs, over the fewest that could do.

use crate::support::surfaces::{ENOUGH, FORMULAS, Formula, HALF_MM, listed};
use morion::internals::geom::{DVec2, Precision};
use morion::internals::mesh::{Limits, mesh};

/// The sheets are their formulas, so that the peers of the benchmark mesh the same surfaces.
#[test]
fn sheets_follow_their_formulas() {
    for formula in FORMULAS {
        let mirror = formula.mirror();
        let mut worst: f64 = 0.0;
        for k in 0..301 * 301 {
            let [x, y] = [k / 301, k % 301].map(|k| HALF_MM * (f64::from(k) / 150.0 - 1.0));
            let at = |x, y| mirror.surface.at(DVec2::new(x, y)).f;
            worst = worst.max((at(x, y) - (formula.z)(x, y)).abs());
            assert!(!formula.even[0] || at(x, y) == at(-x, y), "{}", formula.name);
            assert!(!formula.even[1] || at(x, y) == at(x, -y), "{}", formula.name);
        }
        println!("{}: {worst:.1e} mm", formula.name);
        assert!(worst < 1e-9, "{}: {worst:e} mm", formula.name);
    }
}

/// Sizes of facets grow by steps, but a place that hardly bends is not meshed for its size.
#[test]
fn flat_places_get_few_triangles() {
    let formula = Formula {
        name: "flat middle",
        z: |x, y| {
            let share = (x * x + y * y) / (HALF_MM * HALF_MM);
            2.0 * share * share * share * share
        },
        degree: [8, 8],
        even: [true, true],
        most: f64::INFINITY,
    };
    let mirror = formula.mirror();
    let limits = Limits { chord_mm: Some(1e-3), facet_mm: None, precision: Precision::Single };
    let face = mesh(&mirror, &mirror.chart, None, limits).unwrap();
    let middle = |t: &usize| {
        let [a, b, c] = face.mesh.corners(*t);
        ((a + b + c) / 3.0).truncate().abs().max_element() < 0.3 * HALF_MM
    };
    let all = face.mesh.triangles.len();
    let flat = (0..all).filter(middle).count();
    println!("{flat} of {all} facets on 9 % of the area");
    assert!(limits.hold(&face.bound) && all > 10_000);
    assert!(flat * 300 < all, "{flat} of {all}");
}

/// With at least a hundred thousand triangles, at the usual limits or finer ones.
#[test]
#[ignore = "long: .ci/nightly"]
fn few_triangles_over_the_fewest() {
    let mut failures = Vec::new();
    for listed in listed() {
        let Some(most) = listed.most else { continue };
        let case = listed.case();
        let name = format!("{}, {}", case.name, case.rule.name());
        let (limit, face) = case.enough().unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(
            case.limits(limit, Precision::Single).hold(&face.bound),
            "{name}: {:?}",
            face.bound
        );
        assert!(face.mesh.triangles.len() as f64 >= ENOUGH);
        let over = case.over(&face, limit).unwrap_or_else(|| panic!("{name} has no bound"));
        println!("{name}: {} triangles at {limit:.3e} mm, {over:.3}", face.mesh.triangles.len());
        if over > most {
            failures.push(format!("{name}: {over:.3} times the fewest, over {most}"));
        }
    }
    assert!(failures.is_empty(), "\n{}\n", failures.join("\n"));
}

/// On a cone a facet's halves may be worse than it is: those of a flat corner beside its longest
/// edge are tilted twice as much, and rounding tilts them more.
#[test]
fn no_cone_is_refused_for_its_slivers() {
    let cone =
        listed().into_iter().find(|listed| listed.name == "conical").expect("the cone").case();
    for limit_um in [61.204, 75.652_173_913, 80.1, 82.6, 84.8] {
        let limit = 1e-3 * limit_um;
        let face =
            cone.mesh(limit, Precision::Single).unwrap_or_else(|e| panic!("{limit_um}: {e}"));
        println!("{limit_um} um: {} triangles", face.mesh.triangles.len());
        assert!(face.bound.facet_mm <= limit, "{limit_um} um: {:?}", face.bound);
    }
}
