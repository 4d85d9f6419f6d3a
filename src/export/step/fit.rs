//! The spline nearest to a mirror, on as few knots as its tolerance takes.

use super::FitError;
use super::b_spline::{BSplineSurface, KnotVector};
use super::knots::{KnotLines, MOST_SPANS, choose_breaks, written_digits};
use super::panelled::FittedPanels;
use super::parametric_surface::ParametricSurface;
use super::rim_curve::RimCurve;
use super::wall_foot::WallFoot;
use crate::geom::{Border, DVec2, DVec3};
use crate::mirror::{Mirror, Surface};
use crate::num::{max_or_nan, radians};

/// The largest distance of the spline from the mirror, mm.
const LIMIT_MM: f64 = 2e-6;
/// Places in every span where the error is measured.
const PARTS: usize = 12;
/// Rounds of choosing knots before giving up.
const ROUNDS: usize = 6;
/// A round mirror that takes more control points over a square is a surface of revolution instead.
const MOST_POINTS: usize = 3400;

/// Splines within a known distance of a mirror, as a STEP file holds them.
#[derive(Debug, Clone)]
pub struct FittedMirror {
    pub(super) faces: FittedFaces,
    /// The largest distance of the splines from the mirror, mm, at corresponding points: on a grid
    /// four times as dense as the one that they were fitted to, and along a round rim.
    pub error_mm: f64,
    pub(super) foot: WallFoot,
}

/// The faces of a fitted mirror.
#[derive(Debug, Clone)]
pub(super) enum FittedFaces {
    /// A rectangular panel, and its reflection in Y = 0 if it is folded. Its sides are straight
    /// from above if X and Y are the spline's parameters.
    Panel { net: BSplineSurface, straight: bool, folded: bool },
    /// Rectangular panels with steps between them.
    Panels(FittedPanels),
    /// A bicubic surface with X and Y for parameters, cut along rims.
    Trimmed {
        net: BSplineSurface,
        outer: (f64, RimCurve),
        inner: Option<(f64, RimCurve)>,
        middle_mm: f64,
    },
    /// A surface of revolution: the control points of its meridian in the XZ plane, outwards.
    Revolved { radius: KnotVector, points: Vec<DVec3> },
}

impl FittedMirror {
    /// Checks that holes of `border` through the land inside the mirror, if it has any, go through a plane.
    ///
    /// # Errors
    /// [`FitError::Land`] when there are some, and the land is no plane.
    pub fn check_land(&self, border: Option<&Border>) -> Result<(), FitError> {
        let drilled = border.is_some_and(|border| border.land.is_some());
        let flat = matches!(&self.faces, FittedFaces::Revolved { points, .. } if points[0].x > 0.0);
        if drilled && !flat { Err(FitError::Land) } else { Ok(()) }
    }

    /// How many control points the surface has along each axis, of panels with steps the largest of their surfaces; one,
    /// for the curve of a surface of revolution, along the second.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        match &self.faces {
            FittedFaces::Panel { net, .. } | FittedFaces::Trimmed { net, .. } => net.size(),
            FittedFaces::Panels(panels) => panels.size(),
            FittedFaces::Revolved { points, .. } => [points.len(), 1],
        }
    }
}

/// Fits splines to `mirror`, to 2 nm or better.
///
/// # Errors
/// [`FitError`] when no reasonable number of knots suffices, or the mirror is no surface over X
/// and Y.
pub fn fit_splines(mirror: &Mirror) -> Result<FittedMirror, FitError> {
    if let Surface::Panels(surface) = &mirror.surface {
        let fit = |panel: &Mirror| {
            let surface = ParametricSurface::new(panel)?.with_plane_sides();
            fit_bicubic(&surface, false)
        };
        let fits = mirror.panels().iter().map(fit).collect::<Result<Vec<_>, _>>()?;
        let error_mm = fits.iter().map(|(_, error_mm)| *error_mm).fold(0.0, max_or_nan);
        let nets = fits.into_iter().map(|(net, _)| net).collect();
        let panels = FittedPanels { parts: surface.parts.clone(), nets, chart: mirror.chart };
        let foot = WallFoot::Below;
        return Ok(FittedMirror { faces: FittedFaces::Panels(panels), error_mm, foot });
    }
    let surface = ParametricSurface::new(mirror)?;
    let Some(ring) = surface.ring else {
        let (net, error_mm) = fit_bicubic(&surface, mirror.folded)?;
        let faces =
            FittedFaces::Panel { net, straight: surface.is_direct(), folded: mirror.folded };
        return Ok(FittedMirror { faces, error_mm, foot: WallFoot::Below });
    };
    if !surface.is_round() {
        return fit_trimmed(mirror, &surface, ring);
    }
    if ring[0] > 0.0 {
        return fit_revolved(&surface, ring);
    }
    let square = fit_trimmed(mirror, &surface, ring);
    let small = |fit: &FittedMirror| fit.size().iter().product::<usize>() <= MOST_POINTS;
    square.ok().filter(small).map_or_else(|| fit_revolved(&surface, ring), Ok)
}

