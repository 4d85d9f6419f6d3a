//! A given mirror's heights: lines of X, Y and Z that together are a complete regular grid.

use crate::geom::{GridAxis, XyzFault, XyzLine, xyz_lines};
use thiserror::Error;

/// Heights on a regular grid, in millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct SagGrid {
    /// Places along X.
    pub x: GridAxis,
    /// Places along Y.
    pub y: GridAxis,
    /// Z, row after row along X, the row of the least Y first.
    pub z_mm: Vec<f64>,
}

/// Most nodes that a grid may have.
const MOST_NODES: usize = 4_000_000;
/// Fewest along an axis: a cubic takes four.
const LEAST: usize = 4;
/// Largest distance of a place from its node, in steps.
const OFF: f64 = 1e-6;

/// Reason why a file holds no grid of heights.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GridError {
    /// Not text.
    #[error("line {line}: a table of heights must be UTF-8 text, found other bytes")]
    NotText {
        /// Line, from 1.
        line: usize,
    },
    /// A line with fewer than three columns.
    #[error("line {line}: a line must hold X, Y and Z in millimetres, found {found:?}")]
    Columns {
        /// Line, from 1.
        line: usize,
        /// Its text, cut short.
        found: String,
    },
    /// A column that is no finite number.
    #[error("line {line}: {axis} must be a finite number of millimetres, found {found:?}")]
    Number {
        /// Line, from 1.
        line: usize,
        /// X, Y or Z.
        axis: char,
        /// Its text, cut short.
        found: String,
    },
    /// Too many nodes.
    #[error("line {line}: a grid must have at most {MOST_NODES} nodes, found more")]
    TooMany {
        /// The first line too many, from 1.
        line: usize,
    },
    /// Too few nodes.
    #[error("a grid must have at least {LEAST} x {LEAST} nodes, found {columns} x {rows}")]
    TooFew {
        /// Different values of X.
        columns: usize,
        /// Different values of Y.
        rows: usize,
    },
    /// A place between the nodes.
    #[error(
        "line {line}: {axis} must be on the even grid with step {step_mm} (to 1e-6 of it), as \
         {nearest_mm} is; found {found_mm}"
    )]
    OffGrid {
        /// Line, from 1.
        line: usize,
        /// X or Y.
        axis: char,
        /// The place, mm.
        found_mm: f64,
        /// The nearest place on the grid.
        nearest_mm: f64,
        /// The grid's step.
        step_mm: f64,
    },
    /// A node given twice.
    #[error(
        "line {line}: each node must be given once, found X = {x_mm}, Y = {y_mm} of line {first} again"
    )]
    Twice {
        /// The second line, from 1.
        line: usize,
        /// The first one.
        first: usize,
        /// X of the node.
        x_mm: f64,
        /// Y of the node.
        y_mm: f64,
    },
    /// Nodes not given.
    #[error(
        "the grid must be complete, {columns} x {rows} nodes; {missing} of them are missing, the \
         first at X = {x_mm}, Y = {y_mm}"
    )]
    Missing {
        /// Different values of X.
        columns: usize,
        /// Different values of Y.
        rows: usize,
        /// Number of missing nodes.
        missing: usize,
        /// X of the first one.
        x_mm: f64,
        /// Y of the first one.
        y_mm: f64,
    },
}

impl From<XyzFault> for GridError {
    fn from(fault: XyzFault) -> Self {
        match fault {
            XyzFault::NotText { line } => Self::NotText { line },
            XyzFault::Columns { line, found } => Self::Columns { line, found },
            XyzFault::Number { line, axis, found } => Self::Number { line, axis, found },
            XyzFault::TooMany { line, .. } => Self::TooMany { line },
        }
    }
}

