//! Requests and their answers.

use super::designs::{LastDesigns, sketch};
use super::edit::TextEdit;
use super::failure::RequestFailure;
use super::message::{Asked, Content};
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

/// Letters of a profile's name.
const MOST_LETTERS: usize = 64;

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

/// A text and the name of its profile.
#[derive(Debug, Deserialize)]
struct Source {
    name: String,
    text: String,
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

impl Source {
    fn profile(&self) -> Result<Profile, RequestFailure> {
        if !is_name(&self.name) {
            return Err(RequestFailure::of_text(
                "the name must be of at most 64 letters a to z, digits, - and _",
            ));
        }
        view::checked(&self.name, &self.text)
    }
}

/// Whether a profile may have this name, which is that of a file and a folder too.
pub(super) fn is_name(name: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    (1..=MOST_LETTERS).contains(&name.len()) && name.chars().all(is_letter)
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
            ("POST", "/check") => Ok(Content::Json(check(&read(asked)?))),
            ("POST", "/edit") => {
                let text = read::<TextEdit>(asked)?.made().map_err(RequestFailure::of_text)?;
                Ok(Content::Json(json!({ "text": text })))
            }
            ("POST", "/preview") => {
                self.of_design(&self.quick, preview, asked, |design, fidelity| {
                    json(view::preview(design, fidelity.sketch))
                })
            }
            ("POST", "/part") => {
                self.of_design(&self.beside, part, asked, |design, _| json(view::part(design)))
            }
            ("POST", "/still") => self.of_design(&self.slow, still, asked, |design, _| {
                view::part_still(design).map(Content::Png)
            }),
            ("POST", "/estimate") => {
                newest(&self.slow, estimate, asked, |profile| json(view::estimate(profile)))
            }
            ("POST", "/picture") => newest(&self.slow, picture, asked, |profile| {
                view::picture(profile).map(Content::Png)
            }),
            ("POST", "/pixel") => {
                let Pixel { x, y } = read(asked)?;
                let see = move |design: &Design, _| json(view::pixel(design, [x, y]));
                self.of_design(&self.quick, pixel, asked, see)
            }
            ("POST", "/build") => self.build(&read(asked)?),
            ("POST", "/cancel") => Ok(Content::Json(self.cancelled())),
            ("GET", "/build") => Ok(Content::Json(self.status())),
            ("GET", path) => self.file(path),
            _ => Err(nothing_there()),
        }
    }

    /// What `see` makes of the design of a request's text, on a queue; of a sketch of it, if the request says so and it has one.
    fn of_design(
        &self,
        queue: &WorkQueue,
        subject: &Arc<Subject>,
        asked: &Asked,
        see: impl FnOnce(&Design, Fidelity) -> Result<Content, RequestFailure> + Send + 'static,
    ) -> Result<Content, RequestFailure> {
        let designs = Arc::clone(&self.designs);
        let fidelity: Fidelity = read(asked)?;
        newest(queue, subject, asked, move |profile| {
            // (A sketch may have no answer where the mirror has one.)
            let sketched = fidelity.sketch.then(|| sketch(profile)).flatten();
            match sketched.and_then(|profile| designs.of(&profile).ok()) {
                Some(design) => see(&design, fidelity),
                None => see(&*designs.of(profile)?, fidelity),
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

/// Every complaint about a text, as `morion check --format json` tells them, the key of each, and all values.
fn check(source: &Source) -> Json {
    let errors = source.profile().err().map_or(Vec::new(), |failure| failure.errors);
    let keys: Vec<_> = errors.iter().map(|error| form::key_of(&error.message)).collect();
    json!({ "errors": errors, "keys": keys, "values": form::values(&source.text) })
}

fn read<T: DeserializeOwned>(asked: &Asked) -> Result<T, RequestFailure> {
    let wrong = |error| {
        RequestFailure::said(400, format!("the body must be JSON of this request: {error}"))
    };
    serde_json::from_slice(asked.body).map_err(wrong)
}

/// What `see` makes of the profile of a request's text, on a queue.
fn newest(
    queue: &WorkQueue,
    subject: &Arc<Subject>,
    asked: &Asked,
    see: impl FnOnce(&Profile) -> Result<Content, RequestFailure> + Send + 'static,
) -> Result<Content, RequestFailure> {
    let profile = read::<Source>(asked)?.profile()?;
    let superseded = || RequestFailure::said(409, "a newer request took the place of this one");
    queue.newest(subject, move || see(&profile)).ok_or_else(superseded)?
}

fn json(answer: Result<Json, RequestFailure>) -> Result<Content, RequestFailure> {
    answer.map(Content::Json)
}

fn nothing_there() -> RequestFailure {
    RequestFailure::said(404, "there is nothing at this address")
}

/// A name for a profile of the file `name`, with hyphens in the place of letters that it may not have.
pub(super) fn tamed(name: &str) -> String {
    let tame = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    let tamed: String = name.chars().map(tame).take(MOST_LETTERS).collect();
    if tamed.is_empty() { "mirror".to_owned() } else { tamed }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_of_plain_letters() {
        assert!(is_name("conquistador") && is_name("a_1-B"));
        let long = "a".repeat(65);
        for name in ["", ".", "..", "a/b", "a\\b", "a.b", "ä", "a b", "\u{202e}", &*long] {
            assert!(!is_name(name), "{name}");
            assert!(is_name(&tamed(name)), "{name}");
        }
    }
}
