//! A measured part against its profile: pose, form error and what the camera would see in it.
//!
//! `cargo run --release --example verify_scan -- scan.stl conquistador`
//!
//! Without a file the part is made first, turned and shifted as a scanner might see it.

use morion::internals::export::read_stl;
use morion::internals::pipeline::{Command, Silent, Verify, VerifyOptions, build, load};
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let scan = arguments.next().map(PathBuf::from);
    let source = load(&arguments.next().unwrap_or_else(|| "parabolic".into()))?;
    let folder = tempfile::tempdir()?;
    let scan = match scan {
        Some(scan) => scan,
        None => {
            build(&source, folder.path(), &Silent)?;
            let part = folder.path().join(&source.name).join("mirror.stl");
            moved(&part, &folder.path().join("scan.obj"))?
        }
    };

    let options = VerifyOptions { align: true, ..VerifyOptions::default() };
    let verify = Verify { path: &scan, options };
    let report = verify.publish(&source, folder.path(), &Silent)?;
    if let Some(alignment) = &report.alignment {
        println!("pose:       distances of {:.3} um RMS are left", alignment.rms_um);
    }
    if let Some(form) = &report.form_error_um {
        println!("form error: {:.3} um from peak to valley", form.all.pv);
    }
    println!("verdict:    {:?}", report.verdict);
    for reason in &report.reasons {
        println!("            {reason}");
    }
    Ok(())
}

/// Writes the part as a scanner might see it: turned by 52 mrad about X, and shifted.
fn moved(part: &Path, scan: &Path) -> Result<PathBuf, Box<dyn std::error::Error>> {
    let mesh = read_stl(&std::fs::read(part)?)?.mesh;
    let (s, c) = (0.052, (1.0 - 0.052f64 * 0.052).sqrt());
    let mut obj = String::new();
    for v in &mesh.vertices {
        let (y, z) = (c * v.y - s * v.z, s * v.y + c * v.z);
        writeln!(obj, "v {} {} {}", v.x + 1.5, y - 0.8, z + 2.0)?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(obj, "f {} {} {}", a + 1, b + 1, c + 1)?;
    }
    std::fs::write(scan, obj)?;
    Ok(scan.to_path_buf())
}
