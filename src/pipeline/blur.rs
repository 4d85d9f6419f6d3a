//! `morion blur`: how large a spot each pixel sees through a lens of a given aperture.

use super::run::{Command, Run};
use super::{Error, Stage};
use crate::design::Design;
use crate::optics::{Camera, CameraModel};
use crate::pencil::{BlurEllipse, Quantiles, best_focus, map_pencils, quantiles};
use crate::profile::Profile;
use crate::report::Answer;
use crate::results::Aperture;
use crate::results::{BlurReport, FocusPlane, SpotFacts, VirtualImages};
use crate::verdict::sharpness;

/// How the blur is worked out: writes `blur.json`, `blur.html` and `blur.png` into NAME.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BlurOptions {
    /// How wide the lens is open; none: as the profile says.
    pub aperture: Option<Aperture>,
    /// The plane in focus: its distance from the entrance pupil (pinhole) or its height Z (telecentric),
    /// mm; none: the best.
    pub focus_mm: Option<f64>,
}

/// Most pixels of a frame: some 170 bytes are kept for each.
const MOST_PIXELS: u64 = 40_000_000;

impl Command for BlurOptions {
    type Report = BlurReport;

    fn check(&self, profile: &Profile) -> Result<(), Error> {
        let [columns, rows] = profile.camera.pixels().map(u64::from);
        if columns * rows > MOST_PIXELS {
            return Err(Error::Lens {
                profile: profile.name.clone(),
                reason: "its frame has over 40 million pixels, of each of which a spot is kept; take a profile \
                         with fewer, whose spots in pixels are as much smaller",
            });
        }
        Lens::new(profile, self).map(drop)
    }

    fn run(&self, run: &mut Run) -> Result<BlurReport, Error> {
        let profile = run.profile;
        let lens = Lens::new(profile, self)?;
        let design = run.design()?;
        let (report, lengths) = run.stage(Stage::Blur, || {
            let (report, lengths) = spots(profile, &design, &lens, self.focus_mm)?;
            let note = format!("{:.3} px p95", report.spots.length_px.p95);
            Ok(((report, lengths), note))
        })?;
        let map = report.map(&lengths);
        let png = run.picture(|| map.png())?;
        let page =
            report.html(run.profile, &map).map_err(|error| Error::Picture(error.to_string()))?;
        run.publish(Stage::Report, |files, _| {
            files.add_bytes("blur.png", &png)?;
            files.add_bytes("blur.html", page.as_bytes())?;
            files.add_report("blur.json", &report.json())?;
            Ok(())
        })?;
        Ok(report)
    }
}

/// A lens of the kind that the profile's camera has.
struct Lens {
    aperture: Aperture,
    /// The aperture's radius: mm, or the tangent of the cone's half angle.
    radius: f64,
}

