//! A forming tool's shape: its face, the foot of its walls, and what is around it.

use super::face_limits::{FaceLimits, FormingFault};
use super::tool_frame::ToolFrame;
use super::volume::body_mm3;
use crate::geom::{
    Border, Contour, DVec2, DVec3, FaceMesh, Outline, PartFeatures, PlanPolygon, Rect, TriMesh,
};
use crate::mirror::Mirror;
use crate::parallel;
use crate::profile::{BorderSpec, FormingSpec, ToolForm};
use std::ops::Deref;

/// The height of a mould's cavity, and the remedy of a low face, are whole micrometres.
const PER_MM: f64 = 1e3;
/// What rounding may leave of a whole number of micrometres.
const ROUNDED: f64 = 1e-6;
/// Vertices that a thread moves at a time; fixed, so that results do not depend on the threads.
const CHUNK: usize = 4096;

/// A mould or a mandrel: lengths in mm of its own frame, unless said otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct FormingTool {
    /// Its frame.
    frame: ToolFrame,
    /// The outline of the foot of its walls.
    pub foot: PlanPolygon,
    /// The material around it, of which the flat top is the plane of the foot; none of a mandrel without a flat rim.
    pub border: Option<Border>,
    /// Length along each axis.
    pub size_mm: [f64; 3],
    /// Volume, mm^3, with true circles where a mesh has polygons.
    pub volume_mm3: f64,
    /// Least length of the sheet's sides over that of the mirror.
    pub least_stretch: f64,
    /// Largest length of the tool's face over that of the mirror, without its growth.
    pub most_stretch: f64,
    /// Radius of the fan of facets inside a ring, and least and largest Z of its rim.
    land: Option<(f64, [f64; 2])>,
    /// Least and largest Z of its face in the part's frame.
    heights_mm: [f64; 2],
}

impl Deref for FormingTool {
    type Target = ToolFrame;

    fn deref(&self) -> &ToolFrame {
        &self.frame
    }
}

impl FormingTool {
    /// The tool that forms `mirror`, whose walls end at `foot_mm` of the part's frame, over `base_mm` of material; without
    /// what is around it.
    ///
    /// # Errors
    /// [`FormingFault`] where the sheet is thicker than the mirror allows, or the face does not stand out of the foot's
    /// plane.
    pub fn new(
        mirror: &Mirror,
        spec: FormingSpec,
        [foot_mm, base_mm]: [f64; 2],
    ) -> Result<Self, FormingFault> {
        let limits = FaceLimits::new(mirror, spec.offset_mm(), spec.other_side_mm())?;
        let [lowest_mm, highest_mm] = limits.heights_mm;
        // As much as the least border is wide.
        let least = foot_mm + BorderSpec::LEAST_MM;
        if !(lowest_mm >= least) {
            let enough_mm = ((base_mm + least - lowest_mm) * PER_MM).ceil() / PER_MM;
            return Err(FormingFault::Low { foot_mm, lowest_mm, enough_mm });
        }
        let tall = rounded_up(spec.growth() * (highest_mm - foot_mm));
        let flange_mm = match spec.form {
            ToolForm::Mandrel => foot_mm,
            ToolForm::Mould => tall + spec.back_mm,
        };
        let frame = ToolFrame { spec, flange_mm, foot_mm };
        let rim = frame.rim(mirror, 0).into_iter();
        let tool = Self {
            frame,
            foot: PlanPolygon(rim.map(|(q, p)| frame.foot_below(mirror, q, p)).collect()),
            border: None,
            size_mm: [0.0; 3],
            volume_mm3: 0.0,
            least_stretch: limits.least_stretch,
            most_stretch: limits.most_stretch,
            land: land(&frame.rim(mirror, 1)),
            heights_mm: limits.heights_mm,
        };
        Ok(tool.with_border(mirror, None))
    }

    /// The same with what is around it.
    #[must_use]
    pub fn with_border(mut self, mirror: &Mirror, border: Option<Border>) -> Self {
        self.border = border;
        let size = match self.border.as_ref().map(|border| border.contour) {
            Some(Contour::Rect { half, .. }) => 2.0 * half,
            Some(Contour::Circle { radius_mm }) => DVec2::splat(2.0 * radius_mm),
            None => self.foot.bounds().size(),
        };
        self.size_mm = size.extend(self.height_mm()).to_array();
        self.volume_mm3 = body_mm3(&self.frame, self.border.as_ref(), mirror);
        self
    }

    /// Share of what the facets of what is formed may be off that those of the mirror's mesh may: the rest is for digits of
    /// the tool's file and for normals that are told by facets.
    #[must_use]
    pub fn mesh_share(&self) -> f64 {
        /// Vertices inside leave a thousandth, those on a round rim up to a tenth.
        const SHARE: f64 = 0.9;
        SHARE / self.most_stretch.max(1.0)
    }

