//! The rules of a profile: which values each key may take, and what goes with what.

mod border;
mod calibrated;
mod camera;
mod drawing;
mod finishing_path;
mod fits;
mod forming;
mod hole;
mod layout;
mod limits;
mod map;
mod mirror;
mod mount;
mod obstacle;
mod panels;
mod posed_target;
mod program;
mod program_table;
mod projection;
mod reach;
mod rough_cutter;
mod sag;
mod servo;
mod shell;
mod table;
mod target;
mod tolerance;
mod turning;
mod view;

use toml::de::{DeTable, DeValue};

use super::profile_file::sha256;
use super::reader::Need::{Optional, Required};
use super::reader::{ProfileReader, Section};
use super::{Layout, PartSpec, Profile};

const SIZE: &str = "a number from 0.001 to 1000000";
const LARGE: &str = "from 0.001 to 1e12";
const SIGNED: &str = "a number from 0.001 to 1e12 or from -1e12 to -0.001";

fn is_size(f: f64) -> bool {
    (1e-3..=1e6).contains(&f)
}

fn is_large(f: f64) -> bool {
    (1e-3..=1e12).contains(&f)
}

fn is_signed(f: f64) -> bool {
    is_large(f.abs())
}

/// Entries of a profile that must fit each other. An absent one is missing or wrong, and has its
/// complaint.
struct Entries<'t> {
    camera: Option<camera::CameraEntry>,
    projection: Option<projection::ProjectionEntry<'t>>,
    layout: Option<layout::LayoutEntry>,
    shape: Option<mirror::ShapeEntry>,
    part: limits::PartEntry,
    /// The target surface in any pose.
    posed: Option<posed_target::PosedEntry>,
    /// The mirror is given and there is no projection.
    bare: bool,
    /// Neither is there a layout.
    rectangle: bool,
}

impl<'t> Entries<'t> {
    /// The layout, or that of a given mirror without a picture.
    fn layout(&self) -> Option<Layout> {
        match self.part.height {
            Some(height) if self.is_rectangle() => {
                Some(Layout::Rectangle { height_mm: Some(height.value) })
            }
            None if self.is_rectangle() && !self.rectangle => {
                Some(Layout::Rectangle { height_mm: None })
            }
            _ => self.layout.as_ref()?.layout,
        }
    }

    /// Whether the mirror is a rectangle of its own height.
    fn is_rectangle(&self) -> bool {
        let named = self.layout.as_ref().is_some_and(|l| l.name == layout::LayoutName::Rectangle);
        self.rectangle || named
    }

    fn read(reader: &mut ProfileReader, root: &Section<'t>) -> Self {
        let given = root.has("mirror") && !root.has("method") && !reader.is_torn();
        let bare = given && !root.has("projection") && !root.has("panel");
        let rectangle = bare && !root.has("layout");
        let posed = posed_target::read(reader, root);
        let target = posed.as_ref().and_then(|posed| posed.target.clone());
        Self {
            camera: camera(reader, root),
            projection: if bare { None } else { projection::read(reader, root, target) },
            posed,
            layout: if rectangle { None } else { layout::read(reader, root) },
            shape: mirror::read(reader, root),
            part: limits::part(reader, root),
            bare,
            rectangle,
        }
    }
}

