//! Views side by side, each on a panel of its own: the parts of the frame, and what goes with them.

use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, NumbersFormat, numbers};
use super::super::{PanelSpec, PanelViewSpec};
use super::Entries;
use super::camera::CameraName;
use super::map::{self, MapKeys};
use super::view::{AzimuthalKeys, LAWS, azimuthal};
use crate::optics::{Camera, CameraModel, Mount, Target};

/// Most panels: their heights are chosen among all orders of them.
const MOST: usize = 6;
/// More pixels than a frame has on a side.
const MOST_PIXELS: f64 = 32767.0;

/// A panel's keys.
pub(super) struct PanelKeys {
    at: usize,
    path: String,
    columns: Option<Located<[u32; 2]>>,
    rows: Option<Located<[u32; 2]>>,
    view: PanelViewKeys,
}

/// The keys of what a panel shows.
enum PanelViewKeys {
    Azimuthal(AzimuthalKeys),
    /// None without a sound file.
    Map(Option<MapKeys>),
}

/// The keys of a view, with which no file goes.
const VIEW_KEYS: [&str; 5] = ["law", "centre_deg", "hfov_deg", "roll_deg", "mirrored"];

impl PanelKeys {
    /// The panel, if every figure of it is there.
    pub(super) fn finish(self, target: Target) -> Option<PanelSpec> {
        let view = match self.view {
            PanelViewKeys::Azimuthal(keys) => PanelViewSpec::Azimuthal(keys.finish(target)?),
            PanelViewKeys::Map(keys) => PanelViewSpec::Map(keys?.finish(target)),
        };
        Some(PanelSpec { columns: self.columns?.value, rows: self.rows?.value, view })
    }

    /// The directions that are given as data, with the path of the panel's table.
    pub(super) fn map(&self) -> Option<(&str, &MapKeys)> {
        match &self.view {
            PanelViewKeys::Map(Some(keys)) => Some((&self.path, keys)),
            PanelViewKeys::Map(None) | PanelViewKeys::Azimuthal(_) => None,
        }
    }

    /// Columns and rows, if both are there.
    fn area(&self) -> Option<[[u32; 2]; 2]> {
        Some([self.columns.as_ref()?.value, self.rows.as_ref()?.value])
    }
}

pub(super) fn read<'t>(
    reader: &mut ProfileReader,
    root: &Section<'t>,
) -> Option<(Section<'t>, Vec<PanelKeys>)> {
    let hints = [
        "each has columns, rows, centre_deg and hfov_deg",
        "the heights of the panels are chosen among all orders of them; make two frames of it",
    ];
    let mut sections = reader.sections(root, "panel", MOST, hints);
    if let [one] = &sections[..] {
        let message = format!("there must be 2 to {MOST} panels, found 1");
        reader.complain(one.at, message, "one view alone is [projection.perspective]");
    }
    for (k, section) in sections.iter_mut().enumerate() {
        section.path = format!("panel[{}]", k + 1);
    }
    let panels = sections.iter().map(|section| one(reader, section)).collect();
    Some((sections.into_iter().next()?, panels))
}

fn one(reader: &mut ProfileReader, section: &Section) -> PanelKeys {
    let columns = edges(reader, section, "columns");
    let rows = edges(reader, section, "rows");
    let view = if section.has("file") {
        PanelViewKeys::Map(directions(reader, section))
    } else {
        PanelViewKeys::Azimuthal(view(reader, section))
    };
    PanelKeys { at: section.at, path: section.path.clone(), columns, rows, view }
}

/// The directions of a panel that are given as data.
fn directions(reader: &mut ProfileReader, section: &Section) -> Option<MapKeys> {
    let given: Vec<&str> = VIEW_KEYS.into_iter().filter(|key| section.has(key)).collect();
    if !given.is_empty() {
        let (path, given) = (section.path_of("file"), given.join(", "));
        let message = format!("{path} must be alone, found a view's {given}");
        let hint = "the file has a direction for each place of the panel; remove it, or these keys";
        reader.complain(section.at, message, hint);
        return None;
    }
    map::directions(reader, section)
}

/// The keys of a panel's view.
fn view(reader: &mut ProfileReader, section: &Section) -> AzimuthalKeys {
    let view = azimuthal(reader, section, &LAWS);
    if !section.has("centre_deg") {
        let message =
            format!("{}.centre_deg must be [azimuth, elevation], found nothing", section.path);
        let hint = "the direction that the panel's middle shows, as in centre_deg = [90, 10]";
        reader.missing(section, message, hint);
    }
    view
}

/// The first and the last edge of a panel across or down the frame.
fn edges(
    reader: &mut ProfileReader,
    section: &Section,
    key: &'static str,
) -> Option<Located<[u32; 2]>> {
    let form = "the panel's first and last edge in the frame, in pixels, as in [0, 320]";
    let format = NumbersFormat {
        key,
        parts: "[first, last]",
        each: "a whole number from 0 to 32767",
        form,
        limit: form,
    };
    let whole = |f: f64| f.fract() == 0.0 && (0.0..=MOST_PIXELS).contains(&f);
    let found = numbers(reader, section, &format, whole)?;
    let [first, last] = found.value.map(|f| f as u32);
    if first >= last {
        let path = section.path_of(key);
        let message = format!("{path} must rise from first to last, found [{first}, {last}]");
        reader.complain(found.at, message, form);
        return None;
    }
    Some(Located { value: [first, last], at: found.at })
}

