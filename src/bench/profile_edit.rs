//! Profiles with other settings: the text stays as it is but for them.

use toml_edit::{DocumentMut, Item};

/// The text of a profile, to be edited; none where it cannot be read.
pub(super) fn document(text: &[u8]) -> Option<DocumentMut> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

/// Sets a key of a table; what is said beside its old value stays.
pub(super) fn set(table: &mut Item, key: &str, new: Item) {
    let decor = table.get(key).and_then(Item::as_value).map(|old| old.decor().clone());
    table[key] = new;
    if let (Some(decor), Some(value)) = (decor, table[key].as_value_mut()) {
        *value.decor_mut() = decor;
    }
}
