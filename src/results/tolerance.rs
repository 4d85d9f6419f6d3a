//! A study of tolerances, with its verdict.

use super::MachiningReport;
use super::{ProfileId, Reason, SCHEMA, StudyFault, Verdict};
use crate::tolerance::{Offender, Study};
use serde::Serialize;

/// Study of tolerances with its verdict: `tolerance.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ToleranceReport {
    /// Version of these keys.
    pub schema: u32,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// The answers.
    #[serde(flatten)]
    pub study: Study,
    /// Where the limit of `facets_px` comes from, if facets are a source.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub facets_from: Option<FacetsFrom>,
    /// The errors that do most alone after adjustment.
    pub worst_offenders: Vec<Offender>,
    /// What the ball cutter makes of the mirror as designed, where tool tracks are a source. Its own
    /// reasons do not count here: the tracks do, in the trials.
    pub machining: Option<MachiningReport>,
    /// Pass or fail.
    pub verdict: Verdict,
    /// Why it fails; empty for a pass.
    pub reasons: Vec<Reason>,
}

/// Where the limit of the facets' displacement comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum FacetsFrom {
    /// The profile's `tolerance.limits`.
    Limits,
    /// The profile's `mesh.facet_px`.
    Mesh,
    /// What a mesh by the profile's other limits is foreseen to keep.
    Foreseen,
}

impl ToleranceReport {
    /// The report of `study`; it fails when the yield is below the target or the blur
    /// above its budget.
    #[must_use]
    pub fn new(
        profile: ProfileId,
        study: Study,
        facets_from: Option<FacetsFrom>,
        worst_offenders: Vec<Offender>,
        machining: Option<MachiningReport>,
    ) -> Self {
        let mut faults = Vec::new();
        if study.yields.share < study.target_yield {
            faults.push(StudyFault::Yield {
                share: study.yields.share,
                budget_px: study.budget_px,
                target: study.target_yield,
            });
        }
        if study.blur_px > study.budget_blur_px {
            let most =
                study.sources.iter().max_by(|a, b| a.spread.blur_px.total_cmp(&b.spread.blur_px));
            faults.push(StudyFault::Blur {
                blur_px: study.blur_px,
                budget_px: study.budget_blur_px,
                worst: most.map_or("none".to_owned(), |source| source.source.clone()),
            });
        }
        let reasons: Vec<Reason> = faults.into_iter().map(Reason::from).collect();
        let verdict = if reasons.is_empty() { Verdict::Pass } else { Verdict::Fail };
        let schema = SCHEMA;
        Self { schema, profile, study, facets_from, worst_offenders, machining, verdict, reasons }
    }
}
