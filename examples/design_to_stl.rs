//! A mirror from its profile to the bytes of an STL file, all in memory.
//!
//! `cargo run --release --example design_to_stl`

use morion::{MeshFormat, Profile};

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
    let design = profile.design()?;
    if let Some(error) = design.facts.ray_error_mrad {
        println!("design: ray error {:.1e} mrad RMS", error.rms);
    }

    // No facet may displace the image by more than facet_px, as rounded to an STL's single precision.
    let face = design.mesh()?;
    let proven_px = face.bound.facet_mm / design.camera.pixel_mm;
    println!(
        "mesh:   {} triangles, facet error {proven_px:.3} px at most",
        face.mesh.triangles.len()
    );

    let solid = face.close(&design)?;
    println!("solid:  {:.1} mm^3, closed", solid.check().volume_mm3);

    let mut stl = Vec::new();
    solid.write(MeshFormat::Stl, &design.label(&face), &mut stl)?;
    println!("STL:    {:.1} MB", stl.len() as f64 / 1e6);
    Ok(())
}
