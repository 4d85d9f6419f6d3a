//! Files altered between writing and reading.

use morion::internals::pipeline::Observer;
use std::path::Path;

/// Rewrites each file as soon as it is written.
pub struct FileRewriter<F>(pub F);

impl<F: Fn(Vec<u8>) -> Vec<u8> + Sync> Observer for FileRewriter<F> {
    fn written(&self, path: &Path) {
        let bytes = std::fs::read(path).unwrap();
        std::fs::write(path, self.0(bytes)).unwrap();
    }
}

/// `bytes` with some bits changed of the one that is so far along, percent.
pub fn flipped(mut bytes: Vec<u8>, percent: usize, bits: u8) -> Vec<u8> {
    let at = bytes.len() * percent / 100;
    bytes[at] ^= bits;
    bytes
}
