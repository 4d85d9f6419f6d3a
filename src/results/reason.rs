//! Reasons of a negative verdict: of a kind, with figures, rendered last.

use super::faults::{FileFault, PictureFault, RayFault, Refusal, ShapeFault};
use super::study_faults::{CuttingFault, ReplayFault, StudyFault};
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// What a reason is about, with its figures.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReasonKind {
    /// The bytes of a file.
    #[error(transparent)]
    File(#[from] FileFault),
    /// The shape of the part.
    #[error(transparent)]
    Shape(#[from] ShapeFault),
    /// Rays that do not reach the world.
    #[error(transparent)]
    Rays(#[from] RayFault),
    /// What the camera sees.
    #[error(transparent)]
    Picture(#[from] PictureFault),
    /// A face as a cutter leaves it.
    #[error(transparent)]
    Cutting(#[from] CuttingFault),
    /// A study of tolerances.
    #[error(transparent)]
    Study(#[from] StudyFault),
    /// A file of a replayed trial.
    #[error(transparent)]
    Replay(#[from] ReplayFault),
    /// Files that are not written although they are asked for.
    #[error(transparent)]
    NotWritten(#[from] Refusal),
    /// What a report said that was read from a file, which holds sentences alone.
    #[error("{0}")]
    Recorded(String),
}

/// What a reason is about, without its figures, which the report has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ReasonSubject {
    /// The bytes of a file.
    File,
    /// The shape of the part.
    Shape,
    /// Rays that do not reach the world.
    Rays,
    /// What the camera sees.
    Picture,
    /// A face as a cutter leaves it.
    Cutting,
    /// A study of tolerances.
    Study,
    /// A file of a replayed trial.
    Replay,
    /// Files that are not written although they are asked for.
    NotWritten,
    /// What a report said that was read from a file, which holds sentences alone.
    Recorded,
}

/// Why a verdict is negative: what files hold of it is one sentence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(into = "String", from = "String")]
pub struct Reason {
    /// What it is about, with its figures; [`Self::subject`] alone is promised to stay.
    #[doc(hidden)]
    pub kind: ReasonKind,
    /// The file that it is said of; of the whole part without one.
    pub file: Option<String>,
    /// A way out, which has been tried or follows from the figures.
    pub way_out: Option<String>,
}

impl Reason {
    /// What it is about.
    ///
    /// ```
    /// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../../examples/small.toml"))?;
    /// # let out = tempfile::tempdir()?;
    /// let report = morion::build(&profile, out.path())?;
    /// let is_picture = |reason: &morion::Reason| reason.subject() == morion::ReasonSubject::Picture;
    /// assert!(!report.reasons.iter().any(is_picture));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn subject(&self) -> ReasonSubject {
        match self.kind {
            ReasonKind::File(_) => ReasonSubject::File,
            ReasonKind::Shape(_) => ReasonSubject::Shape,
            ReasonKind::Rays(_) => ReasonSubject::Rays,
            ReasonKind::Picture(_) => ReasonSubject::Picture,
            ReasonKind::Cutting(_) => ReasonSubject::Cutting,
            ReasonKind::Study(_) => ReasonSubject::Study,
            ReasonKind::Replay(_) => ReasonSubject::Replay,
            ReasonKind::NotWritten(_) => ReasonSubject::NotWritten,
            ReasonKind::Recorded(_) => ReasonSubject::Recorded,
        }
    }

    /// The same, said of the file `name`.
    #[must_use]
    pub fn of_file(self, name: &str) -> Self {
        Self { file: Some(name.to_owned()), ..self }
    }
}

impl Display for Reason {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{file}: ")?;
        }
        write!(f, "{}", self.kind)?;
        self.way_out.iter().try_for_each(|way| write!(f, "; {way}"))
    }
}

impl<K: Into<ReasonKind>> From<K> for Reason {
    fn from(kind: K) -> Self {
        Self { kind: kind.into(), file: None, way_out: None }
    }
}

impl From<Reason> for String {
    fn from(reason: Reason) -> Self {
        reason.to_string()
    }
}

impl From<String> for ReasonKind {
    fn from(sentence: String) -> Self {
        Self::Recorded(sentence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_has_the_file_first_and_the_way_out_last() {
        let mut reason = Reason::from(RayFault::Missed { count: 2, rays: 9 });
        assert_eq!(reason.to_string(), "2 of 9 rays aimed at the mirror miss the part");
        reason.way_out = Some("look".to_owned());
        let said = reason.of_file("mirror.stl").to_string();
        assert_eq!(said, "mirror.stl: 2 of 9 rays aimed at the mirror miss the part; look");
    }

    #[test]
    fn files_hold_the_sentence_and_give_it_back() {
        let reason = Reason::from(FileFault::Altered).of_file("mirror.obj");
        let text = serde_json::to_string(&reason).unwrap();
        let read: Reason = serde_json::from_str(&text).unwrap();
        assert_eq!(read.kind, ReasonKind::Recorded(reason.to_string()));
        assert_eq!(read.to_string(), reason.to_string());
    }
}
