//! Profiles of parts with a flat rim, of every layout.

pub const STRIP: &str = "
camera.orthographic.pixels = [640, 480]
projection.cylindrical = { azimuth_deg = [-90, 90], elevation_deg = [-20, 20] }
layout.strip = {}
method.vector-field.degree = 8
mesh.facet_px = 6
export.formats = [\"stl\", \"obj\"]
";
pub const CONQUISTADOR: &str = "
camera.orthographic.pixels = [640, 480]
projection.mercator = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }
layout.conquistador.fill_frame = true
method.vector-field.degree = 10
mesh.facet_px = 6
export.formats = [\"stl\", \"obj\"]
";
pub const DISC: &str = "
camera.orthographic.pixels = [400, 400]
projection.parabolic.outer_polar_deg = 100
layout.disc = {}
method.vector-field.degree = 8
mesh.chord_um = 20
export.formats = [\"stl\", \"obj\"]
";
pub const ANNULUS: &str = "
camera.pinhole = { pixels = [480, 480], focal_px = 800, distance_mm = 100 }
projection.area-proportional = { inner_polar_deg = 20, outer_polar_deg = 100 }
layout.annulus.inner_width_mm = 16
method.vector-field.degree = 24
mesh.chord_um = 20
export.formats = [\"stl\", \"obj\"]
";
/// A strip whose footprint has curved sides.
pub const PINHOLE: &str = "
camera.pinhole = { pixels = [640, 480], focal_px = 1600, distance_mm = 150 }
projection.mercator = { azimuth_deg = [-90, 90], elevation_deg = [-20, 20] }
layout.strip = {}
method.vector-field.degree = 10
mesh.facet_px = 6
export.formats = [\"stl\", \"obj\"]
";
pub const GIVEN: &str = "
camera.orthographic.pixels = [640, 480]
mirror.polynomial = { radius_mm = -80, terms = [[3, 0, 1e-5], [0, 1, 0.01]] }
mesh.chord_um = 20
export.formats = [\"stl\", \"obj\"]
";

pub const PLAIN: &str = "width_mm = 60, base_mm = 12, border_mm = 8";
pub const ROUNDED: &str = "width_mm = 60, base_mm = 12, border_mm = 8, corner_radius_mm = 6, rim_mm = 3, \
    edge_chamfer_mm = 0.75";
/// Four holes and three marks beside a rectangle 60 mm wide.
pub const SIDES: &str = "width_mm = 60, base_mm = 12, border_mm = 9, corner_radius_mm = 4, rim_mm = 3.1, \
    holes_mm = [[34.5, 3, 3.3], [-34.5, 5, 3.3], [-34.5, -4, 4], [34.5, -4, 5.5]], \
    marks_mm = [[34.5, 7, 1], [-34.5, 9, 1.5], [-34.5, 0, 0.7]]";
/// The same around a circle, with chamfered edges.
pub const AROUND: &str = "width_mm = 60, base_mm = 12, border_mm = 9, rim_mm = 3.1, edge_chamfer_mm = 0.5, \
    holes_mm = [[34.5, 3, 3.3], [-34.5, 5, 3.3], [0, -35, 4], [0, 35, 5.5]], \
    marks_mm = [[24, 24, 1], [-24, 24, 1.5], [-24, -24, 0.7]]";

/// The case's name, its profile without the part and the part.
pub fn cases() -> Vec<(&'static str, String)> {
    let with = |what, text: &str, part: &str| (what, format!("{text}part = {{ {part} }}\n"));
    vec![
        with("strip, plain", STRIP, PLAIN),
        with("strip, holes", STRIP, SIDES),
        with("conquistador, rounded", CONQUISTADOR, ROUNDED),
        with("conquistador, holes", CONQUISTADOR, SIDES),
        with("disc, plain", DISC, PLAIN),
        with("disc, holes", DISC, AROUND),
        with("annulus, plain", ANNULUS, PLAIN),
        with("annulus, holes", ANNULUS, AROUND),
        with(
            "annulus, land",
            ANNULUS,
            &AROUND.replace("[[34.5, 3", "[[0, 0, 6], [-5, 2, 2], [34.5, 3"),
        ),
        with("pinhole, rounded", PINHOLE, ROUNDED),
        // Where the part is 60 mm wide at the camera's distance, the strip's ends are farther out.
        with("pinhole, holes", PINHOLE, &SIDES.replace("34.5", "36.5")),
        with("given, rounded", GIVEN, &format!("{ROUNDED}, height_mm = 40")),
        with("given, holes", GIVEN, &format!("{SIDES}, height_mm = 40")),
    ]
}

/// The profile of one case.
pub fn case(name: &str) -> String {
    let found = cases().into_iter().find(|(what, _)| *what == name);
    found.unwrap_or_else(|| panic!("no case {name}")).1
}
