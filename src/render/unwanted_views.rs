//! What a mirror shows that nobody asks for: parts of the world a second time, and the camera itself.

use super::smooth_sight::reflected;
use crate::design::Design;
use crate::geom::{DVec2, DVec3, Ray, angle};
use crate::num::degrees;
use crate::optics::{ImagingTask, ThinnedFrame};
use crate::parallel;
use serde::{Deserialize, Serialize};

/// Most columns of places that are looked at.
const COLUMNS: u32 = 200;
/// Halvings of the step between those places in the search for the ray that is nearest to its own way back.
const HALVINGS: usize = 40;

/// What the smooth mirror of a design shows that nobody asks for. Shadows and second reflections are the witness's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct UnwantedViews {
    /// Share of the picture that is reversed against what is wanted: what it shows is seen again beside it.
    pub seen_twice: f64,
    /// The reflected ray that is nearest to the camera.
    pub own_camera: OwnCamera,
}

/// The reflected ray that is nearest to the way on which its camera ray came.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OwnCamera {
    /// Column and row of its image point, pixels from the upper left corner of the frame.
    pub pixel: [f64; 2],
    /// Angle between both, degrees: twice the angle of incidence.
    pub off_deg: f64,
    /// Distance at which it passes the middle of the entrance pupil, mm; absent of a telecentric camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passes_mm: Option<f64>,
}

impl UnwantedViews {
    /// Of a design; none without a projection, and where the camera sees nothing of the mirror.
    #[must_use]
    pub fn of(design: &Design) -> Option<Self> {
        let view = design.view.as_ref()?;
        let camera = &design.camera;
        let thinned = ThinnedFrame::at_most(camera.pixels, COLUMNS);
        let columns: Vec<usize> = thinned.columns().collect();
        let rows: Vec<usize> = thinned.rows(0..camera.pixels[1] as usize).collect();
        let places = parallel::map(rows.len(), 1, |k| {
            let at = |x: usize| camera.image_point(x as f64 + 0.5, rows[k] as f64 + 0.5);
            let images: Vec<DVec2> = columns.iter().map(|&x| at(x)).collect();
            let rays = reflected(design, &images);
            images.into_iter().zip(rays).collect::<Vec<_>>()
        });
        let shown = |row: &Vec<_>| row.iter().map(|place| Shown::of(view, place)).collect();
        let shown: Vec<Vec<_>> = places.iter().map(shown).collect();
        let off = |image: DVec2, ray: &Option<Ray>| Some((off_rad(design, image, ray)?, image));
        let all = places.iter().flatten().filter_map(|(image, ray)| off(*image, ray));
        let nearest = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let step_mm = camera.pixel_mm * f64::from(camera.pixels[0].div_ceil(COLUMNS));
        Some(Self {
            seen_twice: reversed_share(&shown),
            own_camera: own_camera(design, nearest, step_mm)?,
        })
    }
}

/// What an image point shows of what is wanted.
struct Shown {
    image: DVec2,
    /// The image point where it belongs, mm.
    content: DVec2,
    /// Number of the panel: neighbours on two panels have no common picture.
    panel: usize,
}

impl Shown {
    fn of(view: &ImagingTask, (image, ray): &(DVec2, Option<Ray>)) -> Option<Self> {
        let ray = ray.filter(|_| view.projection.wants(*image))?;
        let turn = view.turn(image.x);
        let content = view.shown_turned(ray.origin, ray.direction, (*image, turn)).image;
        let panel = view.panel_of(*image);
        content.is_finite().then_some(Self { image: *image, content, panel })
    }
}

/// Share of the cells between neighbours of rows of places whose contents go around the other way.
fn reversed_share(rows: &[Vec<Option<Shown>>]) -> f64 {
    let (mut all, mut reversed) = (0, 0);
    for pair in rows.windows(2) {
        for (upper, lower) in pair[0].windows(2).zip(pair[1].windows(2)) {
            let [Some(a), Some(b)] = upper else { continue };
            let [Some(c), Some(d)] = lower else { continue };
            if [b, c, d].iter().any(|other| other.panel != a.panel) {
                continue;
            }
            let area = |of: fn(&Shown) -> DVec2| (of(d) - of(a)).perp_dot(of(c) - of(b));
            all += 1;
            reversed += i32::from(area(|shown| shown.content) * area(|shown| shown.image) < 0.0);
        }
    }
    f64::from(reversed) / f64::from(all.max(1))
}

/// Angle between a reflected ray and the way on which its camera ray came, radians.
fn off_rad(design: &Design, image: DVec2, ray: &Option<Ray>) -> Option<f64> {
    let off = angle(ray.as_ref()?.direction, -design.camera.ray(image, 0.0).direction);
    off.is_finite().then_some(off)
}

