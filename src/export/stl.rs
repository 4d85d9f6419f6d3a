//! Binary STL through `stl_io`.

use super::Label;
use crate::solid::Solid;
use std::io::{self, Write};
use stl_io::{Normal, Triangle, Vertex};

/// Length of the free text that begins a binary STL.
const HEADER: usize = 80;

/// Bytes of a triangle: its normal, its corners, and an attribute that nothing uses.
const TRIANGLE: u64 = 50;

/// The length of what [`write_stl`] writes of so many triangles.
#[must_use]
pub fn stl_bytes(triangles: usize) -> u64 {
    HEADER as u64 + 4 + TRIANGLE * triangles as u64
}

/// Writes `solid`, whose coordinates should be single-precision numbers, as binary STL with facet
/// normals. The header names the program, the profile, the unit, the camera's place and the tolerances, as
/// far as they fit, and never begins with "solid", by which readers know the text form.
///
/// # Errors
/// Whatever `out` returns, flushing included.
pub fn write_stl(out: &mut impl Write, solid: &Solid, label: &Label) -> io::Result<()> {
    let mesh = solid.mesh();
    let facets = (0..mesh.triangles.len()).map(|t| {
        let normal = mesh.area_vector(t).normalize().as_vec3() + 0.0;
        let corners = mesh.corners(t).map(|v| Vertex::new(v.as_vec3().to_array()));
        Triangle { normal: Normal::new(normal.to_array()), vertices: corners }
    });
    let mut out = WithHeader { out, header: header(label), written: 0 };
    stl_io::write_stl(&mut out, facets)?;
    out.flush()
}

fn header(label: &Label) -> [u8; HEADER] {
    let hash = &label.sha256[..label.sha256.len().min(8)];
    let camera = label.mounting.first().map_or(String::new(), |camera| format!("{camera}; "));
    let text = format!("Morion {} {hash} mm {camera}{}", label.profile, label.tolerances);
    let mut header = [b' '; HEADER];
    for (to, from) in header.iter_mut().zip(Label::plain(&text).bytes()) {
        *to = from;
    }
    header
}

/// Puts our header in the place of the blank one that `stl_io` writes.
struct WithHeader<'a, W: Write> {
    out: &'a mut W,
    header: [u8; HEADER],
    written: usize,
}

impl<W: Write> Write for WithHeader<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = if self.written < HEADER {
            let count = bytes.len().min(HEADER - self.written);
            self.out.write(&self.header[self.written..self.written + count])?
        } else {
            self.out.write(bytes)?
        };
        self.written += count;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