/// The bicubic surface over a square that is cut along the rims of a round mirror.
fn fit_trimmed(
    mirror: &Mirror,
    surface: &ParametricSurface,
    ring: [f64; 2],
) -> Result<FittedMirror, FitError> {
    let (net, error_mm) = fit_bicubic(surface, false)?;
    let rim = |rho: f64| Ok((written_digits(rho), RimCurve::new(&net, written_digits(rho))?));
    let inner = if ring[0] > 0.0 { Some(rim(ring[0])?) } else { None };
    let (outer, middle_mm) = (rim(ring[1])?, written_digits(mirror.rim_mm(ring[0])));
    let faces = FittedFaces::Trimmed { net, outer, inner, middle_mm };
    Ok(FittedMirror { faces, error_mm, foot: WallFoot::Below })
}

/// The bicubic surface with the fewest control points found, and its distance from the mirror, mm.
pub(super) fn fit_bicubic(
    surface: &ParametricSurface,
    folded: bool,
) -> Result<(BSplineSurface, f64), FitError> {
    let lines = [0, 1].map(|axis| KnotLines::across(surface, axis));
    let mut limit = 0.7 * LIMIT_MM;
    let mut best: Option<(BSplineSurface, f64)> = None;
    let mut reached = (f64::INFINITY, [0; 2]);
    for _ in 0..ROUNDS {
        let u = choose_breaks(surface, &lines[0], limit);
        let v =
            if surface.is_round() { u.clone() } else { choose_breaks(surface, &lines[1], limit) };
        let spans = [u.len() - 1, v.len() - 1];
        let net = fit_net(surface, [KnotVector::new(&u), KnotVector::new(&v)], folded);
        let error_mm = max_distance(surface, &net);
        let fewer = best.as_ref().is_none_or(|(best, _)| net.points.len() < best.points.len());
        if error_mm <= LIMIT_MM && fewer {
            best = Some((net, error_mm));
        } else if !(error_mm >= reached.0) {
            reached = (error_mm, spans);
        }
        // Errors along both axes add up, by how much depends on where each is worst.
        let near = (0.85..=1.0).contains(&(error_mm / LIMIT_MM));
        let full = spans.iter().all(|&n| n >= MOST_SPANS);
        if near || full || error_mm.is_nan() || error_mm < 1e-3 * LIMIT_MM {
            break;
        }
        limit *= (0.93 * LIMIT_MM / error_mm).clamp(0.05, 4.0);
    }
    best.ok_or(FitError::Rough { reached_mm: reached.0, spans: reached.1 })
}

/// The surface of revolution of a round mirror.
pub(super) fn fit_revolved(
    surface: &ParametricSurface,
    ring: [f64; 2],
) -> Result<FittedMirror, FitError> {
    let ends = ring.map(written_digits);
    let lines = KnotLines { axis: 0, ends, even: false, across: vec![0.0] };
    let mut limit = 0.2 * LIMIT_MM;
    let mut reached = (f64::INFINITY, [0; 2]);
    for _ in 0..ROUNDS {
        let radius = KnotVector::new(&choose_breaks(surface, &lines, limit));
        let heights = |places: &[f64]| -> Vec<f64> {
            surface.grid(places, &[0.0])[0].iter().map(|p| p.z).collect()
        };
        let mut z: Vec<f64> =
            radius.fit(1, &heights(&radius.sites())).into_iter().map(written_digits).collect();
        if ends[0] == 0.0 {
            // Smooth on the axis.
            z[1] = z[0];
        }
        let places = [&ends[..], &radius.interior_points(PARTS)].concat();
        let off = |(&rho, wanted): (&f64, f64)| {
            let (first, b) = radius.basis(rho);
            ((0..4).map(|k| b[k] * z[first + k]).sum::<f64>() - wanted).abs()
        };
        let error_mm = places.iter().zip(heights(&places)).map(off).fold(0.0, max_or_nan);
        if error_mm <= LIMIT_MM {
            let at = |(rho, &z): (f64, &f64)| DVec3::new(written_digits(rho), 0.0, z);
            let points = radius.greville().into_iter().zip(&z).map(at).collect();
            let faces = FittedFaces::Revolved { radius, points };
            return Ok(FittedMirror { faces, error_mm, foot: WallFoot::Below });
        }
        if !(error_mm >= reached.0) {
            reached = (error_mm, [radius.breaks().len() - 1, 1]);
        }
        limit *= (0.5 * LIMIT_MM / error_mm).clamp(0.05, 0.8);
    }
    Err(FitError::Rough { reached_mm: reached.0, spans: reached.1 })
}