    /// What its body has around its face.
    #[must_use]
    pub fn features(&self) -> PartFeatures<'_> {
        PartFeatures::bordered(self.border.as_ref())
    }

    /// The outline about the axis that holds its foot: a rectangle, or a disc if the mirror is one.
    #[must_use]
    pub fn foot_about_axis(&self, mirror: &Mirror) -> Outline {
        match mirror.outline {
            Outline::Rect(_) => {
                let Rect { min, max } = self.foot.bounds();
                let half = min.abs().max(max.abs());
                Outline::Rect(Rect { min: -half, max: half })
            }
            Outline::Ring { .. } => {
                let outer = self.foot.0.iter().map(|p| p.length()).fold(0.0, f64::max);
                Outline::Ring { inner: 0.0, outer }
            }
        }
    }

    /// Its face from that of the mirror: vertices beside the mirror, and the foot below each of them.
    #[must_use]
    pub fn face(&self, mirror: &Mirror, face: FaceMesh) -> FaceMesh {
        let TriMesh { mut vertices, mut triangles } = face.into_panels();
        let mut feet = vec![DVec2::ZERO; vertices.len()];
        let offset_mm = self.spec.offset_mm();
        let moved = parallel::map_slice(&vertices, CHUNK, |v| {
            let (q, _) = mirror.chart.coordinates(*v);
            let beside = match offset_mm {
                0.0 => DVec3::ZERO,
                d => d * mirror.extended_surface(q).normal(),
            };
            let p = self.from_part(*v + beside);
            (p, self.foot_below(mirror, q, p))
        });
        for (k, (vertex, foot)) in moved.into_iter().enumerate() {
            (vertices[k], feet[k]) = (vertex, foot);
        }
        if self.is_hollow() {
            triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        FaceMesh::drafted(TriMesh { vertices, triangles }, feet)
    }

    /// Distance of a point beside its face from its other surfaces, mm: the foot of its walls, what is around them, and the
    /// land inside a ring.
    #[must_use]
    pub fn distance_around(&self, v: DVec3) -> f64 {
        let p = v.truncate();
        if let Some((radius, [lo, hi])) = self.land
            && p.length() <= radius
        {
            let flat = (lo - v.z).max(v.z - hi).max(0.0);
            return flat.min(self.distance_around_face(v));
        }
        self.distance_around_face(v)
    }

    fn distance_around_face(&self, v: DVec3) -> f64 {
        let p = v.truncate();
        let outside = -self.foot.inset(p);
        match &self.border {
            Some(border) => border.distance(v, outside, false, &[]),
            None => DVec2::new(outside.max(0.0), v.z).length(),
        }
    }

    /// What facets of a mirror's mesh that are off by `chord_mm`, and chords of round rims and of circles, may change its
    /// volume by, mm^3.
    #[must_use]
    pub fn volume_tolerance_mm3(&self, mirror: &Mirror, chord_mm: f64) -> f64 {
        let foot = self.foot.bounds().area();
        let growth = self.spec.growth();
        let tall = growth * (self.heights_mm[1] - self.foot_mm);
        let chords = match mirror.outline {
            Outline::Rect(_) => 0.0,
            // Chords that cut EDGE of the radius take 4/3 of that share of the disc.
            Outline::Ring { .. } => 4.0 / 3.0 * Outline::EDGE * foot * (tall + chord_mm),
        };
        let faces = foot * chord_mm * self.most_stretch.max(1.0) * growth;
        faces + chords + self.features().chords_mm3()
    }

    fn height_mm(&self) -> f64 {
        match self.spec.form {
            ToolForm::Mould => self.flange_mm,
            ToolForm::Mandrel => {
                self.flange_mm + self.spec.growth() * (self.heights_mm[1] - self.foot_mm)
            }
        }
    }
}

/// Radius and heights of the land within the inner rim of a face.
fn land(rim: &[(DVec2, DVec3)]) -> Option<(f64, [f64; 2])> {
    let (_, first) = rim.first()?;
    let heights = rim.iter().fold([first.z; 2], |[lo, hi], (_, p)| [lo.min(p.z), hi.max(p.z)]);
    let radius = rim.iter().map(|(_, p)| p.truncate().length()).fold(f64::INFINITY, f64::min);
    Some((radius, heights))
}

/// The least whole number of micrometres that is no less, mm.
fn rounded_up(mm: f64) -> f64 {
    (mm * PER_MM - ROUNDED).ceil() / PER_MM
}
