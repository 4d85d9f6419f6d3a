//! The laws of strips that a profile can ask for.

use super::Cause;
use super::best::Search;
use crate::num::radians;
use crate::optics::{Camera, Field, Ladder, Law, Target};
use crate::profile::{StripLaw, StripProjection};
use std::sync::Arc;

/// Where a strip's panel lies in the image.
#[derive(Debug, Clone, Copy)]
pub struct Panel<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Where the world is, its origin on the camera's reference plane.
    pub target: Target,
    /// mm per radian of azimuth.
    pub scale_mm: f64,
    /// Azimuth at X = 0, radians.
    pub azimuth: f64,
    /// Azimuth across the panel, radians.
    pub across: f64,
    /// Share of the panel's height below Y = 0.
    pub below: f64,
}

/// The law and the range of its coordinate z (paper's units) from the lowest to the highest row.
///
/// # Errors
/// [`Cause::Law`] when there is none.
pub fn law(wanted: &StripProjection, panel: &Panel) -> Result<(Law, [f64; 2]), Cause> {
    let law = match &wanted.law {
        StripLaw::Cylindrical => Law::Cylindrical,
        StripLaw::Mercator => Law::Mercator,
        StripLaw::Equirectangular => Law::Equirectangular,
        StripLaw::EqualArea => Law::EqualArea,
        StripLaw::Best => {
            let (ladder, height) = best(wanted, panel).law()?;
            return Ok((Law::Ladder(Arc::new(ladder)), [0.0, height]));
        }
        StripLaw::Table(rows) => return table(rows, panel.camera.pixel_mm / panel.scale_mm),
    };
    let z = wanted.elevation_deg.map(|e| law.image_of_degrees(e));
    Ok((law, z))
}

fn best<'a>(wanted: &StripProjection, panel: &Panel<'a>) -> Search<'a> {
    Search {
        field: Field { chart: &panel.camera.chart, target: panel.target, origin_mm: 0.0 },
        scale_mm: panel.scale_mm,
        azimuth: panel.azimuth,
        across: panel.across,
        elevation_deg: wanted.elevation_deg,
        below: panel.below,
    }
}

/// The law through rows (pixels down the picture) and elevations (degrees), for pixels of `pixel`
/// in the paper's units.
fn table(rows: &[[f64; 2]], pixel: f64) -> Result<(Law, [f64; 2]), Cause> {
    let z: Vec<f64> = rows.iter().rev().map(|[row, _]| -row * pixel).collect();
    let elevations: Vec<f64> = rows.iter().rev().map(|[_, e]| radians(*e)).collect();
    let ladder = Ladder::of_elevations(&z, &elevations).ok_or(Cause::Table)?;
    Ok((Law::Ladder(Arc::new(ladder)), [z[0], z[z.len() - 1]]))
}

#[cfg(test)]
mod tests {
    use super::super::layout::{Plan, Ties};
    use super::super::{Design, design};
    use super::*;
    use crate::geom::{DVec2, DVec3, Outline};
    use crate::num::{atan2, degrees};
    use crate::optics::Projection;
    use crate::profile::Profile;

    const PARALLEL: &str = "camera.orthographic.pixels = [640, 480]";
    const PINHOLE: &str =
        "camera.pinhole = { pixels = [640, 480], focal_px = 1600, distance_mm = 150 }";
    const STRIP: &str = "layout.strip = {}";

