//! A folder of pictures through the mirror -> a folder of their panoramas, views or plans, by one map.

use super::run::{Command, Run};
use super::unwrap::{MapFormat, decoded};
use super::unwrap_facts::{file_facts, report_on};
use super::unwrap_map::{MappedPicture, PhotoSystem, PictureRequest, check_projection};
use super::unwrap_picture::UnwrapPicture;
use super::{Error, PhotoError, Stage};
use crate::parallel;
use crate::profile::Profile;
use crate::publish::files_of;
use crate::results::{FileFacts, FramesFacts, PhotoFacts, UnwrapMapFacts, UnwrapReport};
use crate::unwrap::RemapTable;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Ends of the names of pictures that are read, in small letters.
const ENDS: [&str; 4] = ["png", "jpg", "jpeg", "exr"];

/// Unwrapping of all pictures of a folder, in the order of their names: each to a PNG of its name, as [`super::Unwrap`] does it alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnwrapFolder<'a> {
    /// The folder: its PNG, JPEG and EXR, all of one size.
    pub photos: &'a Path,
    /// What is shown.
    pub picture: UnwrapPicture,
    /// Whether the map is written too, and how.
    pub map: Option<MapFormat>,
    /// A file as `tolerance --replay` writes: how the part is mounted, and the camera's errors. Without it the mirror is the designed one.
    pub pose: Option<&'a Path>,
}

/// A picture to be unwrapped, and the name of its file.
#[derive(Debug, PartialEq, Eq)]
struct FolderPicture {
    path: PathBuf,
    name: String,
}

impl Command for UnwrapFolder<'_> {
    type Report = UnwrapReport;

    fn check(&self, profile: &Profile) -> Result<(), Error> {
        check_projection(profile)?;
        self.picture.check()
    }

    fn folder(&self, profile: &Profile) -> PathBuf {
        let kind = match self.picture {
            UnwrapPicture::Panorama { .. } => "unwrapped",
            UnwrapPicture::View { .. } => "view",
            UnwrapPicture::Ground { .. } => "ground",
        };
        // (Of the folder `.` too.)
        let full = self.photos.canonicalize().unwrap_or_else(|_| self.photos.to_owned());
        let name = full.file_name().map_or("frames".into(), |name| name.to_string_lossy());
        PathBuf::from(&profile.name).join(format!("{name}-{kind}"))
    }

    fn run(&self, run: &mut Run) -> Result<UnwrapReport, Error> {
        let name = self.photos.display().to_string();
        let (pictures, pixels) = run.stage(Stage::Read, || {
            let pictures = self.pictures()?;
            let first = decoded(&pictures[0].path)?;
            let pixels = [first.width, first.height];
            let note =
                format!("{name}: {} of {} x {} pixels", pictures.len(), pixels[0], pixels[1]);
            Ok(((pictures, pixels), note))
        })?;
        let request = PictureRequest { photo: &name, picture: self.picture, pose: self.pose };
        let (MappedPicture { framed, map }, system) = request.made(run, pixels, Ok)?;
        let files = self.written(run, &pictures, &map)?;
        let PhotoSystem { scale: pixels_per_sensor_pixel, warnings } = system;
        let photo = PhotoFacts { name, pixels, pixels_per_sensor_pixel };
        let count = pictures.len() as u64;
        let report = report_on(run.profile, photo, self.pose, (&framed, "remap"));
        Ok(UnwrapReport {
            frames: Some(FramesFacts { format: "pictures", count }),
            map: Some(UnwrapMapFacts::from(&map)),
            files,
            warnings,
            ..report
        })
    }
}

impl UnwrapFolder<'_> {
    /// The folder's pictures, one at least.
    fn pictures(&self) -> Result<Vec<FolderPicture>, Error> {
        let folder = || self.photos.display().to_string();
        let pictures = named(files_of(self.photos)?)
            .map_err(|(name, files)| PhotoError::SameName { folder: folder(), name, files })?;
        if pictures.is_empty() {
            return Err(PhotoError::NoPictures { folder: folder() }.into());
        }
        Ok(pictures)
    }

    /// Unwraps picture after picture, as many at a time as there are threads, and publishes all.
    fn written(
        &self,
        run: &mut Run,
        pictures: &[FolderPicture],
        map: &RemapTable,
    ) -> Result<Vec<FileFacts>, Error> {
        let mut files = Vec::new();
        let Run { timer, files: transaction, .. } = run;
        timer.stage(Stage::Frames, || {
            let begun = Instant::now();
            for some in pictures.chunks(parallel::threads()) {
                let made = parallel::map_slice(some, 1, |picture| unwrapped(&picture.path, map));
                for (picture, png) in some.iter().zip(made) {
                    let png = png?;
                    let staged = transaction.add_of_many(&picture.name, &png)?;
                    files.push(file_facts(staged, "png", &png));
                }
            }
            let rate = pictures.len() as f64 / begun.elapsed().as_secs_f64();
            Ok::<_, Error>(((), format!("{} frames, {rate:.1} a second", pictures.len())))
        })?;
        let table = self.map.map(|format| {
            let bytes = format.encode(map).map_err(PhotoError::from)?;
            Ok::<_, Error>((format.name(), bytes))
        });
        let table = table.transpose()?;
        run.publish(Stage::Write, |transaction, _| {
            if let Some((format, bytes)) = &table {
                let staged = transaction.add_bytes(&format!("map.{format}"), bytes)?;
                files.push(file_facts(staged, format, bytes));
            }
            Ok(())
        })?;
        Ok(files)
    }
}

/// The PNG file of what a picture is unwrapped to.
fn unwrapped(path: &Path, map: &RemapTable) -> Result<Vec<u8>, Error> {
    let photo = decoded(path)?;
    let pixels = [photo.width, photo.height];
    if pixels != map.photo {
        let photo = path.display().to_string();
        return Err(PhotoError::OtherSize { photo, pixels, first: map.photo }.into());
    }
    map.paint(&photo).to_png().map_err(|error| Error::Picture(error.to_string()))
}

/// Pictures among files, in the order of their names, each with the name of its PNG; or a name that two of them would have, and those two.
fn named(mut files: Vec<PathBuf>) -> Result<Vec<FolderPicture>, (String, [String; 2])> {
    files.sort();
    let (mut pictures, mut taken) = (Vec::new(), BTreeMap::new());
    let text =
        |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    for path in files {
        let end = text(path.extension()).to_lowercase();
        if !ENDS.contains(&&*end) || text(path.file_name()).starts_with('.') {
            continue;
        }
        let name = format!("{}.png", text(path.file_stem()));
        if let Some(other) = taken.insert(name.clone(), text(path.file_name())) {
            return Err((name, [other, text(path.file_name())]));
        }
        pictures.push(FolderPicture { path, name });
    }
    Ok(pictures)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_in_order_and_each_has_a_name_of_its_own() {
        let paths = |names: &[&str]| names.iter().map(|name| Path::new("in").join(name)).collect();
        let found =
            named(paths(&["b.JPG", "a2.png", "notes.txt", ".c.png", "a1.exr", "d"])).unwrap();
        let names: Vec<&str> = found.iter().map(|picture| &*picture.name).collect();
        assert_eq!(names, ["a1.png", "a2.png", "b.png"]);
        let (name, files) = named(paths(&["a.png", "a.jpg"])).unwrap_err();
        assert_eq!((&*name, files), ("a.png", ["a.jpg", "a.png"].map(String::from)));
    }
}
