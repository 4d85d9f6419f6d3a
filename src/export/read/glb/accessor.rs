//! Accessors of a GLB: where in the binary chunk a sequence lies, every claim of which is checked.

use super::GlbError;
use super::document::{Accessor, Buffer, BufferView, Document};
use crate::geom::DVec3;

/// Codes of the kinds of numbers that are read.
const BYTE: u32 = 5121;
const SHORT: u32 = 5123;
const LONG: u32 = 5125;
const SINGLE: u32 = 5126;

/// Greatest distance of neighbours in a sequence, bytes.
const MOST_STRIDE: usize = 252;

/// A sequence of equally long items within the binary chunk.
struct Items<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
}

impl<'a> Items<'a> {
    /// Finds the items of an accessor, of `size` bytes each.
    fn new(
        document: &Document,
        bin: &'a [u8],
        (part, accessor): (&str, &Accessor),
        size: usize,
    ) -> Result<Self, GlbError> {
        let wrong = |fault: String| GlbError::of(part, fault);
        if accessor.sparse.is_some() {
            return Err(wrong("sparse data are not read: save it without them".to_owned()));
        }
        let Some(view) = accessor.buffer_view else {
            let fault = "it has no data of its own: save it without compression";
            return Err(wrong(fault.to_owned()));
        };
        let name = format!("bufferViews[{view}]");
        let view = item(&document.buffer_views.0, view, part, "bufferView")?;
        let stride = view.byte_stride.unwrap_or(size);
        if !(size..=MOST_STRIDE).contains(&stride) {
            let fault = format!("byteStride is {stride}, not from {size} to {MOST_STRIDE}");
            return Err(GlbError::of(name, fault));
        }
        let bytes = viewed(document, bin, &name, view)?;
        let count = accessor.count;
        let length = || count.checked_sub(1)?.checked_mul(stride)?.checked_add(size);
        let found = length().and_then(|length| bytes.get(accessor.byte_offset..)?.get(..length));
        match found {
            Some(bytes) => Ok(Self { bytes, stride, count }),
            None if count == 0 => Err(wrong("its count is 0".to_owned())),
            None => Err(wrong(format!(
                "its {count} items of {size} bytes do not fit into the {} bytes of {name}",
                bytes.len()
            ))),
        }
    }

    /// The first `N` bytes of an item that is there.
    #[inline]
    fn get<const N: usize>(&self, k: usize) -> [u8; N] {
        let mut item = [0; N];
        item.copy_from_slice(&self.bytes[k * self.stride..][..N]);
        item
    }
}

/// An accessor by its number, and its name.
fn accessor<'d>(
    document: &'d Document,
    user: &str,
    number: usize,
) -> Result<(&'d Accessor, String), GlbError> {
    let accessor = item(&document.accessors.0, number, user, "accessor")?;
    Ok((accessor, format!("accessors[{number}]")))
}

/// An item of a list of the document by its number.
pub(super) fn item<'d, T>(
    list: &'d [T],
    number: usize,
    user: &str,
    kind: &str,
) -> Result<&'d T, GlbError> {
    let count = list.len();
    list.get(number).ok_or_else(|| {
        GlbError::of(user, format!("there is no {kind} {number}, but {count} of them"))
    })
}

/// The bytes of a view, which must lie in the binary chunk.
fn viewed<'a>(
    document: &Document,
    bin: &'a [u8],
    name: &str,
    view: &BufferView,
) -> Result<&'a [u8], GlbError> {
    let Buffer { byte_length, uri } = item(&document.buffers.0, view.buffer, name, "buffer")?;
    let buffer = format!("buffers[{}]", view.buffer);
    if view.buffer != 0 || uri.is_some() {
        let fault = "it is outside of the file's binary chunk, which alone is read: save it as one GLB \
                     without compression";
        return Err(GlbError::of(buffer, fault));
    }
    let Some(bytes) = bin.get(..*byte_length) else {
        let fault = format!("it has {byte_length} bytes, but the binary chunk has {}", bin.len());
        return Err(GlbError::of(buffer, fault));
    };
    bytes.get(view.byte_offset..).and_then(|bytes| bytes.get(..view.byte_length)).ok_or_else(|| {
        let fault = format!("it does not fit into the {byte_length} bytes of {buffer}");
        GlbError::of(name, fault)
    })
}

/// Positions of vertices.
pub(super) struct Positions<'a>(Items<'a>);

impl<'a> Positions<'a> {
    /// The positions in an accessor.
    pub(super) fn new(
        document: &Document,
        bin: &'a [u8],
        part: &str,
        number: usize,
    ) -> Result<Self, GlbError> {
        let (accessor, part) = accessor(document, part, number)?;
        if (&*accessor.kind, accessor.component_type) != ("VEC3", SINGLE) || accessor.normalized {
            let fault = "positions must be VEC3 of single-precision numbers (5126): save it without \
                         quantization";
            return Err(GlbError::of(part, fault));
        }
        Ok(Self(Items::new(document, bin, (&part, accessor), 12)?))
    }

    pub(super) fn count(&self) -> usize {
        self.0.count
    }

    #[inline]
    pub(super) fn get(&self, k: usize) -> DVec3 {
        let bytes: [u8; 12] = self.0.get(k);
        let number = |k: usize| {
            f64::from(f32::from_le_bytes([bytes[k], bytes[k + 1], bytes[k + 2], bytes[k + 3]]))
        };
        DVec3::new(number(0), number(4), number(8))
    }
}

/// Numbers of the vertices at the corners of facets.
pub(super) enum Corners<'a> {
    /// Those of an accessor.
    Listed(Indices<'a>),
    /// All vertices in turn, so many.
    InTurn(usize),
}

/// Numbers of vertices in an accessor.
pub(super) struct Indices<'a> {
    items: Items<'a>,
    kind: u32,
}

impl<'a> Indices<'a> {
    /// The numbers in an accessor.
    pub(super) fn new(
        document: &Document,
        bin: &'a [u8],
        part: &str,
        number: usize,
    ) -> Result<Self, GlbError> {
        let (accessor, part) = accessor(document, part, number)?;
        let kind = accessor.component_type;
        let size = match kind {
            BYTE => 1,
            SHORT => 2,
            LONG => 4,
            _ => 0,
        };
        if size == 0 || accessor.kind != "SCALAR" || accessor.normalized {
            let fault = "indices must be SCALAR and unsigned (5121, 5123 or 5125)";
            return Err(GlbError::of(part, fault));
        }
        Ok(Self { items: Items::new(document, bin, (&part, accessor), size)?, kind })
    }

    #[inline]
    fn get(&self, k: usize) -> u32 {
        match self.kind {
            BYTE => u32::from(self.items.get::<1>(k)[0]),
            SHORT => u32::from(u16::from_le_bytes(self.items.get(k))),
            _ => u32::from_le_bytes(self.items.get(k)),
        }
    }
}

impl Corners<'_> {
    pub(super) fn count(&self) -> usize {
        match self {
            Self::Listed(indices) => indices.items.count,
            Self::InTurn(count) => *count,
        }
    }

    /// The vertices of a facet that is there.
    #[inline]
    pub(super) fn facet(&self, t: usize) -> [usize; 3] {
        [3 * t, 3 * t + 1, 3 * t + 2].map(|k| match self {
            Self::Listed(indices) => indices.get(k) as usize,
            Self::InTurn(_) => k,
        })
    }
}