/// The spline on these knots, its control points as they will be written.
fn fit_net(surface: &ParametricSurface, axes: [KnotVector; 2], folded: bool) -> BSplineSurface {
    let [u, v] = &axes;
    let samples = surface.grid(&u.sites(), &v.sites()).concat();
    let spline = |axis: usize| {
        let samples: Vec<f64> = samples.iter().map(|p| p[axis]).collect();
        BSplineSurface::fit([u, v], &samples)
    };
    let (across, up) = (u.greville(), v.greville());
    let (columns, rows) = (across.len(), up.len());
    let plain = |k: usize| DVec2::new(across[k / rows], up[k % rows]);
    let z = spline(2);
    let mut points: Vec<DVec3> = if surface.is_direct() {
        z.iter().enumerate().map(|(k, &z)| plain(k).extend(z)).collect()
    } else {
        let (x, y) = (spline(0), spline(1));
        (0..z.len()).map(|k| DVec3::new(x[k], y[k], z[k])).collect()
    };
    // Even to the last digit, and the ridge where it belongs.
    for k in 0..points.len() {
        let (i, j) = (k / rows, k % rows);
        if surface.even[0] && 2 * i < columns {
            let other = (columns - 1 - i) * rows + j;
            let (p, q) = (points[k], points[other]);
            let mean = 0.5 * (p + DVec3::new(-q.x, q.y, q.z));
            (points[k], points[other]) = (mean, DVec3::new(-mean.x, mean.y, mean.z));
        }
    }
    for k in 0..points.len() {
        let (i, j) = (k / rows, k % rows);
        if surface.even[1] && 2 * j < rows {
            let other = i * rows + rows - 1 - j;
            let (p, q) = (points[k], points[other]);
            let mean = 0.5 * (p + DVec3::new(q.x, -q.y, q.z));
            (points[k], points[other]) = (mean, DVec3::new(mean.x, -mean.y, mean.z));
        }
        if folded && up[j] == 0.0 {
            points[k].y = 0.0;
        }
        let ends = [[i == 0, i + 1 == columns], [j == 0, j + 1 == rows]];
        points[k] = surface.on_plane_sides(points[k], ends);
    }
    let fine = |p: DVec3| DVec3::from_array(p.to_array().map(written_digits));
    BSplineSurface { points: points.into_iter().map(fine).collect(), axes }
}

/// The largest distance of corresponding points of both surfaces, mm.
fn max_distance(surface: &ParametricSurface, net: &BSplineSurface) -> f64 {
    let places = |k: usize| -> Vec<f64> {
        let half = |&x: &f64| !surface.even[k] || x <= 0.0;
        net.axes[k].interior_points(PARTS).into_iter().filter(half).collect()
    };
    let (us, vs) = (places(0), places(1));
    let (found, wanted) = (net.grid(&us, &vs), surface.grid(&us, &vs));
    let mut worst = 0.0f64;
    let mut look = |off: f64| worst = max_or_nan(worst, off);
    for (j, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
        for (i, (found, wanted)) in found.iter().zip(wanted).enumerate() {
            if surface.contains(DVec2::new(us[i], vs[j])) {
                look((*found - *wanted).length());
            }
        }
    }
    for rho in surface.ring.iter().flatten() {
        for q in (0..360).map(|k| RimCurve::direction(radians(f64::from(k))) * *rho) {
            look((net.at(q) - surface.grid(&[q.x], &[q.y])[0][0]).length());
        }
    }
    worst
}
