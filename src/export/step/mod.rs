//! STEP (ISO 10303-21, AP214 or AP242): the mirror as bicubic splines in a closed body, for CAD and CAM.
//!
//! The body is the mesh solid's, with curved faces: the mirror, vertical walls and a base plane, or
//! the material around the mirror. Faces share their edges, and no edge is further from a face than
//! 1e-7 mm.
//!
//! - A rectangular panel is one untrimmed bicubic spline.
//! - Panels with steps between them are untrimmed bicubic splines, whose sides lie in planes through the pinhole; so do the
//!   walls between them and below their outer sides.
//! - A disc is a bicubic spline over a square, smooth on the axis too, cut along a curve that lies
//!   on it; so is an annulus whose mirror is not round. The land in the annulus is then a fan from
//!   the rim to the rim's mean height in the middle.
//! - An annulus whose mirror is round is a surface of revolution, with true circles for rims and a
//!   plane land; so is a disc so steep at its rim that a square would take too many control points.

mod b_spline;
mod border;
mod brep;
mod cavity;
mod face_role;
mod fit;
mod fit_tool;
mod hole;
mod knots;
mod mirror_faces;
mod panelled;
mod panels;
mod parametric_surface;
mod part21;
mod pmi;
mod rim_curve;
mod topology;
mod wall_foot;

pub use fit::{FittedMirror, fit_splines};
pub use fit_tool::fit_tool;
pub use pmi::Pmi;

use super::Label;
use crate::geom::{DVec3, PartFeatures};
use part21::{DataSection, InstanceId, list, quoted};
use pmi::ShapeContext;
use std::io::{self, Write};
use thiserror::Error;

/// Why a mirror cannot be written as STEP.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FitError {
    /// Too few knots.
    #[error(
        "no spline that STEP should hold meets the mirror: {} x {} spans leave {reached_mm:.1e} mm; \
         give a smoother mirror, or leave step out",
        spans[0], spans[1]
    )]
    Rough {
        /// The least of the largest errors, mm.
        reached_mm: f64,
        /// Spans along X and along Y that left it.
        spans: [usize; 2],
    },
    /// A round rim is too rough.
    #[error(
        "no curve that STEP should hold follows the mirror's rim: {off_mm:.1e} mm are left; give a \
         smoother mirror, or leave step out"
    )]
    Rim {
        /// The curve's distance from the mirror's spline, mm.
        off_mm: f64,
    },
    /// The mirror has more than one height over some X and Y.
    #[error(
        "the mirror hangs over itself, seen from above, which STEP cannot show of a round one; \
         move the camera away, or leave step out"
    )]
    Overhang,
    /// Holes lead through a land that is a fan of facets.
    #[error(
        "holes go through the land inside a mirror that is not known to be round; give the mirror \
         by radius_mm and conic alone, drill elsewhere, or leave step out"
    )]
    Land,
    /// A forming tool with a round outline for a mirror that is not round.
    #[error(
        "the tool of a mirror with a round outline can be written as STEP only when the mirror is round; \
         leave step out"
    )]
    RoundTool,
    /// A mirror that is neither over X and Y nor round.
    #[error(
        "a mirror with a round outline that is itself not round can be written as STEP only when \
         it is given over X and Y"
    )]
    Chart,
}

/// The schema of a file: what else it says of the part.
#[derive(Debug, Clone, PartialEq)]
pub enum StepSchema {
    /// AP214: the shape and its colours.
    Ap214,
    /// AP242 in its first edition: datum features and the mirror's tolerance too.
    Ap242(Pmi),
}

impl StepSchema {
    /// Name and number of the schema, its application's name and its short name, and the year of the standard.
    fn names(&self) -> [&'static str; 4] {
        match self {
            Self::Ap214 => [
                "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }",
                "automotive design",
                "automotive_design",
                "2000",
            ],
            Self::Ap242(_) => [
                "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
                "managed model based 3d engineering",
                "ap242_managed_model_based_3d_engineering",
                "2014",
            ],
        }
    }
}

/// Splines of a body's freeform faces.
#[derive(Debug, Clone, Copy)]
pub struct FittedBody<'a> {
    /// Those of the mirror.
    pub mirror: &'a FittedMirror,
    /// Those of the roof of a cavity.
    pub roof: Option<&'a FittedMirror>,
}

impl<'a> From<&'a FittedMirror> for FittedBody<'a> {
    fn from(mirror: &'a FittedMirror) -> Self {
        Self { mirror, roof: None }
    }
}

