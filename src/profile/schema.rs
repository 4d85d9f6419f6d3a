//! Tables that a file may have, and the keys of each: those of a profile.

use crate::tolerance_terms::Perturbation;

const STRIP: &[&str] = &["azimuth_deg", "elevation_deg", "target_radius_mm", "target_plane_mm"];
const TABLE: &[&str] =
    &["azimuth_deg", "elevation_deg", "polar_deg", "target_radius_mm", "target_plane_mm"];
const ONE_PARAMETER: &[&str] = &["outer_polar_deg", "target_radius_mm", "target_plane_mm"];
const TWO_PARAMETERS: &[&str] =
    &["inner_polar_deg", "outer_polar_deg", "target_radius_mm", "target_plane_mm"];
const PERSPECTIVE: &[&str] =
    &["centre_deg", "hfov_deg", "roll_deg", "mirrored", "target_radius_mm", "target_plane_mm"];
const FISHEYE: &[&str] = &[
    "law",
    "centre_deg",
    "hfov_deg",
    "roll_deg",
    "mirrored",
    "target_radius_mm",
    "target_plane_mm",
];
const PANEL: &[&str] =
    &["columns", "rows", "law", "centre_deg", "hfov_deg", "roll_deg", "mirrored", "file"];
const METHOD: &[&str] = &["degree", "minimax"];
/// Error sources, each with its unit.
const SOURCES: &[&str] = Perturbation::KEYS;

/// Keys that most profiles do without.
const RARE: &[&str] = &[
    "hfov_deg",
    "lens_mm",
    "pixel_um",
    "na",
    "f_number",
    "pupil_mm",
    "wavelength_nm",
    "body_mm",
    "model",
    "principal_px",
    "distortion",
    "target_radius_mm",
    "target_plane_mm",
    "inner_polar_deg",
    "minimax",
    "centre_deg",
    "roll_deg",
    "mirrored",
    "shift_mm",
    "height_mm",
    "max_triangles",
    "border_mm",
    "rim_mm",
    "corner_radius_mm",
    "edge_chamfer_mm",
    "holes_mm",
    "marks_mm",
    "shell_mm",
    "drains_mm",
    "form",
    "thread_depth_mm",
    "bottom",
    "counterbore_diameter_mm",
    "counterbore_depth_mm",
    "chamfer_mm",
    "sag",
    "step",
    "paper",
    "revision",
    "imperfections",
    "texture",
    "general_tolerance",
    "work_offset",
    "polish_um",
    "flute_mm",
    "shank_diameter_mm",
    "stickout_mm",
    "rough_ball_mm",
    "rough_flute_mm",
    "rough_shank_diameter_mm",
    "rough_stickout_mm",
    "inner_edge_deg",
    "outer_edge_deg",
    "stepdown_mm",
    "teeth",
    "rough_feed_mm_min",
    "rough_feed_mm_rev",
    "rapid_mm_min",
    "max_feed_mm_min",
    "max_spindle_rpm",
    "acceleration_mm_s2",
    "jerk_mm_s3",
    "travel_mm",
    "safe_mm",
    "holder_diameter_mm",
];

/// Tables that a kind of file may have.
#[derive(Clone, Copy)]
pub(super) struct Schema {
    /// What the whole file is called.
    pub whole: &'static str,
    /// Every table by its path, and its keys. The file itself is the empty path.
    pub tables: &'static [(&'static str, &'static [&'static str])],
    /// Tables of which a file may have several, each written `[[path]]`.
    pub lists: &'static [&'static str],
}

/// The tables of a profile.
pub(super) const PROFILE: Schema = Schema { whole: "the profile", tables: TABLES, lists: LISTS };

