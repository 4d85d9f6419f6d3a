//! What photos of one size are unwrapped to, and the map for it.

use super::mounted_system::MadeSystem;
use super::observer::Silent;
use super::pose::KnownErrors;
use super::run::Run;
use super::tolerance_spec::engine;
use super::unwrap_picture::{FramedPicture, UnwrapPicture};
use super::{Error, PhotoError, Stage};
use crate::design::Design;
use crate::profile::{Profile, ProjectionSpec};
use crate::unwrap::{DirectionPicture, ImagingSystem, RemapTable, UnwrapError};
use std::path::Path;

/// A picture that photos are to be unwrapped to.
pub(super) struct PictureRequest<'a> {
    /// Name of the photo, the folder or the stream, for messages.
    pub photo: &'a str,
    /// What is shown.
    pub picture: UnwrapPicture,
    /// A file of how the part is mounted; none: the mirror is the designed one.
    pub pose: Option<&'a Path>,
}

/// The picture for photos of one size, and where its pixels are in them.
pub(super) struct MappedPicture {
    /// The picture.
    pub framed: FramedPicture,
    /// Its map.
    pub map: RemapTable,
}

/// What was found out about photos on the way.
pub(super) struct PhotoSystem {
    /// Pixels of the photo to one of the sensor, across.
    pub scale: f64,
    /// Remarks.
    pub warnings: Vec<String>,
}

/// Refuses a profile that says nothing about directions.
///
/// # Errors
/// [`PhotoError::NoProjection`].
pub(super) fn check_projection(profile: &Profile) -> Result<(), Error> {
    profile.projection.as_ref().map(drop).ok_or_else(|| no_projection(profile))
}

fn no_projection(profile: &Profile) -> Error {
    PhotoError::NoProjection { profile: profile.name.clone() }.into()
}

/// The system of a design that shows something.
///
/// # Errors
/// [`PhotoError::NoProjection`].
pub(super) fn imaging<'a>(
    design: &'a Design,
    profile: &Profile,
) -> Result<ImagingSystem<'a>, Error> {
    let Design { mirror, camera, view: Some(view), .. } = design else {
        return Err(no_projection(profile));
    };
    Ok(ImagingSystem { mirror, camera, view })
}

/// Runs the stage of a picture, which `made` makes of so many pixels.
///
/// # Errors
/// Those of `made`.
pub(super) fn picture_stage<T>(
    run: &Run,
    made: impl FnOnce() -> Result<(T, [usize; 2]), Error>,
) -> Result<T, Error> {
    run.stage(Stage::Picture, || {
        let (made, [width, height]) = made()?;
        Ok((made, format!("{width} x {height} pixels")))
    })
}

impl PictureRequest<'_> {
    fn unfit(&self, source: UnwrapError) -> Error {
        PhotoError::Unfit { photo: self.photo.to_owned(), source }.into()
    }

    /// Designs the mirror and finds the map for photos of `size` pixels, which `make` uses in the same stage.
    ///
    /// # Errors
    /// [`enum@Error`] when there is no such picture, or `make` fails.
    pub(super) fn made<T>(
        &self,
        run: &Run,
        size: [usize; 2],
        make: impl FnOnce(MappedPicture) -> Result<T, Error>,
    ) -> Result<(T, PhotoSystem), Error> {
        let pose = self.pose.map(KnownErrors::read).transpose()?;
        let design = run.design()?;
        let optics = imaging(&design, run.profile)?;
        let unfit = |source| self.unfit(source);
        let [scale, _] = optics.scale(size).map_err(unfit)?;
        let framed = self.picture.framed(&optics, size).map_err(unfit)?;
        let pixels = framed.size();
        let way = MapWay::new(run, (&design, &framed), pose.as_ref())?;
        let made = picture_stage(run, || {
            let map = way.map(&optics, &framed, size).map_err(unfit)?;
            self.check_seen(&way, (&optics, &framed), &map)?;
            Ok((make(MappedPicture { framed: framed.clone(), map })?, pixels))
        })?;
        let warnings = pose.and_then(|pose| pose.warning(run.profile)).into_iter().collect();
        Ok((made, PhotoSystem { scale, warnings }))
    }

    /// Refuses a view or a plan of which the photo shows nothing.
    fn check_seen(
        &self,
        way: &MapWay,
        (optics, framed): (&ImagingSystem, &FramedPicture),
        map: &RemapTable,
    ) -> Result<(), Error> {
        let (what, remedy) = match framed {
            _ if map.seen() > 0.0 => return Ok(()),
            FramedPicture::Panorama(_) => return Ok(()),
            FramedPicture::View(..) => (
                "this view".to_owned(),
                "the panorama, without --view, shows the directions that there are",
            ),
            FramedPicture::Ground(floor) => {
                if let MapWay::Traced(made) = way {
                    let system = made.before(optics.camera);
                    floor.check_shown(system.traced(system.grid()).rays(), "--ground")?;
                }
                let plane = floor.plane();
                let (z_mm, range_mm) = (plane.z_mm, plane.range_mm);
                (
                    format!("the floor at Z = {z_mm} mm within {range_mm} mm of the axis"),
                    "--range-mm reaches farther, and --mm-per-px looks closer",
                )
            }
        };
        Err(PhotoError::Unseen { photo: self.photo.to_owned(), what, remedy }.into())
    }
}

