//! What is promised of a mesh file, which its verdict holds it to.

use crate::design::Design;
use crate::forming::FormingTool;
use crate::mesh::Face;
use crate::num::units::{Mm, Px, Um};
use crate::profile::{MeshGoal, Profile};

/// Errors that a mesh file may have against its design: what its verdict holds it to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Promise {
    /// Height of a facet off the mirror, mm.
    pub chord_mm: f64,
    /// Facet error, and what sets it; none where nothing does.
    pub facet: Option<(Px, &'static str)>,
}

impl Promise {
    /// Chord of a file of unknown making where the profile has no limit of its own.
    const USUAL_CHORD: Um = Um(10.0);

    /// What was asked and proven of a face.
    pub(crate) fn of_face(profile: &Profile, design: &Design, face: &Face) -> Self {
        let facet = match profile.mesh {
            MeshGoal::Limits { facet, .. } => facet.map(|px| (px, "mesh.facet_px")),
            // A number of triangles sets no limit; what was proven of them is to be seen.
            MeshGoal::Budget(_) => {
                let share = design.tool.as_ref().map_or(1.0, FormingTool::mesh_share);
                Some((design.camera.to_px(Mm(face.bound.facet_mm / share)), "the mesh's bound"))
            }
        };
        Self { chord_mm: face.bound.chord_mm, facet }
    }

    /// What the profile asks of any file: of one of unknown making nothing is proven.
    pub(crate) fn of_profile(profile: &Profile) -> Self {
        let (chord, facet) = match profile.mesh {
            MeshGoal::Limits { chord, facet } => (chord, facet.map(|px| (px, "mesh.facet_px"))),
            MeshGoal::Budget(_) => (None, None),
        };
        Self { chord_mm: Mm::from(chord.unwrap_or(Self::USUAL_CHORD)).0, facet }
    }

    /// The design itself, without a limit for facets.
    pub(crate) fn exact() -> Self {
        Self { chord_mm: 0.0, facet: None }
    }
}
