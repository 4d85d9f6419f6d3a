//! One run of a command: its source, its stages, and the files that it publishes at its end.

use super::Error;
use super::observer::{Observer, Stage, StageTimer};
use super::obstacles;
use crate::design::{Design, DesignError, design, design_alone, design_unmeasured};
use crate::profile::Profile;
use crate::publish::{OutputFile, StagedFile, Transaction};
use crate::render::Picture;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A command on one profile, with its options.
pub trait Command {
    /// What it finds out.
    type Report;

    /// Refuses options that cannot mean anything, before there is a folder.
    ///
    /// # Errors
    /// [`enum@Error`] for the first of them.
    fn check(&self, _profile: &Profile) -> Result<(), Error> {
        Ok(())
    }

    /// The folder of its files below that for results.
    fn folder(&self, profile: &Profile) -> PathBuf {
        PathBuf::from(&profile.name)
    }

    /// Goes through the stages, and publishes the files of `run` at the end.
    ///
    /// # Errors
    /// [`enum@Error`] when a stage cannot be done; then nothing is published.
    fn run(&self, run: &mut Run) -> Result<Self::Report, Error>;

    /// Runs it on `profile`, with its files in a folder below `out`.
    ///
    /// # Errors
    /// [`enum@Error`] when the folder cannot be written to, before any work, or a stage cannot be done;
    /// then nothing under `out` has changed.
    fn publish(
        &self,
        profile: &Profile,
        out: &Path,
        observer: &dyn Observer,
    ) -> Result<Self::Report, Error> {
        self.check(profile)?;
        let files = Transaction::open(&out.join(self.folder(profile)))?;
        self.run(&mut Run { profile, timer: StageTimer::new(observer), files })
    }

    /// Runs it on `profile`, with its files in memory.
    ///
    /// # Errors
    /// [`enum@Error`] when a stage cannot be done.
    fn in_memory(
        &self,
        profile: &Profile,
        observer: &dyn Observer,
    ) -> Result<(Self::Report, Vec<OutputFile>), Error> {
        self.check(profile)?;
        let mut run = Run::in_memory(profile, observer);
        let report = self.run(&mut run)?;
        Ok((report, run.files.into_files()))
    }
}

/// A command under way.
pub struct Run<'a> {
    /// The profile.
    pub profile: &'a Profile,
    /// Times of the stages, and who watches them.
    pub timer: StageTimer<'a>,
    /// Files, until they are published.
    pub files: Transaction,
}

impl<'a> Run<'a> {
    /// A run that leaves its files in memory.
    pub fn in_memory(profile: &'a Profile, observer: &'a dyn Observer) -> Self {
        Self { profile, timer: StageTimer::new(observer), files: Transaction::in_memory() }
    }

    /// Runs a stage; its value comes with the note for the observer.
    ///
    /// # Errors
    /// That of the stage.
    pub fn stage<T>(
        &self,
        stage: Stage,
        run: impl FnOnce() -> Result<(T, String), Error>,
    ) -> Result<T, Error> {
        self.check_wanted()?;
        self.timer.stage(stage, run)
    }

    /// Whether the run is to go on.
    ///
    /// # Errors
    /// [`Error::Stopped`] where the observer wants it to end.
    pub(super) fn check_wanted(&self) -> Result<(), Error> {
        if self.timer.is_stopped() { Err(Error::Stopped) } else { Ok(()) }
    }

    /// Designs the mirror.
    ///
    /// # Errors
    /// [`Error::Design`] when it has no answer.
    pub fn design(&self) -> Result<Design, Error> {
        self.designed_by(design)
    }

    /// Designs the mirror without measuring it: for what asks for its shape alone.
    ///
    /// # Errors
    /// [`Error::Design`] when it has no answer.
    pub fn design_unmeasured(&self) -> Result<Design, Error> {
        self.designed_by(design_unmeasured)
    }

    fn designed_by(
        &self,
        design: fn(&Profile) -> Result<Design, DesignError>,
    ) -> Result<Design, Error> {
        self.stage(Stage::Design, || {
            let design = designed_by(self.profile, design)?;
            let note = design.facts.method.to_owned();
            Ok((design, note))
        })
    }

    /// Encodes a picture.
    ///
    /// # Errors
    /// [`Error::Picture`] when it cannot be.
    pub fn picture<E: Display>(
        &self,
        encode: impl FnOnce() -> Result<Vec<u8>, E>,
    ) -> Result<Vec<u8>, Error> {
        self.stage(Stage::Picture, || {
            let png = encode().map_err(|error| Error::Picture(error.to_string()))?;
            let note = format!("{} kB", png.len() / 1000);
            Ok((png, note))
        })
    }

    /// Paints a picture and encodes it.
    ///
    /// # Errors
    /// [`Error::Picture`] when it cannot be encoded.
    pub fn painted(&self, paint: impl FnOnce() -> Picture) -> Result<(Picture, Vec<u8>), Error> {
        self.stage(Stage::Picture, || {
            let picture = paint();
            let png = picture.to_png().map_err(|error| Error::Picture(error.to_string()))?;
            let note = format!("{} kB", png.len() / 1000);
            Ok(((picture, png), note))
        })
    }

    /// Writes a file of the part, and tells the observer of it.
    ///
    /// # Errors
    /// [`Error::File`] when the disk refuses.
    pub fn write(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<&StagedFile, Error> {
        self.check_wanted()?;
        self.timer.stage(Stage::Write, || {
            let staged = self.files.add(name, write)?;
            if let Some(path) = staged.path() {
                self.timer.written(path);
            }
            Ok::<_, Error>((staged, name.to_owned()))
        })
    }

    /// Adds the last files and publishes all, as one stage.
    ///
    /// # Errors
    /// [`enum@Error`] when one cannot be made, or the disk refuses.
    pub fn publish(
        &mut self,
        stage: Stage,
        add: impl FnOnce(&mut Transaction, &StageTimer) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.check_wanted()?;
        self.timer.stage(stage, || {
            add(&mut self.files, &self.timer)?;
            self.files.commit()?;
            Ok(((), self.files.place()))
        })
    }
}

/// The mirror of `profile`.
///
/// # Errors
/// [`Error::Design`] when it has no answer.
pub(crate) fn designed(profile: &Profile) -> Result<Design, Error> {
    designed_by(profile, design)
}

/// The mirror of `profile` with all figures but the least error of any other mirror.
///
/// # Errors
/// [`Error::Design`] when it has no answer.
pub(crate) fn designed_alone(profile: &Profile) -> Result<Design, Error> {
    designed_by(profile, design_alone)
}

/// The mirror of `profile` without its figures, for what asks for its shape alone.
///
/// # Errors
/// [`Error::Design`] when it has no answer.
pub(crate) fn designed_unmeasured(profile: &Profile) -> Result<Design, Error> {
    designed_by(profile, design_unmeasured)
}

fn designed_by(
    profile: &Profile,
    design: fn(&Profile) -> Result<Design, DesignError>,
) -> Result<Design, Error> {
    let design = design(profile)
        .map_err(|source| Error::Design { profile: profile.name.clone(), source })?;
    obstacles::check(&design)?;
    Ok(design)
}
