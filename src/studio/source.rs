//! The text of a profile that a request brings, and names that profiles may have.

use super::failure::RequestFailure;
use super::view;
use crate::profile::Profile;
use serde::Deserialize;

/// Letters of a profile's name.
const MOST_LETTERS: usize = 64;

/// A text and the name of its profile.
#[derive(Debug, Deserialize)]
pub(super) struct Source {
    /// Its name.
    pub name: String,
    /// The text.
    pub text: String,
}

impl Source {
    /// The profile.
    ///
    /// # Errors
    /// [`RequestFailure`] with every complaint about name and text.
    pub(super) fn profile(&self) -> Result<Profile, RequestFailure> {
        if !is_name(&self.name) {
            return Err(RequestFailure::of_text(
                "the name must be of at most 64 letters a to z, digits, - and _",
            ));
        }
        view::checked(&self.name, &self.text)
    }
}

/// Whether a profile may have this name, which is that of a file and a folder too.
fn is_name(name: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    (1..=MOST_LETTERS).contains(&name.len()) && name.chars().all(is_letter)
}

/// A name for a profile of the file `name`, with hyphens in the place of letters that it may not have.
pub(super) fn tamed(name: &str) -> String {
    let tame = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    let tamed: String = name.chars().map(tame).take(MOST_LETTERS).collect();
    if tamed.is_empty() { "mirror".to_owned() } else { tamed }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_of_plain_letters() {
        assert!(is_name("conquistador") && is_name("a_1-B"));
        let long = "a".repeat(65);
        for name in ["", ".", "..", "a/b", "a\\b", "a.b", "ä", "a b", "\u{202e}", &*long] {
            assert!(!is_name(name), "{name}");
            assert!(is_name(&tamed(name)), "{name}");
        }
    }
}