/// Every table of a profile by its path, and its keys. The profile itself is the empty path.
pub(crate) const TABLES: &[(&str, &[&str])] = &[
    (
        "",
        &[
            "summary",
            "camera",
            "mount",
            "projection",
            "panel",
            "target",
            "obstacle",
            "hole",
            "layout",
            "method",
            "mirror",
            "part",
            "forming",
            "mesh",
            "export",
            "drawing",
            "program",
            "accept",
            "tolerance",
        ],
    ),
    ("camera", &["orthographic", "pinhole", "calibrated"]),
    ("camera.orthographic", &["pixels", "na", "wavelength_nm"]),
    (
        "camera.pinhole",
        &[
            "pixels",
            "focal_px",
            "hfov_deg",
            "lens_mm",
            "pixel_um",
            "distance_mm",
            "f_number",
            "pupil_mm",
            "wavelength_nm",
            "body_mm",
        ],
    ),
    ("mount", &["fold_deg", "towards_deg", "shift_mm"]),
    (
        "camera.calibrated",
        &[
            "file",
            "model",
            "pixels",
            "focal_px",
            "principal_px",
            "distortion",
            "distance_mm",
            "lens_mm",
            "f_number",
            "pupil_mm",
            "wavelength_nm",
            "body_mm",
        ],
    ),
    (
        "projection",
        &[
            "cylindrical",
            "mercator",
            "equirectangular",
            "equal-area",
            "best",
            "table",
            "parabolic",
            "hyperbolic",
            "conical",
            "equiangular",
            "tangent-proportional",
            "area-proportional",
            "plane",
            "equi-areal",
            "cylinder",
            "perspective",
            "fisheye",
            "map",
        ],
    ),
    ("projection.cylindrical", STRIP),
    ("projection.mercator", STRIP),
    ("projection.equirectangular", STRIP),
    ("projection.equal-area", STRIP),
    ("projection.best", STRIP),
    ("projection.table", TABLE),
    ("projection.parabolic", ONE_PARAMETER),
    ("projection.hyperbolic", ONE_PARAMETER),
    ("projection.conical", ONE_PARAMETER),
    ("projection.equiangular", TWO_PARAMETERS),
    ("projection.tangent-proportional", TWO_PARAMETERS),
    ("projection.area-proportional", TWO_PARAMETERS),
    ("projection.plane", ONE_PARAMETER),
    ("projection.equi-areal", TWO_PARAMETERS),
    ("projection.cylinder", TWO_PARAMETERS),
    ("projection.perspective", PERSPECTIVE),
    ("projection.fisheye", FISHEYE),
    ("projection.map", &["file", "kind", "target_radius_mm", "target_plane_mm"]),
    ("panel", PANEL),
    ("target", &["plane", "sphere", "cylinder", "mesh"]),
    ("target.plane", &["point_mm", "normal", "viewpoint_mm"]),
    ("target.sphere", &["centre_mm", "radius_mm", "viewpoint_mm"]),
    ("target.cylinder", &["point_mm", "axis", "radius_mm", "viewpoint_mm"]),
    ("target.mesh", &["file", "unit_mm", "viewpoint_mm"]),
    ("layout", &["strip", "conquistador", "disc", "annulus", "rectangle"]),
    ("layout.strip", &["fill_frame"]),
    ("layout.conquistador", &["panel", "ridge", "fill_frame"]),
    ("layout.disc", &[]),
    ("layout.annulus", &["inner_width_mm"]),
    ("layout.rectangle", &[]),
    ("method", &["vector-field", "fixed-surface", "distribution"]),
    ("method.vector-field", METHOD),
    ("method.fixed-surface", METHOD),
    ("method.distribution", METHOD),
    ("mirror", &["polynomial", "grid"]),
    ("mirror.polynomial", &["radius_mm", "conic", "terms"]),
    ("mirror.grid", &["file"]),
    (
        "part",
        &[
            "width_mm",
            "base_mm",
            "height_mm",
            "border_mm",
            "rim_mm",
            "corner_radius_mm",
            "edge_chamfer_mm",
            "holes_mm",
            "marks_mm",
            "shell_mm",
            "drains_mm",
            "form",
        ],
    ),
    (
        "forming",
        &["sheet_mm", "mirror_side", "shrinkage_ppm", "draft_deg", "back_mm", "vents", "vent_mm"],
    ),
    ("mesh", &["chord_um", "facet_px", "max_triangles"]),
    ("export", &["formats", "sag", "step"]),
    ("export.step", &["schema"]),
    ("export.sag", &["path", "pitch_mm", "step_mm"]),
    (
        "drawing",
        &[
            "paper",
            "projection",
            "owner",
            "number",
            "revision",
            "title",
            "material",
            "coating",
            "imperfections",
            "texture",
            "general_tolerance",
            "creator",
            "approver",
            "date",
        ],
    ),
    ("accept", &["pixel_error_rms_px", "pixel_error_max_px", "frame_filled", "blur_p95_px"]),
    (
        "tolerance",
        &[
            "preset",
            "budget_px",
            "budget_blur_px",
            "criterion",
            "reference",
            "form",
            "target_yield",
            "made_from",
            "compensators",
            "expansion_ppm_per_k",
            "waviness_period_mm",
            "waviness_direction_deg",
            "slope_correlation_mm",
            "ball_radius_mm",
            "stepover_direction_deg",
            "map_file",
            "limits",
            "distributions",
            "weights",
        ],
    ),
    ("tolerance.limits", SOURCES),
    ("tolerance.distributions", SOURCES),
    ("tolerance.weights", SOURCES),
    ("obstacle", &["name", "box", "cylinder", "tube", "stl"]),
    ("obstacle.box", &["centre_mm", "size_mm"]),
    ("obstacle.cylinder", &["from_mm", "to_mm", "radius_mm", "solid"]),
    ("obstacle.tube", &["from_mm", "to_mm", "inner_radius_mm", "outer_radius_mm"]),
    ("obstacle.stl", &["file"]),
    (
        "hole",
        &[
            "at_mm",
            "diameter_mm",
            "thread",
            "screw",
            "dowel_mm",
            "depth_mm",
            "thread_depth_mm",
            "bottom",
            "counterbore_diameter_mm",
            "counterbore_depth_mm",
            "chamfer_mm",
        ],
    ),
    (
        "program",
        &[
            "machine",
            "material",
            "control",
            "work_offset",
            "stock_mm",
            "ball_mm",
            "nose_mm",
            "inner_edge_deg",
            "outer_edge_deg",
            "clearance_deg",
            "path",
            "stepover_mm",
            "feed_mm_rev",
            "scallop_um",
            "budget_px",
            "angle_deg",
            "chord_um",
            "polish_um",
            "flute_mm",
            "shank_diameter_mm",
            "stickout_mm",
            "rough_ball_mm",
            "rough_radius_mm",
            "rough_corner_mm",
            "rough_flute_mm",
            "rough_shank_diameter_mm",
            "rough_stickout_mm",
            "allowance_mm",
            "stepdown_mm",
            "teeth",
            "feed_mm_min",
            "rough_feed_mm_min",
            "rough_feed_mm_rev",
            "spindle_rpm",
            "rapid_mm_min",
            "max_feed_mm_min",
            "max_spindle_rpm",
            "acceleration_mm_s2",
            "jerk_mm_s3",
            "travel_mm",
            "safe_mm",
            "holder_diameter_mm",
        ],
    ),
];

