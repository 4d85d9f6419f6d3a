//! Tools of round domes against closed forms: what is parallel to a sphere and to a paraboloid, and volumes of solids of revolution.

use super::{built, conic, dome};
use crate::support::{designed, meshed};
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{radians, tan};
use morion::internals::profile::Profile;
use morion::internals::results::Verdict;
use std::f64::consts::PI;

/// What a tool of a round dome has over the foot of its wall, before it is grown.
struct RoundFace {
    /// Radius of its rim, mm.
    rim_mm: f64,
    /// Height of the rim over the foot, mm.
    low_mm: f64,
    /// What is above the rim, mm3.
    cap_mm3: f64,
}

/// Height of the foot of the wall, mm.
const FOOT_MM: f64 = 5.0;

impl RoundFace {
    /// The sphere of this radius about the centre of the dome's.
    fn sphere(radius_mm: f64) -> Self {
        let (sine, cosine) = (30.0 / 80.0, f64::sqrt(1.0 - 0.140625));
        // The mirror's lowest place is its rim, at 12 mm.
        let centre = 12.0 - 80.0 * cosine;
        let cap = radius_mm * (1.0 - cosine);
        Self {
            rim_mm: radius_mm * sine,
            low_mm: centre + radius_mm * cosine - FOOT_MM,
            cap_mm3: PI * cap * cap * (radius_mm - cap / 3.0),
        }
    }

    /// The surface beside the paraboloid by `offset_mm`: its section's places are (r + d r / (80 w), -r^2 / 160 + d / w) with
    /// w^2 = 1 + (r / 80)^2. Its cap is that of frustums of two widths, extrapolated.
    fn beside_paraboloid(offset_mm: f64) -> Self {
        let section = |r: f64| {
            let w = f64::sqrt(1.0 + r * r / 6400.0);
            [r + offset_mm * r / (80.0 * w), PARABOLOID_TOP_MM - r * r / 160.0 + offset_mm / w]
        };
        let [rim_mm, rim_height] = section(30.0);
        let n = 2000;
        let at = |k: usize| section(30.0 * k as f64 / n as f64);
        let mut cap_mm3 = 0.0;
        for k in (0..n).step_by(2) {
            let [a, b, c] = [k, k + 1, k + 2].map(at);
            let slice = |p: [f64; 2], q: [f64; 2]| {
                PI / 3.0 * (p[0] * p[0] + p[0] * q[0] + q[0] * q[0]) * (p[1] - q[1])
            };
            let fine = slice(a, b) + slice(b, c);
            cap_mm3 += fine + (fine - slice(a, c)) / 3.0;
        }
        Self { rim_mm, low_mm: rim_height - FOOT_MM, cap_mm3 }
    }

    /// The closed form of the volume of the tool: the cap over a cone's frustum with the draft, and the plate around it.
    fn tool_mm3(&self, growth: f64, top_mm: f64) -> f64 {
        let (rim, low) = (growth * self.rim_mm, growth * self.low_mm);
        let wide = rim + tan(radians(3.0)) * low;
        let frustum = PI * low / 3.0 * (rim * rim + rim * wide + wide * wide);
        let core = growth * growth * growth * self.cap_mm3 + frustum;
        let outer = wide + 25.0;
        let mark = PI / 3.0 * 0.125;
        let plate = PI * outer * outer * top_mm - PI * 2.25 * top_mm - mark;
        if top_mm == 5.0 { plate + core } else { plate - core }
    }
}

/// Height of the top of the paraboloid z = -r^2 / 160 whose rim is at 12 mm.
const PARABOLOID_TOP_MM: f64 = 12.0 + 900.0 / 160.0;

/// Distance of a point from that paraboloid, mm: its foot is where r (1 + z / 80) + r^3 / 12800 is the point's radius, for z
/// over the top.
fn from_paraboloid_mm(v: DVec3) -> f64 {
    let (radius, z) = (v.truncate().length(), v.z - PARABOLOID_TOP_MM);
    let linear = 1.0 + z / 80.0;
    let mut r = radius;
    for _ in 0..50 {
        r -= (r * linear + r * r * r / 12_800.0 - radius) / (linear + 3.0 * r * r / 12_800.0);
    }
    DVec2::new(radius - r, z + r * r / 160.0).length()
}

