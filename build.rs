//! Tells the program which sources it is made of, so that it knows its own results again, and packs its large texts.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use sha2::{Digest, Sha256};
use std::fs;
use std::io::Write;
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
    let mut texts =
        vec!["docs/profile.md".into(), "src/report/page/assets/three/three.min.js".into()];
    for (folder, ends) in [
        ("src/cli/schemas", &["json"][..]),
        ("src/studio/assets", &["css", "html", "js"]),
        ("profiles", &["toml"]),
    ] {
        let mut files = Vec::new();
        collect(Path::new(folder), &mut files)?;
        let is_text =
            |file: &PathBuf| ends.iter().any(|end| file.extension() == Some(end.as_ref()));
        texts.extend(files.into_iter().filter(is_text));
    }
    texts.iter().try_for_each(|file| pack(file))
}

/// Packs a text into a file of its name that the program includes: nine tenths of a megabyte are a fifth of one so.
fn pack(file: &Path) -> std::io::Result<()> {
    println!("cargo:rerun-if-changed={}", file.display());
    let name = file.file_name().unwrap_or_default();
    let folder = std::env::var_os("OUT_DIR").unwrap_or_default();
    let packed = fs::File::create(Path::new(&folder).join(name))?;
    let mut encoder = ZlibEncoder::new(packed, Compression::best());
    encoder.write_all(&fs::read(file)?)?;
    encoder.finish()?;
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