impl SagGrid {
    /// Reads lines of X, Y, Z in any order, separated by commas, semicolons, tabs or spaces.
    /// Further columns do not matter; `#` begins a comment, and one line of titles may come first.
    ///
    /// # Errors
    /// The first [`GridError`] met.
    pub fn parse(bytes: &[u8]) -> Result<Self, GridError> {
        let samples = xyz_lines(bytes, MOST_NODES)?;
        let axes = [0, 1].map(|k| {
            let mut places: Vec<f64> = samples.iter().map(|s| s.at[k]).collect();
            places.sort_unstable_by(f64::total_cmp);
            axis(&places)
        });
        if let Some(error) = samples.iter().find_map(|s| off_grid(s, &axes)) {
            return Err(error);
        }
        let [x, y] = axes;
        if x.count < LEAST || y.count < LEAST {
            return Err(GridError::TooFew { columns: x.count, rows: y.count });
        }
        // As long as a node may be missing, the grid may be far larger than the file.
        let index =
            |s: &XyzLine| node(&y, s.at[1]).0 as u64 * x.count as u64 + node(&x, s.at[0]).0 as u64;
        let mut nodes: Vec<(u64, u32, f64)> =
            samples.iter().map(|s| (index(s), s.line, s.at[2])).collect();
        drop(samples);
        nodes.sort_unstable_by_key(|node| (node.0, node.1));
        let place = |k: u64| {
            let columns = x.count as u64;
            (x.at((k % columns) as usize), y.at((k / columns) as usize))
        };
        let twice = nodes.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        if let Some(pair) = twice.min_by_key(|pair| pair[1].1) {
            let (x_mm, y_mm) = place(pair[0].0);
            let (first, line) = (pair[0].1 as usize, pair[1].1 as usize);
            return Err(GridError::Twice { line, first, x_mm, y_mm });
        }
        let whole = x.count.saturating_mul(y.count);
        if nodes.len() < whole {
            let found = nodes.iter().enumerate().find(|(k, node)| *k as u64 != node.0);
            let (x_mm, y_mm) = place(found.map_or(nodes.len(), |(k, _)| k) as u64);
            let missing = whole - nodes.len();
            return Err(GridError::Missing {
                columns: x.count,
                rows: y.count,
                missing,
                x_mm,
                y_mm,
            });
        }
        Ok(Self { x, y, z_mm: nodes.into_iter().map(|node| node.2).collect() })
    }
}

/// The even places that most of the sorted ones lie on; a few strays do not matter.
fn axis(places: &[f64]) -> GridAxis {
    let (Some(&first), count) = (places.first(), places.len()) else {
        return GridAxis { first_mm: 0.0, step_mm: 0.0, count: 0 };
    };
    let strays = count / 100 + usize::from(count >= LEAST * LEAST);
    let mut gaps: Vec<f64> =
        places[strays..count - strays].windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.sort_unstable_by(f64::total_cmp);
    // The gap within which half of the way is made: places that differ by rounding make none.
    let half = 0.5 * gaps.iter().sum::<f64>();
    let mut way = 0.0;
    let gap = gaps.into_iter().find(|gap| {
        way += gap;
        way >= half
    });
    let Some(gap) = gap.filter(|gap| *gap > 0.0) else {
        return GridAxis { first_mm: first, step_mm: 0.0, count: 1 };
    };
    // The step, from the outermost places that it leads to.
    let middle = places[count / 2];
    let steps = |place: f64| ((place - middle) / gap).round();
    let fits = |place: &&f64| {
        let steps = steps(**place);
        steps.abs() < MOST_NODES as f64 && ((**place - middle) / gap - steps).abs() < 0.1
    };
    let low = *places.iter().find(fits).unwrap_or(&middle);
    let high = *places.iter().rev().find(fits).unwrap_or(&middle);
    let count = steps(high) - steps(low);
    if !(count >= 1.0) {
        return GridAxis { first_mm: first, step_mm: 0.0, count: 1 };
    }
    GridAxis { first_mm: low, step_mm: (high - low) / count, count: count as usize + 1 }
}

/// The nearest node, and how far off it is, in steps.
fn node(axis: &GridAxis, place: f64) -> (usize, f64) {
    if axis.step_mm == 0.0 {
        return (0, 0.0);
    }
    let steps = (place - axis.first_mm) / axis.step_mm;
    let nearest = steps.round().clamp(0.0, axis.count as f64 - 1.0);
    (nearest as usize, (steps - nearest).abs())
}

