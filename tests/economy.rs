//! How many triangles a tolerance costs, over the fewest that could do.

#[path = "support/surfaces.rs"]
mod surfaces;

use morion::geom::{DVec2, Precision};
use surfaces::{ENOUGH, FORMULAS, HALF_MM, cases};

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

/// With at least a hundred thousand triangles, at the usual limits or finer ones.
#[test]
fn few_triangles_over_the_fewest() {
    let mut failures = Vec::new();
    for case in cases() {
        let Some(most) = case.most else { continue };
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