/// The nearest ray around the nearest one of those that were looked at, which are `step_mm` apart in the picture.
fn own_camera(design: &Design, mut nearest: (f64, DVec2), mut step_mm: f64) -> Option<OwnCamera> {
    let camera = &design.camera;
    let of = |image: DVec2| reflected(design, &[image])[0].filter(|_| camera.frames(image));
    for _ in 0..HALVINGS {
        let sides = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y];
        let beside = sides.map(|side| nearest.1 + side * step_mm);
        let off = |image: &DVec2| Some((off_rad(design, *image, &of(*image))?, *image));
        match beside.iter().filter_map(off).min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some(nearer) if nearer.0 < nearest.0 => nearest = nearer,
            _ => step_mm *= 0.5,
        }
    }
    let (off, image) = nearest;
    let Ray { origin, direction } = of(image)?;
    let passes_mm = design.mounting.pupil_mm.map(|pupil| {
        let way = DVec3::from_array(pupil) - origin;
        way.cross(direction).length()
    });
    Some(OwnCamera { pixel: camera.picture_point(image), off_deg: degrees(off), passes_mm })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::design;
    use crate::num::{radians, sin};
    use crate::profile::Profile;

    fn views(text: &str) -> (Design, UnwantedViews) {
        let profile = Profile::parse("p", "p.toml", text.as_bytes());
        let design = design(&profile.unwrap_or_else(|error| panic!("{error}\n{text}"))).unwrap();
        let found = UnwantedViews::of(&design).unwrap();
        (design, found)
    }

    /// Under parallel rays f = c r^4 - 90 c r^2 bends the picture back where f'' has changed its sign and f' has not:
    /// between r^2 = 15 and 45 of 100.
    #[test]
    fn a_wave_shows_again_what_is_between_its_turns() {
        let (_, found) = views(
            "camera.orthographic.pixels = [400, 400]\nprojection.equiangular.outer_polar_deg = 60\n\
             layout.disc = {}\nmirror.polynomial.terms = [[2, 0, -9e-3], [0, 2, -9e-3], [4, 0, 1e-4], [2, 2, 2e-4], \
             [0, 4, 1e-4]]\npart = { width_mm = 20, base_mm = 2 }\nmesh.chord_um = 5\nexport.formats = [\"stl\"]\n",
        );
        // Cells across the two circles, 2.7 % of the disc, count in whole or not at all.
        assert!((found.seen_twice - 0.3).abs() < 1.35e-2, "{found:?}");
        let OwnCamera { pixel, off_deg, passes_mm } = found.own_camera;
        assert!(off_deg < 1e-9 && passes_mm.is_none(), "{found:?}");
        // All around the valley at r^2 = 45 too.
        let from_middle = DVec2::new(pixel[0] - 200.0, pixel[1] - 200.0).length() / 20.0;
        let off = from_middle.min((from_middle - f64::sqrt(45.0)).abs());
        assert!(off < 1e-6, "{pixel:?}");
    }

    /// A flat mirror sends each ray back by twice the angle to its normal, as if from the pupil's image behind it.
    #[test]
    fn a_flat_mirror_off_the_axis_does_not_show_the_camera() {
        let text = |fold: f64| {
            format!(
                "camera.pinhole = {{ pixels = [320, 240], hfov_deg = 20, distance_mm = 60 }}\n\
                 mount = {{ fold_deg = {fold}, towards_deg = 90 }}\nprojection.perspective.hfov_deg = 20\n\
                 layout.rectangle = {{}}\nmirror.polynomial.radius_mm = 1e12\n\
                 part = {{ width_mm = 60, height_mm = 60, base_mm = 2 }}\nmesh.chord_um = 5\nexport.formats = [\"stl\"]\n"
            )
        };
        for fold in [30.0, 50.0] {
            let (design, found) = views(&text(fold));
            let OwnCamera { pixel, off_deg, passes_mm } = found.own_camera;
            let nearest_deg = 0.5 * fold - 10.0;
            assert!((off_deg - 2.0 * nearest_deg).abs() < 1e-6, "{found:?}");
            assert!((pixel[0] - 160.0).abs() > 159.999 && (pixel[1] - 120.0).abs() < 1e-3);
            let [.., pupil] = design.mounting.pupil_mm.unwrap();
            let passes = 2.0 * (pupil - design.mounting.mean_mm) * sin(radians(nearest_deg));
            assert!((passes_mm.unwrap() - passes).abs() < 1e-5 * passes, "{found:?} {passes}");
            assert_eq!(found.seen_twice, 0.0);
        }
        let (_, found) = views(&text(12.0));
        assert!(found.own_camera.off_deg < 1e-6 && found.own_camera.passes_mm.unwrap() < 1e-6);
    }
}