fn off_grid(sample: &XyzLine, axes: &[GridAxis; 2]) -> Option<GridError> {
    (0..2).find_map(|k| {
        let (nearest, off) = node(&axes[k], sample.at[k]);
        (off > OFF).then(|| GridError::OffGrid {
            line: sample.line as usize,
            axis: ['X', 'Y'][k],
            found_mm: sample.at[k],
            nearest_mm: axes[k].at(nearest),
            step_mm: axes[k].step_mm,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 5 x 4 nodes, Z = X + 10 Y, as lines.
    fn lines() -> Vec<String> {
        let node = |k: usize| {
            let (x, y) = (0.1 * (k % 5) as f64 - 0.2, 0.5 * (k / 5) as f64);
            format!("{x},{y},{}", x + 10.0 * y)
        };
        (0..20).map(node).collect()
    }

    fn parse(lines: &[String]) -> Result<SagGrid, GridError> {
        SagGrid::parse(lines.join("\n").as_bytes())
    }

    fn message(lines: &[String]) -> String {
        parse(lines).unwrap_err().to_string()
    }

    #[test]
    fn any_order_and_dialect_gives_the_same_grid() {
        let grid = parse(&lines()).unwrap();
        assert_eq!((grid.x.count, grid.y.count), (5, 4));
        assert!((grid.x.first_mm + 0.2).abs() < 1e-15 && (grid.x.last_mm() - 0.2).abs() < 1e-15);
        assert!((grid.y.step_mm - 0.5).abs() < 1e-15);
        for (k, z) in grid.z_mm.iter().enumerate() {
            let exact = grid.x.at(k % 5) + 10.0 * grid.y.at(k / 5);
            assert!((z - exact).abs() < 1e-12);
        }
        let text = lines().join("\n");
        let mut reversed = lines();
        reversed.reverse();
        for variant in [
            reversed.join("\n"),
            text.replace('\n', "\r\n") + "\r\n",
            text.replace(',', " ; "),
            text.replace(',', "\t"),
            text.replace(',', "   "),
            text.replace('\n', ",17,note\n"),
            format!("\u{feff}# sag\n\nX (mm),Y,Z # titles\n{text} # the last\n\n"),
            text.replace("-0.2,", "-2.0E-1,"),
        ] {
            let found =
                SagGrid::parse(variant.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{variant}"));
            assert_eq!(found, grid, "{variant}");
        }
    }

    #[test]
    fn columns_may_differ_by_rounding() {
        let mut lines = lines();
        lines[7] = lines[7].replacen("0,", "0.00000001,", 1);
        assert_eq!(parse(&lines).unwrap().x.count, 5);
    }

    #[test]
    fn complaints_name_the_line() {
        let with = |k: usize, line: &str| {
            let mut lines = lines();
            lines[k] = line.into();
            message(&lines)
        };
        for (found, wanted) in [
            (with(2, "0,0"), "line 3: a line must hold X, Y and Z in millimetres, found \"0,0\""),
            (
                with(2, "0,zero,0"),
                "line 3: Y must be a finite number of millimetres, found \"zero\"",
            ),
            (with(2, "0,0,nan"), "line 3: Z must be a finite number of millimetres, found \"nan\""),
            (with(19, "0.2,1.5,1e999"), "line 20: Z must be a finite number"),
            (with(7, "0.03,0.5,5"), "line 8: X must be on the even grid with step 0.1"),
            (with(7, "0.03,0.5,5"), "as 0 is; found 0.03"),
            (with(0, "-1e9,0,5"), "line 1: X must be"),
            (
                with(12, "0,0,1"),
                "line 13: each node must be given once, found X = 0, Y = 0 of line 3",
            ),
        ] {
            assert!(found.contains(wanted), "{found}\n{wanted}");
        }
        let mut few = lines();
        few.remove(13);
        let found = message(&few);
        assert!(
            found.contains("5 x 4 nodes; 1 of them are missing, the first at X = 0.1"),
            "{found}"
        );
        assert!(message(&lines()[..15]).contains("at least 4 x 4 nodes, found 5 x 3"));
        assert!(message(&lines()[..5]).contains("found 5 x 1"));
        assert!(message(&[]).contains("found 0 x 0"));
        assert!(message(&["X,Y,Z".into(), "X,Y,Z".into()]).starts_with("line 2: X must be"));
        let binary = SagGrid::parse(b"1,2,3\n\xff\xfe").unwrap_err();
        assert_eq!(binary, GridError::NotText { line: 2 });
    }
}
