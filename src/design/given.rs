//! Given mirrors: from a formula or a grid of heights to a surface, and where the camera stands.

use super::conic::{along_radius, over_area, plus};
use super::facts::DesignFacts;
use super::layout::{self, DesignProblem, SelfConsistentGeometry};
use super::{Design, DesignError, FailureCause, MOST_ROUNDS, place_on_base};
use crate::geom::{BicubicSpline, Chart, DVec2, Outline, Rect};
use crate::mirror::{Mirror, RadialLegendre, RadialTensorSum, Surface, TensorLegendre};
use crate::num::legendre::Series;
use crate::optics::{Camera, ImagingTask};
use crate::profile::{Layout, Monomial, Polynomial, Profile, SagGrid};

/// Largest excess of an outline over a grid, as a share of its size: its corners are rounded.
const ROUNDED: f64 = 1e-6;
/// Degree of a spline's patches.
const CUBIC: usize = 3;

/// The mirror of a formula.
pub(super) fn polynomial(profile: &Profile, given: &Polynomial) -> Result<Design, DesignError> {
    let outline = outline(profile)?;
    let (surface, degree) = formula(given, outline)?;
    let odd = |by: fn(&Monomial) -> usize| given.terms.iter().any(|t| t.c != 0.0 && by(t) % 2 == 1);
    let centred = outline.bounds().centre();
    let even = [!odd(|t| t.i) && centred.x == 0.0, !odd(|t| t.j) && centred.y == 0.0];
    with_camera(
        profile,
        Mirror { surface, outline, mirror_symmetric: even, ..bare(outline) },
        degree,
    )
}

/// The mirror through heights on a grid.
pub(super) fn grid(profile: &Profile, sag: &SagGrid) -> Result<Design, DesignError> {
    let outline = outline(profile)?;
    let bounds = outline.bounds();
    let slack = ROUNDED * bounds.size();
    let covered = Rect {
        min: DVec2::new(sag.x.first_mm, sag.y.first_mm),
        max: DVec2::new(sag.x.last_mm(), sag.y.last_mm()),
    };
    let wide = Rect { min: covered.min - slack, max: covered.max + slack };
    if !(wide.contains(bounds.min) && wide.contains(bounds.max)) {
        let ends = |a: DVec2, b: DVec2| [[a.x, b.x], [a.y, b.y]];
        return Err(DesignError::BeyondGrid {
            outline: ends(bounds.min, bounds.max),
            grid: ends(covered.min, covered.max),
        });
    }
    let patches = BicubicSpline::new(sag.x, sag.y, &sag.z_mm)
        .ok_or(FailureCause::NotFinite { what: "sag" })?;
    let surface = Surface::Spline(patches);
    with_camera(profile, Mirror { surface, ..bare(outline) }, CUBIC)
}

/// A flat mirror, X and Y being its chart's coordinates.
fn bare(outline: Outline) -> Mirror {
    let chart = Chart::on_axis(0.0, 0.0);
    let surface = Surface::Tensor(sheet(Series::from_fn(1, 1, |_, _| 0.0), outline.bounds()));
    Mirror { surface, chart, outline, folded: false, mirror_symmetric: [false; 2] }
}

fn sheet(series: Series, area: Rect) -> TensorLegendre {
    TensorLegendre { series, centre: area.centre(), half: 0.5 * area.size(), scale_mm: 1.0 }
}

/// The mirror's outline over X and Y, a rectangle's corners rounded to single precision.
fn outline(profile: &Profile) -> Result<Outline, DesignError> {
    let outer = 0.5 * profile.part.width_mm;
    let exact = match profile.layout {
        Layout::Disc => return Ok(Outline::Ring { inner: 0.0, outer }),
        Layout::Annulus { inner_width_mm } => {
            return Ok(Outline::Ring { inner: 0.5 * inner_width_mm, outer });
        }
        Layout::Rectangle { .. } => {
            let camera = Camera::new(&profile.camera, &profile.mount, profile.part.width_mm);
            layout::rectangle_of(profile, &camera)
        }
        Layout::Strip { .. } | Layout::Conquistador { .. } => {
            let problem = DesignProblem::new(profile, &SelfConsistentGeometry::initial(profile))?;
            problem.expect("strips have a projection").outline.bounds()
        }
    };
    Ok(Outline::Rect(Rect {
        min: layout::to_single_precision(exact.min),
        max: layout::to_single_precision(exact.max),
    }))
}

