//! Faults of a file, a shape, rays and a picture, with their figures, and how each is said.

use crate::align::LengthUnit;
use crate::profile::{AcceptanceLimit, AcceptanceLimits};
use std::fmt::{self, Display, Formatter};
use thiserror::Error;

/// What is wrong with the bytes of a file.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FileFault {
    /// They are others than were written.
    #[error("the bytes on the disk are not those that were written")]
    Altered,
    /// They are no file of their format.
    #[error("{0}")]
    Unreadable(String),
    /// Rays from the camera miss a body.
    #[error("{missed} of {rays} rays from the camera miss the mirror in it")]
    Missed {
        /// Number of rays that miss.
        missed: usize,
        /// Number of rays.
        rays: usize,
    },
    /// The surface of a body is off the design.
    #[error("its mirror is {off_mm:.3e} mm off the design, over {limit_mm:e} mm")]
    SurfaceError {
        /// Largest departure along the normal, mm.
        off_mm: f64,
        /// What the fit of the splines and rounding explain, mm.
        limit_mm: f64,
    },
    /// The volume of a body is another than the design's.
    #[error("volume {found_mm3:.6} mm^3 where the design has {designed_mm3:.6}")]
    VolumeError {
        /// Volume of the body, mm^3.
        found_mm3: f64,
        /// Volume of the design, mm^3.
        designed_mm3: f64,
    },
    /// A table's heights are off the design.
    #[error("a height is {off_mm:.3e} mm off the design, over {limit_mm:e} mm")]
    HeightError {
        /// Largest departure, mm.
        off_mm: f64,
        /// What rounding explains, mm.
        limit_mm: f64,
    },
    /// A table's normals are off the design.
    #[error("a normal is {off_rad:.3e} rad off the design, over {limit_rad:e} rad")]
    NormalError {
        /// Largest departure, radians.
        off_rad: f64,
        /// What rounding explains, radians.
        limit_rad: f64,
    },
    /// A table has no rows.
    #[error("it holds no rows, all beside the mirror; take a smaller pitch_mm and step_mm")]
    EmptyTable,
}

/// What is wrong with the shape of a part.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ShapeFault {
    /// The mesh is not closed, not oriented, in pieces or inside out.
    #[error("{0}")]
    NotSolid(String),
    /// The volume is another than the design's.
    #[error(
        "volume {found_mm3:.4} mm^3 where the design has {designed_mm3:.4}, off by {:.4}, over the \
         {allowed_mm3:.4} that the chord error explains", found_mm3 - designed_mm3
    )]
    Volume {
        /// Of the mesh, mm^3.
        found_mm3: f64,
        /// Of the design, mm^3.
        designed_mm3: f64,
        /// What facets and rounding explain, mm^3.
        allowed_mm3: f64,
    },
    /// A vertex is off the designed part.
    #[error(
        "the vertex ({}, {}, {}) is {off_mm:.6} mm off the designed part, over {limit_mm:.6} mm",
        at_mm[0], at_mm[1], at_mm[2]
    )]
    OffSurface {
        /// The vertex, mm.
        at_mm: [f64; 3],
        /// Its distance, mm.
        off_mm: f64,
        /// The chord error, mm.
        limit_mm: f64,
    },
    /// The part has another size, as with another unit.
    #[error("{}", size(*factor, *unit))]
    Size {
        /// Its size over the design's.
        factor: f64,
        /// The unit that explains it, if one does.
        unit: Option<LengthUnit>,
    },
    /// Facets lie far from the part.
    #[error("{count} facets lie far from the part and were left out")]
    FarFacets {
        /// How many.
        count: usize,
    },
    /// A measured part departs from the design.
    #[error(
        "form error {pv_um:.3} um PV without outliers, over {limit_um} um (mesh.chord_um); give \
         accept.pixel_error_max_px to judge it by the picture"
    )]
    FormError {
        /// Peak to valley without outliers, um.
        pv_um: f64,
        /// The limit, um.
        limit_um: f64,
    },
}

fn size(factor: f64, unit: Option<LengthUnit>) -> String {
    let (times, way) = if factor > 1.0 { (factor, "large") } else { (1.0 / factor, "small") };
    match unit {
        Some(unit) => {
            let times = (1e6 * times).round() / 1e6;
            format!("the part is {times} times too {way}: is the unit {}?", unit.word())
        }
        None => format!("the part is about {times:.1} times too {way}"),
    }
}

/// Rays of the camera that are aimed at the mirror and do not reach the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum RayFault {
    /// There are none.
    #[error("no camera ray is aimed at the mirror")]
    NothingAimed,
    /// They miss the part.
    #[error("{count} of {rays} rays aimed at the mirror miss the part")]
    Missed {
        /// How many do.
        count: usize,
        /// Of how many.
        rays: usize,
    },
    /// The part shadows them.
    #[error(
        "{count} of {rays} rays aimed at the mirror are shadowed by the part itself{}{}",
        over(*allowed), rim(*by_rim)
    )]
    Shadowed {
        /// How many.
        count: usize,
        /// Of how many.
        rays: usize,
        /// How many walls between panels may shadow.
        allowed: usize,
        /// How many of them are shadowed by the flat rim.
        by_rim: usize,
    },
    /// They meet the back of a facet.
    #[error("{count} of {rays} rays aimed at the mirror meet the back of a facet")]
    BackFace {
        /// How many do.
        count: usize,
        /// Of how many.
        rays: usize,
    },
}

