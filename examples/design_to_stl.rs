//! A mirror from its profile to the bytes of an STL file, all in memory.
//!
//! `cargo run --release --example design_to_stl`

use morion::internals::design::design;
use morion::internals::export::{Label, write_stl};
use morion::internals::geom::Precision;
use morion::internals::mesh::{Limits, mesh};
use morion::internals::profile::Profile;
use morion::internals::solid::Solid;

/// A telecentric camera over a strip 60 mm wide; a law that a mirror can meet exactly.
const PROFILE: &str = r#"
[camera.orthographic]
pixels = [640, 480]

[projection.mercator]
azimuth_deg = [-180, 180]
elevation_deg = [-30, 30]

[layout.strip]

[method.vector-field]
degree = 12

[part]
width_mm = 60
base_mm = 5

[mesh]
facet_px = 1

[export]
formats = ["stl"]
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let profile = Profile::parse("panorama", "panorama.toml", PROFILE.as_bytes())?;
    let design = design(&profile)?;
    if let Some(error) = design.facts.ray_error_mrad {
        println!("design: ray error {:.1e} mrad RMS", error.rms);
    }

    // No facet may displace the image by more than this, as rounded to an STL's single precision.
    let limits = Limits {
        chord_mm: None,
        facet_mm: profile.mesh.facet_px().map(|px| px * design.camera.pixel_mm),
        precision: Precision::Single,
    };
    let face = mesh(&design.mirror, &design.camera.chart, design.view.as_ref(), limits)?;
    let proven_px = face.bound.facet_mm / design.camera.pixel_mm;
    println!(
        "mesh:   {} triangles, facet error {proven_px:.3} px at most",
        face.mesh.triangles.len()
    );

    let solid = Solid::from_face(&face.mesh, design.border.as_ref(), Precision::Single)?;
    println!("solid:  {:.1} mm^3, closed", solid.check().volume_mm3);

    let label = Label {
        profile: profile.name.clone(),
        sha256: profile.sha256.clone(),
        tolerances: "facet px 1".into(),
        mounting: design.mounting.statements(),
    };
    let mut stl = Vec::new();
    write_stl(&mut stl, &solid, &label)?;
    println!("STL:    {:.1} MB", stl.len() as f64 / 1e6);
    Ok(())
}
