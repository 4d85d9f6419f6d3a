//! Standard input and output as streams of bytes: without the buffers for lines that they have else, which would copy each frame once more.

#[cfg(unix)]
use std::fs::File;
use std::io::{self, Read, Write};

/// Standard input.
pub(super) fn input() -> Box<dyn Read + Send> {
    #[cfg(unix)]
    if let Ok(file) = owned(&io::stdin()) {
        return Box::new(file);
    }
    Box::new(io::stdin())
}

/// Standard output.
pub(super) fn output() -> Box<dyn Write + Send> {
    #[cfg(unix)]
    if let Ok(file) = owned(&io::stdout()) {
        return Box::new(file);
    }
    Box::new(io::stdout())
}

#[cfg(unix)]
fn owned(stream: &impl std::os::fd::AsFd) -> io::Result<File> {
    stream.as_fd().try_clone_to_owned().map(File::from)
}