/// Tables of which a profile may have several, each written `[[path]]`.
pub(crate) const LISTS: &[&str] = &["hole", "obstacle", "panel"];

impl Schema {
    /// The keys of a table; none for a path that is no table.
    pub(super) fn keys(self, path: &str) -> &'static [&'static str] {
        self.tables.iter().find(|(table, _)| *table == path).map_or(&[], |(_, keys)| keys)
    }

    /// Whether a path is that of a table.
    pub(super) fn is_table(self, path: &str) -> bool {
        self.tables.iter().any(|(table, _)| *table == path)
    }

    /// The keys of a table that are tables themselves.
    pub(super) fn below(self, path: &str) -> Vec<&'static str> {
        let is_table = |key: &&str| self.is_table(&format!("{path}.{key}"));
        self.keys(path).iter().copied().filter(is_table).collect()
    }

    /// The keys of a table that most files use.
    pub(super) fn usual_keys(self, path: &str) -> Vec<&'static str> {
        self.keys(path).iter().copied().filter(|key| !RARE.contains(key)).collect()
    }

    /// How the heading of a table is written.
    pub(super) fn heading(self, path: &str) -> String {
        if self.lists.contains(&path) { format!("[[{path}]]") } else { format!("[{path}]") }
    }

    /// The first table that has a key of this name.
    pub(super) fn home(self, key: &str) -> Option<&'static str> {
        let mut tables = self.tables.iter();
        let found = tables.find(|(table, keys)| !table.is_empty() && keys.contains(&key));
        found.map(|(table, _)| *table)
    }
}

