//! Lines of row, column, X, Y and Z.

use super::{MOST_SAMPLES, VectorMap, VectorMapError, checked};
use crate::geom::DVec3;

/// Largest row or column: more are too many samples whatever the other is.
const MOST_SIDE: f64 = MOST_SAMPLES as f64;

pub(super) fn parse(text: &str) -> Result<VectorMap, VectorMapError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (mut samples, mut titles) = (Vec::new(), true);
    let [mut columns, mut rows] = [0; 2];
    for (line, text) in (1..).zip(text.lines()) {
        let text = text.split('#').next().unwrap_or("").trim();
        if text.is_empty() {
            continue;
        }
        let may_be_titles = std::mem::take(&mut titles);
        let fields: Vec<&str> = fields(text);
        if may_be_titles && fields[0].parse::<f64>().is_err() {
            continue;
        }
        let fault = |account: String| VectorMapError::Text { line, account };
        let &[row, column, x, y, z] = fields.as_slice() else {
            let account =
                format!("it must hold row, column, X, Y and Z, found {} of them", fields.len());
            return Err(fault(account));
        };
        let number = |field: &str| {
            field.parse::<f64>().map_err(|_| fault(format!("{field:?} is no number")))
        };
        let side = |field: &str| match number(field)? {
            side if side.fract() == 0.0 && (0.0..MOST_SIDE).contains(&side) => Ok(side as usize),
            _ => {
                Err(fault(format!("a row or column must be a whole number from 0, found {field}")))
            }
        };
        let (row, column) = (side(row)?, side(column)?);
        (rows, columns) = (rows.max(row + 1), columns.max(column + 1));
        if samples.len() == MOST_SAMPLES {
            return Err(VectorMapError::TooMany { found: samples.len() + 1 });
        }
        samples.push((line, row, column, DVec3::new(number(x)?, number(y)?, number(z)?)));
    }
    let mut vectors = vec![DVec3::NAN; checked(columns, rows)?];
    let mut lines = vec![0; vectors.len()];
    for (line, row, column, vector) in samples {
        let k = row * columns + column;
        if lines[k] > 0 {
            let account = format!(
                "row {row}, column {column} must be given once, line {} has it too",
                lines[k]
            );
            return Err(VectorMapError::Text { line, account });
        }
        (vectors[k], lines[k]) = (vector, line);
    }
    Ok(VectorMap { columns, vectors })
}

/// The columns of a line, between commas, semicolons, or spaces and tabs.
fn fields(line: &str) -> Vec<&str> {
    match [';', ','].into_iter().find(|&mark| line.contains(mark)) {
        Some(mark) => line.split(mark).map(str::trim).collect(),
        None => line.split_whitespace().collect(),
    }
}
