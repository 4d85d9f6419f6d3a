//! The vector-field design against closed forms and an independent one-dimensional solution.

use morion::design::{Design, design};
use morion::geom::DVec2;
use morion::num::{asinh, cos, cosh, exp, hypot, quadrature::gauss_legendre, sinh};
use morion::profile::{
    Accept, Camera, Format, Law, Layout, MeshLimits, Method, PanelSource, Part, Profile,
    Projection, Ridge,
};
use std::f64::consts::PI;

fn profile(law: Law, layout: Layout, elevation: f64, degree: usize) -> Profile {
    Profile {
        name: "test".into(),
        sha256: String::new(),
        summary: String::new(),
        camera: Camera::Orthographic { pixels: [640, 480] },
        projection: Projection {
            law,
            azimuth_deg: [-180.0, 180.0],
            elevation_deg: [-elevation, elevation],
        },
        layout,
        method: Method::VectorField { degree },
        part: Part { width_mm: 60.0, base_mm: 5.0 },
        mesh: MeshLimits { chord_um: None, facet_px: Some(1.0) },
        formats: vec![Format::Stl],
        accept: Accept::default(),
    }
}

fn strip(law: Law, elevation: f64, degree: usize) -> Design {
    design(&profile(law, Layout::Strip { fill_frame: false }, elevation, degree)).unwrap()
}

fn folded(law: Law, panel: PanelSource, degree: usize) -> Design {
    let layout = Layout::Conquistador { panel, ridge: Ridge::Crest, fill_frame: true };
    design(&profile(law, layout, 30.0, degree)).unwrap()
}

/// f in the paper's units at (y, z) around the panel's centre.
fn sag(design: &Design, q: DVec2) -> f64 {
    let sheet = &design.mirror.sheet;
    (sheet.at(q).sag - sheet.lift_mm) / sheet.scale_mm
}

