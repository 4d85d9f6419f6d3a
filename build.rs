//! Tells the program which sources it is made of, so that it knows its own results again.

use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};

fn main() -> std::io::Result<()> {
    println!("cargo:rerun-if-changed=src");
    println!("cargo:rerun-if-changed=profiles");
    let mut files: Vec<PathBuf> = ["Cargo.toml".into(), "Cargo.lock".into()].into();
    for folder in ["src", "profiles"] {
        collect(Path::new(folder), &mut files)?;
    }
    // The order of a folder's entries is the file system's.
    files.sort();
    let mut hash = Sha256::new();
    for file in files {
        println!("cargo:rerun-if-changed={}", file.display());
        // As a dependency it has no lock file of its own.
        hash.update(fs::read(&file).unwrap_or_default());
    }
    let hex: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    println!("cargo:rustc-env=MORION_SOURCES={hex}");
    Ok(())
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}
