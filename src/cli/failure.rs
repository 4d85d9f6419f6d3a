//! Why a command could not be done, in words and as JSON.

use crate::pipeline::all_errors;
use crate::results::ErrorLine;
use serde_json::json;
use std::error::Error;
use std::fmt::{self, Display, Formatter};

/// Similarity (Jaro-Winkler) from which a name is taken for a misspelt one, as with names of profiles.
const LIKE: f64 = 0.8;

/// One error or several.
pub(super) struct CommandFailure(Vec<Box<dyn Error>>);

impl CommandFailure {
    /// A failure that is a sentence.
    pub(super) fn said(sentence: String) -> Self {
        Self(vec![sentence.into()])
    }

    /// No `kind` has this name: what may be meant, and all `names`.
    pub(super) fn unknown(kind: &str, name: &str, names: &[&str]) -> Self {
        let closest = names
            .iter()
            .map(|known| (strsim::jaro_winkler(name, known), known))
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|(likeness, _)| *likeness > LIKE);
        let meant = closest.map_or(String::new(), |(_, name)| format!("; did you mean {name}?"));
        let names = names.join(", ");
        Self::said(format!("no {kind} is called {name:?}{meant} (there are {names})"))
    }

    /// Success, or all of `failures`.
    pub(super) fn none_of(failures: Vec<Self>) -> Result<(), Self> {
        let all: Vec<_> = failures.into_iter().flat_map(|failure| failure.0).collect();
        if all.is_empty() { Ok(()) } else { Err(Self(all)) }
    }

    /// A line of JSON for each error: `{"error": {"file", "line", "column", "message", "hint"}}`, null what is not
    /// known. Every complaint about a profile is one.
    pub(super) fn json(&self) -> String {
        let told = self.0.iter().flat_map(|error| all_errors(&**error));
        told.map(|error| format!("{}\n", json!(ErrorLine { error }))).collect()
    }
}

impl<E: Error + 'static> From<E> for CommandFailure {
    fn from(error: E) -> Self {
        Self(vec![Box::new(error)])
    }
}

impl Display for CommandFailure {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for (k, error) in self.0.iter().enumerate() {
            let end = if k == 0 { "" } else { "\n" };
            write!(f, "{end}{error}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::SourceError;
    use crate::profile::{Complaint, Complaints};
    use serde_json::Value;

    #[test]
    fn every_complaint_is_a_line_with_its_place() {
        let one = Complaint {
            file: "a.toml".into(),
            line: 3,
            column: 7,
            message: "no".into(),
            hint: Some("yes".into()),
        };
        let two = Complaint { hint: None, line: 9, ..one.clone() };
        let faulty = SourceError::Faulty(Complaints(vec![one, two]));
        let all = vec![CommandFailure::from(faulty), CommandFailure::said("full\nof lines".into())];
        let Err(failure) = CommandFailure::none_of(all) else { panic!("there are two") };
        let lines: Vec<Value> =
            failure.json().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(lines.len(), 3);
        let error = |k: usize, key: &str| lines[k]["error"][key].clone();
        assert_eq!(error(0, "file"), "a.toml");
        assert_eq!([error(0, "line"), error(1, "line")], [json!(3), json!(9)]);
        assert_eq!([error(0, "hint"), error(1, "hint")], [json!("yes"), Value::Null]);
        assert_eq!([error(2, "message"), error(2, "line")], [json!("full\nof lines"), Value::Null]);
        assert!(CommandFailure::none_of(vec![]).is_ok());
    }
}
