use super::*;
use exr::prelude::{Image, SpecificChannels, Vec2, WritableImage};
use std::io::Cursor;

/// The vector of a row and a column, each part of it a number of single precision.
fn vector(row: usize, column: usize) -> DVec3 {
    DVec3::new(row as f64 + 0.5, column as f64 - 0.25, 0.125)
}

fn wanted() -> VectorMap {
    let vectors = (0..6).map(|k| if k == 4 { DVec3::NAN } else { vector(k / 3, k % 3) });
    VectorMap { columns: 3, vectors: vectors.collect() }
}

/// Whether two maps are the same, gaps included.
fn same(a: &VectorMap, b: &VectorMap) -> bool {
    let bits = |map: &VectorMap| {
        let parts = map.vectors.iter().flat_map(|v| v.to_array());
        parts.map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }).collect::<Vec<_>>()
    };
    a.columns == b.columns && bits(a) == bits(b)
}

fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = npy::MAGIC.to_vec();
    bytes.extend([version, 0]);
    match version {
        1 => bytes.extend((header.len() as u16).to_le_bytes()),
        _ => bytes.extend((header.len() as u32).to_le_bytes()),
    }
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn header(descr: &str, fortran: &str, shape: &str) -> String {
    format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n")
}

#[test]
fn arrays_of_all_kinds_are_the_same_map() {
    let map = wanted();
    let parts: Vec<f64> = map.vectors.iter().flat_map(|v| v.to_array()).collect();
    let little: Vec<u8> = parts.iter().flat_map(|x| x.to_le_bytes()).collect();
    let big: Vec<u8> = parts.iter().flat_map(|x| (*x as f32).to_be_bytes()).collect();
    // Column-major: the row changes fastest.
    let turned: Vec<u8> = (0..18)
        .map(|k| parts[3 * ((k % 2) * 3 + k / 2 % 3) + k / 6])
        .flat_map(f64::to_le_bytes)
        .collect();
    for bytes in [
        npy(1, &header("<f8", "False", "(2, 3, 3)"), &little),
        npy(2, &header(">f4", "False", "(2, 3, 3)"), &big),
        npy(3, &header("<f8", "True", "(2, 3, 3)"), &turned),
    ] {
        assert!(same(&VectorMap::parse(&bytes).unwrap(), &map));
    }
}

#[test]
fn pictures_and_text_are_the_same_map() {
    let map = wanted();
    let at = |place: Vec2<usize>| {
        let [x, y, z] = map.vectors[place.y() * 3 + place.x()].to_array().map(|x| x as f32);
        (x, y, z)
    };
    let mut bytes = Cursor::new(Vec::new());
    let channels = SpecificChannels::rgb(at);
    Image::from_channels((3, 2), channels).write().non_parallel().to_buffered(&mut bytes).unwrap();
    assert!(same(&VectorMap::parse(&bytes.into_inner()).unwrap(), &map));

    // The gap has no line, or says so.
    for (mark, gap) in [(",", ""), ("; ", "1; 1; nan; NaN; nan\n"), ("\t", "")] {
        let lines = (0..6).rev().filter(|k| *k != 4).map(|k| {
            let [x, y, z] = map.vectors[k].to_array();
            let (row, column) = (k / 3, k % 3);
            [row.to_string(), column.to_string(), x.to_string(), y.to_string(), z.to_string()]
                .join(mark)
        });
        let lines: Vec<String> = lines.collect();
        let text =
            format!("row{mark}column{mark}x{mark}y{mark}z\n# none\n{gap}{}\n", lines.join("\n"));
        assert!(same(&VectorMap::parse(text.as_bytes()).unwrap(), &map), "{mark:?}");
    }
}

#[test]
fn faults_are_named_at_their_place() {
    let fault = |bytes: &[u8]| VectorMap::parse(bytes).unwrap_err().to_string();
    let array = |header: &str, bytes: usize| fault(&npy(1, header, &vec![0; bytes]));
    let shape = array(&header("<f8", "False", "(480, 640)"), 0);
    assert!(shape.ends_with("its shape must be (rows, columns, 3), found (480, 640)"), "{shape}");
    let whole = array(&header("<i8", "False", "(2, 3, 3)"), 144);
    assert!(whole.ends_with("its numbers must be float32 or float64, found \"<i8\""), "{whole}");
    let short = array(&header("<f8", "False", "(2, 3, 3)"), 143);
    assert!(short.ends_with("2 x 3 x 3 numbers of 8 bytes are 144 bytes, found 143"), "{short}");
    let many = array(&header("<f8", "False", "(30000, 40000, 3)"), 0);
    assert!(
        many.starts_with("a map must have at most 4000000 samples, found 1200000000"),
        "{many}"
    );
    let huge = array(&header("<f8", "False", &format!("({0}, {0}, 3)", u64::MAX)), 0);
    assert!(huge.contains("samples, found 18446744073709551615"), "{huge}");
    assert_eq!(array(&header("<f8", "False", "(0, 3, 3)"), 0), "it holds no samples");
    for cut in 6..20 {
        let bytes = npy(1, &header("<f8", "False", "(2, 3, 3)"), &[0; 144]);
        assert!(fault(&bytes[..cut]).ends_with("the file ends too early"), "{cut}");
    }
    assert_eq!(fault(b"0,0,1,2,3\n0,1,1,x,3"), "line 2: \"x\" is no number");
    let two = "line 2: it must hold row, column, X, Y and Z, found 2 of them";
    assert_eq!(fault(b"0 0 1 2 3\n0 1\n"), two);
    let whole = "line 1: a row or column must be a whole number from 0, found 0.5";
    assert_eq!(fault(b"0.5 0 1 2 3\n"), whole);
    let again = "line 3: row 0, column 1 must be given once, line 2 has it too";
    assert_eq!(fault(b"row column x y z\n0 1 1 2 3\n0 1 1 2 3\n"), again);
    assert!(fault(b"3999999 3999999 0 0 1").contains("must have at most 4000000 samples"));
    assert_eq!(fault(b"# nothing\n"), "it holds no samples");
    assert_eq!(fault(b"\xff\xfe\x00"), VectorMapError::Unknown.to_string());
}
