//! Entries of the sag table.

use super::super::SagTable;
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, number, word};
use super::limits::PartEntry;
use super::{SIZE, is_size};
use crate::geom::{ScanPath, ScanPattern};
use std::f64::consts::PI;

/// The table's places; the defaults where `[export]` does not say.
pub(super) fn read(reader: &mut ProfileReader, export: &Section, part: &PartEntry) -> SagTable {
    let Some(section) = reader.section(export, "sag", Optional) else {
        return SagTable::default();
    };
    let words = [("raster", ScanPattern::Raster), ("spiral", ScanPattern::Spiral)];
    let hint = "a raster runs along X, a spiral about the axis from outside in";
    let path = word(reader, &section, "path", &words, hint).unwrap_or_default();
    let hint = "millimetres from line to line or turn to turn, as in pitch_mm = 0.5";
    let pitch = number(reader, &section, "pitch_mm", Optional, SIZE, hint, is_size);
    let hint = "millimetres from point to point along a line, as in step_mm = 0.5";
    let step = number(reader, &section, "step_mm", Optional, SIZE, hint, is_size);
    let table = SagTable { path, pitch_mm: pitch.map(|f| f.value), step_mm: step.map(|f| f.value) };
    if let (Some(width), Some(finest)) = (&part.width, finest(pitch, step)) {
        let ScanPath { pitch_mm, step_mm, .. } = table.scan(width.value);
        let height = part.height.as_ref().map_or(width.value, |height| height.value);
        let covered = match path {
            ScanPattern::Raster => height * width.value,
            // About the axis out to the corners.
            ScanPattern::Spiral => 0.25 * PI * (height * height + width.value * width.value),
        };
        let points = covered / (pitch_mm * step_mm);
        if points > SagTable::MOST_POINTS {
            let path = &section.path;
            let message = format!(
                "{path} must ask for at most {:.0e} points, found about {points:.0e}",
                SagTable::MOST_POINTS
            );
            reader.complain(finest, message, "raise pitch_mm or step_mm");
        }
    }
    table
}

/// Offset of the smaller of both.
fn finest(pitch: Option<Located<f64>>, step: Option<Located<f64>>) -> Option<usize> {
    let all = [pitch, step].into_iter().flatten();
    all.min_by(|a, b| a.value.total_cmp(&b.value)).map(|least| least.at)
}

impl SagTable {
    /// Most points of a table.
    pub const MOST_POINTS: f64 = 2e7;
    /// Points that are taken across the part's width where the profile does not say.
    const ACROSS: f64 = 200.0;

    /// Scan of a part of that width, mm.
    pub fn scan(&self, width_mm: f64) -> ScanPath {
        let [pitch_mm, step_mm] =
            [self.pitch_mm, self.step_mm].map(|mm| mm.unwrap_or(width_mm / Self::ACROSS));
        ScanPath { pattern: self.path, pitch_mm, step_mm }
    }
}
