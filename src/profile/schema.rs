//! Which tables a profile may have, and which keys each of them.

/// Every table by its path, and its keys. The profile itself is the empty path.
pub(super) const TABLES: &[(&str, &[&str])] = &[
    (
        "",
        &[
            "summary",
            "camera",
            "projection",
            "layout",
            "method",
            "part",
            "mesh",
            "export",
            "accept",
        ],
    ),
    ("camera", &["orthographic"]),
    ("camera.orthographic", &["pixels"]),
    ("projection", &["cylindrical", "mercator"]),
    ("projection.cylindrical", &["azimuth_deg", "elevation_deg"]),
    ("projection.mercator", &["azimuth_deg", "elevation_deg"]),
    ("layout", &["strip", "conquistador"]),
    ("layout.strip", &["fill_frame"]),
    ("layout.conquistador", &["panel", "ridge", "fill_frame"]),
    ("method", &["vector-field"]),
    ("method.vector-field", &["degree"]),
    ("part", &["width_mm", "base_mm"]),
    ("mesh", &["chord_um", "facet_px"]),
    ("export", &["formats"]),
    ("accept", &["pixel_error_rms_px", "pixel_error_max_px", "frame_filled"]),
];

/// The keys of a table; none for a path that is no table.
pub(super) fn keys(path: &str) -> &'static [&'static str] {
    TABLES.iter().find(|(table, _)| *table == path).map_or(&[], |(_, keys)| keys)
}

/// The first table that has a key of this name.
pub(super) fn home(key: &str) -> Option<&'static str> {
    TABLES
        .iter()
        .find(|(table, keys)| !table.is_empty() && keys.contains(&key))
        .map(|(table, _)| *table)
}

/// The word that `found` was probably meant to be.
pub(super) fn nearest<'w>(found: &str, words: &[&'w str]) -> Option<&'w str> {
    let found = found.to_lowercase().replace('-', "_");
    if let Some(word) =
        words.iter().find(|w| found.len() >= 3 && (w.starts_with(&found) || found.starts_with(*w)))
    {
        return Some(word);
    }
    words
        .iter()
        .map(|w| (strsim::osa_distance(&found, &w.replace('-', "_")), *w))
        .filter(|(distance, w)| *distance <= (w.len() / 3).max(1))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, w)| w)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_hangs_on_its_parent() {
        for (path, _) in TABLES.iter().filter(|(path, _)| !path.is_empty()) {
            let (parent, key) = path.rsplit_once('.').unwrap_or(("", path));
            assert!(keys(parent).contains(&key), "{path}");
        }
    }

    #[test]
    fn near_words_are_found_and_far_ones_are_not() {
        let part = keys("part");
        assert_eq!(nearest("widht_mm", part), Some("width_mm"));
        assert_eq!(nearest("width", part), Some("width_mm"));
        assert_eq!(nearest("height_mm", part), None);
        assert_eq!(nearest("STL", &["obj", "stl"]), Some("stl"));
        assert_eq!(nearest("step", &["obj", "stl"]), None);
        assert_eq!(nearest("vector_field", keys("method")), Some("vector-field"));
        assert_eq!(nearest("", part), None);
    }

    #[test]
    fn keys_know_their_table() {
        assert_eq!(home("degree"), Some("method.vector-field"));
        assert_eq!(home("colour"), None);
    }
}
