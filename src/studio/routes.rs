//! Requests and their answers.

use super::designs::{LastDesigns, sketch};
use super::failure::RequestFailure;
use super::message::{Asked, Content};
use super::source::Source;
use super::work_queue::{Subject, WorkQueue};
use super::{build::Build, form, page, view};
use crate::design::Design;
use crate::profile::{Profile, shipped};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value as Json, json};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use tempfile::NamedTempFile;

/// Where the studio stands: the profile that it was opened with, its folder, and the work under way.
#[derive(Debug)]
pub(super) struct Studio {
    /// Name and text of the first profile.
    pub first: [String; 2],
    /// Folder of profiles and results.
    pub folder: PathBuf,
    /// What follows a slider first.
    pub quick: WorkQueue,
    /// What follows it next.
    pub beside: WorkQueue,
    /// What may take longer.
    pub slow: WorkQueue,
    /// Designs of the profiles that were asked about last.
    pub designs: Arc<LastDesigns>,
    /// One subject for each kind of request of which the newest counts.
    pub subjects: Subjects,
    /// The last build.
    pub build: Mutex<Option<Build>>,
    /// The file that leads a browser here, until the first page is asked for.
    pub opening: Mutex<Option<NamedTempFile>>,
}

/// Kinds of requests of which the newest counts.
#[derive(Debug, Default)]
pub(super) struct Subjects {
    preview: Arc<Subject>,
    picture: Arc<Subject>,
    estimate: Arc<Subject>,
    part: Arc<Subject>,
    still: Arc<Subject>,
    pixel: Arc<Subject>,
}

/// How near to the profile's design what is asked for has to be.
#[derive(Debug, Clone, Copy, Deserialize)]
struct Fidelity {
    #[serde(default)]
    sketch: bool,
}

/// A pixel of the camera's frame.
#[derive(Debug, Deserialize)]
struct Pixel {
    x: u32,
    y: u32,
}

impl Studio {
    /// The answer to a request.
    ///
    /// # Errors
    /// [`RequestFailure`] with what is wrong.
    pub(super) fn answer(&self, asked: &Asked) -> Result<Content, RequestFailure> {
        let Subjects { preview, picture, estimate, part, still, pixel } = &self.subjects;
        match (asked.method, asked.path) {
            ("GET", "/") => {
                drop(self.opening.lock().unwrap_or_else(PoisonError::into_inner).take());
                page::page()
            }
            ("POST", "/start") => Ok(Content::Json(self.start())),
            ("POST", "/open") => open(read::<Named>(asked)?),
            ("POST", "/follow") => self.follow(read(asked)?),
            ("POST", "/part") => json(self.of_asked(&self.beside, part, asked, view::part)),
            ("POST", "/still") => {
                self.of_asked(&self.slow, still, asked, view::part_still).map(Content::Png)
            }
            ("POST", "/estimate") => {
                let profile = read::<Source>(asked)?.profile()?;
                json(newest(&self.slow, estimate, move || view::estimate(&profile)))
            }
            ("POST", "/picture") => {
                let profile = read::<Source>(asked)?.profile()?;
                let wanted = preview.newest();
                let see = move || view::picture(&profile, &wanted);
                newest(&self.slow, picture, see).map(Content::Png)
            }
            ("POST", "/pixel") => {
                let Pixel { x, y } = read(asked)?;
                let see = move |design: &Design| view::pixel(design, [x, y]);
                json(self.of_asked(&self.quick, pixel, asked, see))
            }
            ("POST", "/build") => self.build(&read(asked)?),
            ("POST", "/cancel") => Ok(Content::Json(self.cancelled())),
            ("GET", "/build") => Ok(Content::Json(self.status())),
            ("GET", path) => self.file(path),
            _ => Err(nothing_there()),
        }
    }

    /// The small picture and the maps that follow a change of a profile, or of a sketch of it.
    ///
    /// # Errors
    /// [`RequestFailure`] with what is wrong.
    pub(super) fn previewed(
        &self,
        profile: Profile,
        is_sketch: bool,
    ) -> Result<Json, RequestFailure> {
        let see = move |design: &Design| view::preview(design, is_sketch);
        self.of_design(&self.quick, &self.subjects.preview, (profile, is_sketch), see)
    }

