//! A photo and a profile -> a panorama and its map.

use super::files::{self, Folder, Staged};
use super::observer::{Observer, Stage, StageTimer};
use super::{Error, Source, designed};
use crate::optics::StripLaw;
use crate::raster::{Raster, RasterError};
use crate::report::{
    FileFacts, PanoramaFacts, PhotoFacts, ProfileId, SCHEMA, UnwrapMapFacts, UnwrapReport,
};
use crate::unwrap::{
    ImagingSystem, MapEncodingError, Panorama, RemapTable, UnwrapError, crop_panels,
};
use std::path::Path;
use thiserror::Error;

/// How a photo becomes a panorama.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
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

/// Why a photo cannot be unwrapped.
#[derive(Debug, Error)]
pub enum PhotoError {
    /// It is no picture.
    #[error("{photo}: {source}")]
    Picture {
        /// The file.
        photo: String,
        /// Why not.
        source: RasterError,
    },
    /// The profile says nothing about directions.
    #[error(
        "{profile} has no [projection], and without one there is no telling what its picture should \
         show; add the projection that the mirror was made for"
    )]
    NoProjection {
        /// Profile name.
        profile: String,
    },
    /// Photo and profile do not go together.
    #[error("cannot unwrap {photo}: {source}")]
    Unfit {
        /// The file.
        photo: String,
        /// Why.
        source: UnwrapError,
    },
    /// The map cannot be encoded.
    #[error(transparent)]
    Table(#[from] MapEncodingError),
}

/// Turns `photo`, taken through the mirror of `source`, into `out`/NAME/PHOTO-unwrapped.png and, where
/// asked for, PHOTO-map.npy or PHOTO-map.exr.
///
/// # Errors
/// [`enum@Error`] when it cannot be done; then no file has changed.
pub fn unwrap(
    source: &Source,
    photo: &Path,
    way: Way,
    out: &Path,
    observer: &dyn Observer,
) -> Result<UnwrapReport, Error> {
    let profile = &source.profile;
    let clock = StageTimer::new(observer);
    let name = photo.display().to_string();
    if profile.projection.is_none() {
        return Err(PhotoError::NoProjection { profile: profile.name.clone() }.into());
    }
    let light = clock.stage(Stage::Read, || {
        let bytes = files::read(photo)?;
        let light = Raster::decode(&bytes)
            .map_err(|source| PhotoError::Picture { photo: name.clone(), source })?;
        let note = format!("{name}: {} x {} pixels", light.width, light.height);
        Ok::<_, Error>((light, note))
    })?;
    let size = [light.width, light.height];
    let design = clock.stage(Stage::Design, || designed(source))?;
    let view = design.view.as_ref().expect("a profile with a projection has a view");
    let optics = ImagingSystem { mirror: &design.mirror, camera: &design.camera, view };
    let unfit = |source| Error::from(PhotoError::Unfit { photo: name.clone(), source });
    let scale = optics.scale(size).map_err(unfit)?;

    let (panorama, picture, map) = clock.stage(Stage::Picture, || {
        let made = match way {
            Way::Cuts => {
                let (picture, panorama) = crop_panels(&optics, &light).map_err(unfit)?;
                (panorama, picture, None)
            }
            Way::Remap { projection, width, .. } => {
                let law = projection.map(Rows::law);
                let panorama = Panorama::new(&optics, size, law, width).map_err(unfit)?;
                let map = RemapTable::new(&optics, &panorama, size).map_err(unfit)?;
                let picture = map.paint(&light);
                (panorama, picture, Some(map))
            }
        };
        let note = format!("{} x {} pixels", made.1.width, made.1.height);
        Ok::<_, Error>((made, note))
    })?;

    let stem = photo.file_stem().unwrap_or_default().to_string_lossy();
    let mut made = vec![{
        let png = picture.to_png().map_err(|error| Error::Picture(error.to_string()))?;
        (format!("{stem}-unwrapped.png"), "png", png)
    }];
    if let (Way::Remap { map: Some(format), .. }, Some(map)) = (way, &map) {
        made.push(match format {
            MapFormat::Npy => (format!("{stem}-map.npy"), "npy", map.npy()),
            MapFormat::Exr => {
                let bytes = map.exr().map_err(PhotoError::from)?;
                (format!("{stem}-map.exr"), "exr", bytes)
            }
        });
    }
    let files = publish(&clock, &out.join(&profile.name), made)?;
    Ok(UnwrapReport {
        schema: SCHEMA,
        profile: ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() },
        photo: PhotoFacts { name, pixels: size, pixels_per_sensor_pixel: scale[0] },
        panorama: PanoramaFacts {
            way: if way == Way::Cuts { "cuts" } else { "remap" },
            projection: law_name(&panorama.law),
            pixels: panorama.size,
            azimuth_deg: panorama.azimuth_deg(),
            elevation_deg: panorama.elevation_deg(),
        },
        map: map.map(|map| UnwrapMapFacts { seen: map.seen(), distortion_px: map.distortion_px }),
        files,
    })
}

/// Writes all files, then gives them their names.
fn publish(
    clock: &StageTimer,
    folder: &Path,
    made: Vec<(String, &'static str, Vec<u8>)>,
) -> Result<Vec<FileFacts>, Error> {
    clock.stage(Stage::Write, || {
        let folder = Folder::create(folder)?;
        let (mut staged, mut files) = (Vec::<Staged>::new(), Vec::new());
        for (name, format, bytes) in made {
            let file = folder.stage(&name, |out| out.write_all(&bytes))?;
            let sha256 = file.sha256().to_owned();
            staged.push(file);
            let format = format.into();
            files.push(FileFacts { name, format, bytes: bytes.len() as u64, sha256 });
        }
        folder.replace(staged, &[])?;
        Ok::<_, Error>((files, folder.path().display().to_string()))
    })
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
