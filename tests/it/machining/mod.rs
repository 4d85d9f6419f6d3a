//! Cutters: closed forms, the as-cut part against what was foreseen of it, valleys, hollows, refusals.

mod fit;
mod program;
mod scallops;

use crate::support::builds;
use morion::internals::pipeline::{Command, MachiningOptions, Silent};
use morion::internals::profile::Profile;
use morion::internals::results::MachiningReport;
use std::path::Path;

const CUTTING: MachiningOptions = MachiningOptions {
    ball_mm: 1.0,
    stepover_mm: Some(0.137),
    angle_deg: None,
    budget_px: None,
    scallop_um: None,
    allowance_mm: 0.0,
    as_cut: false,
};

/// A mirror of a formula, without a projection.
fn given(outline: &str, formula: &str) -> Profile {
    let text = format!(
        "camera.orthographic.pixels = [64, 48]\n{outline}\nmirror.polynomial = {{ {formula} }}\n\
         mesh.chord_um = 5\nexport.formats = [\"stl\"]\n"
    );
    builds::parsed(&text)
}

/// A ring that lies between the centres of pixels.
fn unseen_profile() -> Profile {
    builds::parsed(
        "camera.orthographic.pixels = [8, 6]\nlayout.annulus.inner_width_mm = 23.2\n\
         part = { width_mm = 24, base_mm = 3 }\nmirror.polynomial = { radius_mm = -40, conic = 0 }\n\
         mesh.chord_um = 5\nexport.formats = [\"stl\"]\n",
    )
}

const DISC: &str = "layout.disc = {}\npart = { width_mm = 24, base_mm = 3 }";
const RECTANGLE: &str = "part = { width_mm = 12, height_mm = 9, base_mm = 3 }";

fn cut(profile: &Profile, cutting: MachiningOptions, out: &Path) -> MachiningReport {
    let found = cutting.publish(profile, out, &Silent);
    found.unwrap_or_else(|error| panic!("{error}"))
}
