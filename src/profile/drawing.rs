//! What a drawing of the part says beside its figures.

/// What a drawing of the part says beside its figures; texts are empty where the profile does not say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawingSpec {
    /// Its paper.
    pub paper: PaperSize,
    /// How its views are arranged.
    pub arrangement: ViewArrangement,
    /// The title block.
    pub title: TitleBlock,
    /// Material of the part.
    pub material: String,
    /// Coating of the mirror.
    pub coating: String,
    /// Permissible surface imperfections: what follows `5/` (ISO 10110-7).
    pub imperfections: String,
    /// Texture of the mirror (ISO 10110-8), as `P3` or `Rq 5 nm`.
    pub texture: String,
    /// The standard of tolerances of all sizes that have none of their own.
    pub general_tolerance: String,
}

/// Fields of a title block (ISO 7200).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TitleBlock {
    /// Legal owner.
    pub owner: String,
    /// Identification number.
    pub number: String,
    /// Revision.
    pub revision: String,
    /// Title.
    pub title: String,
    /// Creator.
    pub creator: String,
    /// Approval person.
    pub approver: String,
    /// Date of issue, as `2026-11-27`.
    pub date: String,
}

/// Paper of a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PaperSize {
    /// A3, lying.
    #[default]
    A3,
    /// A4, upright.
    A4,
}

/// Arrangement of views (ISO 5456-2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewArrangement {
    /// First angle, as in Europe and most of Asia: the view from below stands above.
    #[default]
    FirstAngle,
    /// Third angle, as in the USA: the view from below stands below.
    ThirdAngle,
}

impl DrawingSpec {
    /// Most characters of a text.
    pub const MOST_CHARACTERS: usize = 60;
}

impl PaperSize {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::A3 => "A3",
            Self::A4 => "A4",
        }
    }
}

impl ViewArrangement {
    /// Its name in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FirstAngle => "first angle",
            Self::ThirdAngle => "third angle",
        }
    }
}
