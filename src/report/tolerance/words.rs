//! Words and figures that the terminal's summary and the page of a study share.

use crate::results::{FacetsFrom, digits, displacement};
use crate::tolerance::{
    AllocationError, Criterion, Distribution, Reference, SourceFacts, Statistics, Study,
};

impl FacetsFrom {
    /// In a sentence.
    pub fn words(self) -> &'static str {
        match self {
            Self::Limits => "facets_px as in tolerance.limits",
            Self::Mesh => "facets_px is mesh.facet_px: the part is made from the mesh",
            Self::Foreseen => {
                "facets_px is what the mesh is foreseen to keep: the part is made from it"
            }
        }
    }
}

/// Said where form errors are not from peak to valley.
pub(super) const FORM_RMS: &str = "form errors (legendre, zernike) are root mean squares";

/// Said where errors are fixed.
pub(super) const SYSTEMATIC: &str = "fixed errors that are no textures are the same in every part: they \
    add with their signs, have no variance, and keep their limits in concert";

/// A figure that a single trial does not have.
pub(super) fn or_dash(x: Option<f64>) -> String {
    x.map_or("-".into(), displacement)
}

/// How far off first derivatives are, in percent.
pub(super) fn gap_percent(study: &Study) -> String {
    match 100.0 * study.gap.relative {
        x if x.is_finite() => format!("{x:.1}"),
        _ => "lost".into(),
    }
}

/// Why there are no limits in concert.
pub(super) fn unmet(unmet: AllocationError) -> &'static str {
    match unmet {
        AllocationError::Design => "the design alone uses it up",
        AllocationError::Systematic => "the errors that keep their limits use it up",
        AllocationError::NothingToShare => "no error that is not fixed displaces the picture",
        AllocationError::RaysLost => "rays are lost at all that were tried",
    }
}

/// Which figure counts.
pub(super) fn criterion(criterion: Criterion) -> &'static str {
    match criterion {
        Criterion::Rms => "RMS",
        Criterion::P95 => "P95",
    }
}

/// What displacements are measured from.
pub(super) fn reference(reference: Reference) -> &'static str {
    match reference {
        Reference::Design => "the picture as designed",
        Reference::Projection => "the projection",
    }
}

/// How likely errors are.
pub(super) fn distribution(distribution: Distribution) -> &'static str {
    match distribution {
        Distribution::Uniform => "uniform",
        Distribution::Normal => "normal",
        Distribution::Truncated => "truncated",
        Distribution::Fixed => "fixed",
    }
}

/// All figures with their names.
pub(super) fn statistics(s: &Statistics) -> [(&'static str, String); 9] {
    [
        ("mean", displacement(s.mean_px)),
        ("sigma", or_dash(s.sigma_px)),
        ("P50", displacement(s.p50_px)),
        ("P80", displacement(s.p80_px)),
        ("P90", displacement(s.p90_px)),
        ("P95", displacement(s.p95_px)),
        ("P98", displacement(s.p98_px)),
        ("P99", displacement(s.p99_px)),
        ("worst", displacement(s.worst_px)),
    ]
}

/// An error source's figures.
pub(super) struct SourceCells {
    /// Its limit, as it was given.
    pub limit: String,
    /// Distribution within the limit.
    pub distribution: &'static str,
    /// Displacement at the lower and the upper limit as made, then after adjustment.
    pub displacements: [String; 4],
    /// Blur by a texture.
    pub blur: String,
    /// Share of the variance, %.
    pub share: String,
    /// Limit at which the source uses up the budget by itself.
    pub alone: String,
    /// Limit in concert with the others', starred where it is as wide as one is made.
    pub joint: String,
}

impl SourceCells {
    /// The figures of `source`.
    pub(super) fn new(source: &SourceFacts) -> Self {
        let SourceFacts { minus_px, plus_px, minus_adjusted_px, plus_adjusted_px, .. } = *source;
        let limit = |limit: Option<f64>| limit.map_or("none".into(), digits);
        let mark = if source.limit_joint_widest { "*" } else { "" };
        Self {
            limit: source.limit.to_string(),
            distribution: distribution(source.distribution),
            displacements: [minus_px, plus_px, minus_adjusted_px, plus_adjusted_px]
                .map(displacement),
            blur: match source.spread.blur_px {
                0.0 => "-".into(),
                blur => displacement(blur),
            },
            share: match source.systematic {
                true => "-".into(),
                false => format!("{:.2}", 100.0 * source.share_of_variance),
            },
            alone: limit(source.limit_alone),
            joint: limit(source.limit_joint) + mark,
        }
    }
}