    fn profile(camera: &str, law: &str, elevation: &str, layout: &str) -> Profile {
        let text = format!(
            "{camera}\nprojection.{law} = {{ azimuth_deg = [-180, 180], elevation_deg = {elevation} \
             }}\n{layout}\nmethod.vector-field.degree = 10\npart = {{ width_mm = 60, base_mm = 5 }}\n\
             mesh.chord_um = 2\nexport.formats = [\"stl\"]\n"
        );
        Profile::parse("p", "p.toml", text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"))
    }

    fn designed(camera: &str, law: &str, elevation: &str, layout: &str) -> Design {
        design(&profile(camera, law, elevation, layout), None).unwrap()
    }

    /// Largest difference between the mirrors' heights over the first one's panel, mm.
    fn apart(a: &Design, b: &Design) -> f64 {
        let z = |d: &Design, q: DVec2| d.mirror.surface.at(q).f + d.mirror.chart.plane_mm;
        let places = a.mirror.outline.samples(40).into_iter().flatten();
        places.map(|(q, _)| (z(a, q) - z(b, q)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn best_far_away_is_mercator() {
        for layout in [STRIP, "layout.conquistador = { panel = \"refit\", ridge = \"valley\" }"] {
            let [best, mercator] =
                ["best", "mercator"].map(|law| designed(PARALLEL, law, "[-35, 30]", layout));
            assert!(apart(&best, &mercator) < 1e-10, "{:e}", apart(&best, &mercator));
            assert!(best.facts.curl.unwrap().max < 1e-12);
        }
    }

    #[test]
    fn best_has_less_curl_on_the_mirror_too() {
        let (far, near) = ("[-20, 35]", "[-20, 35], target_radius_mm = 90");
        for (camera, range) in [(PINHOLE, far), (PARALLEL, near), (PINHOLE, near)] {
            let [best, others @ ..] = ["best", "cylindrical", "mercator", "equirectangular"]
                .map(|law| designed(camera, law, range, STRIP).facts.curl.unwrap().rms);
            assert!(others.iter().all(|rms| best < *rms), "{camera} {best:e} {others:?}");
        }
    }

    #[test]
    fn the_panel_lies_where_the_search_had_it() {
        let folded = |ridge: &str| {
            format!("layout.conquistador = {{ panel = \"refit\", ridge = \"{ridge}\" }}")
        };
        for (layout, below) in
            [(STRIP.to_owned(), 0.5), (folded("crest"), 0.0), (folded("valley"), 1.0)]
        {
            let profile = profile(PINHOLE, "best", "[-20, 35]", &layout);
            let plan = Plan::new(&profile, &Ties::new(&profile)).unwrap().unwrap();
            let (Projection::Strip(strip), Outline::Rect(panel)) =
                (&plan.view.projection, plan.outline)
            else {
                panic!("a strip");
            };
            let height = panel.size().y;
            assert!((panel.min.y + below * height).abs() < 1e-12);
            assert!((strip.z * strip.scale_mm - below * height).abs() < 1e-12);
        }
    }

    #[test]
    fn a_table_of_a_law_gives_its_mirror() {
        let scale_px = 640.0 / std::f64::consts::TAU;
        let row = |e: &f64| format!("[{:?}, {e:?}]", -radians(*e) * scale_px + 7.0);
        let rows: Vec<String> = [30.0, 22.0, 3.5, -1.0, -40.0].iter().map(row).collect();
        let table = designed(PARALLEL, "table", &format!("[{}]", rows.join(", ")), STRIP);
        let law = designed(PARALLEL, "equirectangular", "[-40, 30]", STRIP);
        assert!(apart(&table, &law) < 1e-10, "{:e}", apart(&table, &law));
    }

    #[test]
    fn rows_see_their_elevations() {
        let rows = [[0.0, 41.0], [30.0, 39.0], [31.0, 33.0], [90.0, 0.0], [215.0, -28.5]];
        for camera in [PARALLEL, PINHOLE] {
            let found = designed(camera, "table", &format!("{rows:?}"), STRIP);
            for [row, elevation] in rows {
                let y = (0.5 * 215.0 - row) * found.camera.pixel_mm;
                let seen = found.view.as_ref().unwrap().wanted(DVec2::new(3.0, y), DVec3::ZERO);
                let off = degrees(atan2(seen.z, seen.truncate().length())) - elevation;
                assert!(off.abs() < 1e-11, "row {row}: {off:e}");
            }
        }
    }
}
