//! Keys of a profile, as a study names them: `part.width_mm`, `hole[0].depth_mm`.

use super::super::edit::KeyStep;
use super::super::schema::{self, PROFILE};
use super::super::words::list;

/// The steps of a key; none where it is not of the form `a.b[0].c`.
pub(super) fn steps(key: &str) -> Option<Vec<KeyStep>> {
    let mut steps = Vec::new();
    for part in key.split('.') {
        let (name, mut entries) = part.split_at(part.find('[').unwrap_or(part.len()));
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || !name.chars().all(is_word) {
            return None;
        }
        steps.push(KeyStep::Key(name.to_owned()));
        while !entries.is_empty() {
            let (entry, rest) = entries.strip_prefix('[')?.split_once(']')?;
            steps.push(KeyStep::Entry(entry.parse().ok()?));
            entries = rest;
        }
    }
    Some(steps)
}

/// Checks that a profile may have a value under a key.
///
/// # Errors
/// A hint, or nothing.
pub(super) fn check(steps: &[KeyStep]) -> Result<(), String> {
    let last = steps.iter().rev().find_map(|step| match step {
        KeyStep::Key(key) => Some(key.as_str()),
        KeyStep::Entry(_) => None,
    });
    let (mut path, mut steps) = (String::new(), steps.iter().peekable());
    while let Some(KeyStep::Key(key)) = steps.next() {
        if !PROFILE.keys(&path).contains(&key.as_str()) {
            return Err(meant(&path, key, last.unwrap_or(key)));
        }
        path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        let is_list = PROFILE.lists.contains(&path.as_str());
        let has_entry = matches!(steps.peek(), Some(KeyStep::Entry(_)));
        match (PROFILE.is_table(&path), steps.peek()) {
            (true, _) if is_list && !has_entry => {
                return Err(format!("{path} is a list of tables; write {path}[0] for the first"));
            }
            (true, Some(_)) if has_entry && !is_list => {
                return Err(format!("there is one {path}; leave the number in brackets out"));
            }
            (true, None) => {
                let keys = PROFILE.usual_keys(&path);
                let keys: Vec<String> = keys.iter().map(|key| format!("{path}.{key}")).collect();
                let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
                return Err(format!(
                    "it is a table; name one of its keys, as {}",
                    list(&keys, "or")
                ));
            }
            (true, Some(_)) => {
                steps.next_if(|step| matches!(step, KeyStep::Entry(_)));
                // (A list of tables is no value either.)
                if steps.peek().is_none() {
                    return Err(format!(
                        "it is a table; name one of its keys, as {path}[0].{}",
                        PROFILE.keys(&path)[0]
                    ));
                }
            }
            (false, _) => {
                while steps.next_if(|step| matches!(step, KeyStep::Entry(_))).is_some() {}
                if steps.peek().is_some() {
                    return Err(format!("{path} is a value and has no keys"));
                }
            }
        }
    }
    Ok(())
}

/// What may have been meant by a key that the table `path` has not; `last` is the last one of the whole.
fn meant(path: &str, key: &str, last: &str) -> String {
    let keys = PROFILE.keys(path);
    let join = |table: &str, key: &str| match table {
        "" => key.to_owned(),
        table => format!("{table}.{key}"),
    };
    let home = |key| Some(join(PROFILE.home(key)?, key));
    match (home(key).or_else(|| home(last)), schema::nearest(key, keys)) {
        (Some(whole), _) => format!("did you mean {whole}?"),
        (None, Some(near)) => format!("did you mean {}?", join(path, near)),
        (None, None) if path.is_empty() => {
            "write the table and the key, as part.width_mm; docs/profile.md lists all".to_owned()
        }
        (None, None) => format!("{path} has {}", list(keys, "and")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(key: &str) -> Result<(), String> {
        check(&steps(key).ok_or("no form")?)
    }

    #[test]
    fn every_value_of_a_profile_may_be_swept() {
        for (table, keys) in PROFILE.tables {
            for key in *keys {
                let path =
                    if table.is_empty() { (*key).to_owned() } else { format!("{table}.{key}") };
                let list = PROFILE.lists.iter().find(|list| path.starts_with(&format!("{list}.")));
                let path =
                    list.map_or(path.clone(), |list| path.replacen(list, &format!("{list}[0]"), 1));
                let bare = path.replace("[0]", "");
                assert_eq!(checked(&path).is_ok(), !PROFILE.is_table(&bare), "{path}");
            }
        }
    }

    #[test]
    fn what_is_no_value_has_a_hint() {
        for (key, hint) in [
            ("part.widht_mm", "did you mean part.width_mm?"),
            ("width_mm", "did you mean part.width_mm?"),
            ("part", "part.width_mm or part.base_mm"),
            ("prat.width_mm", "did you mean part.width_mm?"),
            ("hole.depth_mm", "write hole[0]"),
            ("hole[0]", "hole[0].at_mm"),
            ("part[1].width_mm", "leave the number in brackets out"),
            ("part.width_mm.x", "is a value and has no keys"),
            ("colour", "docs/profile.md"),
            ("part..x", "no form"),
            ("part.width_mm[x]", "no form"),
            ("part.\"width_mm\"", "no form"),
            ("", "no form"),
        ] {
            let told = checked(key).unwrap_err();
            assert!(told.contains(hint), "{key}: {told}");
        }
        assert!(checked("projection.cylindrical.elevation_deg[1]").is_ok());
        assert!(checked("hole[2].at_mm[0]").is_ok());
        assert!(checked("mirror.polynomial.terms[0][2]").is_ok());
    }
}