    /// What `see` makes of the design of a request's text, or of a sketch of it, on a queue.
    fn of_asked<T: Send + 'static>(
        &self,
        queue: &WorkQueue,
        subject: &Arc<Subject>,
        asked: &Asked,
        see: impl FnOnce(&Design) -> Result<T, RequestFailure> + Send + 'static,
    ) -> Result<T, RequestFailure> {
        let Fidelity { sketch } = read(asked)?;
        self.of_design(queue, subject, (read::<Source>(asked)?.profile()?, sketch), see)
    }

    /// What `see` makes of a profile's design, on a queue; of a sketch of it, if that is asked for and it has one.
    fn of_design<T: Send + 'static>(
        &self,
        queue: &WorkQueue,
        subject: &Arc<Subject>,
        (profile, is_sketch): (Profile, bool),
        see: impl FnOnce(&Design) -> Result<T, RequestFailure> + Send + 'static,
    ) -> Result<T, RequestFailure> {
        let designs = Arc::clone(&self.designs);
        newest(queue, subject, move || {
            // (A sketch may have no answer where the mirror has one.)
            let sketched = is_sketch.then(|| sketch(&profile)).flatten();
            match sketched.and_then(|profile| designs.of(&profile).ok()) {
                Some(design) => see(&design),
                None => see(&*designs.of(&profile)?),
            }
        })
    }

    fn start(&self) -> Json {
        let [name, text] = &self.first;
        let names: Vec<&str> = shipped().iter().map(|profile| profile.name).collect();
        json!({ "name": name, "text": text, "form": form::form(), "shipped": names })
    }

    fn build(&self, source: &Source) -> Result<Content, RequestFailure> {
        source.profile()?;
        let mut last = self.build.lock().unwrap_or_else(PoisonError::into_inner);
        if last.as_mut().is_some_and(Build::is_running) {
            return Err(RequestFailure::said(409, "a build is under way; cancel it first"));
        }
        let started = last.insert(Build::start(&source.name, &source.text, &self.folder)?);
        Ok(Content::Json(started.status()))
    }

    fn status(&self) -> Json {
        let mut last = self.build.lock().unwrap_or_else(PoisonError::into_inner);
        last.as_mut().map_or_else(|| json!({ "state": "none" }), Build::status)
    }

    /// Ends the build that goes on; whoever asks for another waits for the end of the program.
    pub(super) fn end(&self) {
        let mut last = self.build.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(build) = last.as_mut() {
            build.cancel();
        }
        std::mem::forget(last);
    }

    fn cancelled(&self) -> Json {
        let mut last = self.build.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(build) = last.as_mut() {
            build.cancel();
        }
        last.as_mut().map_or_else(|| json!({ "state": "none" }), Build::status)
    }

    /// A file of the last build: the path is compared with the names that there are, and never joined.
    fn file(&self, path: &str) -> Result<Content, RequestFailure> {
        let name = path.strip_prefix("/files/").ok_or_else(nothing_there)?;
        let last = self.build.lock().unwrap_or_else(PoisonError::into_inner);
        let build = last.as_ref().ok_or_else(nothing_there)?;
        Ok(Content::File(name.to_owned(), build.open(name)?))
    }
}

/// The name of a shipped profile.
#[derive(Debug, Deserialize)]
struct Named {
    name: String,
}

fn open(Named { name }: Named) -> Result<Content, RequestFailure> {
    let known = shipped().iter().find(|profile| profile.name == name);
    let missing = || RequestFailure::of_text("no profile of this name is shipped");
    Ok(Content::Json(json!({ "name": name, "text": known.ok_or_else(missing)?.text })))
}

fn read<T: DeserializeOwned>(asked: &Asked) -> Result<T, RequestFailure> {
    let wrong = |error| {
        RequestFailure::said(400, format!("the body must be JSON of this request: {error}"))
    };
    serde_json::from_slice(asked.body).map_err(wrong)
}

/// What `see` makes on a queue, unless a newer request on the subject comes before its turn.
fn newest<T: Send + 'static>(
    queue: &WorkQueue,
    subject: &Arc<Subject>,
    see: impl FnOnce() -> Result<T, RequestFailure> + Send + 'static,
) -> Result<T, RequestFailure> {
    queue.newest(subject, see).ok_or_else(RequestFailure::superseded)?
}

fn json(answer: Result<Json, RequestFailure>) -> Result<Content, RequestFailure> {
    answer.map(Content::Json)
}

fn nothing_there() -> RequestFailure {
    RequestFailure::said(404, "there is nothing at this address")
}
