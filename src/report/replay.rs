//! A replayed trial as JSON and as text, and its pose as JSON.

use super::answer::{Answer, AnswerRows, Head, json};
use super::facts::{FileFacts, ProfileId, Verdict};
use super::wording::{digits, displacement};
use crate::num::stats::Summary;
use crate::solid::SolidCheck;
use crate::tolerance::{Criterion, Displacement, Reference, RigidTransform, Witnessed};
use serde::Serialize;
use serde_json::{Map, Value};

/// `replay.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReplayReport {
    /// Version of these keys.
    pub schema: u32,
    /// Which profile.
    pub profile: ProfileId,
    /// Seed of the trials.
    pub seed: u64,
    /// Number of the trial.
    pub trial: u64,
    /// Pixels that stand for the picture.
    pub samples: usize,
    /// Which figure counts.
    pub criterion: Criterion,
    /// What displacements are measured from.
    pub reference: Reference,
    /// All errors of the trial.
    pub errors: Vec<DrawnError>,
    /// Those that are not in the files: the stand-in for facets, and what was left out.
    pub without: Vec<String>,
    /// The trial's figures, as in `trials.csv`.
    pub repeated: Displacement,
    /// The figures of the smooth surface that the files are of, without those errors.
    pub smooth: Displacement,
    /// Edges of the optical face are no longer than this before it is displaced, mm; none where
    /// the mesh of the design is fine enough for everything.
    pub longest_edge_mm: Option<f64>,
    /// The files, read back.
    pub files: Vec<ReplayFile>,
    /// Whether every file is a solid, has the surface, and shows the smooth surface's figures
    /// within its facet error.
    pub verdict: Verdict,
    /// Why it fails; empty for a pass.
    pub reasons: Vec<String>,
}

/// An error of a trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DrawnError {
    /// Its key in the profile, which ends in its unit.
    pub source: String,
    /// Its value; of a texture its strength.
    pub value: f64,
}

/// A file of the imperfect part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReplayFile {
    /// The file.
    #[serde(flatten)]
    pub file: FileFacts,
    /// Facets in all.
    pub triangles: usize,
    /// Facets of the optical face.
    pub optical_triangles: usize,
    /// The check of the mesh that was read.
    pub solid: SolidCheck,
    /// The largest distance along Z of the optical face's vertices from the made surface, mm.
    pub off_surface_mm: f64,
    /// What rounding to the file's digits explains, mm.
    pub rounding_mm: f64,
    /// What it shows.
    #[serde(flatten)]
    pub witnessed: Witnessed,
}

/// `pose.json`: what a file of the part cannot hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PoseFile {
    /// Version of these keys.
    pub schema: u32,
    /// Which profile.
    pub profile: ProfileId,
    /// Seed of the trials.
    pub seed: u64,
    /// Number of the trial.
    pub trial: u64,
    /// How the part is mounted, about the middle of its base: turns about X, then Y, then the
    /// axis.
    pub part: Map<String, Value>,
    /// The same as a motion, for the file's coordinates.
    pub world_from_file: RigidTransform,
    /// The camera's errors.
    pub camera: Map<String, Value>,
    /// Errors of size, which the files have already.
    pub in_the_files: Map<String, Value>,
    /// How much larger the part is by them.
    pub growth: f64,
}

impl PoseFile {
    /// `pose.json`.
    #[must_use]
    pub fn json(&self) -> String {
        json(self)
    }
}

impl Answer for ReplayReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons)
    }

    fn rows(&self) -> AnswerRows {
        let Self { trial, seed, samples, .. } = self;
        let mut rows = AnswerRows::default();
        rows.terminal("replay", format!("trial {trial} of seed {seed}, {samples} pixels"));
        let errors: Vec<String> =
            self.errors.iter().map(|e| format!("{} {}", e.source, digits(e.value))).collect();
        for (k, line) in errors.chunks(4).enumerate() {
            rows.terminal(if k == 0 { "errors" } else { "" }, line.join(", "));
        }
        rows.terminal("trial", figures(&self.repeated));
        let without = match self.without.as_slice() {
            [] => String::new(),
            keys => format!("; without {}", keys.join(", ")),
        };
        rows.terminal("surface", format!("{}{without}", figures(&self.smooth)));
        self.files.iter().for_each(|file| file.add_to(&mut rows));
        rows
    }
}

impl ReplayFile {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { file, triangles, off_surface_mm, witnessed, .. } = self;
        let Witnessed { rays, hit, shadowed, beyond, displacement, facet_error_px, .. } = witnessed;
        let facets = facet_error_px.map_or("no".into(), |Summary { rms, max, .. }| {
            format!("{} rms, {} max", digits(rms), digits(max))
        });
        let shown = figures(displacement);
        rows.line(format!("  {:8} {shown}; facet error {facets} px", file.name));
        let off = digits(1e3 * off_surface_mm);
        rows.terminal(
            "",
            format!(
                "{triangles} triangles, {hit} of {rays} rays hit ({shadowed} shadowed), {beyond} led over the \
                 rim; vertices within {off} um of the made surface"
            ),
        );
    }
}

/// Displacements as made and after adjustment.
fn figures(of: &Displacement) -> String {
    let Displacement { as_made, adjusted } = of;
    let [a, b, c, d] =
        [as_made.rms_px, as_made.p95_px, adjusted.rms_px, adjusted.p95_px].map(displacement);
    format!("as made {a} rms, {b} p95; adjusted {c} rms, {d} p95 px")
}
