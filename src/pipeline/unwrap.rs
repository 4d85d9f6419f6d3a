//! A photo and a profile -> a panorama, a view or a plan of the floor, and its map.

use super::mounted_system::MountedSystem;
use super::observer::Silent;
use super::pose::KnownErrors;
use super::run::{Command, Run};
use super::tolerance_spec::engine;
use super::unwrap_picture::{FramedPicture, UnwrapPicture};
use super::{Error, PhotoError, Stage};
use crate::design::Design;
use crate::num::random::RandomStream;
use crate::optics::StripLaw;
use crate::profile::{Profile, ProjectionSpec};
use crate::publish;
use crate::raster::Raster;
use crate::results::{
    FileFacts, GroundFacts, PanoramaFacts, PhotoFacts, SCHEMA, UnwrapMapFacts, UnwrapReport,
    ViewFacts,
};
use crate::tolerance::{Engine, Perturbation};
use crate::unwrap::{ImagingSystem, Panorama, RemapTable, UnwrapError, crop_panels};
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
        if profile.projection.is_none() {
            return Err(no_projection(profile));
        }
        match &self.options {
            UnwrapOptions::Cuts => Ok(()),
            UnwrapOptions::Remap { picture, .. } => picture.check(),
        }
    }

    fn run(&self, run: &mut Run) -> Result<UnwrapReport, Error> {
        let photo = run.stage(Stage::Read, || {
            let photo = self.decoded()?;
            let note = format!("{}: {} x {} pixels", self.name(), photo.width, photo.height);
            Ok((photo, note))
        })?;
        let pose = self.pose().map(KnownErrors::read).transpose()?;
        let design = run.design()?;
        let Design { mirror, camera, view: Some(view), .. } = &design else {
            return Err(no_projection(run.profile));
        };
        let optics = ImagingSystem { mirror, camera, view };
        let size = [photo.width, photo.height];
        let scale = optics.scale(size).map_err(|source| self.unfit(source))?;
        let made = self.unwrapped(run, (&design, &optics), pose.as_ref(), &photo)?;
        let files = self.written(run, &made)?;
        let UnwrappedPhoto { framed, map, .. } = made;
        let mut report = UnwrapReport {
            schema: SCHEMA,
            profile: run.profile.into(),
            photo: PhotoFacts {
                name: self.name(),
                pixels: size,
                pixels_per_sensor_pixel: scale[0],
            },
            pose: self.pose().map(|path| path.display().to_string()),
            panorama: None,
            view: None,
            ground: None,
            map: map
                .map(|map| UnwrapMapFacts { seen: map.seen(), distortion_px: map.distortion_px }),
            files,
            warnings: pose.and_then(|pose| pose.warning(run.profile)).into_iter().collect(),
        };
        self.add_picture(&mut report, &framed);
        Ok(report)
    }
}

/// A file of a map: the end of its name, its format and its bytes.
type Table = (&'static str, &'static str, Vec<u8>);

