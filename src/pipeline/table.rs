//! `morion table`: from pixels to directions and places of a floor, and back, for other programs.

use super::floor_plan::FloorPlan;
use super::mounted_system::{MadeSystem, MountedSystem};
use super::pose::KnownErrors;
use super::run::{Command, Run};
use super::table_files::TableFiles;
use super::table_sight::TracedTable;
use super::tolerance_spec::{PreparedStudy, prepared};
use super::{Error, Stage};
use crate::geom::Ray;
use crate::lookup::{FieldErrors, MapFrame, NodeTable, PixelGrid, PlaceMap};
use crate::num::stats::Summary;
use crate::profile::Profile;
use crate::report::Answer;
use crate::results::{FieldFacts, FileFacts, FloorFacts, PlaceMapFacts, SCHEMA, TableReport};
use std::path::{Path, PathBuf};

/// Which tables are made: writes `table.npy`, `table.csv`, `table.h`, maps for OpenCV and ffmpeg, `camera_info.yaml` of a lens and
/// `table.json` into NAME/table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableOptions<'a> {
    /// Pixels along each side of the block that a node is in the middle of.
    pub every: usize,
    /// Z of a floor in the part's frame, mm; none: no floor.
    pub floor_mm: Option<f64>,
    /// Farthest place of the floor from the axis, mm; none: five times as far as the floor.
    pub range_mm: Option<f64>,
    /// Millimetres to a pixel of the floor's plan; none: 500 pixels across.
    pub mm_per_px: Option<f64>,
    /// Degrees to a pixel of the panorama, to a whole number in a turn.
    pub deg_per_px: f64,
    /// A file as `tolerance --replay` writes: how the part is mounted, and the camera's errors.
    pub pose: Option<&'a Path>,
}

/// Most nodes.
const MOST_NODES: usize = 4_000_000;

impl TableOptions<'_> {
    /// Pixels along a node's block, usually: a table of 320 x 240 pixels takes 40 kB.
    pub const EVERY: usize = 4;
    /// Degrees to a pixel of the panorama, usually.
    pub const DEG_PER_PX: f64 = 0.25;
}

impl Default for TableOptions<'_> {
    fn default() -> Self {
        Self {
            every: Self::EVERY,
            floor_mm: None,
            range_mm: None,
            mm_per_px: None,
            deg_per_px: Self::DEG_PER_PX,
            pose: None,
        }
    }
}

impl Command for TableOptions<'_> {
    type Report = TableReport;

    fn folder(&self, profile: &Profile) -> PathBuf {
        Path::new(&profile.name).join("table")
    }

    fn check(&self, profile: &Profile) -> Result<(), Error> {
        let bad = |option, must: String, found: String| Err(Error::Option { option, must, found });
        let grid = self.grid(profile);
        let most = grid.frame.into_iter().min().unwrap_or(0) / 2;
        if !(1..=most).contains(&self.every) {
            let must = format!("a whole number from 1 to {most}, half of the frame");
            return bad("--every", must, self.every.to_string());
        }
        if grid.count() > MOST_NODES {
            let must = format!("so large that there are at most {MOST_NODES} nodes");
            return bad("--every", must, self.every.to_string());
        }
        if !(0.01..=10.0).contains(&self.deg_per_px) {
            let must = "a number from 0.01 to 10".into();
            return bad("--deg-per-px", must, self.deg_per_px.to_string());
        }
        self.floor().map_or(Ok(()), |floor| floor.check("--floor-mm"))
    }

    fn run(&self, run: &mut Run) -> Result<TableReport, Error> {
        let pose = self.pose.map(KnownErrors::read).transpose()?;
        let PreparedStudy { design, engine, .. } = prepared(run)?;
        let made = MadeSystem::new(engine, pose.as_ref());
        let sight = made.before(&design.camera);
        let (mut report, files) = run.stage(Stage::Trace, || {
            let table = sight.table(self.grid(run.profile));
            if let Some(floor) = self.floor() {
                floor.check_shown(table.rays(), "--floor-mm")?;
            }
            let note = format!("{} nodes, {} places between", table.grid().count(), table.known());
            Ok((self.filled(run.profile, &sight, &table), note))
        })?;
        report.warnings.extend(pose.and_then(|pose| pose.warning(run.profile)));
        let (encoded, header_bytes) = files.encoded(run.profile, &self.comments(run.profile));
        report.header_bytes = header_bytes;
        let facts = encoded.iter().map(|(name, format, bytes)| FileFacts::of(name, format, bytes));
        report.files = facts.collect();
        run.publish(Stage::Report, |transaction, _| {
            for (name, _, bytes) in &encoded {
                transaction.add_bytes(name, bytes)?;
            }
            transaction.add_report("table.json", &report.json())?;
            Ok(())
        })?;
        Ok(report)
    }
}

