//! How sharp the picture is through the profile's lens, and at best.

use crate::design::Design;
use crate::num::{asin, atan, sin, tan};
use crate::pencil::{self, BlurEllipse, Quantiles, best_focus, map_pencils_sparsely, quantiles};
use crate::profile::{Aperture, Profile};
use crate::results::{ApertureFacts, PictureFault, Reason, SharpnessFacts};

/// Pixels along a side of the sensor that stand for all of them.
const SOME: u32 = 64;

/// The aperture's radius as pencils have it: mm, or the tangent of the cone's half angle.
pub(crate) fn radius(aperture: Aperture) -> f64 {
    match aperture {
        Aperture::Pupil { pupil_mm } => 0.5 * pupil_mm,
        Aperture::Na { na } => tan(asin(na)),
    }
}

/// The aperture of this radius of the camera of `design`.
pub(crate) fn aperture(design: &Design, radius: f64) -> Aperture {
    if design.camera.chart.vergence == 0.0 {
        Aperture::Na { na: sin(atan(radius)) }
    } else {
        Aperture::Pupil { pupil_mm: 2.0 * radius }
    }
}

/// phi of the nearest plane that a lens focuses on, as far as infinity.
pub(crate) fn least_focus(design: &Design) -> f64 {
    if design.camera.chart.vergence == 0.0 { f64::NEG_INFINITY } else { 0.0 }
}

/// Blur ellipses of pixels spread over the frame.
pub(crate) struct SampledSpots {
    /// Columns and rows of the pixels.
    pixels: [u32; 2],
    /// For an aperture radius of 1, px; none where there is no mirror.
    spots: Vec<Option<BlurEllipse>>,
}

/// Sizes of the spots of pixels spread over the frame.
pub(crate) struct SpotSizes {
    /// Columns and rows of the pixels.
    pub pixels: [u32; 2],
    /// Root of the sum of squares of ellipse, Airy disc and pixel, px; none where there is no mirror.
    pub sizes_px: Vec<Option<f64>>,
    /// Their quantiles.
    pub quantiles: Quantiles,
}

impl SampledSpots {
    /// Those of so many columns and rows of pixels of the frame of `design`.
    fn new(design: &Design, pixels: [u32; 2]) -> Self {
        let Design { mirror, camera, view, .. } = design;
        let unit = 1.0 / camera.pixel_mm;
        let spot = |pencil: &pencil::Pencil| BlurEllipse::new(pencil).scaled(unit);
        let spots = map_pencils_sparsely(mirror, camera, view.as_ref(), pixels, spot);
        Self { pixels, spots }
    }

    /// Those of `some` pixels along the frame's longer side, and as many along the shorter as make squares of them.
    pub(crate) fn in_squares(design: &Design, some: u32) -> Self {
        let [columns, rows] = design.camera.pixels;
        let share = |side: u32| (some * side / columns.max(rows)).clamp(1, side);
        Self::new(design, [share(columns), share(rows)])
    }

    fn seen(&self) -> Vec<BlurEllipse> {
        self.spots.iter().copied().flatten().collect()
    }

    /// Their sizes in the best focus, through the lens of the profile of `design` or else the aperture at which they are least.
    pub(crate) fn sizes(&self, design: &Design, facts: &SharpnessFacts) -> Option<SpotSizes> {
        let lens = facts.given.as_ref().unwrap_or(&facts.best);
        let focus = best_focus(&self.seen(), least_focus(design))?;
        let radius = radius(lens.aperture);
        let size = |spot: BlurEllipse| {
            let [ellipse, airy] = [spot.length(focus) * radius, lens.sharp.diffraction_px];
            (ellipse * ellipse + airy * airy + 1.0).sqrt()
        };
        let sizes_px: Vec<Option<f64>> = self.spots.iter().map(|spot| spot.map(size)).collect();
        let quantiles = quantiles(sizes_px.iter().copied().flatten().collect())?;
        Some(SpotSizes { pixels: self.pixels, sizes_px, quantiles })
    }

    /// How sharp the picture of `design` is by them; none where no pixel has a spot.
    pub(crate) fn sharpness(&self, profile: &Profile, design: &Design) -> Option<SharpnessFacts> {
        let spots = self.seen();
        let best = best_focus(&spots, least_focus(design))?;
        of(profile, design, &spots, [best; 2], profile.lens.aperture)
    }
}

/// Sizes of the spots in the best focus.
pub(crate) fn spot_sizes(design: &Design, facts: &SharpnessFacts) -> Option<SpotSizes> {
    SampledSpots::in_squares(design, SOME).sizes(design, facts)
}

/// How sharp the picture of `design` is; none where no pixel has a spot.
pub(crate) fn sharpness(profile: &Profile, design: &Design) -> Option<SharpnessFacts> {
    let pixels = design.camera.pixels.map(|side| side.min(SOME));
    SampledSpots::new(design, pixels).sharpness(profile, design)
}

/// The same of `spots`, in pixels: at best in the first focus, through `given` in the second.
pub(crate) fn of(
    profile: &Profile,
    design: &Design,
    spots: &[BlurEllipse],
    [best, asked]: [f64; 2],
    given: Option<Aperture>,
) -> Option<SharpnessFacts> {
    let vergence = design.camera.vergence();
    let cone = if vergence == 0.0 { 1.0 } else { vergence };
    let wavelength_nm = profile.lens.wavelength_nm;
    let wavelength_px = 1e-6 * wavelength_nm / design.camera.pixel_mm;
    let at = |phi: f64| pencil::Sharpness::new(spots, phi, wavelength_px, cone);
    let opened = |sharpness: &pencil::Sharpness, radius: f64| {
        let (sharp, aperture) = (sharpness.at(radius), aperture(design, radius));
        let f_number = match aperture {
            Aperture::Pupil { pupil_mm } => profile.lens.focal_mm.map(|mm| mm / pupil_mm),
            Aperture::Na { .. } => None,
        };
        let resolved = design.camera.pixels.map(|px| two_digits(f64::from(px) / sharp.spot_px));
        ApertureFacts { aperture, f_number, sharp, resolved }
    };
    let least = at(best)?;
    let radius_best = Some(least.best_radius()).filter(|radius| radius.is_finite())?;
    let asked = at(asked)?;
    Some(SharpnessFacts {
        wavelength_nm,
        best: opened(&least, radius_best),
        given: given.map(|aperture| opened(&asked, radius(aperture))),
    })
}

/// A number as it deserves.
fn two_digits(x: f64) -> u32 {
    let mut step = 1.0;
    while x / step >= 100.0 {
        step *= 10.0;
    }
    ((x / step).round() * step) as u32
}

/// Why the picture is not sharp enough for the profile, through its own lens or, without one, through the
/// best.
pub(crate) fn reason(profile: &Profile, sharpness: Option<&SharpnessFacts>) -> Option<Reason> {
    let limit = profile.accept.blur_p95_px?;
    let sharpness = sharpness?;
    let lens = sharpness.given.as_ref().unwrap_or(&sharpness.best);
    let spot_px = lens.sharp.spot_px;
    if spot_px <= limit {
        return None;
    }
    let best = &sharpness.best;
    let way = if best.sharp.spot_px < spot_px {
        format!("{} has {:.3} px", best.lens(), best.sharp.spot_px)
    } else {
        "no aperture has shorter ones".to_owned()
    };
    let blur = PictureFault::Blur { lens: lens.lens(), spot_px, limit_px: limit };
    Some(Reason { way_out: Some(way), ..blur.into() })
}
