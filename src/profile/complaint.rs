//! Complaints about a profile, each with its place.

use std::fmt;

/// One thing that is wrong with a profile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Complaint {
    /// The file, as the caller named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The key, what it must be and what was found.
    pub message: String,
    /// Hint at a text that would be right.
    pub hint: Option<String>,
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file, self.line, self.column, self.message)?;
        if let Some(hint) = &self.hint {
            write!(f, "\n  hint: {hint}")?;
        }
        Ok(())
    }
}

/// Everything that is wrong with a profile, in the order of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Complaints(pub Vec<Complaint>);

impl fmt::Display for Complaints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, complaint) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str("\n\n")?;
            }
            complaint.fmt(f)?;
        }
        Ok(())
    }
}

impl std::error::Error for Complaints {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_paragraph_each() {
        let one = Complaint {
            file: "a.toml".into(),
            line: 3,
            column: 7,
            message: "part.width_mm must be positive, found 0".into(),
            hint: Some("try 60".into()),
        };
        let two = Complaint { hint: None, line: 9, ..one.clone() };
        assert_eq!(
            Complaints(vec![one, two]).to_string(),
            "a.toml:3:7: part.width_mm must be positive, found 0\n  hint: try 60\n\n\
             a.toml:9:7: part.width_mm must be positive, found 0"
        );
    }
}