impl TableOptions<'_> {
    fn grid(&self, profile: &Profile) -> PixelGrid {
        PixelGrid { frame: profile.camera.pixels().map(|x| x as usize), every: self.every }
    }

    /// The floor.
    fn floor(&self) -> Option<FloorPlan> {
        let Self { range_mm, mm_per_px, .. } = *self;
        self.floor_mm.map(|z_mm| FloorPlan { z_mm, range_mm, mm_per_px })
    }

    /// What a reader of the files has to know.
    fn comments(&self, profile: &Profile) -> Vec<String> {
        let mut comments = vec![
            format!("Morion: profile {}, sha256 {}", profile.name, profile.sha256),
            "part frame, mm: X right in the picture, Y up in it, Z towards the camera; base at Z = 0".into(),
        ];
        comments.extend(self.floor_mm.map(|mm| format!("floor at Z = {mm} mm")));
        comments.extend(self.pose.map(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            format!("as mounted by {name}")
        }));
        comments
    }

    /// The report of a table, and what its files hold.
    fn filled(
        &self,
        profile: &Profile,
        sight: &MountedSystem,
        table: &TracedTable,
    ) -> (TableReport, TableFiles) {
        let plane = self.floor().map(|floor| floor.plane());
        let rows = NodeTable::new(table.grid(), table.shown(), plane);
        let pole = table.pole();
        let project = |ray: &Ray| Some(pole.project(ray));
        let (directions, errors) = table.field(project);
        let panorama = table.panorama(self.deg_per_px);
        let panorama = sight.map(panorama, (&directions, pole), project);
        let direction_facts = facts(errors, rows.angle_deviation());
        let floor = self.floor().map(|floor| {
            let plane = floor.plane();
            let (field, errors) = table.field(|ray| plane.meets(ray));
            let beyond = floor.beyond();
            let plan = sight.map(floor.map(), (&field, pole), |ray| beyond.meets(ray));
            let facts = FloorFacts {
                z_mm: plane.z_mm,
                range_mm: plane.range_mm,
                field: facts(errors, rows.floor_deviation()),
                plan: map_facts(&plan),
            };
            (facts, (field, plan))
        });
        let (floor_facts, floor) = floor.unzip();
        let report = TableReport {
            schema: SCHEMA,
            profile: profile.into(),
            frame_px: table.grid().frame,
            every: self.every,
            nodes: table.grid().nodes(),
            numbers: rows.names().into_iter().map(str::to_owned).collect(),
            pose: self.pose.map(|path| path.display().to_string()),
            directions: direction_facts,
            floor: floor_facts,
            header_bytes: 0,
            panorama: map_facts(&panorama),
            files: Vec::new(),
            warnings: Vec::new(),
        };
        (report, TableFiles { rows, pole, directions, floor, panorama })
    }
}

fn facts(FieldErrors { off_px, told }: FieldErrors, deviation: Option<Summary>) -> FieldFacts {
    FieldFacts { off_px, told, deviation }
}

fn map_facts(map: &PlaceMap) -> PlaceMapFacts {
    let per_px = match map.frame {
        MapFrame::Floor { mm_per_px, .. } => mm_per_px,
        MapFrame::Panorama { deg_per_px, .. } => deg_per_px,
    };
    PlaceMapFacts { pixels: map.frame.size(), per_px, corner: map.frame.corner(), seen: map.seen() }
}