/// Hint for an unknown key in a table; empty if there is none.
pub(super) fn note(path: &str) -> &'static str {
    if path == "layout.disc" { "the disc's diameter is part.width_mm" } else { "" }
}

/// The word that `found` was probably meant to be.
pub(super) fn nearest<'w>(found: &str, words: &[&'w str]) -> Option<&'w str> {
    let found = found.to_lowercase().replace('-', "_");
    let slip = words
        .iter()
        .map(|w| (strsim::osa_distance(&found, &w.replace('-', "_")), *w))
        .filter(|(distance, w)| *distance <= (w.len() / 3).max(1))
        .min_by_key(|(distance, _)| *distance);
    let start = |w: &&&str| found.len() >= 3 && (w.starts_with(&found) || found.starts_with(**w));
    slip.map(|(_, w)| w).or_else(|| words.iter().find(start).copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_hangs_on_its_parent() {
        for (path, _) in TABLES.iter().filter(|(path, _)| !path.is_empty()) {
            let (parent, key) = path.rsplit_once('.').unwrap_or(("", path));
            assert!(PROFILE.keys(parent).contains(&key), "{path}");
        }
    }

    /// `docs/profile.md` has a row for each key, and no other.
    #[test]
    fn the_page_of_keys_has_them_all() {
        let page = include_str!("../../docs/profile.md");
        let rows = page.lines().filter_map(|line| line.strip_prefix("| `")?.split_once('`'));
        let mut told: Vec<String> = rows.map(|(key, _)| key.to_owned()).collect();
        let path = |table: &str, key: &str| match table {
            "" => key.to_owned(),
            table => format!("{table}.{key}"),
        };
        let all = TABLES.iter().flat_map(|(table, keys)| keys.iter().map(|key| path(table, key)));
        let is_table = |path: &str| TABLES.iter().any(|(table, _)| *table == path);
        let mut known: Vec<String> = all.filter(|path| !is_table(path)).collect();
        told.sort();
        known.sort();
        assert_eq!(told, known);
    }

    #[test]
    fn usual_keys_leave_the_rare_ones_out() {
        assert_eq!(PROFILE.usual_keys("part"), ["width_mm", "base_mm"]);
        assert_eq!(PROFILE.usual_keys("camera.pinhole"), ["pixels", "focal_px", "distance_mm"]);
        for rare in RARE {
            assert!(PROFILE.home(rare).is_some(), "{rare}");
        }
    }

    #[test]
    fn near_words_are_found_and_far_ones_are_not() {
        let part = PROFILE.keys("part");
        assert_eq!(nearest("widht_mm", part), Some("width_mm"));
        assert_eq!(nearest("width", part), Some("width_mm"));
        assert_eq!(nearest("colour", part), None);
        assert_eq!(nearest("cylinderical", PROFILE.keys("projection")), Some("cylindrical"));
        assert_eq!(nearest("equi", PROFILE.keys("projection")), Some("equirectangular"));
        assert_eq!(nearest("STL", &["obj", "stl"]), Some("stl"));
        assert_eq!(nearest("step", &["obj", "stl"]), None);
        assert_eq!(nearest("vector_field", PROFILE.keys("method")), Some("vector-field"));
        assert_eq!(nearest("", part), None);
    }

    #[test]
    fn keys_know_their_table() {
        assert_eq!(PROFILE.home("degree"), Some("method.vector-field"));
        assert_eq!(PROFILE.home("height_mm"), Some("part"));
        assert_eq!(PROFILE.home("colour"), None);
    }
}
