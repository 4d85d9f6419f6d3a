//! Product and manufacturing information of AP242 that programs read, not only people: datum features, and the mirror's
//! profile tolerance with respect to them (ISO 10303-47 and 242, ISO 1101).

use super::face_role::FaceRole;
use super::part21::{DataSection, InstanceId, WrittenFace, list, real};
use crate::geom::{DVec2, DatumFeature, DatumScheme};

/// What an AP242 file says beyond its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Pmi {
    /// The datum features.
    pub datums: DatumScheme,
    /// Width, mm, of the zone about the mirror's faces, along their normals, in which the made ones lie; none where
    /// nothing limits it.
    pub profile_mm: Option<f64>,
}

/// Largest sine of the angle between a side's normal and that of its datum feature: rounding.
const ASKEW: f64 = 1e-9;

/// Whether a face is the datum feature; `bordered`: of a part with a flat rim, whose outer walls are its sides.
fn is_feature(face: &WrittenFace, feature: DatumFeature, bordered: bool) -> bool {
    let is_outer = face.role == if bordered { FaceRole::Side } else { FaceRole::Wall };
    let looks = |out: DVec2| {
        let along = |n: DVec2| n.dot(out) > 0.0 && n.perp_dot(out).abs() < ASKEW;
        is_outer && face.out.is_some_and(along)
    };
    match feature {
        DatumFeature::Base => face.role == FaceRole::Base,
        DatumFeature::Hole(k) => {
            matches!(face.role, FaceRole::Hole(hole) if hole.number == k)
        }
        DatumFeature::Outside => is_outer,
        DatumFeature::FrontSide => looks(DVec2::NEG_Y),
        DatumFeature::LeftSide => looks(DVec2::NEG_X),
    }
}

/// Where the shape's features are said: its definition, its representation and its unit of length.
pub(super) struct ShapeContext {
    pub shape: InstanceId,
    pub brep: InstanceId,
    pub length: InstanceId,
}

impl Pmi {
    /// Writes the datum features and the tolerance of the faces written so far.
    pub(super) fn write(&self, data: &mut DataSection, context: &ShapeContext) {
        let bordered = data.faces.iter().any(|face| face.role == FaceRole::Rim);
        let datums: Vec<InstanceId> = self
            .datums
            .lettered()
            .filter_map(|(letter, feature)| {
                let face = *data.faces.iter().find(|face| is_feature(face, feature, bordered))?;
                Some(write_datum(data, context, letter, face.id))
            })
            .collect();
        let Some(width_mm) = self.profile_mm else { return };
        let shape = context.shape;
        let compartments: Vec<InstanceId> = datums
            .into_iter()
            .map(|datum| {
                data.add(format_args!("DATUM_REFERENCE_COMPARTMENT('','',{shape},.F.,{datum},$)"))
            })
            .collect();
        let compartments = list(&compartments);
        let system = data.add(format_args!("DATUM_SYSTEM('','',{shape},.F.,{compartments})"));
        let mirror = toleranced_mirror(data, context);
        let (width, length) = (real(width_mm), context.length);
        let width =
            data.add(format_args!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({width}),{length})"));
        data.add(format_args!(
            "(GEOMETRIC_TOLERANCE('profile of the mirror','',{width},{mirror})\
             GEOMETRIC_TOLERANCE_WITH_DATUM_REFERENCE(({system}))SURFACE_PROFILE_TOLERANCE())"
        ));
    }
}

/// Names `face` as the feature of a datum; the datum.
fn write_datum(
    data: &mut DataSection,
    context: &ShapeContext,
    letter: char,
    face: InstanceId,
) -> InstanceId {
    let shape = context.shape;
    let feature = data.add(format_args!("DATUM_FEATURE('{letter}','',{shape},.T.)"));
    identify(data, context, feature, face);
    let datum = data.add(format_args!("DATUM('','',{shape},.F.,'{letter}')"));
    data.add(format_args!("SHAPE_ASPECT_RELATIONSHIP('','',{feature},{datum})"));
    datum
}

/// The mirror's faces as one feature.
fn toleranced_mirror(data: &mut DataSection, context: &ShapeContext) -> InstanceId {
    let shape = context.shape;
    let faces: Vec<InstanceId> = data.optical().collect();
    let parts: Vec<InstanceId> = faces
        .into_iter()
        .map(|face| {
            let part = data.add(format_args!("SHAPE_ASPECT('mirror','',{shape},.T.)"));
            identify(data, context, part, face);
            part
        })
        .collect();
    let [only] = parts[..] else {
        let all = data
            .add(format_args!("COMPOSITE_GROUP_SHAPE_ASPECT('multiple elements','',{shape},.T.)"));
        for part in parts {
            data.add(format_args!("SHAPE_ASPECT_RELATIONSHIP('','',{all},{part})"));
        }
        return all;
    };
    only
}

/// Says which face a feature of the shape is.
fn identify(data: &mut DataSection, context: &ShapeContext, feature: InstanceId, face: InstanceId) {
    let brep = context.brep;
    data.add(format_args!("GEOMETRIC_ITEM_SPECIFIC_USAGE('','',{feature},{brep},{face})"));
}