/// The least possible integral of |grad f - s|^2 for the cylindrical law over a full turn and
/// |z| <= reach. There f = cos(y) phi(z), phi'' - phi = -(E + E'), phi' = -E at both ends, and the
/// integral is pi * int (phi - E)^2 + (phi' + E)^2 dz, by E = exp(-asinh z). The boundary-value
/// problem is solved by its Green's function, with quadrature only.
fn least_residual(reach: f64) -> f64 {
    let e = |z: f64| exp(-asinh(z));
    // psi = phi - E solves psi'' - psi = -(E'' + E'), psi' = -(E + E') at the ends.
    let d = |z: f64| -e(z) / hypot(1.0, z);
    let dd = |z: f64| {
        let far = hypot(1.0, z);
        e(z) / (far * far) + e(z) * z / (far * far * far)
    };
    let (nodes, weights) = gauss_legendre(60);
    let between = |lo: f64, hi: f64, f: &dyn Fn(f64) -> f64| -> f64 {
        let (mid, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        nodes.iter().zip(&weights).map(|(x, w)| w * half * f(mid + half * x)).sum()
    };
    let source = |t: f64| -(dd(t) + d(t));
    // Particular solution int_{-reach}^z sinh(z - t) source(t) dt vanishes with its slope at the
    // lower end; A cosh + B sinh of (z + reach) fits the two end conditions.
    let particular = |z: f64| between(-reach, z, &|t| sinh(z - t) * source(t));
    let particular_slope = |z: f64| between(-reach, z, &|t| cosh(z - t) * source(t));
    let end = |z: f64| -(e(z) + d(z));
    let b = end(-reach);
    let a = (end(reach) - particular_slope(reach) - b * cosh(2.0 * reach)) / sinh(2.0 * reach);
    let psi = |z: f64| particular(z) + a * cosh(z + reach) + b * sinh(z + reach);
    let psi_slope = |z: f64| particular_slope(z) + a * sinh(z + reach) + b * cosh(z + reach);
    PI * between(-reach, reach, &|z| {
        let (p, q) = (psi(z), psi_slope(z) + d(z) + e(z));
        p * p + q * q
    })
}

#[test]
fn panoramic_residual_is_the_exact_optimum() {
    let exact = least_residual(1.0 / 3.0f64.sqrt());
    let found = strip(Law::Cylindrical, 30.0, 12).facts.gradient_residual;
    assert!((found / exact - 1.0).abs() < 1e-9, "{found} for {exact}");
    // The check can tell: degree 6 is visibly off the optimum.
    let coarse = strip(Law::Cylindrical, 30.0, 6).facts.gradient_residual;
    assert!(coarse / exact - 1.0 > 1e-7, "{coarse} for {exact}");
}

#[test]
fn residual_falls_to_the_optimum_as_the_degree_grows() {
    let exact = least_residual(1.0 / 3.0f64.sqrt());
    let excess: Vec<f64> = [2, 4, 6, 8]
        .map(|degree| strip(Law::Cylindrical, 30.0, degree).facts.gradient_residual / exact - 1.0)
        .to_vec();
    assert!(excess.windows(2).all(|pair| pair[1] < 0.1 * pair[0]), "{excess:?}");
}

#[test]
fn mercator_strip_is_the_harmonic_mirror() {
    let design = strip(Law::Mercator, 30.0, 20);
    let scale = design.mirror.sheet.scale_mm;
    let f = |y: f64, z: f64| exp(-z) * cos(y);
    let gauge = sag(&design, DVec2::ZERO) - f(0.0, 0.0);
    let mut worst: f64 = 0.0;
    for (q, _) in design.mirror.panel.grid(64, 40) {
        worst = worst.max((sag(&design, q) - gauge - f(q.x / scale, q.y / scale)).abs());
    }
    assert!(worst < 1e-12, "{worst:e}");
    assert_eq!(design.facts.curl.max, 0.0);
    assert!(design.facts.ray_error_mrad.max < 1e-8);
}

#[test]
fn mercator_converges_spectrally() {
    let error = |degree| strip(Law::Mercator, 30.0, degree).facts.ray_error_mrad.max;
    let errors: Vec<f64> = [4, 8, 12, 16].map(error).to_vec();
    assert!(errors.windows(2).all(|pair| pair[1] < 0.02 * pair[0]), "{errors:?}");
}

#[test]
fn the_papers_mirrors_have_their_known_worst_ray_errors() {
    let panoramic = strip(Law::Cylindrical, 30.0, 12).facts.ray_error_mrad.max;
    let refit = folded(Law::Cylindrical, PanelSource::Refit, 12).facts.ray_error_mrad.max;
    assert!((panoramic - 29.3).abs() < 0.2, "{panoramic}");
    assert!((refit - 22.0).abs() < 0.2, "{refit}");
}

#[test]
fn a_refitted_panel_is_nearer_to_the_field_than_a_section() {
    let section = folded(Law::Cylindrical, PanelSource::Section, 12).facts;
    let refit = folded(Law::Cylindrical, PanelSource::Refit, 12).facts;
    assert!(refit.ray_error_mrad.rms < section.ray_error_mrad.rms);
    // Half the domain has at most half the full turn's residual.
    assert!(refit.gradient_residual < 0.5 * section.gradient_residual);
}

#[test]
fn curl_is_the_cylindrical_laws() {
    // curl = sin y (E + E'); largest at the lower edge, y = +-90 degrees.
    let z = -1.0 / 3.0f64.sqrt();
    let exact = exp(-asinh(z)) * (1.0 - 1.0 / hypot(1.0, z));
    let facts = strip(Law::Cylindrical, 30.0, 12).facts;
    // The panel's rim is rounded to single precision.
    assert!((facts.curl.max / exact - 1.0).abs() < 1e-7);
    assert!(facts.curl.rms > 0.1 * exact && facts.curl.rms < exact);
}

#[test]
fn fill_frame_gives_the_filled_elevation_range() {
    for (law, expected) in [(Law::Cylindrical, 30.50), (Law::Mercator, 32.0)] {
        let design = folded(law, PanelSource::Refit, 8);
        let outline = design.mirror.outline();
        assert!((outline.size() - DVec2::new(60.0, 45.0)).length() < 1e-5);
        let top = design.image.wanted(DVec2::new(0.0, outline.max.y));
        let elevation = morion::num::degrees(morion::num::asin(top.z));
        assert!((elevation - expected).abs() < 0.05, "{law:?} {elevation}");
    }
    let strip = profile(Law::Cylindrical, Layout::Strip { fill_frame: true }, 30.0, 8);
    let outline = design(&strip).unwrap().mirror.outline();
    assert!((outline.size() - DVec2::new(60.0, 45.0)).length() < 1e-5);
}

#[test]
fn crest_and_valley_are_ridges_of_the_right_sense() {
    for (ridge, sign) in [(Ridge::Crest, -1.0), (Ridge::Valley, 1.0)] {
        let layout = Layout::Conquistador { panel: PanelSource::Refit, ridge, fill_frame: true };
        let mirror = design(&profile(Law::Cylindrical, layout, 30.0, 12)).unwrap().mirror;
        for x in [-20.0, -5.0, 0.0, 13.0, 29.0] {
            // Sag away from the ridge, on either side alike.
            let at = |y: f64| mirror.row(y).at(x);
            assert!(sign * (at(0.5).sag - at(0.0).sag) > 0.0, "{ridge:?} {x}");
            assert_eq!(at(0.5).sag, at(-0.5).sag);
            assert_eq!(at(0.5).slope.y, -at(-0.5).slope.y);
        }
    }
}

#[test]
fn a_strip_turned_by_half_a_turn_is_the_same_problem_with_the_other_sign() {
    let plain = strip(Law::Cylindrical, 30.0, 10);
    let mut turned = profile(Law::Cylindrical, Layout::Strip { fill_frame: false }, 30.0, 10);
    turned.projection.azimuth_deg = [0.0, 360.0];
    let turned = design(&turned).unwrap();
    assert!(turned.mirror.even_x);
    for (q, _) in plain.mirror.panel.grid(12, 8) {
        assert!((sag(&plain, q) + sag(&turned, q)).abs() < 1e-12);
    }
    // An uneven range needs the odd terms, and reaches the same kind of fit with them.
    let mut uneven = profile(Law::Mercator, Layout::Strip { fill_frame: false }, 30.0, 20);
    uneven.projection.azimuth_deg = [-90.0, 200.0];
    let uneven = design(&uneven).unwrap();
    assert!(!uneven.mirror.even_x);
    assert!(uneven.facts.ray_error_mrad.max < 1e-8, "{:?}", uneven.facts);
}

#[test]
fn the_base_is_as_thick_as_asked_also_where_the_lowest_point_lies_between_samples() {
    let mut uneven = profile(Law::Cylindrical, Layout::Strip { fill_frame: false }, 30.0, 12);
    uneven.projection.azimuth_deg = [-90.0, 200.0];
    uneven.part = Part { width_mm: 1e6, base_mm: 0.001 };
    let mirror = design(&uneven).unwrap().mirror;
    let near_180 = |x: f64| mirror.row(mirror.panel.min.y).at(x).sag;
    // Least near azimuth 180, which no even division of the range meets.
    let least = (0..100_000).map(|k| near_180(4.0e5 + f64::from(k))).fold(f64::INFINITY, f64::min);
    assert!((least - 0.001).abs() < 1e-4, "{least}");
}