fn over(allowed: usize) -> String {
    match allowed {
        0 => String::new(),
        allowed => format!(", over the {allowed} that walls between panels may shadow"),
    }
}

fn rim(by_rim: usize) -> String {
    if by_rim == 0 {
        return String::new();
    }
    format!(
        ", {by_rim} of them by its flat rim: lower part.rim_mm, raise base_mm or narrow border_mm"
    )
}

fn lost(share: f64, what: &str) -> String {
    match share {
        0.0 => String::new(),
        share => format!("; {:.3} % {what}", 100.0 * share),
    }
}

/// What is wrong with a picture.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PictureFault {
    /// Facets displace it.
    #[error("facet error {found_px:.3} px, over the {limit_px} px of {key}")]
    FacetError {
        /// The largest, px.
        found_px: f64,
        /// What was asked for or proven, px.
        limit_px: f64,
        /// The key that says so.
        key: &'static str,
    },
    /// It is off the projection.
    #[error(
        "{} {found_px:.3} px, over the {} px {}",
        figure.name(), limit.value, figure.limited_by(*limit)
    )]
    PixelError {
        /// Which figure.
        figure: PixelErrorFigure,
        /// The figure, px.
        found_px: f64,
        /// What the profile accepts, px.
        limit: AcceptanceLimit,
    },
    /// An error has no finite value.
    #[error("{what} is not finite")]
    NotFinite {
        /// Which error.
        what: &'static str,
    },
    /// Too little of the frame is filled.
    #[error(
        "{:.3} % of the frame see their part of the world within {tolerance_px} px, {least}{}{}",
        100.0 * filled, lost(*hidden, "are behind obstacles"), lost(*shadowed, "are in the part's own shadow")
    )]
    FrameFilled {
        /// The share that is, 0 to 1.
        filled: f64,
        /// Up to which error a pixel counts as filled, px.
        tolerance_px: f64,
        /// The share that is to be.
        least: LeastFilled,
        /// The share that obstacles hide, 0 to 1.
        hidden: f64,
        /// The share that the part shadows, 0 to 1.
        shadowed: f64,
    },
    /// It is not sharp.
    #[error(
        "95 % of the spots through {lens} are up to {spot_px:.3} px long, over the {limit_px} px of \
         accept.blur_p95_px"
    )]
    Blur {
        /// The lens.
        lens: String,
        /// Length of its spots, px.
        spot_px: f64,
        /// The limit, px.
        limit_px: f64,
    },
}

/// Which figure of the pixel errors a limit is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelErrorFigure {
    /// The root mean square.
    Rms,
    /// The largest.
    Max,
}

impl PixelErrorFigure {
    /// The figure in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rms => "RMS pixel error",
            Self::Max => "largest pixel error",
        }
    }

    /// Who set the limit.
    fn limited_by(self, limit: AcceptanceLimit) -> String {
        let (key, share) = match self {
            Self::Rms => ("accept.pixel_error_rms_px", AcceptanceLimits::RMS),
            Self::Max => ("accept.pixel_error_max_px", AcceptanceLimits::MAX),
        };
        if !limit.usual {
            return format!("of {key}");
        }
        let percent = 100.0 * share;
        format!("that are usual, {percent} % of the frame's width ({key} sets another limit)")
    }
}

/// The share of the frame that is to be filled, and who says so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeastFilled {
    /// The profile, or what is usual in its place.
    Accepted(AcceptanceLimit),
    /// The command.
    Asked(f64),
}

impl LeastFilled {
    /// The share, 0 to 1.
    pub(crate) fn share(self) -> f64 {
        match self {
            Self::Accepted(limit) => limit.value,
            Self::Asked(share) => share,
        }
    }
}

impl Display for LeastFilled {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (key, percent) = ("accept.frame_filled", 100.0 * self.share());
        match self {
            Self::Accepted(AcceptanceLimit { usual: true, .. }) => {
                write!(f, "{percent:.3} % are usual ({key} sets another share)")
            }
            Self::Accepted(_) => write!(f, "{percent:.3} % are accepted ({key})"),
            Self::Asked(_) => write!(f, "under the {percent:.3} % asked for"),
        }
    }
}

/// Files of a mesh that are not written although they are asked for, and why.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{}", self.said(if self.files.len() == 1 { "was" } else { "were" }, "not"))]
pub struct Refusal {
    /// The kind of cause.
    pub cause: RefusalCause,
    /// The files; none where it is a mesh for the rays alone.
    pub files: Vec<&'static str>,
    /// What the mesher said.
    pub why: String,
}

/// Kind of cause for which a file of a mesh is not written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RefusalCause {
    /// Single precision does not carry the tolerances.
    SinglePrecision,
    /// No mesh keeps the tolerances.
    NoMesh,
}

impl Refusal {
    /// As a forecast says it.
    pub(crate) fn foreseen(&self) -> String {
        self.said("would", "not be")
    }

    fn said(&self, verb: &str, not: &str) -> String {
        match &self.files[..] {
            [] => format!("no mesh could be made to trace: {}", self.why),
            files => format!("{} {verb} {not} written: {}", files.join(" and "), self.why),
        }
    }
}
