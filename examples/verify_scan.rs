//! A measured part against its profile: pose, form error and what the camera would see in it.
//!
//! `cargo run --release --example verify_scan -- scan.stl conquistador`
//!
//! Without a file the part is made first, turned and shifted as a scanner might see it.

use morion::{Command, Profile, Silent, Verify, VerifyOptions, build};
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let scan = arguments.next().map(PathBuf::from);
    let profile = Profile::load(&arguments.next().unwrap_or_else(|| "parabolic".into()))?;
    let folder = tempfile::tempdir()?;
    let scan = match scan {
        Some(scan) => scan,
        None => {
            build(&profile, folder.path())?;
            let part = folder.path().join(&profile.name).join("mirror.stl");
            moved(&part, &folder.path().join("scan.obj"))?
        }
    };

    let options = VerifyOptions { align: true, ..VerifyOptions::default() };
    let verify = Verify { path: &scan, options };
    let report = verify.publish(&profile, folder.path(), &Silent)?;
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
    let stl = std::fs::read(part)?;
    let (s, c) = (0.052, (1.0 - 0.052f32 * 0.052).sqrt());
    let mut obj = String::new();
    // After a header of 84 bytes, 50 bytes a facet: its normal, its corners, and two bytes more.
    for (k, facet) in stl[84..].chunks_exact(50).enumerate() {
        for corner in facet[12..48].chunks_exact(12) {
            let number = |i: usize| f32::from_le_bytes(std::array::from_fn(|k| corner[4 * i + k]));
            let [x, y, z] = [0, 1, 2].map(number);
            let (y, z) = (c * y - s * z, s * y + c * z);
            writeln!(obj, "v {} {} {}", x + 1.5, y - 0.8, z + 2.0)?;
        }
        writeln!(obj, "f {} {} {}", 3 * k + 1, 3 * k + 2, 3 * k + 3)?;
    }
    std::fs::write(scan, obj)?;
    Ok(scan.to_path_buf())
}
