//! A photo and a profile -> a panorama and its map.

use super::run::{Command, Run};
use super::{Error, PhotoError, Stage};
use crate::design::Design;
use crate::optics::StripLaw;
use crate::profile::Profile;
use crate::publish;
use crate::raster::Raster;
use crate::results::{FileFacts, PanoramaFacts, PhotoFacts, SCHEMA, UnwrapMapFacts, UnwrapReport};
use crate::unwrap::{ImagingSystem, Panorama, RemapTable, UnwrapError, crop_panels};
use std::path::Path;

/// How a photo becomes a panorama.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnwrapOptions {
    /// The panels cut out and laid side by side.
    Cuts,
    /// Every direction fetched from where the designed mirror shows it.
    Remap {
        /// The law of the rows; the profile's own without it.
        projection: Option<Rows>,
        /// Pixels across; at the photo's scale without it.
        width: Option<usize>,
        /// Whether the map is written too, and how.
        map: Option<MapFormat>,
    },
}

impl Default for UnwrapOptions {
    /// A panorama by the profile's law at the photo's scale, without its map.
    fn default() -> Self {
        Self::Remap { projection: None, width: None, map: None }
    }
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

/// Formats of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapFormat {
    /// A NumPy array.
    Npy,
    /// An OpenEXR picture.
    Exr,
}

/// A photo to be unwrapped, and how: writes `PHOTO-unwrapped.png` and, where asked for, `PHOTO-map.npy` or
/// `PHOTO-map.exr` into NAME.
#[derive(Debug, Clone, Copy)]
pub struct Unwrap<'a> {
    /// The photo: a PNG, JPEG or EXR, taken through the mirror.
    pub photo: &'a Path,
    /// How it becomes a panorama.
    pub options: UnwrapOptions,
}

impl Command for Unwrap<'_> {
    type Report = UnwrapReport;

    fn check(&self, profile: &Profile) -> Result<(), Error> {
        match profile.projection {
            Some(_) => Ok(()),
            None => Err(no_projection(profile)),
        }
    }

    fn run(&self, run: &mut Run) -> Result<UnwrapReport, Error> {
        let photo = run.stage(Stage::Read, || {
            let photo = self.decoded()?;
            let note = format!("{}: {} x {} pixels", self.name(), photo.width, photo.height);
            Ok((photo, note))
        })?;
        let design = run.design()?;
        let Design { mirror, camera, view: Some(view), .. } = &design else {
            return Err(no_projection(run.profile));
        };
        let optics = ImagingSystem { mirror, camera, view };
        let size = [photo.width, photo.height];
        let scale = optics.scale(size).map_err(|source| self.unfit(source))?;
        let (panorama, picture, map) = run.stage(Stage::Picture, || {
            let made = self.picture(&optics, &photo)?;
            let note = format!("{} x {} pixels", made.1.width, made.1.height);
            Ok((made, note))
        })?;
        let png = picture.to_png().map_err(|error| Error::Picture(error.to_string()))?;
        let table = map.as_ref().and_then(|map| self.table(map)).transpose()?;
        let mut files = Vec::new();
        run.publish(Stage::Write, |transaction, _| {
            for (suffix, format, bytes) in [("unwrapped.png", "png", png)].into_iter().chain(table)
            {
                let stem = self.photo.file_stem().unwrap_or_default().to_string_lossy();
                let staged = transaction.add_bytes(&format!("{stem}-{suffix}"), &bytes)?;
                files.push(FileFacts {
                    name: staged.name().to_owned(),
                    format: format.into(),
                    bytes: bytes.len() as u64,
                    sha256: staged.sha256().to_owned(),
                });
            }
            Ok(())
        })?;
        Ok(UnwrapReport {
            schema: SCHEMA,
            profile: run.profile.into(),
            photo: PhotoFacts {
                name: self.name(),
                pixels: size,
                pixels_per_sensor_pixel: scale[0],
            },
            panorama: PanoramaFacts {
                way: if self.options == UnwrapOptions::Cuts { "cuts" } else { "remap" },
                projection: law_name(&panorama.law),
                pixels: panorama.size,
                azimuth_deg: panorama.azimuth_deg(),
                elevation_deg: panorama.elevation_deg(),
            },
            map: map
                .map(|map| UnwrapMapFacts { seen: map.seen(), distortion_px: map.distortion_px }),
            files,
        })
    }
}

/// A file of a map: the end of its name, its format and its bytes.
type Table = (&'static str, &'static str, Vec<u8>);

impl Unwrap<'_> {
    fn name(&self) -> String {
        self.photo.display().to_string()
    }

    fn unfit(&self, source: UnwrapError) -> Error {
        PhotoError::Unfit { photo: self.name(), source }.into()
    }

    /// The photo in linear light.
    fn decoded(&self) -> Result<Raster, Error> {
        Raster::decode(&publish::read(self.photo)?)
            .map_err(|source| PhotoError::Picture { photo: self.name(), source }.into())
    }

    fn picture(
        &self,
        optics: &ImagingSystem,
        photo: &Raster,
    ) -> Result<(Panorama, Raster, Option<RemapTable>), Error> {
        let unfit = |source| self.unfit(source);
        match self.options {
            UnwrapOptions::Cuts => {
                let (picture, panorama) = crop_panels(optics, photo).map_err(unfit)?;
                Ok((panorama, picture, None))
            }
            UnwrapOptions::Remap { projection, width, .. } => {
                let size = [photo.width, photo.height];
                let law = projection.map(Rows::law);
                let panorama = Panorama::new(optics, size, law, width).map_err(unfit)?;
                let map = RemapTable::new(optics, &panorama, size).map_err(unfit)?;
                let picture = map.paint(photo);
                Ok((panorama, picture, Some(map)))
            }
        }
    }

    /// The map's file, if there is to be one.
    fn table(&self, map: &RemapTable) -> Option<Result<Table, Error>> {
        let UnwrapOptions::Remap { map: Some(format), .. } = self.options else { return None };
        Some(match format {
            MapFormat::Npy => Ok(("map.npy", "npy", map.npy())),
            MapFormat::Exr => {
                let exr = map.exr().map_err(|error| PhotoError::from(error).into());
                exr.map(|bytes| ("map.exr", "exr", bytes))
            }
        })
    }
}

fn no_projection(profile: &Profile) -> Error {
    PhotoError::NoProjection { profile: profile.name.clone() }.into()
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

fn law_name(law: &StripLaw) -> &'static str {
    match law {
        StripLaw::Cylindrical => "cylindrical",
        StripLaw::Mercator => "mercator",
        StripLaw::Equirectangular => "equirectangular",
        StripLaw::EqualArea => "equal-area",
        StripLaw::Tabulated(_) => "table",
    }
}
