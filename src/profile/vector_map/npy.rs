//! NumPy arrays of vectors, by the format's definition (NumPy Enhancement Proposal 1).

use super::{VectorMap, VectorMapError, checked};
use crate::geom::DVec3;

/// The first bytes.
pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

pub(super) fn parse(bytes: &[u8]) -> Result<VectorMap, VectorMapError> {
    let fault = |account: &str| VectorMapError::Npy(account.to_owned());
    let cut = || fault("the file ends too early");
    let version = *bytes.get(MAGIC.len()).ok_or_else(cut)?;
    // The length of the header has two bytes in version 1, and four in 2 and 3.
    let width = if version == 1 { 2 } else { 4 };
    let first = MAGIC.len() + 2;
    let length = bytes.get(first..first + width).ok_or_else(cut)?;
    let length = length.iter().rev().fold(0usize, |sum, byte| 256 * sum + usize::from(*byte));
    let begin = first + width;
    let header = bytes.get(begin..begin.saturating_add(length)).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| fault("its header is no text"))?;
    let [rows, columns] = shape(header)?;
    let is_fortran = field(header, "fortran_order").is_some_and(|order| order.starts_with("True"));
    let number = number(header)?;
    let size = number.bytes;
    let count = checked(columns, rows)?;
    let data = &bytes[begin + length..];
    if data.len() != 3 * count * size {
        let (found, wanted) = (data.len(), 3 * count * size);
        return Err(fault(&format!(
            "{rows} x {columns} x 3 numbers of {size} bytes are {wanted} bytes, found {found}"
        )));
    }
    let value = |k: usize| (number.read)(&data[k * size..(k + 1) * size]);
    let vector = |k: usize| {
        let (row, column) = (k / columns, k % columns);
        let place = |axis: usize| match is_fortran {
            false => 3 * k + axis,
            true => (axis * columns + column) * rows + row,
        };
        DVec3::from_array([0, 1, 2].map(|axis| value(place(axis))))
    };
    Ok(VectorMap { columns, vectors: (0..count).map(vector).collect() })
}

/// What follows a key of the header, a dictionary as Python writes it.
fn field<'h>(header: &'h str, key: &str) -> Option<&'h str> {
    let (_, rest) = header.split_once(&format!("'{key}'"))?;
    Some(rest.trim_start().strip_prefix(':')?.trim_start())
}

/// Rows and columns.
fn shape(header: &str) -> Result<[usize; 2], VectorMapError> {
    let list = field(header, "shape").and_then(|rest| rest.strip_prefix('(')?.split_once(')'));
    let (list, _) = list.ok_or_else(|| VectorMapError::Npy("its header has no shape".into()))?;
    let sides: Option<Vec<usize>> = list
        .split(',')
        .map(str::trim)
        .filter(|side| !side.is_empty())
        .map(|s| s.parse().ok())
        .collect();
    match sides.as_deref() {
        Some(&[rows, columns, 3]) => Ok([rows, columns]),
        _ => {
            let account = format!("its shape must be (rows, columns, 3), found ({list})");
            Err(VectorMapError::Npy(account))
        }
    }
}

/// A kind of number in a file.
struct NumberFormat {
    bytes: usize,
    read: fn(&[u8]) -> f64,
}

fn number(header: &str) -> Result<NumberFormat, VectorMapError> {
    let found = field(header, "descr").and_then(|rest| rest.strip_prefix('\'')?.split_once('\''));
    let found = found.map_or("", |(found, _)| found);
    Ok(match found {
        "<f4" => NumberFormat { bytes: 4, read: |b| f64::from(f32::from_le_bytes(array(b))) },
        ">f4" => NumberFormat { bytes: 4, read: |b| f64::from(f32::from_be_bytes(array(b))) },
        "<f8" => NumberFormat { bytes: 8, read: |b| f64::from_le_bytes(array(b)) },
        ">f8" => NumberFormat { bytes: 8, read: |b| f64::from_be_bytes(array(b)) },
        other => {
            return Err(VectorMapError::Npy(format!(
                "its numbers must be float32 or float64, found {other:?}"
            )));
        }
    })
}

/// The bytes of one number.
fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|k| bytes[k])
}
