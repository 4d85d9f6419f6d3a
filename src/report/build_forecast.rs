//! What a build would make, foreseen without making it.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use super::facts::{ProfileId, SCHEMA};
use super::wording::{megabytes, of_at_most};
use serde::Serialize;

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
    pub chord_um: ForecastLimit,
    /// Image displacement by flat facets, pixels.
    pub facet_px: ForecastLimit,
}

/// A limit asked for, and what is foreseen for a number of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ForecastLimit {
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
}

impl Answer for BuildForecast {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::of(&[&self.mesh, &self.files]);
        self.reasons.iter().for_each(|reason| rows.line(format!("  - {reason}")));
        rows.terminal("dry run", "nothing was written");
        rows
    }
}

impl ToRows for MeshForecast {
    fn add_to(&self, rows: &mut AnswerRows) {
        let tolerances = [(self.chord_um, "chord", "um"), (self.facet_px, "facet", "px")];
        let tolerances: Vec<String> = tolerances
            .into_iter()
            .filter_map(|(value, what, unit)| match value {
                ForecastLimit { limit: Some(limit), .. } => {
                    Some(format!("{what} within {limit} {unit}"))
                }
                ForecastLimit { foreseen: Some(x), .. } => {
                    Some(format!("{what} about {x:.3} {unit}"))
                }
                _ => None,
            })
            .collect();
        let [optical, all] = [self.optical_triangles, self.triangles].map(rough);
        let (most, tolerances) = (of_at_most(self.max_triangles), tolerances.join(", "));
        rows.terminal(
            "mesh",
            format!("about {optical} optical triangles ({all} in all{most}); {tolerances}"),
        );
    }
}

impl ToRows for FileForecast {
    fn add_to(&self, rows: &mut AnswerRows) {
        rows.terminal("file", format!("{}  about {}", self.name, megabytes(self.bytes)));
    }
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