/// Writes the body as STEP: what was fitted to its faces, with its features.
/// Lengths have the digits that matter, 1e-10 mm; nothing depends on the time or the machine.
///
/// # Errors
/// Whatever `out` returns, flushing included.
pub fn write_step<'a>(
    out: &mut impl Write,
    body: impl Into<FittedBody<'a>>,
    features: PartFeatures,
    schema: &StepSchema,
    label: &Label,
) -> io::Result<()> {
    let mut data = DataSection::default();
    let body = body.into();
    let fit = body.mirror;
    let context = product(&mut data, (body, features), schema, label);
    if let StepSchema::Ap242(pmi) = schema {
        pmi.write(&mut data, &context);
    }
    let [named, ..] = schema.names();
    let description = [
        format!("Morion mirror: profile {}", label.profile),
        format!("sha256 {}", label.sha256),
        format!("millimetres; {}", label.tolerances),
        format!("splines within {:.2} nm of the design", fit.error_mm * 1e6),
    ];
    let all: Vec<String> =
        description.iter().chain(&label.mounting).map(|line| quoted(line)).collect();
    let description = all.join(",\n");
    let name = quoted(&label.profile);
    let program = quoted(concat!("Morion ", env!("CARGO_PKG_VERSION")));
    write!(
        out,
        "ISO-10303-21;\nHEADER;\n\
         FILE_DESCRIPTION(({description}),'2;1');\n\
         FILE_NAME({name},'',(''),(''),{program},{program},'');\n\
         FILE_SCHEMA(('{named}'));\n\
         ENDSEC;\nDATA;\n"
    )?;
    out.write_all(data.text.as_bytes())?;
    out.write_all(b"ENDSEC;\nEND-ISO-10303-21;\n")?;
    out.flush()
}

/// The product, its shape and the body.
fn product(
    data: &mut DataSection,
    (body, features): (FittedBody, PartFeatures),
    schema: &StepSchema,
    label: &Label,
) -> ShapeContext {
    let name = quoted(&label.profile);
    let [_, application, short, year] = schema.names();
    let context = data.add(format_args!("APPLICATION_CONTEXT('{application}')"));
    data.add(format_args!(
        "APPLICATION_PROTOCOL_DEFINITION('international standard','{short}',{year},{context})"
    ));
    let kind = data.add(format_args!("PRODUCT_CONTEXT('',{context},'mechanical')"));
    let product = data.add(format_args!("PRODUCT({name},{name},'',({kind}))"));
    data.add(format_args!("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,({product}))"));
    let version = data.add(format_args!("PRODUCT_DEFINITION_FORMATION('','',{product})"));
    let stage =
        data.add(format_args!("PRODUCT_DEFINITION_CONTEXT('part definition',{context},'design')"));
    let definition = data.add(format_args!("PRODUCT_DEFINITION('design','',{version},{stage})"));
    let shape = data.add(format_args!("PRODUCT_DEFINITION_SHAPE('','',{definition})"));
    let length = data.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
    let angle = data.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    let solid_angle = data.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
    let uncertainty = data.add(format_args!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),{length},'distance_accuracy_value',\
         'largest gap between faces and edges')"
    ));
    let space = data.add(format_args!(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)\
         GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({uncertainty}))\
         GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))\
         REPRESENTATION_CONTEXT('part','3D'))"
    ));
    let origin = data.placement(DVec3::ZERO, DVec3::Z, DVec3::X);
    let body = brep::write_body(data, body, features);
    let brep =
        data.add(format_args!("ADVANCED_BREP_SHAPE_REPRESENTATION('',({origin},{body}),{space})"));
    data.add(format_args!("SHAPE_DEFINITION_REPRESENTATION({shape},{brep})"));
    coloured(data, space);
    ShapeContext { shape, brep, length }
}

/// Gives every face the colour of its role.
fn coloured(data: &mut DataSection, space: InstanceId) {
    let mut styles: Vec<(&str, InstanceId)> = Vec::new();
    let mut items = Vec::new();
    for face in data.faces.clone() {
        let colour = face.role.colour();
        let known = styles.iter().find(|(known, _)| *known == colour);
        let style = match known {
            Some((_, style)) => *style,
            None => {
                let style = style(data, colour);
                styles.push((colour, style));
                style
            }
        };
        items.push(data.add(format_args!("STYLED_ITEM('',({style}),{})", face.id)));
    }
    let items = list(&items);
    data.add(format_args!(
        "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{items},{space})"
    ));
}

/// The style of surfaces with a colour, seen from both sides.
fn style(data: &mut DataSection, colour: &str) -> InstanceId {
    let colour = data.add(format_args!("COLOUR_RGB('',{colour})"));
    let fill = data.add(format_args!("FILL_AREA_STYLE_COLOUR('',{colour})"));
    let fill = data.add(format_args!("FILL_AREA_STYLE('',({fill}))"));
    let fill = data.add(format_args!("SURFACE_STYLE_FILL_AREA({fill})"));
    let side = data.add(format_args!("SURFACE_SIDE_STYLE('',({fill}))"));
    let usage = data.add(format_args!("SURFACE_STYLE_USAGE(.BOTH.,{side})"));
    data.add(format_args!("PRESENTATION_STYLE_ASSIGNMENT(({usage}))"))
}