/// The way in which places of a photo are found.
enum MapWay<'a> {
    /// These directions by the inverse of the designed mirror: not those of a system as mounted, nor of panels, each of which has a
    /// projection of its own.
    Inverse(&'a dyn DirectionPicture),
    /// Rays of the system as it is mounted.
    Traced(Box<MadeSystem>),
}

impl<'a> MapWay<'a> {
    fn new(
        run: &Run,
        (design, framed): (&Design, &'a FramedPicture),
        pose: Option<&KnownErrors>,
    ) -> Result<Self, Error> {
        let is_panels = matches!(run.profile.projection, Some(ProjectionSpec::Panels(_)));
        match framed.directions() {
            Some(directions) if pose.is_none() && !is_panels => Ok(Self::Inverse(directions)),
            _ => Ok(Self::Traced(Box::new(MadeSystem::new(engine(run, design)?.0, pose)))),
        }
    }

    /// The table of a picture for photos of `photo` pixels.
    fn map(
        &self,
        optics: &ImagingSystem,
        framed: &FramedPicture,
        photo: [usize; 2],
    ) -> Result<RemapTable, UnwrapError> {
        match self {
            Self::Inverse(directions) => RemapTable::new(optics, *directions, photo),
            Self::Traced(made) => framed.mounted(optics, &made.before(optics.camera), photo),
        }
    }
}

impl Design {
    /// Where photos of `photo` pixels, columns and rows, show each pixel of a panorama, a view or a plan of a floor: of the mirror as
    /// designed, or as mounted by a file as `tolerance --replay` writes it. These are the numbers of `morion unwrap --map`.
    ///
    /// ```
    /// use morion::UnwrapPicture;
    /// # let profile = morion::Profile::parse("part", "part.toml", include_bytes!("../../examples/small.toml"))?;
    /// let panorama = UnwrapPicture::Panorama { projection: None, width: Some(90) };
    /// let map = profile.design()?.unwrap_map(&panorama, [160, 120], None)?;
    /// assert_eq!(map.entries().len(), 90 * map.size[1]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`enum@Error`] of a profile without a projection, of a file that is no pose, and of a picture that cannot be made of such photos.
    pub fn unwrap_map(
        &self,
        picture: &UnwrapPicture,
        photo: [usize; 2],
        pose: Option<&Path>,
    ) -> Result<RemapTable, Error> {
        let unfit = |source| {
            let photo = format!("a photo of {} x {} pixels", photo[0], photo[1]);
            Error::from(PhotoError::Unfit { photo, source })
        };
        picture.check()?;
        let pose = pose.map(KnownErrors::read).transpose()?;
        let optics = imaging(self, &self.profile)?;
        let framed = picture.framed(&optics, photo).map_err(unfit)?;
        let run = Run::in_memory(&self.profile, &Silent);
        let way = MapWay::new(&run, (self, &framed), pose.as_ref())?;
        way.map(&optics, &framed, photo).map_err(unfit)
    }
}
