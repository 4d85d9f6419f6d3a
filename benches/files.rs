//! How long writing and reading a part takes in each mesh format, beside copying the file.
//!
//! usage: cargo bench --bench files [-- TRIANGLES]

use morion::internals::export::{Label, read_3mf, read_stl, write_3mf, write_stl};
use morion::internals::geom::{DVec3, PartFeatures, Precision, TriMesh};
use morion::internals::solid::Solid;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::time::Instant;

/// A gently curved square face of about so many triangles.
fn face(triangles: usize) -> TriMesh {
    let side = ((triangles / 2) as f64).sqrt() as u32;
    let at = |k: u32| 60.0 * (f64::from(k) / f64::from(side) - 0.5);
    let vertex = |k: u32| {
        let (x, y) = (at(k % (side + 1)), at(k / (side + 1)));
        DVec3::new(x, y, 20.0 + 0.005 * x * x - 0.004 * y * y)
    };
    let cell = |k: u32| {
        let a = k % side + (k / side) * (side + 1);
        let [b, c, d] = [a + 1, a + side + 1, a + side + 2];
        [[a, b, d], [a, d, c]]
    };
    TriMesh {
        vertices: (0..(side + 1) * (side + 1)).map(vertex).collect(),
        triangles: (0..side * side).flat_map(cell).collect(),
    }
}

/// The least of three times, ms.
fn least<T>(mut run: impl FnMut() -> Result<T, Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        run()?;
        best = best.min(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(best)
}

fn main() -> Result<(), Box<dyn Error>> {
    // cargo adds `--bench`.
    let mut given = std::env::args().skip(1).filter(|text| text != "--bench");
    let triangles = given.next().map_or(Ok(1_000_000), |text| text.parse())?;
    let solid = Solid::from_face(&face(triangles).into(), PartFeatures::NONE, Precision::Single)?;
    let label = Label {
        profile: "files".into(),
        sha256: "0".repeat(64),
        tolerances: "none".into(),
        mounting: Vec::new(),
    };
    let folder = tempfile::tempdir()?;
    println!("{} triangles", solid.mesh().triangles.len());
    for format in ["stl", "3mf"] {
        let path = folder.path().join(format!("part.{format}"));
        let write = least(|| {
            let mut out = BufWriter::with_capacity(1 << 20, File::create(&path)?);
            match format {
                "stl" => write_stl(&mut out, &solid, &label)?,
                _ => write_3mf(&mut out, &solid, &label)?,
            }
            Ok(out.flush()?)
        })?;
        let read = least(|| {
            let bytes = std::fs::read(&path)?;
            Ok(match format {
                "stl" => read_stl(&bytes)?,
                _ => read_3mf(&bytes)?,
            })
        })?;
        // Through memory: some systems copy by a mere reference.
        let copy =
            least(|| Ok(std::fs::write(folder.path().join("copy"), std::fs::read(&path)?)?))?;
        let megabytes = std::fs::metadata(&path)?.len() as f64 / 1e6;
        println!(
            "{format}: {megabytes:.1} MB; copy {copy:.0} ms, write {write:.0} ms, read {read:.0} ms"
        );
    }
    Ok(())
}
