//! The data section of an exchange structure (ISO 10303-21): numbered entity instances, reals and strings.

use super::face_role::FaceRole;
use crate::geom::DVec2;
use std::fmt::{Display, Write};

/// The number of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct InstanceId(u32);

impl Display for InstanceId {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "#{}", self.0)
    }
}

/// A face that is written.
#[derive(Debug, Clone, Copy)]
pub(super) struct WrittenFace {
    pub id: InstanceId,
    pub role: FaceRole,
    /// X and Y of the outward normal of an upright plane.
    pub out: Option<DVec2>,
}

/// The entity instances written so far.
#[derive(Debug, Default)]
pub(super) struct DataSection {
    pub text: String,
    /// The body's faces.
    pub(super) faces: Vec<WrittenFace>,
    /// Whether faces that are written now bound a cavity: they are turned round, and have its name.
    pub(super) is_cavity: bool,
    last: u32,
}

impl DataSection {
    /// Writes an instance.
    pub(super) fn add(&mut self, what: impl Display) -> InstanceId {
        self.last += 1;
        // Writing to memory cannot fail.
        let _ = writeln!(self.text, "#{}={what};", self.last);
        InstanceId(self.last)
    }

    /// The mirror's faces.
    pub(super) fn optical(&self) -> impl Iterator<Item = InstanceId> {
        self.faces.iter().filter(|face| face.role == FaceRole::Optical).map(|face| face.id)
    }
}

/// `(#1,#2,...)`.
pub(super) fn list(ids: &[InstanceId]) -> String {
    let ids: Vec<String> = ids.iter().map(InstanceId::to_string).collect();
    format!("({})", ids.join(","))
}

/// A number to 1e-10: what matters of millimetres.
pub(super) fn real(x: f64) -> String {
    digits(x, 10)
}

/// A number to so many decimals, without those that are 0.
pub(super) fn digits(x: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", x + 0.0);
    let text = text.trim_end_matches('0');
    if text == "-0." { "0.".into() } else { text.into() }
}

/// A string in quotes: printable ASCII of at most 256 characters.
pub(super) fn quoted(text: &str) -> String {
    let cut: String = super::super::Label::plain(text).chars().take(256).collect();
    format!("'{}'", cut.replace('\\', "\\\\").replace('\'', "''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_reals_with_the_digits_that_matter() {
        for (x, text) in [
            (0.0, "0."),
            (-0.0, "0."),
            (-1e-12, "0."),
            (12.0, "12."),
            (-0.5, "-0.5"),
            (1.0 / 3.0, "0.3333333333"),
            (1e6 + 1e-10, "1000000.0000000001"),
        ] {
            assert_eq!(real(x), text);
        }
    }

    #[test]
    fn strings_end_where_they_should() {
        assert_eq!(quoted("it's\n"), "'it''s?'");
        assert_eq!(quoted("a\\b"), "'a\\\\b'");
        assert_eq!(quoted(&"x".repeat(300)).len(), 258);
    }
}
