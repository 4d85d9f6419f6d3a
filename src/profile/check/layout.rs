//! The mirror's outline.

use super::super::reader::Need::Required;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, flag, number, word};
use super::super::{Layout, PanelSource, Ridge};
use super::{SIZE, is_size, only};
use std::fmt;

/// Which layout it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LayoutName {
    Strip,
    Conquistador,
    Disc,
    Annulus,
    Rectangle,
}

impl LayoutName {
    /// The layout of a table's name: one that the schema has.
    fn find(name: &str) -> Self {
        match name {
            "disc" => Self::Disc,
            "annulus" => Self::Annulus,
            "rectangle" => Self::Rectangle,
            "conquistador" => Self::Conquistador,
            _ => Self::Strip,
        }
    }
}

impl fmt::Display for LayoutName {
    /// The name of its table.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Strip => "strip",
            Self::Conquistador => "conquistador",
            Self::Disc => "disc",
            Self::Annulus => "annulus",
            Self::Rectangle => "rectangle",
        })
    }
}

/// A layout, and where its table and keys stand.
pub(super) struct LayoutEntry {
    pub(super) name: LayoutName,
    pub(super) at: usize,
    pub(super) layout: Option<Layout>,
    /// Offset of `fill_frame = true`.
    pub(super) fills: Option<usize>,
    /// Diameter of an annulus' land.
    pub(super) inner: Option<Located<f64>>,
}

impl LayoutEntry {
    pub(super) fn is_round(&self) -> bool {
        matches!(self.name, LayoutName::Disc | LayoutName::Annulus)
    }

    /// Panels one above the other.
    pub(super) fn panels(&self) -> f64 {
        if self.name == LayoutName::Conquistador { 2.0 } else { 1.0 }
    }
}

pub(super) fn read(reader: &mut ProfileReader, root: &Section) -> Option<LayoutEntry> {
    let hint = "a strip is one panel, a conquistador folds a full turn into two; discs and \
                annuli are for laws about the axis, rectangles for perspective views";
    let read = reader
        .alternatives(root, "layout", hint)
        .into_iter()
        .map(|(name, section)| one(reader, LayoutName::find(name), &section))
        .collect();
    only(read)
}

fn one(reader: &mut ProfileReader, name: LayoutName, section: &Section) -> LayoutEntry {
    let mut found = LayoutEntry { name, at: section.at, layout: None, fills: None, inner: None };
    match name {
        LayoutName::Disc => found.layout = Some(Layout::Disc),
        // Its height is a key of the part, or the frame's.
        LayoutName::Rectangle => {}
        LayoutName::Annulus => {
            let hint = "the diameter of the flat land in the middle, as in inner_width_mm = 10";
            found.inner = number(reader, section, "inner_width_mm", Required, SIZE, hint, is_size);
            found.layout = found.inner.map(|inner| Layout::Annulus { inner_width_mm: inner.value });
        }
        LayoutName::Strip | LayoutName::Conquistador => {
            let fills = flag(reader, section, "fill_frame").filter(|fills| fills.value);
            found.fills = fills.map(|fills| fills.at);
            let fill_frame = fills.is_some();
            found.layout = Some(match name {
                LayoutName::Conquistador => conquistador(reader, section, fill_frame),
                _ => Layout::Strip { fill_frame },
            });
        }
    }
    found
}

fn conquistador(reader: &mut ProfileReader, section: &Section, fill_frame: bool) -> Layout {
    let panels = [("refit", PanelSource::Refit), ("section", PanelSource::Section)];
    let hint = "refit solves for the half turn, section cuts the full turn's mirror";
    let panel = word(reader, section, "panel", &panels, hint);
    let ridges = [("crest", Ridge::Crest), ("valley", Ridge::Valley)];
    let hint = "a crest stands out of the part and can be cut; a valley is sunk into it";
    let ridge = word(reader, section, "ridge", &ridges, hint);
    Layout::Conquistador {
        panel: panel.unwrap_or(PanelSource::Refit),
        ridge: ridge.unwrap_or(Ridge::Crest),
        fill_frame,
    }
}
