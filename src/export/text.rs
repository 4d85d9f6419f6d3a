//! Lines of text, many at a time, and how long they are.

use crate::parallel;
use std::io::{self, Write};

/// Lines formatted by a thread at a time.
const CHUNK: usize = 8192;

/// One line of text an item, formatted in parallel, written in order.
pub(super) fn lines<T: Sync>(
    out: &mut impl Write,
    items: &[T],
    line: impl Fn(&mut Vec<u8>, &T) -> io::Result<()> + Sync,
) -> io::Result<()> {
    let format = |chunk: &[T]| -> io::Result<Vec<u8>> {
        let mut text = Vec::with_capacity(64 * chunk.len());
        chunk.iter().try_for_each(|item| line(&mut text, item))?;
        Ok(text)
    };
    // A few chunks at a time, so that the text of a large file is never in memory as a whole.
    for group in items.chunks(16 * CHUNK) {
        for text in parallel::map_chunks(group, CHUNK, format) {
            out.write_all(&text?)?;
        }
    }
    Ok(())
}

/// Counts the bytes written to it and keeps none.
#[derive(Debug, Clone, Default)]
pub struct ByteCounter(u64);

impl ByteCounter {
    /// How many they were.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0
    }
}

impl Write for ByteCounter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