impl Lens {
    fn new(profile: &Profile, options: &BlurOptions) -> Result<Self, Error> {
        let BlurOptions { aperture, focus_mm } = *options;
        let pinhole = profile.camera.distance_mm().is_finite();
        let wrong = |reason| Err(Error::Lens { profile: profile.name.clone(), reason });
        let Some(aperture) = aperture.or(profile.lens.aperture) else {
            return wrong(if matches!(profile.camera, CameraModel::Calibrated { .. }) {
                "how wide its lens is open is not known; give --pupil-mm, the diameter of its entrance \
                 pupil, or write camera.calibrated.pupil_mm (or lens_mm and f_number)"
            } else if pinhole {
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

/// Spots of all pixels through a lens.
struct LensSpots<'a> {
    design: &'a Design,
    /// The aperture's radius.
    radius: f64,
    /// By pixel; none where it sees no mirror.
    map: Vec<Option<BlurEllipse>>,
    /// Those that there are.
    spots: Vec<BlurEllipse>,
}

impl<'a> LensSpots<'a> {
    fn new(design: &'a Design, radius: f64) -> Self {
        let Design { mirror, camera, view, .. } = design;
        let [columns, rows] = camera.pixels;
        let unit = radius / camera.pixel_mm;
        let map = map_pencils(mirror, camera, view.as_ref(), [0..columns, 0..rows], |pencil| {
            BlurEllipse::new(pencil).scaled(unit)
        });
        let spots = map.iter().copied().flatten().collect();
        Self { design, radius, map, spots }
    }

    fn over(&self, figure: impl Fn(&BlurEllipse) -> f64) -> Option<Quantiles> {
        quantiles(self.spots.iter().map(figure).collect())
    }

    /// Their figures with a plane in focus.
    fn focused(&self, phi: f64) -> Option<SpotFacts> {
        let length_px = self.over(|spot| spot.length(phi))?;
        Some(SpotFacts {
            focus: focus(&self.design.camera, phi),
            length_px,
            rms_diameter_px: self.over(|spot| spot.rms_diameter(phi))?,
            largest: sharpness::aperture(self.design, self.radius / length_px.p95),
        })
    }

    /// Where the images of the world are.
    fn images(&self) -> Option<VirtualImages> {
        let camera = &self.design.camera;
        let z = |phi: f64| focus(camera, phi).z_mm;
        let astigmatism_mm = self.over(|spot| {
            // Both at infinity are at one place.
            let [a, b] = spot.foci().map(z);
            if a == b { 0.0 } else { (a - b).abs() }
        })?;
        let foci = self.spots.iter().map(BlurEllipse::foci);
        let [a, b] = foci.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
        // A pinhole's phi falls with distance, a telecentric camera's grows.
        let range = if z(a) <= z(b) { [a, b] } else { [b, a] };
        Some(VirtualImages { range: range.map(|phi| focus(camera, phi)), astigmatism_mm })
    }
}

/// The report, and the length of each pixel's spot.
fn spots(
    profile: &Profile,
    design: &Design,
    lens: &Lens,
    focus_mm: Option<f64>,
) -> Result<(BlurReport, Vec<Option<f64>>), Error> {
    let made = LensSpots::new(design, lens.radius);
    let none = || Error::Lens {
        profile: profile.name.clone(),
        reason: "no pixel has a spot: the camera is not aimed at the mirror, or that is flat",
    };
    let best = best_focus(&made.spots, sharpness::least_focus(design)).ok_or_else(none)?;
    let phi = focus_mm.map_or(best, |mm| phi(&design.camera, mm));
    // For an aperture radius of 1.
    let unit: Vec<BlurEllipse> =
        made.spots.iter().map(|spot| spot.scaled(1.0 / lens.radius)).collect();
    let report = || {
        Some(BlurReport {
            schema: 1,
            profile: profile.into(),
            pixels: design.camera.pixels,
            aimed: made.spots.len(),
            aperture: lens.aperture,
            focus_is_best: focus_mm.is_none(),
            spots: made.focused(phi)?,
            best: made.focused(best)?,
            sharpness: sharpness::of(profile, design, &unit, [best, phi], Some(lens.aperture)),
            images: made.images()?,
        })
    };
    let lengths = made.map.iter().map(|spot| spot.map(|spot| spot.length(phi))).collect();
    Ok((report().ok_or_else(none)?, lengths))
}

/// What stands for the plane in focus in [`crate::pencil`].
fn phi(camera: &Camera, focus_mm: f64) -> f64 {
    match camera.vergence() {
        0.0 => (camera.chart.plane_mm - focus_mm) / camera.axis().z,
        k => 1.0 / (k * focus_mm),
    }
}

/// The plane in focus, where the camera's axis meets it; beyond infinity is infinity.
fn focus(camera: &Camera, phi: f64) -> FocusPlane {
    let (chart, along) = (&camera.chart, camera.axis().z);
    let Some(pupil) = chart.pupil() else {
        return FocusPlane { z_mm: chart.plane_mm - phi * along, distance_mm: None };
    };
    let distance = if phi > 0.0 { 1.0 / (camera.vergence() * phi) } else { f64::INFINITY };
    FocusPlane { z_mm: pupil.z - distance * along, distance_mm: Some(distance) }
}