/// Camera and view about the mirror: the reference plane at the mean height of the mirror, of a
/// round one at its outer rim's; the target's origin at the mean height.
fn with_camera(profile: &Profile, mirror: Mirror, degree: usize) -> Result<Design, DesignError> {
    let mut camera = Camera::new(&profile.camera, &profile.mount, profile.part.width_mm);
    if camera.chart.vergence != 0.0 {
        camera.chart.plane_mm = match mirror.outline {
            Outline::Rect(_) => at_mean(&mirror, camera.chart, profile.part.width_mm),
            Outline::Ring { outer, .. } => mirror.rim_mm(outer),
        };
    }
    let mean = mirror.mean_mm(&camera.chart);
    let mut geometry =
        SelfConsistentGeometry { origin_mm: mean, ..SelfConsistentGeometry::initial(profile) };
    geometry.inner_mm = in_image(&mirror, &camera, geometry.inner_mm);
    let view = DesignProblem::new(profile, &geometry)?
        .map(|problem| ImagingTask { origin_mm: mean, ..problem.view });
    place_on_base(profile, camera, view, mirror, DesignFacts::given(degree))
}

/// The reference plane's height that is the mean height over its own camera's picture, mm: each
/// round brings it closer by the square of the depths' spread over their mean.
fn at_mean(mirror: &Mirror, chart: Chart, width_mm: f64) -> f64 {
    let mut plane_mm = mirror.mean_mm(&mirror.chart);
    for _ in 0..MOST_ROUNDS {
        let mean = mirror.mean_mm(&Chart { plane_mm, ..chart });
        // A mirror that reaches up to the pinhole has no mean there, and is refused for its back.
        if !mean.is_finite() {
            break;
        }
        let step = (mean - plane_mm).abs();
        plane_mm = mean;
        if step <= 1e-13 * width_mm {
            break;
        }
    }
    plane_mm
}

/// The mean image radius of the mirror's points at `radius` from the axis.
fn in_image(mirror: &Mirror, camera: &Camera, radius: f64) -> f64 {
    if radius == 0.0 {
        return 0.0;
    }
    radius / camera.chart.view_scale(mirror.rim_mm(radius))
}

/// The surface of a formula, and its degree.
fn formula(given: &Polynomial, outline: Outline) -> Result<(Surface, usize), DesignError> {
    let area = outline.bounds();
    let terms = (!given.terms.is_empty()).then(|| legendre(&given.terms, area));
    let top = |series: &Series| series.shape().0.max(series.shape().1) - 1;
    Ok(match (given.conic, outline, terms) {
        (None, _, None) => return Err(FailureCause::NotFinite { what: "sag" }.into()),
        (None, _, Some(series)) => {
            let degree = top(&series);
            (Surface::Tensor(sheet(series, area)), degree)
        }
        (Some(conic), Outline::Ring { outer, .. }, terms) => {
            // A series of r^2: smooth inside the land of an annulus too.
            let radial = along_radius(&conic, outer)?;
            let degree = radial.shape().0 - 1;
            let round = RadialLegendre::new(radial, [0.0, outer], 1.0);
            match terms {
                None => (Surface::Radial(round), degree),
                Some(series) => {
                    let degree = degree.max(top(&series));
                    (
                        Surface::Sum(RadialTensorSum {
                            radial: round,
                            tensor: sheet(series, area),
                        }),
                        degree,
                    )
                }
            }
        }
        (Some(conic), Outline::Rect(_), terms) => {
            let found = over_area(&conic, area)?;
            let series = terms.map_or(found.clone(), |terms| plus(&found, &terms));
            let degree = top(&series);
            (Surface::Tensor(sheet(series, area)), degree)
        }
    })
}

/// The terms as a series over `area`, without loss: a power of X is 1 times X so many times, and X
/// times P_k is a sum of P_k-1, P_k and P_k+1.
fn legendre(terms: &[Monomial], area: Rect) -> Series {
    let (centre, half) = (area.centre(), 0.5 * area.size());
    let top = |by: fn(&Monomial) -> usize| terms.iter().map(by).max().unwrap_or(0);
    let x = powers(top(|t| t.i), centre.x, half.x);
    let y = powers(top(|t| t.j), centre.y, half.y);
    Series::from_fn(x.len(), y.len(), |i, j| {
        let part = |t: &Monomial| {
            let (x, y) = (x[t.i].get(i).unwrap_or(&0.0), y[t.j].get(j).unwrap_or(&0.0));
            t.c * x * y
        };
        terms.iter().map(part).sum()
    })
}

