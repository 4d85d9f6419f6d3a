//! Where the camera stands over the part.

use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{NumbersFormat, number, numbers};
use super::Entries;
use super::layout::LayoutName;
use crate::optics::{Camera, Mount};

/// Steepest angle between the camera's axis and the part's normal, degrees: beyond it the part is seen edge on.
const STEEPEST_DEG: f64 = 80.0;

pub(super) fn read(reader: &mut ProfileReader, root: &Section, parts: &Entries) -> Mount {
    if !root.has("mount") {
        return Mount::default();
    }
    let Some(section) = reader.section(root, "mount", Optional) else { return Mount::default() };
    let must = "a number from -160 to 160";
    let hint = "the angle between the ways back to the camera and to what the picture's middle shows, \
                as in fold_deg = 60";
    let fold = number(reader, &section, "fold_deg", Optional, must, hint, |f| {
        f.abs() <= 2.0 * STEEPEST_DEG
    });
    let must = "a number from -360 to 360";
    let hint = "the azimuth, in the picture, to which the view is folded: 0 is up, 90 to the right";
    let towards =
        number(reader, &section, "towards_deg", Optional, must, hint, |f| f.abs() <= 360.0);
    let form = "where the camera's axis meets the part, as in shift_mm = [10, 0]";
    let keys = NumbersFormat {
        key: "shift_mm",
        parts: "[X, Y]",
        each: "from -1000000 to 1000000",
        form,
        limit: form,
    };
    let shift = section
        .has(keys.key)
        .then(|| numbers(reader, &section, &keys, |f| f.abs() <= 1e6))
        .flatten();
    let mount = Mount {
        fold_deg: fold.map_or(0.0, |fold| fold.value),
        towards_deg: towards.map_or(0.0, |towards| towards.value),
        shift_mm: shift.map_or([0.0; 2], |shift| shift.value),
    };
    suits(reader, parts, &section, &mount);
    frame_sees_plane(reader, parts, &section, &mount);
    mount
}

/// The whole frame sees the part's plane where what it sees there is the mirror's height, or its edges the panels'.
fn frame_sees_plane(reader: &mut ProfileReader, parts: &Entries, section: &Section, mount: &Mount) {
    let is_rectangle =
        parts.layout.as_ref().is_some_and(|layout| layout.name == LayoutName::Rectangle);
    let is_panelled = parts.projection.as_ref().is_some_and(|found| found.panels().is_some());
    let Some(camera) = parts.camera.as_ref().and_then(|camera| camera.camera) else { return };
    let asks = is_panelled || is_rectangle && parts.part.height.is_none() && !parts.bare;
    // (Any width: it is a telecentric frame's, whose rays all meet the plane.)
    let sees_plane = |mount: &Mount| Camera::new(&camera, mount, 1.0).sees_plane();
    if !asks || sees_plane(mount) {
        return;
    }
    let folded = |fold_deg: f64| Mount { fold_deg, ..*mount };
    let sense = mount.fold_deg.signum();
    let whole = (1..=mount.fold_deg.abs() as u32).rev().map(|by| folded(sense * f64::from(by)));
    let most = whole.into_iter().find(sees_plane).unwrap_or_default();
    let message = format!(
        "{}.fold_deg must leave the part's plane in all of the frame, found {}, with which the frame reaches beyond the \
         plane's horizon",
        section.path, mount.fold_deg
    );
    let own_height = if is_panelled { "" } else { "; or say part.height_mm" };
    let hint = format!("fold_deg = {} is the most for this camera{own_height}", most.fold_deg);
    reader.complain(section.at, message, &hint);
}

/// Discs and folded panels lie about the camera's axis.
fn suits(reader: &mut ProfileReader, parts: &Entries, section: &Section, mount: &Mount) {
    let Some(layout) = &parts.layout else { return };
    if layout.name == LayoutName::Strip && mount.shift_mm != [0.0; 2] {
        let [x, y] = mount.shift_mm;
        let message = format!(
            "{}.shift_mm must be left out with [layout.strip], whose mirror is where the camera looks, found [{x}, {y}]",
            section.path
        );
        let hint = "fold_deg and towards_deg alone lean the camera over a strip";
        reader.complain(section.at, message, hint);
        return;
    }
    let may_lean = matches!(layout.name, LayoutName::Rectangle | LayoutName::Strip);
    if mount.is_on_axis() || may_lean {
        return;
    }
    let message = format!(
        "layout must be [layout.rectangle] or [layout.strip] with [{}] off the axis, found [layout.{}]",
        section.path, layout.name
    );
    let hint = "discs and folded panels lie about the camera's axis; views and strips need not";
    reader.complain(section.at, message, hint);
}
