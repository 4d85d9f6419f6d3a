//! Pictures that a photo is unwrapped to, and where in the photo their pixels are.

use super::Error;
use super::floor_plan::FloorPlan;
use super::mounted_system::{BEYOND_CELLS, FINE_STEPS, MountedSystem};
use crate::geom::{DVec3, Ray};
use crate::lookup::{FloorPlane, Pole};
use crate::optics::{ImagingTask, StripLaw, stereographic};
use crate::unwrap::{
    DirectionPicture, ImagingSystem, Panorama, PerspectiveView, RemapTable, UnwrapError, ViewAngles,
};

/// How far beyond its range a floor is looked for at the nodes, so that no cell at its range lacks one.
const BEYOND: f64 = 1.25;

/// What a photo is unwrapped to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UnwrapPicture {
    /// All directions that the mirror is meant to show.
    Panorama {
        /// The law of the rows; the profile's own without it.
        projection: Option<Rows>,
        /// Pixels across; at the photo's scale without it.
        width: Option<usize>,
    },
    /// What an ideal camera would see, with Z upright in it.
    View {
        /// Where it looks, and how wide its field is.
        angles: ViewAngles,
        /// Pixels across; at the photo's scale without it.
        width: Option<usize>,
        /// Pixels down; three quarters of those across without it.
        height: Option<usize>,
    },
    /// A floor as seen from the mirror: X to the right, the axis in the middle, Y up for a floor at negative Z and down at positive Z.
    Ground {
        /// Z of the floor in the part's frame, mm.
        height_mm: f64,
        /// Farthest place of the floor from the axis, mm; none: five times as far as the floor.
        range_mm: Option<f64>,
        /// Millimetres to a pixel; none: 500 pixels across.
        mm_per_px: Option<f64>,
    },
}

/// Laws of a panorama's rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rows {
    /// tan e in equal steps.
    Cylindrical,
    /// e in equal steps.
    Equirectangular,
    /// Conformal.
    Mercator,
}

impl Rows {
    fn law(self) -> StripLaw {
        match self {
            Self::Cylindrical => StripLaw::Cylindrical,
            Self::Equirectangular => StripLaw::Equirectangular,
            Self::Mercator => StripLaw::Mercator,
        }
    }
}

/// A picture with its pixels.
#[derive(Debug, Clone)]
pub(super) enum FramedPicture {
    Panorama(Panorama),
    View(ViewAngles, PerspectiveView),
    Ground(FloorPlan),
}

impl UnwrapPicture {
    /// Whether there can be such a picture.
    ///
    /// # Errors
    /// [`Error::Option`] of the first option that has a value without a meaning.
    pub(super) fn check(&self) -> Result<(), Error> {
        match self {
            Self::Panorama { .. } => Ok(()),
            Self::View { angles, .. } => check_angles(*angles),
            Self::Ground { height_mm, range_mm, mm_per_px } => {
                FloorPlan { z_mm: *height_mm, range_mm: *range_mm, mm_per_px: *mm_per_px }
                    .check("--ground")
            }
        }
    }

    /// The picture for photos of `photo` pixels.
    ///
    /// # Errors
    /// [`UnwrapError`].
    pub(super) fn framed(
        &self,
        optics: &ImagingSystem,
        photo: [usize; 2],
    ) -> Result<FramedPicture, UnwrapError> {
        Ok(match *self {
            Self::Panorama { projection, width } => {
                let law = projection.map(Rows::law);
                FramedPicture::Panorama(Panorama::new(optics, photo, law, width)?)
            }
            Self::View { angles, width, height } => {
                let view = PerspectiveView::new(optics, photo, angles, [width, height])?;
                FramedPicture::View(angles, view)
            }
            Self::Ground { height_mm, range_mm, mm_per_px } => {
                FramedPicture::Ground(FloorPlan { z_mm: height_mm, range_mm, mm_per_px })
            }
        })
    }
}

fn check_angles(
    ViewAngles { azimuth_deg, elevation_deg, field_deg }: ViewAngles,
) -> Result<(), Error> {
    let bad = |must: &str, found: f64| {
        Err(Error::Option { option: "--view", must: must.into(), found: found.to_string() })
    };
    if !(azimuth_deg.abs() <= 360.0) {
        return bad("AZ,EL,FOV with an azimuth from -360 to 360 degrees", azimuth_deg);
    }
    if !(elevation_deg.abs() <= 90.0) {
        return bad("AZ,EL,FOV with an elevation from -90 to 90 degrees", elevation_deg);
    }
    if !(field_deg > 0.0 && field_deg < 180.0) {
        return bad("AZ,EL,FOV with a field of more than 0 and less than 180 degrees", field_deg);
    }
    Ok(())
}

impl FramedPicture {
    /// Pixels across and down.
    pub(super) fn size(&self) -> [usize; 2] {
        match self {
            Self::Panorama(panorama) => panorama.size,
            Self::View(_, view) => view.size(),
            Self::Ground(floor) => floor.seen_from_mirror().size(),
        }
    }

    /// The picture as one of directions; none of a floor, whose places are not at infinity.
    pub(super) fn directions(&self) -> Option<&dyn DirectionPicture> {
        match self {
            Self::Panorama(panorama) => Some(panorama),
            Self::View(_, view) => Some(view),
            Self::Ground(_) => None,
        }
    }

    /// The table for photos of `photo` pixels by traced rays of a system.
    ///
    /// # Errors
    /// [`UnwrapError::Aspect`].
    pub(super) fn mounted(
        &self,
        optics: &ImagingSystem,
        sight: &MountedSystem,
        photo: [usize; 2],
    ) -> Result<RemapTable, UnwrapError> {
        let places = match self {
            Self::Panorama(panorama) => directed(panorama, sight, optics.view),
            Self::View(_, view) => directed(view, sight, optics.view),
            Self::Ground(floor) => placed(floor, sight),
        };
        RemapTable::of_places(optics, (self.size(), &places), photo)
    }
}

/// Places of the sensor, px, that show the directions of a picture from the target's origin.
fn directed(
    picture: &impl DirectionPicture,
    sight: &MountedSystem,
    view: &ImagingTask,
) -> Vec<Option<[f64; 2]>> {
    let frame = sight.traced(sight.grid());
    let pole = frame.pole();
    let project = |direction: DVec3| Some(pole.project(&Ray { origin: DVec3::ZERO, direction }));
    let of = |ray: &Ray| project(view.direction_from_origin(ray.origin, ray.direction));
    let [width, height] = picture.size();
    let wanted = |k: usize| {
        let sigma = picture.sigma((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
        project(stereographic::direction(sigma))
    };
    let (field, _) = frame.field(FINE_STEPS, of);
    sight.places((width * height, wanted), (&field, BEYOND_CELLS), of)
}

/// Places of the sensor, px, that show those of a floor.
fn placed(floor: &FloorPlan, sight: &MountedSystem) -> Vec<Option<[f64; 2]>> {
    let (plan, plane) = (floor.seen_from_mirror(), floor.plane());
    let [width, height] = plan.size();
    let told = FloorPlane { range_mm: BEYOND * plane.range_mm, ..plane };
    let (field, _) = sight.traced(sight.grid()).field(FINE_STEPS, |ray| told.meets(ray));
    let beyond = floor.beyond();
    // (A floor has no pole.)
    let wanted = |k: usize| plan.wanted(k, Pole::Below);
    sight.places((width * height, wanted), (&field, BEYOND_CELLS), |ray| beyond.meets(ray))
}