/// (centre + half u)^n as a Legendre series in u, for n up to `top`.
fn powers(top: usize, centre: f64, half: f64) -> Vec<Vec<f64>> {
    let mut powers = vec![vec![1.0]];
    for n in 0..top {
        let mut next = vec![0.0; n + 2];
        for (k, c) in powers[n].iter().enumerate() {
            let odd = (2 * k + 1) as f64;
            next[k] += centre * c;
            next[k + 1] += half * c * (k + 1) as f64 / odd;
            if k > 0 {
                next[k - 1] += half * c * k as f64 / odd;
            }
        }
        powers.push(next);
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::super::conic::sag;
    use super::super::design;
    use super::*;
    use crate::geom::GridAxis;
    use crate::mirror::HeightField;
    use crate::num::sample::Draws;
    use crate::num::tan;

    /// A given mirror in the profile's language.
    fn profile(rest: &str) -> Profile {
        let text = format!("mesh.chord_um = 2\nexport.formats = [\"stl\"]\n{rest}");
        Profile::parse("p", "p.toml", text.as_bytes()).unwrap_or_else(|c| panic!("{c}\n{text}"))
    }

    const RECT: &str = "camera.orthographic.pixels = [640, 480]
part = { width_mm = 80, height_mm = 60, base_mm = 5 }
";
    const DISC: &str = "camera.orthographic.pixels = [480, 480]
part = { width_mm = 60, base_mm = 5 }
layout.disc = {}
";
    const ANNULUS: &str =
        "camera.pinhole = { pixels = [480, 480], focal_px = 900, distance_mm = 150 }
part = { width_mm = 60, base_mm = 5 }
layout.annulus.inner_width_mm = 12
";

    fn monomial(term: &Monomial, q: DVec2) -> f64 {
        let power = |x: f64, n: usize| (0..n).fold(1.0, |power, _| power * x);
        term.c * power(q.x, term.i) * power(q.y, term.j)
    }

    #[test]
    fn polynomials_lose_nothing() {
        let mut r = Draws::new(1);
        for area in [
            Rect { min: DVec2::new(-4.0, -3.0), max: DVec2::new(4.0, 3.0) },
            Rect { min: DVec2::new(-1.0, 2.0), max: DVec2::new(4.0, 5.0) },
        ] {
            let far = area.max.abs().max(area.min.abs());
            let pairs = (0..=40usize).flat_map(|i| (0..=40 - i).map(move |j| (i, j)));
            let terms: Vec<Monomial> = pairs
                .map(|(i, j)| {
                    let size = monomial(&Monomial { i, j, c: 1.0 }, far);
                    Monomial { i, j, c: r.inside([-1.0, 1.0]) / size }
                })
                .collect();
            for terms in [&terms[..], &terms[terms.len() - 1..], &terms[40..41]] {
                let sheet = sheet(legendre(terms, area), area);
                let size: f64 = terms.iter().map(|t| monomial(t, far).abs()).sum();
                for _ in 0..200 {
                    let x = r.inside([area.min.x, area.max.x]);
                    let q = DVec2::new(x, r.inside([area.min.y, area.max.y]));
                    let exact: f64 = terms.iter().map(|t| monomial(t, q)).sum();
                    let off = (sheet.at(q).f - exact).abs() / size;
                    assert!(off < 1e-14, "{off:e}");
                }
            }
        }
    }

    #[test]
    fn conics_are_those_of_the_closed_form() {
        let terms = "terms = [[4, 0, 1e-6], [1, 2, 2e-5]]";
        for (layout, inner) in [(RECT, 0.0), (DISC, 0.0), (ANNULUS, 6.0)] {
            for shape in
                ["radius_mm = -55", "radius_mm = 70, conic = 0.2", "radius_mm = -20, conic = -3"]
            {
                for terms in ["", terms] {
                    let both = if terms.is_empty() { "" } else { ", " };
                    let given =
                        profile(&format!("{layout}mirror.polynomial = {{ {shape}{both}{terms} }}"));
                    let design = design(&given).unwrap();
                    let crate::profile::ShapeSpec::Polynomial(polynomial) = &given.shape else {
                        panic!()
                    };
                    let conic = polynomial.conic.unwrap();
                    let mirror = &design.mirror;
                    assert_eq!(mirror.mirror_symmetric, [terms.is_empty(), true]);
                    for (q, _) in mirror.outline.samples(24).concat() {
                        let rest: f64 = polynomial.terms.iter().map(|t| monomial(t, q)).sum();
                        let exact = sag(&conic, q.length_squared()) + rest;
                        let off = (mirror.surface.at(q).f - exact).abs();
                        assert!(q.length() >= inner - 1e-9 && off < 1e-12 * 20.0, "{off:e}");
                    }
                    assert!(design.facts.degree > 0 && design.view.is_none());
                    assert!(mirror.volume() > 0.0);
                }
            }
        }
    }

    #[test]
    fn a_conic_that_ends_at_the_rim_is_refused() {
        for (layout, reach) in [(RECT, 50.0), (DISC, 30.0)] {
            let radius = -1.00001 * reach;
            let given = profile(&format!("{layout}mirror.polynomial.radius_mm = {radius}"));
            let error = design(&given).unwrap_err();
            assert!(
                matches!(error, DesignError::Steep { reach_mm, .. } if (reach_mm - reach).abs() < 1e-5)
            );
            assert!(error.to_string().contains("too steep"), "{error}");
        }
    }

    /// A grid over a square about the axis.
    fn sampled(reach: f64, count: usize, f: impl Fn(DVec2) -> f64) -> SagGrid {
        let step = 2.0 * reach / (count - 1) as f64;
        let axis = GridAxis { first_mm: -reach, step_mm: step, count };
        let at = |k: usize| -reach + step * k as f64;
        let z_mm =
            (0..count * count).map(|k| f(DVec2::new(at(k % count), at(k / count)))).collect();
        SagGrid { x: axis, y: axis, z_mm }
    }

    #[test]
    fn a_paraboloid_has_the_parabolic_projection() {
        let rate = tan(crate::num::radians(50.0)) / 30.0;
        let radius = -1.0 / rate;
        let projection = "projection.parabolic.outer_polar_deg = 100\n";
        let heights = sampled(30.0, 21, |q| -0.5 * rate * q.length_squared());
        for mirror in [
            format!("mirror.polynomial = {{ radius_mm = {radius}, conic = -1 }}"),
            format!("mirror.polynomial.terms = [[2, 0, {0}], [0, 2, {0}]]", -0.5 * rate),
            "mirror.grid.file = \"sag.csv\"".to_owned(),
        ] {
            let mut given = profile(&format!("{DISC}{projection}{mirror}"));
            given.heights = Some(heights.clone());
            let design = design(&given).unwrap();
            let error = design.facts.pixel_error_px.unwrap().max;
            assert!(error < 1e-6, "{mirror}: {error:e}");
            assert_eq!(design.mirror.chart, design.camera.chart);
            let [lowest, base] = [design.mirror.rim_mm(30.0), given.part.base_mm];
            assert!((lowest - base).abs() < 1e-9);
        }
    }

    #[test]
    fn a_grid_must_be_there_and_cover_the_mirror() {
        let mut given = profile(&format!("{DISC}mirror.grid.file = \"sag.csv\""));
        let missing = design(&given).unwrap_err();
        assert!(missing.to_string().contains("sag.csv"));
        given.heights = Some(sampled(29.9, 9, |_| 1.0));
        let error = design(&given).unwrap_err();
        assert!(error.to_string().contains("X from -30 to 30"), "{error}");
        assert!(error.to_string().contains("X from -29.9 to 29.9"), "{error}");
    }

    #[test]
    fn a_pinhole_sees_a_given_mirror_along_its_rays() {
        let heights =
            sampled(41.0, 30, |q| -0.01 * q.length_squared() + 0.1 * crate::num::sin(q.x / 9.0));
        let pinhole =
            "camera.pinhole = { pixels = [640, 480], focal_px = 900, distance_mm = 150 }\n";
        let rect = RECT.replace("camera.orthographic.pixels = [640, 480]\n", pinhole);
        for (layout, mirror) in [
            (&*rect, "mirror.polynomial = { radius_mm = -60, terms = [[3, 0, 1e-5]] }"),
            (&*rect, "mirror.grid.file = \"sag.csv\""),
            (ANNULUS, "mirror.polynomial = { radius_mm = -60, conic = -1 }"),
            (ANNULUS, "mirror.grid.file = \"sag.csv\""),
        ] {
            let given = profile(&format!("{layout}{mirror}"));
            let given = Profile { heights: Some(heights.clone()), ..given };
            let design = design(&given).unwrap();
            let (mirror, camera) = (&design.mirror, &design.camera.chart);
            let height = match mirror.outline {
                Outline::Rect(_) => mirror.mean_mm(camera),
                Outline::Ring { outer, .. } => mirror.rim_mm(outer),
            };
            assert!((camera.plane_mm - height).abs() < 1e-9);
            for (at, _) in mirror.outline.samples(16).concat() {
                let (image, _) = camera.coordinates(mirror.position(at, &mirror.surface.at(at)));
                let found = mirror.intersect_camera_ray(camera, image).expect("converges");
                let place = mirror.position(found, &mirror.surface.at(found));
                let ray = camera.ray(image, 100.0);
                assert!((place - ray.origin).cross(ray.direction).length() < 1e-10);
                assert!((found - at).length() < 1e-8, "{found} {at}");
            }
        }
    }

    #[test]
    fn a_strip_has_the_outline_of_its_projection() {
        let given = profile(
            "camera.orthographic.pixels = [640, 480]
part = { width_mm = 60, base_mm = 5 }
layout.strip = {}
projection.equirectangular = { azimuth_deg = [-90, 90], elevation_deg = [-30, 30] }
mirror.polynomial.terms = [[2, 0, -0.01], [0, 1, -0.7]]",
        );
        let found = outline(&given).unwrap().bounds();
        assert!((found.size() - DVec2::new(60.0, 20.0)).length() < 1e-5);
        let design = design(&given).unwrap();
        assert!(design.view.is_some() && design.facts.pixel_error_px.is_some());
    }
}
