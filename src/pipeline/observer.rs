//! Progress: who watches a build, and how long its stages take.

use crate::tolerance;
use crate::trace::TraceCounts;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// A stage of the pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Profile -> mirror.
    Design,
    /// Mirror -> optical face.
    Mesh,
    /// Tolerances -> how large the mesh will be, without it.
    Forecast,
    /// Mirror -> places where a part is to be touched.
    Plan,
    /// Design -> the sheet that a shop signs.
    Draw,
    /// Face -> closed, checked body.
    Solid,
    /// Mirror and cutter -> what the cutter leaves.
    Cut,
    /// Body -> files.
    Write,
    /// Files -> triangles, checked again.
    Read,
    /// Triangles -> the pose that brings them onto the mirror.
    Align,
    /// Rays against those triangles.
    Trace,
    /// What the pixels cover of the world.
    Coverage,
    /// How large a spot each pixel sees.
    Blur,
    /// What the camera sees.
    Picture,
    /// Frames -> what each is unwrapped to.
    Frames,
    /// Errors -> derivatives of the picture.
    Sensitivities,
    /// Many made systems.
    Trials,
    /// Trials -> statistics and limits.
    Budget,
    /// Points of a study, each a run of its own.
    Points,
    /// Results -> report files.
    Report,
}

impl Stage {
    /// One word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Design => "design",
            Self::Mesh => "mesh",
            Self::Forecast => "forecast",
            Self::Plan => "plan",
            Self::Draw => "draw",
            Self::Solid => "solid",
            Self::Cut => "cut",
            Self::Write => "write",
            Self::Read => "read",
            Self::Align => "align",
            Self::Trace => "trace",
            Self::Coverage => "coverage",
            Self::Blur => "blur",
            Self::Picture => "picture",
            Self::Frames => "frames",
            Self::Sensitivities => "errors",
            Self::Trials => "trials",
            Self::Budget => "budget",
            Self::Points => "points",
            Self::Report => "report",
        }
    }
}

/// Watches a build. All calls come from one thread, in order.
pub trait Observer: Sync {
    /// A stage begins.
    fn begin(&self, _stage: Stage) {}
    /// A stage is done; `note` says in a few words what came of it.
    fn end(&self, _stage: Stage, _took: Duration, _note: &str) {}
    /// A file has been written under a temporary name, and is read back next.
    fn written(&self, _path: &Path) {}
    /// Whether the run is to end: asked before each stage, and between parts of the trials.
    fn is_stopped(&self) -> bool {
        false
    }
    /// The files in this folder are what the build would write again; it ends here.
    fn unchanged(&self, _folder: &Path) {}
}

/// Watches nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {}

/// What a stage did of one kind, and what it could leave undone.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Work {
    /// Name of the stage.
    pub stage: String,
    /// What is counted.
    pub what: String,
    /// Number of those that were needed.
    pub done: u64,
    /// Number of those that were left undone.
    pub avoided: u64,
    /// Why they could be left undone.
    pub why: String,
}

/// Run times of a command: `tolerance-timings.json`, and the part of `timings.json` that every build has.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Timings {
    /// Run time of each stage that ran, s.
    pub seconds: BTreeMap<&'static str, f64>,
    /// Run time of all, s.
    pub total_s: f64,
    /// Work of the stages.
    pub work: Vec<Work>,
}

/// Times the stages for an observer, and counts their work.
pub struct StageTimer<'a> {
    observer: &'a dyn Observer,
    start: Instant,
    stages: Mutex<Vec<(&'static str, f64)>>,
    work: Mutex<Vec<Work>>,
    shortcuts: bool,
}

impl<'a> StageTimer<'a> {
    /// Starts now.
    pub fn new(observer: &'a dyn Observer) -> Self {
        Self {
            observer,
            start: Instant::now(),
            stages: Mutex::default(),
            work: Mutex::default(),
            shortcuts: true,
        }
    }

    /// Makes later stages do even what they could leave undone.
    pub fn forbid_shortcuts(&mut self) {
        self.shortcuts = false;
    }

    /// Tells the observer that the files in this folder are what a build would write again.
    pub fn unchanged(&self, folder: &Path) {
        self.observer.unchanged(folder);
    }

    /// Whether the observer wants the run to end.
    pub fn is_stopped(&self) -> bool {
        self.observer.is_stopped()
    }

    /// Whether stages may leave undone what changes no result.
    pub fn shortcuts(&self) -> bool {
        self.shortcuts
    }

    /// Counts work of a stage: `what` it is, how much was `[done, avoided]`, and why.
    pub fn worked(&self, stage: Stage, what: &str, [done, avoided]: [usize; 2], why: &str) {
        let Ok(mut all) = self.work.lock() else { return };
        let known = all.iter().position(|work| work.stage == stage.name() && work.what == what);
        let at = known.unwrap_or_else(|| {
            let [stage, what, why] = [stage.name(), what, why].map(str::to_owned);
            all.push(Work { stage, what, done: 0, avoided: 0, why });
            all.len() - 1
        });
        all[at].done += done as u64;
        all[at].avoided += avoided as u64;
    }

    /// The work so far.
    pub fn work(&self) -> Vec<Work> {
        self.work.lock().map(|work| work.clone()).unwrap_or_default()
    }

    /// Runs one stage; its value comes with the note for the observer.
    ///
    /// # Errors
    /// That of the stage.
    pub fn stage<T, E>(
        &self,
        stage: Stage,
        run: impl FnOnce() -> Result<(T, String), E>,
    ) -> Result<T, E> {
        self.observer.begin(stage);
        let start = Instant::now();
        let (value, note) = run()?;
        self.ended(stage, start, &note);
        Ok(value)
    }

    /// Runs a stage that cannot fail.
    pub fn always<T>(&self, stage: Stage, run: impl FnOnce() -> (T, String)) -> T {
        self.observer.begin(stage);
        let start = Instant::now();
        let (value, note) = run();
        self.ended(stage, start, &note);
        value
    }

    fn ended(&self, stage: Stage, start: Instant, note: &str) {
        let took = start.elapsed();
        self.observer.end(stage, took, note);
        if let Ok(mut stages) = self.stages.lock() {
            stages.push((stage.name(), took.as_secs_f64()));
        }
    }

    /// Tells the observer of a file that was written under a temporary name.
    pub fn written(&self, path: &Path) {
        self.observer.written(path);
    }

    /// Counts rays that were traced.
    pub fn traced(&self, counts: TraceCounts) {
        let TraceCounts { rasterized, searched, proven, followed } = counts;
        let drawing =
            "facets are drawn over the pixels, curved faces met along rows, with the same result";
        self.worked(Stage::Trace, "camera rays searched for", [searched, rasterized], drawing);
        let leaving = "they provably meet nothing";
        self.worked(Stage::Trace, "reflected rays followed", [followed, proven], leaving);
    }

    /// Counts what tracing made systems took in a stage.
    pub fn toleranced(&self, stage: Stage, tally: tolerance::WorkCounts) {
        for (kind, counts) in tally.kinds() {
            self.worked(stage, kind.what(), counts.map(|n| n as usize), kind.why());
        }
    }

    /// Seconds per stage, and in all so far, and `work`.
    pub fn timings(&self, work: Vec<Work>) -> Timings {
        let mut seconds = BTreeMap::new();
        for (name, took) in self.stages.lock().map(|s| s.clone()).unwrap_or_default() {
            *seconds.entry(name).or_insert(0.0) += took;
        }
        Timings { seconds, total_s: self.start.elapsed().as_secs_f64(), work }
    }
}
