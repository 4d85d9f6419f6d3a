//! What a build would make, foreseen without making it.

use super::text::{head_line, of_at_most, pretty, written};
use super::{ProfileId, SCHEMA};
use serde::Serialize;
use std::fmt::Write;

/// What a build of one profile would come to. Numbers are forecasts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BuildForecast {
    /// The version of the report's schema whose keys these are.
    pub schema: u32,
    /// Nothing was written.
    pub dry_run: bool,
    /// Which profile.
    pub profile: ProfileId,
    /// The mesh; none where the build would go on without one.
    pub mesh: Option<MeshForecast>,
    /// The mesh files.
    pub files: Vec<FileForecast>,
    /// Why files that are asked for would not be written.
    pub reasons: Vec<String>,
    /// What may be a nuisance later, and what to do about it.
    pub warnings: Vec<String>,
}

/// The mesh that is foreseen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeshForecast {
    /// Facets of the optical face.
    pub optical_triangles: usize,
    /// Facets of the solid.
    pub triangles: usize,
    /// Most of them, where the profile sets that in the place of limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_triangles: Option<usize>,
    /// Height between facet and mirror, um.
    pub chord_um: Foreseen,
    /// Image displacement by flat facets, pixels.
    pub facet_px: Foreseen,
}

/// A limit asked for, and what is foreseen for a number of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Foreseen {
    /// Asked for; none when the profile sets none.
    pub limit: Option<f64>,
    /// What the number of triangles will be good for; none where limits rule.
    pub foreseen: Option<f64>,
}

/// A mesh file that is foreseen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FileForecast {
    /// Name in the output folder.
    pub name: String,
    /// Its format's name.
    pub format: &'static str,
    /// Length.
    pub bytes: u64,
}

impl BuildForecast {
    /// The forecast for `profile`; nothing in it yet but the mesh and the files.
    #[must_use]
    pub fn new(profile: ProfileId, mesh: Option<MeshForecast>, files: Vec<FileForecast>) -> Self {
        let (reasons, warnings) = (Vec::new(), Vec::new());
        Self { schema: SCHEMA, dry_run: true, profile, mesh, files, reasons, warnings }
    }

    /// As JSON.
    #[must_use]
    pub fn json(&self) -> String {
        pretty(self)
    }

    /// A readable summary.
    #[must_use]
    pub fn text(&self) -> String {
        written(|out| self.write_text(out))
    }

    fn write_text(&self, out: &mut String) -> std::fmt::Result {
        head_line(out, &self.profile)?;
        if let Some(mesh) = &self.mesh {
            write_mesh(out, mesh)?;
        }
        for file in &self.files {
            writeln!(out, "  file     {}  about {:.1} MB", file.name, file.bytes as f64 / 1e6)?;
        }
        for reason in &self.reasons {
            writeln!(out, "  - {reason}")?;
        }
        writeln!(out, "  dry run  nothing was written")
    }
}

fn write_mesh(out: &mut String, mesh: &MeshForecast) -> std::fmt::Result {
    let tolerances = [(mesh.chord_um, "chord", "um"), (mesh.facet_px, "facet", "px")];
    let tolerances: Vec<String> = tolerances
        .into_iter()
        .filter_map(|(value, what, unit)| match value {
            Foreseen { limit: Some(limit), .. } => Some(format!("{what} within {limit} {unit}")),
            Foreseen { foreseen: Some(x), .. } => Some(format!("{what} about {x:.3} {unit}")),
            _ => None,
        })
        .collect();
    writeln!(
        out,
        "  mesh     about {} optical triangles ({} in all{}); {}",
        rough(mesh.optical_triangles),
        rough(mesh.triangles),
        of_at_most(mesh.max_triangles),
        tolerances.join(", "),
    )
}

/// A number in three digits.
fn rough(count: usize) -> usize {
    let mut unit = 1;
    while count / unit >= 1000 {
        unit *= 10;
    }
    (count + unit / 2) / unit * unit
}

#[cfg(test)]
mod tests {
    #[test]
    fn rough_numbers_have_three_digits() {
        let found = [0, 7, 999, 1000, 1234, 99_950, 587_936].map(super::rough);
        assert_eq!(found, [0, 7, 999, 1000, 1230, 100_000, 588_000]);
    }
}
