//! SHA-256 of bytes, and of what is written.

use crate::parallel;
use crate::profile::hex;
use sha2::{Digest, Sha256};
use std::io::{self, Read, Write};

/// Bytes from which on hashing them beside writing them is worth a second thread.
const BESIDE: usize = 1 << 17;

/// Writer that passes bytes on and hashes them.
pub struct HashingWriter<W> {
    out: W,
    hash: Sha256,
}

impl<W: Write + Send> HashingWriter<W> {
    /// A writer to `out`.
    pub fn new(out: W) -> Self {
        Self { out, hash: Sha256::new() }
    }

    /// SHA-256 of the bytes so far, hexadecimal.
    pub fn sha256(self) -> String {
        hex(&self.hash.finalize())
    }
}

impl<W: Write + Send> Write for HashingWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if bytes.len() >= BESIDE {
            let mut hash = self.hash.clone();
            let (written, ()) = parallel::join(|| self.out.write(bytes), || hash.update(bytes));
            if let Ok(count) = written
                && count == bytes.len()
            {
                self.hash = hash;
                return Ok(count);
            }
            // (Not all of them, or none.)
            self.hash.update(&bytes[..written.as_ref().map_or(0, |count| *count)]);
            return written;
        }
        let count = self.out.write(bytes)?;
        self.hash.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Reads all bytes of `read` in pieces, the first of so many bytes, the others of so many, and the last of what is
/// left; each is handed on while it is hashed. Their number, and their SHA-256.
///
/// # Errors
/// That of `read`.
pub fn hash_pieces(
    read: &mut (dyn Read + Send),
    [first, size]: [usize; 2],
    mut each: impl FnMut(&[u8]) + Send,
) -> io::Result<(u64, String)> {
    let (mut hash, mut length) = (Sha256::new(), 0);
    let (mut piece, mut next) = (Vec::with_capacity(first), Vec::with_capacity(size));
    read.take(first as u64).read_to_end(&mut piece)?;
    while !piece.is_empty() {
        length += piece.len() as u64;
        next.clear();
        let (read, ()) = parallel::join(
            || {
                each(&piece);
                (&mut *read).take(size as u64).read_to_end(&mut next)
            },
            || hash.update(&piece),
        );
        read?;
        std::mem::swap(&mut piece, &mut next);
    }
    Ok((length, hex(&hash.finalize())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::sha256;

    /// Takes so many bytes at a time, and each third time none.
    struct Reluctant {
        taken: Vec<u8>,
        most: usize,
        calls: usize,
    }

    impl Write for Reluctant {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.calls += 1;
            if self.calls.is_multiple_of(3) {
                return Err(io::ErrorKind::Interrupted.into());
            }
            let count = bytes.len().min(self.most);
            self.taken.extend(&bytes[..count]);
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn pieces_are_all_bytes_in_their_order() {
        for count in [0, 10, 11, 1000, 1003] {
            let bytes: Vec<u8> = (0..count).map(|k| (k * 7) as u8).collect();
            let mut pieces: Vec<Vec<u8>> = Vec::new();
            let found = hash_pieces(&mut &bytes[..], [10, 33], |piece| pieces.push(piece.to_vec()));
            assert_eq!(found.unwrap(), (count as u64, sha256(&bytes)));
            assert_eq!(pieces.concat(), bytes);
            let lengths: Vec<usize> = pieces.iter().map(Vec::len).collect();
            assert!(
                lengths.iter().skip(1).rev().skip(1).all(|length| *length == 33),
                "{lengths:?}"
            );
            assert!(lengths.first().is_none_or(|first| *first == 10), "{lengths:?}");
        }
    }

    #[test]
    fn what_is_hashed_is_what_was_taken() {
        let bytes: Vec<u8> = (0..5 * BESIDE).map(|k| ((k * k) >> 7) as u8).collect();
        for most in [1000, BESIDE, 3 * BESIDE, usize::MAX] {
            let mut out = Reluctant { taken: Vec::new(), most, calls: 0 };
            let mut writer = HashingWriter::new(&mut out);
            writer.write_all(&bytes[..100]).unwrap();
            writer.write_all(&bytes[100..]).unwrap();
            let found = writer.sha256();
            assert!(out.taken == bytes, "{most}");
            assert_eq!(found, sha256(&bytes), "{most}");
        }
    }
}
