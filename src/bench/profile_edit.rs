//! Profiles with other settings: the text stays as it is but for them.

use crate::profile::put;
use toml_edit::{DocumentMut, Item};

/// The text of a profile, to be edited; none where it cannot be read.
pub(super) fn document(text: &[u8]) -> Option<DocumentMut> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

/// Sets a key of a table; what is said beside its old value stays.
pub(super) fn set(table: &mut Item, key: &str, new: Item) {
    if let (Some(table), Ok(new)) = (table.as_table_like_mut(), new.into_value()) {
        put(table, key, new);
    }
}
