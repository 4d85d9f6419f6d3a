//! STEP files (ISO 10303-21) read back as a stranger would: the closed body of curved faces, and where rays meet it.
//!
//! Nothing is taken from a writer but the file. [`Body::read`] reads one solid of one closed shell; everything that
//! it does not know is refused with the line and the number of the entity instance.

mod b_spline;
mod bicubic;
mod charted;
mod context;
mod curve;
mod entities;
mod error;
mod face;
mod geometry;
mod hierarchy;
mod part21;
mod patch;
mod pieces;
mod samples;
mod shell;
mod surface;
mod trim;

pub use charted::{ChartedBody, ChartedHit};
pub use entities::RigidMotion;
pub use error::StepError;
pub use pieces::SurfacePiece;

use crate::geom::{DVec3, Ray, TriMesh};
use crate::parallel;
use context::find_solid;
use entities::Entities;
use face::TrimmedFace;
use hierarchy::Hierarchy;
use part21::Exchange;
use shell::Shell;

/// Pieces across a body at least.
const PIECES_ACROSS: f64 = 64.0;

/// A closed body of curved faces.
#[derive(Debug)]
pub struct Body {
    faces: Vec<TrimmedFace>,
    hierarchy: Hierarchy,
    facts: BodyFacts,
}

/// What a closed body of curved faces is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyFacts {
    /// Number of faces.
    pub faces: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Pieces that hang together by edges.
    pub components: usize,
    /// Vertices - edges + faces, less the loops beyond the first of each face: 2 for a body without handles, 2 less
    /// for each through hole.
    pub euler: i64,
    /// Largest distance of an edge from one of its faces, mm.
    pub gap_mm: f64,
    /// What the file says points and curves may be apart, mm.
    pub uncertainty_mm: f64,
    /// Millimetres of the file's unit of length.
    pub unit_mm: f64,
    /// Volume, mm^3.
    pub volume_mm3: f64,
}

/// Where a ray meets a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyHit {
    /// Distance along the ray, mm.
    pub t: f64,
    /// Number of the face.
    pub face: u32,
    /// Unit normal there, out of the body.
    pub normal: DVec3,
}

impl Body {
    /// Reads the one solid of a STEP file, and checks that its shell is closed: every edge has two faces, on whose
    /// surfaces it lies within the file's uncertainty, and normals lead outwards.
    ///
    /// # Errors
    /// [`StepError`].
    pub fn read(bytes: &[u8]) -> Result<Self, StepError> {
        Self::read_moved(bytes, RigidMotion::NONE)
    }

    /// The same put elsewhere.
    ///
    /// # Errors
    /// [`StepError`].
    pub fn read_moved(bytes: &[u8], motion: RigidMotion) -> Result<Self, StepError> {
        let mut entities = Entities::new(Exchange::parse(bytes)?, motion);
        let solid = find_solid(&mut entities)?;
        let Shell { faces, edges, vertices, loops, components, gap_mm } =
            Shell::read(&entities, &solid)?;
        let volume_mm3 =
            parallel::map_slice(&faces, 1, TrimmedFace::volume_share).into_iter().sum();
        if !(volume_mm3 > 0.0) {
            let fault =
                format!("its volume is {volume_mm3} mm^3: normals must lead out of the body");
            return Err(StepError { line: 0, entity: Some(solid.id), fault });
        }
        let facts = BodyFacts {
            faces: faces.len(),
            edges,
            vertices,
            components,
            euler: vertices as i64 - edges as i64 + 2 * faces.len() as i64 - loops as i64,
            gap_mm,
            uncertainty_mm: solid.uncertainty_mm,
            unit_mm: entities.mm,
            volume_mm3,
        };
        let hierarchy = Hierarchy::new(&faces);
        Ok(Self { faces, hierarchy, facts })
    }

    /// What it is.
    #[must_use]
    pub fn facts(&self) -> BodyFacts {
        self.facts
    }

    /// Least and largest coordinates, mm.
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        trim::bounds(self.faces.iter().flat_map(|face| face.bounds))
    }

    /// Pieces that make up all its faces, small along X and Y by the size of the body.
    #[must_use]
    pub fn pieces(&self) -> Vec<SurfacePiece> {
        let [lo, hi] = self.bounds();
        let size = (hi - lo).truncate().max_element() / PIECES_ACROSS;
        parallel::map_slice(&self.faces, 1, |face| pieces::of_face(face, size)).concat()
    }

    /// Facets with their corners on the faces, some ten thousand: not closed, for what needs to know roughly where the
    /// surface is. Those that an edge cuts are left out.
    #[must_use]
    pub fn sampled(&self) -> TriMesh {
        samples::of_faces(&self.faces)
    }

    /// Z of the highest place of a face, by its number, mm.
    #[must_use]
    pub fn top_of(&self, face: u32) -> f64 {
        self.faces[face as usize].bounds[1].z
    }

    /// Nearest place at more than `least` and less than `most` mm along a ray where it meets the body.
    #[must_use]
    pub fn nearest_hit(&self, ray: &Ray, least: f64, most: f64) -> Option<BodyHit> {
        self.hierarchy.nearest(&self.faces, ray, [least, most])
    }
}
