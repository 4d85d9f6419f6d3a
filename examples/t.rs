use morion::design::design;
use morion::mesh::*;
use morion::profile::*;
use std::time::Instant;
fn main() {
    let f: f64 = std::env::args().nth(1).map_or(1.0, |a| a.parse().unwrap());
    let c: Option<f64> = std::env::args().nth(2).map(|a| a.parse().unwrap());
    for (law, deg, layout) in
        [(Law::Cylindrical, 12, 1), (Law::Mercator, 14, 1), (Law::Cylindrical, 12, 0)]
    {
        let p = Profile {
            name: "t".into(),
            sha256: "".into(),
            summary: "".into(),
            camera: Camera::Orthographic { pixels: [640, 480] },
            projection: Projection { law, azimuth_deg: [-180., 180.], elevation_deg: [-30., 30.] },
            layout: if layout == 1 {
                Layout::Conquistador {
                    panel: PanelSource::Refit,
                    ridge: Ridge::Crest,
                    fill_frame: true,
                }
            } else {
                Layout::Strip { fill_frame: false }
            },
            method: Method::VectorField { degree: deg },
            part: Part { width_mm: 60., base_mm: 5. },
            mesh: MeshLimits { chord_um: None, facet_px: None },
            formats: vec![],
            accept: Accept::default(),
        };
        let t = Instant::now();
        let d = design(&p).unwrap();
        println!("design {:?} {:?}", t.elapsed(), d.facts);
        let px = d.camera.pixel_mm;
        let lim = Limits {
            chord_mm: c.map(|c| c * 1e-3),
            facet_mm: if f > 0. { Some(f * px) } else { None },
        };
        let t = Instant::now();
        let m = mesh(&d.mirror, &d.image.strip, lim).unwrap();
        println!(
            "mesh {:?} tris {} chord {} um facet {} px rounding {} over chord {:.3} facet {:.3}",
            t.elapsed(),
            m.mesh.triangles.len(),
            m.bound.chord_mm * 1e3,
            m.bound.facet_mm / px,
            m.bound.rounding_mm / px,
            m.mesh.triangles.len() as f64 / m.optimum.chord(c.unwrap_or(1.0) * 1e-3),
            m.mesh.triangles.len() as f64 / m.optimum.facet(f * px)
        );
    }
}
