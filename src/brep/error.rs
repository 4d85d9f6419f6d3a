//! Why a STEP file is refused.

use std::fmt;

/// Why a STEP file is refused: the line, the entity instance where there is one, and what is wrong with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StepError {
    /// Line of the file, counted from 1; 0 where the whole file is meant.
    pub line: usize,
    /// Number of the entity instance, if one is meant.
    pub entity: Option<u64>,
    /// What is wrong, without line and number.
    pub fault: String,
}

impl StepError {
    /// A fault of the text at a line.
    pub(super) fn at(line: usize, fault: impl Into<String>) -> Self {
        Self { line, entity: None, fault: fault.into() }
    }

    /// A fault of the file as a whole.
    pub(super) fn of_file(fault: impl Into<String>) -> Self {
        Self::at(0, fault)
    }
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line > 0 {
            write!(f, "line {}: ", self.line)?;
        }
        if let Some(entity) = self.entity {
            write!(f, "#{entity}: ")?;
        }
        f.write_str(&self.fault)
    }
}

impl std::error::Error for StepError {}