impl Unwrap<'_> {
    fn name(&self) -> String {
        self.photo.display().to_string()
    }

    fn pose(&self) -> Option<&Path> {
        match self.options {
            UnwrapOptions::Cuts => None,
            UnwrapOptions::Remap { pose, .. } => pose,
        }
    }

    fn unfit(&self, source: UnwrapError) -> Error {
        PhotoError::Unfit { photo: self.name(), source }.into()
    }

    /// The photo in linear light.
    fn decoded(&self) -> Result<Raster, Error> {
        Raster::decode(&publish::read(self.photo)?)
            .map_err(|source| PhotoError::Picture { photo: self.name(), source }.into())
    }

    fn unwrapped(
        &self,
        run: &Run,
        (design, optics): (&Design, &ImagingSystem),
        pose: Option<&KnownErrors>,
        photo: &Raster,
    ) -> Result<UnwrappedPhoto, Error> {
        let unfit = |source| self.unfit(source);
        let size = [photo.width, photo.height];
        let painted = |framed: FramedPicture, map: RemapTable| {
            self.check_seen(&framed, &map)?;
            Ok(UnwrappedPhoto { picture: map.paint(photo), framed, map: Some(map) })
        };
        let UnwrapOptions::Remap { picture, .. } = self.options else {
            return self.picture_stage(run, || {
                let (picture, panorama) = crop_panels(optics, photo).map_err(unfit)?;
                let framed = FramedPicture::Panorama(panorama);
                Ok(UnwrappedPhoto { framed, picture, map: None })
            });
        };
        let framed = picture.framed(optics, size).map_err(unfit)?;
        let way = MapWay::new(run, (design, &framed), pose)?;
        self.picture_stage(run, || {
            painted(framed.clone(), way.map(optics, &framed, size).map_err(unfit)?)
        })
    }

    fn picture_stage(
        &self,
        run: &Run,
        made: impl FnOnce() -> Result<UnwrappedPhoto, Error>,
    ) -> Result<UnwrappedPhoto, Error> {
        run.stage(Stage::Picture, || {
            let made = made()?;
            let note = format!("{} x {} pixels", made.picture.width, made.picture.height);
            Ok((made, note))
        })
    }

    /// Refuses a view or a plan of which the photo shows nothing.
    fn check_seen(&self, framed: &FramedPicture, map: &RemapTable) -> Result<(), Error> {
        let (what, remedy) = match framed {
            _ if map.seen() > 0.0 => return Ok(()),
            FramedPicture::Panorama(_) => return Ok(()),
            FramedPicture::View(..) => (
                "this view".to_owned(),
                "the panorama, without --view, shows the directions that there are",
            ),
            FramedPicture::Ground(floor) => {
                let plane = floor.plane();
                let (z_mm, range_mm) = (plane.z_mm, plane.range_mm);
                (
                    format!("the floor at Z = {z_mm} mm within {range_mm} mm of the axis"),
                    "Z is positive past the camera and negative behind the mirror, and --range-mm reaches farther",
                )
            }
        };
        Err(PhotoError::Unseen { photo: self.name(), what, remedy }.into())
    }

    /// Publishes the files.
    fn written(&self, run: &mut Run, made: &UnwrappedPhoto) -> Result<Vec<FileFacts>, Error> {
        let png = made.picture.to_png().map_err(|error| Error::Picture(error.to_string()))?;
        let [picture, prefix] = match made.framed {
            FramedPicture::Panorama(_) => ["unwrapped.png", ""],
            FramedPicture::View(..) => ["view.png", "view-"],
            FramedPicture::Ground(_) => ["ground.png", "ground-"],
        };
        let table = made.map.as_ref().and_then(|map| self.table(map)).transpose()?;
        let table = table.map(|(name, format, bytes)| (format!("{prefix}{name}"), format, bytes));
        let stem = self.photo.file_stem().unwrap_or_default().to_string_lossy();
        let mut files = Vec::new();
        run.publish(Stage::Write, |transaction, _| {
            let picture = (picture.to_owned(), "png", png);
            for (suffix, format, bytes) in [picture].into_iter().chain(table) {
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
        Ok(files)
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

    fn add_picture(&self, report: &mut UnwrapReport, framed: &FramedPicture) {
        let pixels = framed.size();
        match framed {
            FramedPicture::Panorama(panorama) => {
                report.panorama = Some(self.panorama_facts(panorama));
            }
            FramedPicture::View(angles, _) => {
                report.view = Some(ViewFacts {
                    pixels,
                    azimuth_deg: angles.azimuth_deg,
                    elevation_deg: angles.elevation_deg,
                    field_deg: angles.field_deg,
                });
            }
            FramedPicture::Ground(floor) => {
                report.ground = Some(GroundFacts {
                    pixels,
                    height_mm: floor.z_mm,
                    range_mm: floor.plane().range_mm,
                    mm_per_px: floor.mm_per_px(),
                    corner_mm: floor.seen_from_mirror().corner(),
                    row_mm: floor.row_seen_mm(),
                });
            }
        }
    }

    fn panorama_facts(&self, panorama: &Panorama) -> PanoramaFacts {
        PanoramaFacts {
            way: if self.options == UnwrapOptions::Cuts { "cuts" } else { "remap" },
            projection: law_name(&panorama.law),
            pixels: panorama.size,
            azimuth_deg: panorama.azimuth_deg(),
            elevation_deg: panorama.elevation_deg(),
        }
    }
}

/// The way in which places of a photo are found.
enum MapWay<'a> {
    /// Directions by the inverse of the designed mirror: not those of a system as mounted, nor of panels, each of which has a projection of
    /// its own.
    Inverse,
    /// Rays of the system as it is mounted.
    Traced(Box<Engine>, &'a [(Perturbation, f64)], bool),
}

impl<'a> MapWay<'a> {
    fn new(
        run: &Run,
        (design, framed): (&Design, &FramedPicture),
        pose: Option<&'a KnownErrors>,
    ) -> Result<Self, Error> {
        let is_panels = matches!(run.profile.projection, Some(ProjectionSpec::Panels(_)));
        if framed.directions().is_some() && pose.is_none() && !is_panels {
            return Ok(Self::Inverse);
        }
        let errors = pose.map_or(&[][..], |pose| &pose.errors);
        Ok(Self::Traced(Box::new(engine(run, design)?.0), errors, pose.is_some()))
    }

    /// The table of a picture for photos of `photo` pixels.
    fn map(
        &self,
        optics: &ImagingSystem,
        framed: &FramedPicture,
        photo: [usize; 2],
    ) -> Result<RemapTable, UnwrapError> {
        match (self, framed.directions()) {
            (Self::Inverse, Some(directions)) => RemapTable::new(optics, directions, photo),
            (Self::Inverse, None) => unreachable!("a floor's places are traced"),
            (Self::Traced(engine, errors, is_mounted), _) => {
                let made = engine.make(errors, RandomStream { seed: 0, trial: 0 });
                let (camera, is_mounted) = (optics.camera, *is_mounted);
                let sight = MountedSystem { engine, camera, made: &made, is_mounted };
                framed.mounted(optics, &sight, photo)
            }
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
        let Self { mirror, camera, view: Some(view), .. } = self else {
            return Err(no_projection(&self.profile));
        };
        let pose = pose.map(KnownErrors::read).transpose()?;
        let optics = ImagingSystem { mirror, camera, view };
        let framed = picture.framed(&optics, photo).map_err(unfit)?;
        let run = Run::in_memory(&self.profile, &Silent);
        let way = MapWay::new(&run, (self, &framed), pose.as_ref())?;
        way.map(&optics, &framed, photo).map_err(unfit)
    }
}

fn no_projection(profile: &Profile) -> Error {
    PhotoError::NoProjection { profile: profile.name.clone() }.into()
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