/// Panels fill the frame of a camera with a pinhole, and come in the place of another projection.
pub(super) fn suits(
    reader: &mut ProfileReader,
    root: &Section,
    parts: &Entries,
    mount: &Mount,
    panels: &[PanelKeys],
) {
    let Some(first) = panels.first() else { return };
    let mut refuse = |message: String, hint: &str| reader.complain(first.at, message, hint);
    if root.has("projection") {
        let hint = "panels are views of their own; remove [projection] or the panels";
        refuse("there must be a projection or panels, found both".to_owned(), hint);
    }
    if parts.shape.as_ref().is_some_and(|shape| shape.is_given) {
        let hint = "each panel is a mirror that is solved for; remove [mirror]";
        refuse("panels must be designed, found a given mirror".to_owned(), hint);
    }
    let Some(camera) = &parts.camera else { return };
    if camera.name == CameraName::Orthographic {
        let found = camera.name.table();
        let message = format!(
            "camera must be [camera.pinhole] or [camera.calibrated] with panels, found [{found}]"
        );
        let hint = "the walls between panels lie along the rays of a pinhole";
        reader.complain(camera.at, message, hint);
    }
    let Some(camera) = camera.camera else { return };
    let areas: Option<Vec<_>> = panels.iter().map(PanelKeys::area).collect();
    if let Some(areas) = areas.filter(|areas| areas.len() > 1) {
        tile(reader, panels, &areas, camera.pixels());
        lines_on_mirror(reader, panels, parts, (&camera, mount));
    }
}

/// No line between panels lies beside the mirror.
fn lines_on_mirror(
    reader: &mut ProfileReader,
    panels: &[PanelKeys],
    parts: &Entries,
    (camera, mount): (&CameraModel, &Mount),
) {
    let Some(width) = parts.part.width else { return };
    let pixels = camera.pixels();
    let camera = Camera::new(camera, mount, width.value);
    // (It is told of the mount that a frame reaches beyond the plane.)
    if !camera.sees_plane() {
        return;
    }
    let area = camera.rectangle(width.value, parts.part.height.map(|height| height.value));
    let size = area.size();
    for panel in panels {
        let keys = [("columns", &panel.columns), ("rows", &panel.rows)];
        for (k, (key, edges)) in keys.into_iter().enumerate() {
            let Some(edges) = edges else { continue };
            let off = |edge: u32| camera.line_at(k, edge, area).abs();
            let most = 0.5 * size[k];
            let mut inner = edges.value.into_iter().filter(|edge| (1..pixels[k]).contains(edge));
            if let Some(edge) = inner.find(|&edge| !(off(edge) < most)) {
                let path = &panel.path;
                let message = format!(
                    "{path}.{key} must have edges on the mirror, less than {most} mm from its middle, found {edge}, which is \
                     {:.3} mm from it",
                    off(edge)
                );
                return reader.complain(
                    edges.at,
                    message,
                    "make the part larger, or the panel wider",
                );
            }
        }
    }
}

/// The panels are within the frame, apart from each other, and leave no gap.
fn tile(
    reader: &mut ProfileReader,
    panels: &[PanelKeys],
    areas: &[[[u32; 2]; 2]],
    frame: [u32; 2],
) {
    for (panel, area) in panels.iter().zip(areas) {
        let [[_, right], [_, bottom]] = *area;
        for (edges, key, last, most) in
            [(&panel.columns, "columns", right, frame[0]), (&panel.rows, "rows", bottom, frame[1])]
        {
            if let Some(edges) = edges.as_ref().filter(|_| last > most) {
                let path = &panel.path;
                let message = format!("{path}.{key} must end at {most} or before, found {last}");
                return reader.complain(edges.at, message, "the frame ends there");
            }
        }
    }
    let common = |a: [u32; 2], b: [u32; 2]| a[0].max(b[0]) < a[1].min(b[1]);
    for (k, (panel, a)) in panels.iter().zip(areas).enumerate() {
        let over = areas[..k].iter().position(|b| common(a[0], b[0]) && common(a[1], b[1]));
        if let Some(over) = over {
            let message = format!(
                "{} must be apart from the others, found pixels that {} has too",
                panel.path, panels[over].path
            );
            return reader.complain(panel.at, message, "a pixel belongs to one panel");
        }
    }
    if let Some([column, row]) = uncovered(areas, frame) {
        let message = format!(
            "the panels must fill the frame of {} x {} pixels, found none at column {column}, row {row}",
            frame[0], frame[1]
        );
        reader.complain(
            panels[0].at,
            message,
            "columns and rows are edges: [0, 320] ends where [320, 640] begins",
        );
    }
}

/// The first pixel of the frame that no panel has.
fn uncovered(areas: &[[[u32; 2]; 2]], frame: [u32; 2]) -> Option<[u32; 2]> {
    // What is covered changes at the edges of panels alone.
    let starts = |axis: usize| {
        let mut starts: Vec<u32> = areas.iter().flat_map(|area| area[axis]).collect();
        starts.push(0);
        starts.retain(|&start| start < frame[axis]);
        starts.sort_unstable();
        starts
    };
    let (columns, rows) = (starts(0), starts(1));
    let covered = |at: [u32; 2]| {
        let within =
            |area: &[[u32; 2]; 2]| (0..2).all(|k| area[k][0] <= at[k] && at[k] < area[k][1]);
        areas.iter().any(within)
    };
    let corners = rows.iter().flat_map(|&row| columns.iter().map(move |&column| [column, row]));
    corners.into_iter().find(|&at| !covered(at))
}