/// A tool of a dome is held to the closed forms of its face and of its volume.
fn held_to_closed_forms(
    profile: &Profile,
    off_face_mm: impl Fn(DVec3) -> f64,
    form: &RoundFace,
    growth: f64,
) {
    let said = format!("{:?}", profile.part);
    let design = designed(profile);
    let tool = design.tool.as_ref().unwrap();
    let face = meshed(profile, &design).unwrap();
    let made = tool.face(&design.mirror, face.mesh.clone());
    for v in &made.vertices {
        let off = off_face_mm(tool.to_part(*v));
        // The mesh has the digits of its coarsest format.
        assert!(off.abs() < 4e-6, "{said}: {off:e}");
    }
    let exact = form.tool_mm3(growth, tool.flange_mm);
    let off = tool.volume_mm3 / exact - 1.0;
    assert!(off.abs() < 1e-6, "{said}: {off:e}");
    let report = built(profile);
    assert_eq!(report.verdict, Verdict::Pass, "{said}: {:?}", report.reasons);
    let step = report.step.unwrap().body.unwrap();
    assert!(step.surface_error_nm < 3.0 && step.rays > 2000, "{said}: {step:?}");
    let off = step.volume_mm3 / exact - 1.0;
    assert!(off.abs() < 1e-6, "{said}: {off:e}");
    assert_eq!(report.tool.unwrap().size_mm[2], tool.size_mm[2]);
}

/// Faces are spheres about the mirror's centre, volumes those of caps and frustums.
#[test]
#[ignore = "long: .ci/nightly"]
fn tools_of_a_dome_are_concentric_spheres() {
    for (form, forming, radius_mm, growth) in [
        ("mandrel", "sheet_mm = 2", 78.0, 1.0),
        ("mandrel", "sheet_mm = 2, shrinkage_ppm = 6000", 78.0, 1.0 / 0.994),
        ("mandrel", "sheet_mm = 2, mirror_side = \"tool\"", 80.0, 1.0),
        ("mould", "sheet_mm = 2", 80.0, 1.0),
        ("mould", "sheet_mm = 2.5, mirror_side = \"free\", back_mm = 7", 82.5, 1.0),
        ("mould", "shrinkage_ppm = 20000", 80.0, 1.0 / 0.98),
    ] {
        let centre = DVec3::Z * (12.0 - 80.0 * f64::sqrt(1.0 - 0.140625));
        let off = |v: DVec3| (v - centre).length() - radius_mm;
        held_to_closed_forms(&dome(form, forming), off, &RoundFace::sphere(radius_mm), growth);
    }
}

/// Faces are beside the paraboloid by the sheet, volumes those of solids of revolution and frustums.
#[test]
#[ignore = "long: .ci/nightly"]
fn tools_of_a_paraboloid_are_beside_it_everywhere() {
    for (form, forming, offset_mm, growth) in [
        ("mandrel", "sheet_mm = 2", -2.0, 1.0),
        ("mandrel", "sheet_mm = 2, shrinkage_ppm = 6000", -2.0, 1.0 / 0.994),
        ("mandrel", "sheet_mm = 2, mirror_side = \"tool\"", 0.0, 1.0),
        ("mould", "sheet_mm = 2.5, mirror_side = \"free\", back_mm = 7", 2.5, 1.0),
        ("mould", "shrinkage_ppm = 20000", 0.0, 1.0 / 0.98),
    ] {
        let off = |v: DVec3| from_paraboloid_mm(v) - f64::abs(offset_mm);
        let form_of = RoundFace::beside_paraboloid(offset_mm);
        held_to_closed_forms(&conic(-1.0, form, forming), off, &form_of, growth);
    }
}
