//! The laws of strips that a profile can ask for.

use super::FailureCause;
use super::least_curl_law::LeastCurlProblem;
use crate::num::radians;
use crate::optics::{Camera, SlopeField, StripLaw, TabulatedLaw, Target};
use crate::profile::{StripLawSpec, StripSpec};
use std::sync::Arc;

/// Place of a strip's panel in the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct StripPanel<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Surface that the picture shows, its origin on the camera's reference plane.
    pub target: &'a Target,
    /// mm per radian of azimuth.
    pub scale_mm: f64,
    /// Azimuth at X = 0, radians.
    pub azimuth: f64,
    /// Azimuth across the panel, radians.
    pub across: f64,
    /// Share of the panel's height below Y = 0.
    pub below: f64,
}

/// The law and the range of its coordinate z (paper's units) from the lowest to the highest row: of what
/// `wanted` asks for, or, `high` in z, about the middle of that (the middle isometric latitude where the
/// law is to be found).
///
/// # Errors
/// [`FailureCause::LeastCurl`] when there is none.
pub(super) fn strip_law(
    wanted: &StripSpec,
    panel: &StripPanel,
    high: Option<f64>,
) -> Result<(StripLaw, [f64; 2]), FailureCause> {
    let law = match &wanted.law {
        StripLawSpec::Named(law) => law.clone(),
        StripLawSpec::LeastCurl => {
            let search = least_curl_problem(wanted, panel);
            let (table, height) = match high {
                Some(high) => search.filling(high)?,
                None => search.law()?,
            };
            return Ok((StripLaw::Tabulated(Arc::new(table)), [0.0, height]));
        }
        StripLawSpec::Table(rows) => {
            let (law, z) = tabulated(rows, panel.camera.pixel_mm / panel.scale_mm)?;
            return Ok((law, centred_range(z, high)));
        }
    };
    let z = wanted.elevation_deg.map(|e| law.image_of_degrees(e));
    Ok((law, centred_range(z, high)))
}

/// The range `z`, or one `high` about its middle.
fn centred_range(z: [f64; 2], high: Option<f64>) -> [f64; 2] {
    let Some(high) = high else { return z };
    let middle = 0.5 * (z[0] + z[1]);
    [middle - 0.5 * high, middle + 0.5 * high]
}

fn least_curl_problem<'a>(wanted: &StripSpec, panel: &StripPanel<'a>) -> LeastCurlProblem<'a> {
    LeastCurlProblem {
        field: SlopeField { chart: &panel.camera.chart, target: panel.target, origin_mm: 0.0 },
        scale_mm: panel.scale_mm,
        azimuth: panel.azimuth,
        across: panel.across,
        elevation_deg: wanted.elevation_deg,
        below: panel.below,
    }
}

/// The law through rows (pixels down the picture) and elevations (degrees), for pixels of `pixel`
/// in the paper's units.
fn tabulated(rows: &[[f64; 2]], pixel: f64) -> Result<(StripLaw, [f64; 2]), FailureCause> {
    let z: Vec<f64> = rows.iter().rev().map(|[row, _]| -row * pixel).collect();
    let elevations: Vec<f64> = rows.iter().rev().map(|[_, e]| radians(*e)).collect();
    let table =
        TabulatedLaw::from_elevations(&z, &elevations).ok_or(FailureCause::DegenerateTable)?;
    Ok((StripLaw::Tabulated(Arc::new(table)), [z[0], z[z.len() - 1]]))
}

#[cfg(test)]
mod tests {
    use super::super::layout::{DesignProblem, SelfConsistentGeometry};
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
        design(&profile(camera, law, elevation, layout)).unwrap()
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

    /// The law that fills the frame is the one between the elevations that it then shows.
    #[test]
    fn best_fills_the_frame_with_the_law_of_its_own_elevations() {
        const LOW: &str =
            "camera.pinhole = { pixels = [640, 200], focal_px = 1600, distance_mm = 150 }";
        for (camera, layout, rows) in [
            (PARALLEL, "layout.conquistador = { panel = \"refit\"", 240.0),
            (PINHOLE, "layout.conquistador = { ridge = \"valley\"", 240.0),
            (LOW, "layout.strip = { fill_frame = false", 200.0),
        ] {
            let fills = match layout.strip_suffix("fill_frame = false") {
                Some(strip) => format!("{strip}fill_frame = true }}"),
                None => format!("{layout}, fill_frame = true }}"),
            };
            let filled = designed(camera, "best", "[-31, 29]", &fills);
            let high = rows * filled.camera.pixel_mm;
            let bounds = filled.mirror.outline.bounds();
            assert!((bounds.size().y / high - 1.0).abs() < 1e-6, "{layout}");
            // What the rows at the edges show.
            let view = filled.view.as_ref().unwrap();
            let ends = [bounds.min.y, bounds.max.y].map(|y| {
                let seen = view.direction_of(DVec2::new(3.0, y), DVec3::ZERO);
                degrees(atan2(seen.z, seen.truncate().length()))
            });
            assert!(ends[1] - ends[0] > 30.0, "{ends:?}");
            let same = designed(camera, "best", &format!("{ends:?}"), &format!("{layout} }}"));
            assert!(apart(&filled, &same) < 1e-5, "{layout} {:e}", apart(&filled, &same));
        }
    }

    #[test]
    fn a_table_higher_than_the_frame_fills_it_with_its_middle_rows() {
        let row = |k: i32| format!("[{}, {:?}]", 20 * k, 60.0 - 4.0 * f64::from(k));
        let rows: Vec<String> = (0..=26).map(row).collect();
        let layout = "layout.strip.fill_frame = true";
        let found = designed(PARALLEL, "table", &format!("[{}]", rows.join(", ")), layout);
        assert!((found.mirror.outline.bounds().size().y - 45.0).abs() < 1e-5);
        // Row 260 of 0 to 520 is in the middle.
        let seen = found.view.as_ref().unwrap().direction_of(DVec2::new(3.0, 0.0), DVec3::ZERO);
        let elevation = degrees(atan2(seen.z, seen.truncate().length()));
        assert!((elevation - 8.0).abs() < 1e-9, "{elevation}");
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
            let problem = DesignProblem::new(&profile, &SelfConsistentGeometry::initial(&profile))
                .unwrap()
                .unwrap();
            let (Projection::Strip(strip), Outline::Rect(panel)) =
                (&problem.view.projection, problem.outline)
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
                let seen =
                    found.view.as_ref().unwrap().direction_of(DVec2::new(3.0, y), DVec3::ZERO);
                let off = degrees(atan2(seen.z, seen.truncate().length())) - elevation;
                assert!(off.abs() < 1e-11, "row {row}: {off:e}");
            }
        }
    }
}