/// Reads the whole tree; `None` if there is anything to complain of.
pub(super) fn profile(
    reader: &mut ProfileReader,
    tree: &DeTable,
    name: &str,
    bytes: &[u8],
) -> Option<Profile> {
    if tree.is_empty() && reader.is_clean() {
        let message = "the file must hold a profile, found nothing in it".to_owned();
        let hint = "`morion profiles --show conquistador` prints one to start from";
        reader.complain(0, message, hint);
        return None;
    }
    let root = reader.root(tree);
    let summary = summary(reader, &root);
    let parts = Entries::read(reader, &root);
    let mount = mount::read(reader, &root, &parts);
    let obstacles = obstacle::read(reader, &root);
    let holes = hole::read(reader, &root);
    let mesh = limits::mesh(reader, &root, &parts);
    let export = reader.section(&root, "export", Required);
    let formats = export.as_ref().and_then(|export| limits::formats(reader, export));
    let sag = export.as_ref().map(|export| sag::read(reader, export, &parts.part));
    let step = export.as_ref().map(|export| limits::step(reader, export));
    let drawing = drawing::read(reader, &root);
    let program = program::read(reader, &root, parts.layout().as_ref());
    let accept = limits::accept(reader, &root, parts.bare);
    let setting = tolerance::Setting {
        camera: parts.camera.as_ref().and_then(|found| found.camera),
        layout: parts.layout.as_ref().and_then(|found| found.layout),
    };
    let tolerance = tolerance::read(reader, &root, setting);
    fits::check(reader, &parts);
    posed_target::suits(reader, &parts);
    if let Some(panels) = parts.projection.as_ref().and_then(|projection| projection.panels()) {
        panels::suits(reader, &root, &parts, &mount, panels);
    }
    target::check(reader, &parts);
    reach::check(reader, &parts);
    let tool = forming::read(reader, &root, parts.part.form, parts.part.base.as_ref());
    forming::check(reader, &parts, (tool.as_ref(), formats.as_deref(), step), &holes);
    shell::check(reader, &parts, tool.as_ref());
    border::check(reader, &parts, &holes, tool.as_ref());
    if !reader.is_clean() {
        return None;
    }
    let layout = parts.layout()?;
    let Entries { camera, projection, shape, part, .. } = parts;
    Some(Profile {
        name: name.to_owned(),
        named: name.to_owned(),
        sha256: sha256(bytes),
        files: Vec::new(),
        summary: summary.unwrap_or_default(),
        lens: camera.as_ref()?.lens,
        camera_file: camera.as_ref()?.file.clone(),
        camera_body: camera.as_ref()?.body,
        obstacles,
        camera: camera?.camera?,
        mount,
        projection: match projection {
            Some(found) => Some(found.finish(layout == Layout::Disc)?),
            None => None,
        },
        layout,
        shape: shape?.shape?,
        heights: None,
        part: {
            let (width_mm, base_mm) = (part.width?.value, part.base?.value);
            let holes = holes.into_iter().map(|hole| hole.value).collect();
            let border = part.border.border(base_mm);
            let shell = part.shell.map(|shell| shell.value);
            PartSpec { width_mm, base_mm, border, holes, forming: tool, shell }
        },
        mesh: mesh?,
        formats: formats?,
        sag: sag?,
        step: step?,
        drawing,
        program,
        accept: accept?,
        tolerance,
        form_map: None,
    })
}

fn camera(reader: &mut ProfileReader, root: &Section) -> Option<camera::CameraEntry> {
    let hint = "an orthographic camera has a telecentric lens, a pinhole camera any other; a calibrated \
                camera has a lens with distortion";
    let read = reader
        .alternatives(root, "camera", hint)
        .into_iter()
        .map(|(name, section)| match camera::CameraName::find(name) {
            camera::CameraName::Calibrated => calibrated::read(reader, &section),
            name => camera::ideal(reader, name, &section),
        })
        .collect();
    only(read)
}

fn summary(reader: &mut ProfileReader, root: &Section) -> Option<String> {
    let hint = "what the mirror is for, in quotes";
    let value = reader.value(root, "summary", Optional, "text", hint)?;
    match value.get_ref() {
        DeValue::String(text) => Some(text.to_string()),
        _ => {
            let found = reader.quote_type(value);
            let message = format!("summary must be text, found {found}");
            reader.complain(value.span().start, message, hint);
            None
        }
    }
}

fn only<T>(mut several: Vec<T>) -> Option<T> {
    let last = several.pop();
    last.filter(|_| several.is_empty())
}
