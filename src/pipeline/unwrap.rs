//! A photo and a profile -> a panorama, a view or a plan of the floor, and its map.

use super::run::{Command, Run};
use super::unwrap_facts::{file_facts, report_on};
use super::unwrap_map::{
    MappedPicture, PhotoSystem, PictureRequest, check_projection, imaging, picture_stage,
};
use super::unwrap_picture::{FramedPicture, UnwrapPicture};
use super::{Error, PhotoError, Stage};
use crate::profile::Profile;
use crate::publish;
use crate::raster::Raster;
use crate::results::{FileFacts, PhotoFacts, UnwrapMapFacts, UnwrapReport};
use crate::unwrap::{MapEncodingError, RemapTable, crop_panels};
use std::path::Path;

/// How a photo is unwrapped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UnwrapOptions<'a> {
    /// The panels cut out and laid side by side.
    Cuts,
    /// Everything fetched from where the mirror shows it.
    Remap {
        /// What is shown.
        picture: UnwrapPicture,
        /// Whether the map is written too, and how.
        map: Option<MapFormat>,
        /// A file as `tolerance --replay` writes: how the part is mounted, and the camera's errors. Without it the mirror is the
        /// designed one.
        pose: Option<&'a Path>,
    },
}

impl Default for UnwrapOptions<'_> {
    /// A panorama by the profile's law at the photo's scale, without its map.
    fn default() -> Self {
        let picture = UnwrapPicture::Panorama { projection: None, width: None };
        Self::Remap { picture, map: None, pose: None }
    }
}

/// Formats of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapFormat {
    /// A NumPy array.
    Npy,
    /// An OpenEXR picture.
    Exr,
}

impl MapFormat {
    /// Its name, which is the end of its files' names too.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Npy => "npy",
            Self::Exr => "exr",
        }
    }

    /// The file of a map.
    ///
    /// # Errors
    /// [`MapEncodingError`] when there is not room enough.
    pub(super) fn encode(self, map: &RemapTable) -> Result<Vec<u8>, MapEncodingError> {
        match self {
            Self::Npy => Ok(map.npy()),
            Self::Exr => map.exr(),
        }
    }
}

/// A photo to be unwrapped, and how: writes `PHOTO-unwrapped.png`, `PHOTO-view.png` or `PHOTO-ground.png` and, where asked for, `PHOTO-map`,
/// `PHOTO-view-map` or `PHOTO-ground-map` as `.npy` or `.exr` into NAME.
#[derive(Debug, Clone, Copy)]
pub struct Unwrap<'a> {
    /// The photo: a PNG, JPEG or EXR, taken through the mirror.
    pub photo: &'a Path,
    /// How it is unwrapped.
    pub options: UnwrapOptions<'a>,
}

/// A photo that was unwrapped.
struct UnwrappedPhoto {
    framed: FramedPicture,
    picture: Raster,
    /// None of cuts.
    map: Option<RemapTable>,
}

impl Command for Unwrap<'_> {
    type Report = UnwrapReport;

    fn check(&self, profile: &Profile) -> Result<(), Error> {
        check_projection(profile)?;
        match &self.options {
            UnwrapOptions::Cuts => Ok(()),
            UnwrapOptions::Remap { picture, .. } => picture.check(),
        }
    }

    fn run(&self, run: &mut Run) -> Result<UnwrapReport, Error> {
        let name = self.photo.display().to_string();
        let photo = run.stage(Stage::Read, || {
            let photo = decoded(self.photo)?;
            let note = format!("{name}: {} x {} pixels", photo.width, photo.height);
            Ok((photo, note))
        })?;
        let (made, system) = match self.options {
            UnwrapOptions::Cuts => cut(run, &name, &photo)?,
            UnwrapOptions::Remap { picture, pose, .. } => {
                let request = PictureRequest { photo: &name, picture, pose };
                request.made(
                    run,
                    [photo.width, photo.height],
                    |MappedPicture { framed, map }| {
                        Ok(UnwrappedPhoto { picture: map.paint(&photo), framed, map: Some(map) })
                    },
                )?
            }
        };
        let files = self.written(run, &made)?;
        let (way, pose) = match self.options {
            UnwrapOptions::Cuts => ("cuts", None),
            UnwrapOptions::Remap { pose, .. } => ("remap", pose),
        };
        let facts = PhotoFacts {
            name,
            pixels: [photo.width, photo.height],
            pixels_per_sensor_pixel: system.scale,
        };
        let report = report_on(run.profile, facts, pose, (&made.framed, way));
        let map = made.map.as_ref().map(UnwrapMapFacts::from);
        Ok(UnwrapReport { map, files, warnings: system.warnings, ..report })
    }
}

/// A photo in linear light.
///
/// # Errors
/// [`enum@Error`] of a file that cannot be read, or is no picture.
pub(super) fn decoded(photo: &Path) -> Result<Raster, Error> {
    let fault = |source| PhotoError::Picture { photo: photo.display().to_string(), source };
    Raster::decode(&publish::read(photo)?).map_err(|source| fault(source).into())
}

/// The panels of a photo, cut out.
fn cut(run: &Run, name: &str, photo: &Raster) -> Result<(UnwrappedPhoto, PhotoSystem), Error> {
    let unfit = |source| PhotoError::Unfit { photo: name.to_owned(), source };
    let design = run.design()?;
    let optics = imaging(&design, run.profile)?;
    let [scale, _] = optics.scale([photo.width, photo.height]).map_err(unfit)?;
    let made = picture_stage(run, || {
        let (picture, panorama) = crop_panels(&optics, photo).map_err(unfit)?;
        let pixels = [picture.width, picture.height];
        let framed = FramedPicture::Panorama(panorama);
        Ok((UnwrappedPhoto { framed, picture, map: None }, pixels))
    })?;
    Ok((made, PhotoSystem { scale, warnings: Vec::new() }))
}

impl Unwrap<'_> {
    /// Publishes the files.
    fn written(&self, run: &mut Run, made: &UnwrappedPhoto) -> Result<Vec<FileFacts>, Error> {
        let png = made.picture.to_png().map_err(|error| Error::Picture(error.to_string()))?;
        let [picture, prefix] = match made.framed {
            FramedPicture::Panorama(_) => ["unwrapped.png", ""],
            FramedPicture::View(..) => ["view.png", "view-"],
            FramedPicture::Ground(_) => ["ground.png", "ground-"],
        };
        let format = match self.options {
            UnwrapOptions::Cuts => None,
            UnwrapOptions::Remap { map, .. } => map,
        };
        let table = made.map.as_ref().zip(format).map(|(map, format)| {
            let bytes = format.encode(map).map_err(PhotoError::from)?;
            let name = format.name();
            Ok::<_, Error>((format!("{prefix}map.{name}"), name, bytes))
        });
        let table = table.transpose()?;
        let stem = self.photo.file_stem().unwrap_or_default().to_string_lossy();
        let mut files = Vec::new();
        run.publish(Stage::Write, |transaction, _| {
            let picture = (picture.to_owned(), "png", png);
            for (suffix, format, bytes) in [picture].into_iter().chain(table) {
                let staged = transaction.add_bytes(&format!("{stem}-{suffix}"), &bytes)?;
                files.push(file_facts(staged, format, &bytes));
            }
            Ok(())
        })?;
        Ok(files)
    }
}
