//! What the three formats of calibration files have in common: keys, numbers, words and lists, each with its
//! line.

use super::CalibrationError;

/// Deepest nesting that is read; a matrix in a calibration is three deep.
pub(super) const DEEPEST: usize = 32;

/// A value and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TreeNode {
    /// Line, from 1.
    pub line: usize,
    pub value: Value,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    /// Finite or not.
    Number(f64),
    Text(String),
    List(Vec<TreeNode>),
    /// Keys in the order of the file, with the values' lines those of the keys.
    Table(Vec<(String, TreeNode)>),
}

/// Numbers, and rows and columns where they are said.
pub(super) struct Matrix {
    pub size: Option<[usize; 2]>,
    pub numbers: Vec<f64>,
}

impl TreeNode {
    /// A word without quotes: a number where it is one, also as OpenCV writes those that are not finite.
    pub(super) fn plain(line: usize, text: &str) -> Self {
        let value = match text.to_ascii_lowercase().as_str() {
            ".nan" | "-.nan" => Value::Number(f64::NAN),
            ".inf" | "+.inf" => Value::Number(f64::INFINITY),
            "-.inf" => Value::Number(f64::NEG_INFINITY),
            _ => match text.parse() {
                Ok(number) => Value::Number(number),
                Err(_) => Value::Text(text.to_owned()),
            },
        };
        Self { line, value }
    }

    /// The value in words.
    pub(super) fn found(&self) -> String {
        match &self.value {
            Value::Number(number) => number.to_string(),
            Value::Text(text) => format!("the text \"{}\"", super::super::words::shown(text)),
            Value::List(list) => format!("a list of {}", list.len()),
            Value::Table(_) => "a table".to_owned(),
        }
    }

    /// That the value of `key` is not what it must be.
    pub(super) fn fault(&self, key: &str, must: impl Into<String>) -> CalibrationError {
        self.found_other(key, must, self.found())
    }

    /// The same, with words for what was found.
    pub(super) fn found_other(
        &self,
        key: &str,
        must: impl Into<String>,
        found: impl Into<String>,
    ) -> CalibrationError {
        let (key, must, found) = (key.to_owned(), must.into(), found.into());
        CalibrationError::Value { line: self.line, key, must, found }
    }

    /// A finite number.
    pub(super) fn number(&self, key: &str) -> Result<f64, CalibrationError> {
        match self.value {
            Value::Number(number) if number.is_finite() => Ok(number),
            _ => Err(self.fault(key, "a finite number")),
        }
    }

    /// A matrix as OpenCV writes it, a list of rows, or a list of numbers.
    pub(super) fn matrix(&self, key: &str) -> Result<Matrix, CalibrationError> {
        match &self.value {
            Value::Number(_) => Ok(Matrix { size: None, numbers: vec![self.number(key)?] }),
            Value::List(list) => listed(list, self, key),
            Value::Table(table) => tabulated(table, self, key),
            Value::Text(_) => Err(self.fault(key, "a matrix or a list of numbers")),
        }
    }
}

/// The one value whose key is any of `names`, written with capitals and underscores or without.
///
/// # Errors
/// Several of them.
pub(super) fn find<'t>(
    table: &'t [(String, TreeNode)],
    names: &[&str],
) -> Result<Option<(&'t str, &'t TreeNode)>, CalibrationError> {
    let plain = |key: &str| key.replace('_', "").to_ascii_lowercase();
    let mut found = table.iter().filter(|(key, _)| names.contains(&plain(key).as_str()));
    let Some((first, node)) = found.next() else { return Ok(None) };
    match found.next() {
        Some((again, other)) => {
            Err(other.found_other(first, "given only once", format!("{again} as well")))
        }
        None => Ok(Some((first, node))),
    }
}

/// A list of numbers, or of lists of equally many numbers.
fn listed(list: &[TreeNode], node: &TreeNode, key: &str) -> Result<Matrix, CalibrationError> {
    if !list.iter().any(|item| matches!(item.value, Value::List(_))) {
        let numbers = list.iter().map(|item| item.number(key)).collect::<Result<_, _>>()?;
        return Ok(Matrix { size: None, numbers });
    }
    let (mut numbers, mut columns) = (Vec::new(), None);
    for row in list {
        let Value::List(items) = &row.value else {
            return Err(row.fault(key, "a list of rows alone"));
        };
        if *columns.get_or_insert(items.len()) != items.len() {
            return Err(row.fault(key, "a list of rows of equal length"));
        }
        for item in items {
            numbers.push(item.number(key)?);
        }
    }
    let columns = columns.ok_or_else(|| node.fault(key, "a list of rows"))?;
    Ok(Matrix { size: Some([list.len(), columns]), numbers })
}

/// Rows, columns and data.
fn tabulated(
    table: &[(String, TreeNode)],
    node: &TreeNode,
    key: &str,
) -> Result<Matrix, CalibrationError> {
    let must = "a matrix with rows, cols and data";
    let part = |name: &str| {
        let found = find(table, &[name])?.map(|(_, part)| part);
        found.ok_or_else(|| node.found_other(key, must, format!("no {name}")))
    };
    let count = |name: &str| {
        let (name, part) = (format!("{key}.{name}"), part(name)?);
        match part.number(&name)? {
            n if n.fract() == 0.0 && (0.0..=1e6).contains(&n) => Ok(n as usize),
            _ => Err(part.fault(&name, "a whole number")),
        }
    };
    let [rows, columns] = [count("rows")?, count("cols")?];
    let (data, name) = (part("data")?, format!("{key}.data"));
    let numbers = match &data.value {
        Value::List(list) => {
            list.iter().map(|item| item.number(&name)).collect::<Result<Vec<f64>, _>>()?
        }
        Value::Number(_) => vec![data.number(&name)?],
        // An XML element without anything in it.
        Value::Text(text) if text.is_empty() => Vec::new(),
        _ => return Err(data.fault(&name, "a list of numbers")),
    };
    if numbers.len() != rows * columns {
        let must = format!("a list of rows x cols = {rows} x {columns} numbers");
        return Err(data.found_other(&name, must, format!("a list of {}", numbers.len())));
    }
    Ok(Matrix { size: Some([rows, columns]), numbers })
}
