//! The blur: how large a spot each pixel sees through a lens of a given aperture.

use super::files::Folder;
use super::observer::StageTimer;
use super::{Error, Observer, Source, Stage, designed, sharpness};
use crate::design::Design;
use crate::geom::Chart;
use crate::pencil::{BlurEllipse, Quantiles, best_focus, map_pencils, quantiles};
use crate::profile::Profile;
use crate::report::{
    Answer, Aperture, BlurReport, FocusPlane, ProfileId, SpotFacts, VirtualImages,
};
use std::path::Path;

/// Works out the spots of the profile of `source` through a lens with `aperture`, or its own, focused
/// `focus_mm` from its entrance pupil (pinhole) or on the plane Z = `focus_mm` (telecentric), or
/// as well as can be; writes `blur.json` and `blur.png` into `out`/NAME.
///
/// # Errors
/// [`enum@Error`] when a stage cannot be done, or the aperture is not one that the camera has.
pub fn blur(
    source: &Source,
    aperture: Option<Aperture>,
    focus_mm: Option<f64>,
    out: &Path,
    observer: &dyn Observer,
) -> Result<BlurReport, Error> {
    let profile = &source.profile;
    let lens = Lens::new(profile, aperture, focus_mm)?;
    let clock = StageTimer::new(observer);
    let design = clock.stage(Stage::Design, || designed(source))?;
    let (report, lengths) = clock.stage(Stage::Blur, || {
        let (report, lengths) = spots(profile, &design, &lens, focus_mm)?;
        let note = format!("{:.3} px p95", report.spots.length_px.p95);
        Ok::<_, Error>(((report, lengths), note))
    })?;
    let png = clock.stage(Stage::Picture, || {
        let png = report.png(&lengths).map_err(|e| Error::Picture(e.to_string()))?;
        let note = format!("{} kB", png.len() / 1000);
        Ok::<_, Error>((png, note))
    })?;
    let folder = Folder::create(&out.join(&profile.name))?;
    clock.stage(Stage::Report, || {
        let files = vec![
            folder.stage("blur.png", |out| out.write_all(&png))?,
            folder.stage("blur.json", |out| out.write_all(report.json().as_bytes()))?,
        ];
        folder.replace(files, &[])?;
        Ok::<_, Error>(((), folder.path().display().to_string()))
    })?;
    Ok(report)
}

/// A lens of the kind that the profile's camera has.
struct Lens {
    aperture: Aperture,
    /// The aperture's radius: mm, or the tangent of the cone's half angle.
    radius: f64,
}

impl Lens {
    fn new(
        profile: &Profile,
        aperture: Option<Aperture>,
        focus_mm: Option<f64>,
    ) -> Result<Self, Error> {
        let pinhole = matches!(profile.camera, crate::optics::CameraModel::Pinhole { .. });
        let wrong = |reason| Err(Error::Lens { profile: profile.name.clone(), reason });
        let Some(aperture) = aperture.or(profile.lens.aperture) else {
            return wrong(if pinhole {
                "how wide its lens is open is not known; give --pupil-mm, the diameter of its entrance \
                 pupil, or write camera.pinhole.pupil_mm (or lens_mm, pixel_um and f_number)"
            } else {
                "how wide its lens is open is not known; give --na, its numerical aperture on the \
                 mirror's side, or write camera.orthographic.na"
            });
        };
        match aperture {
            Aperture::Pupil { .. } if !pinhole => wrong(
                "a telecentric lens has its entrance pupil infinitely far away; give --na, its \
                 numerical aperture on the mirror's side (1 / (2 N) for the working f-number N there)",
            ),
            Aperture::Na { .. } if pinhole => wrong(
                "a pinhole camera's cones differ from place to place; give --pupil-mm, the \
                 diameter of its entrance pupil",
            ),
            _ if pinhole && focus_mm.is_some_and(|mm| !(mm > 0.0)) => wrong(
                "--focus-mm must be over 0: the distance of the plane in focus from the entrance \
                 pupil",
            ),
            _ => Ok(Self { aperture, radius: sharpness::radius(aperture) }),
        }
    }
}

fn spots(
    profile: &Profile,
    design: &Design,
    lens: &Lens,
    focus_mm: Option<f64>,
) -> Result<(BlurReport, Vec<Option<f64>>), Error> {
    let Design { mirror, camera, view, .. } = design;
    let [columns, rows] = camera.pixels;
    let unit = lens.radius / camera.pixel_mm;
    let map = map_pencils(mirror, camera, view.as_ref(), [0..columns, 0..rows], |pencil| {
        BlurEllipse::new(pencil).scaled(unit)
    });
    let spots: Vec<BlurEllipse> = map.iter().copied().flatten().collect();
    // For an aperture radius of 1.
    let unit_spots: Vec<BlurEllipse> =
        spots.iter().map(|spot| spot.scaled(1.0 / lens.radius)).collect();
    let chart = &camera.chart;
    let none = || Error::Lens {
        profile: profile.name.clone(),
        reason: "no pixel has a spot: the camera is not aimed at the mirror, or that is flat",
    };
    let best = best_focus(&spots, sharpness::least_focus(design)).ok_or_else(none)?;
    let phi = focus_mm.map_or(best, |mm| phi(chart, mm));
    let over = |f: &dyn Fn(&BlurEllipse) -> f64| quantiles(spots.iter().map(f).collect());
    let at = |phi: f64| -> Option<SpotFacts> {
        let length_px: Quantiles = over(&|spot| spot.length(phi))?;
        Some(SpotFacts {
            focus: focus(chart, phi),
            length_px,
            rms_diameter_px: over(&|spot| spot.rms_diameter(phi))?,
            largest: sharpness::aperture(design, lens.radius / length_px.p95),
        })
    };
    let z = |phi: f64| focus(chart, phi).z_mm;
    let astigmatism_mm = over(&|spot| {
        // Both at infinity are at one place.
        let [a, b] = spot.foci().map(z);
        if a == b { 0.0 } else { (a - b).abs() }
    });
    let ends = spots.iter().map(BlurEllipse::foci).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    // A pinhole's phi falls with distance, a telecentric camera's grows.
    let sorted = |[a, b]: [f64; 2]| if z(a) <= z(b) { [a, b] } else { [b, a] };
    let range = ends.map(|ends| sorted(ends).map(|phi| focus(chart, phi)));
    let whole = || {
        Some(BlurReport {
            schema: 1,
            profile: ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() },
            pixels: camera.pixels,
            aimed: spots.len(),
            aperture: lens.aperture,
            focus_is_best: focus_mm.is_none(),
            spots: at(phi)?,
            best: at(best)?,
            sharpness: sharpness::of(
                profile,
                design,
                &unit_spots,
                [best, phi],
                Some(lens.aperture),
            ),
            images: VirtualImages { range: range?, astigmatism_mm: astigmatism_mm? },
        })
    };
    let lengths = map.iter().map(|spot| spot.map(|spot| spot.length(phi))).collect();
    Ok((whole().ok_or_else(none)?, lengths))
}

/// What stands for the plane in focus in [`crate::pencil`].
fn phi(chart: &Chart, focus_mm: f64) -> f64 {
    if chart.vergence == 0.0 {
        chart.plane_mm - focus_mm
    } else {
        1.0 / (chart.vergence * focus_mm)
    }
}

/// The plane in focus; beyond infinity is infinity.
fn focus(chart: &Chart, phi: f64) -> FocusPlane {
    let k = chart.vergence;
    if k == 0.0 {
        return FocusPlane { z_mm: chart.plane_mm - phi, distance_mm: None };
    }
    let distance = if phi > 0.0 { 1.0 / (k * phi) } else { f64::INFINITY };
    FocusPlane { z_mm: chart.plane_mm + 1.0 / k - distance, distance_mm: Some(distance) }
}
