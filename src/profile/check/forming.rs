//! The forming tool in the place of the part: `part.form` and `[forming]`, and what goes with them.

use super::super::border::BorderSpec;
use super::super::forming::{FormingSpec, MirrorSide, ToolForm, Vents};
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, number, word};
use super::super::{CadFormat, FileFormat, HoleSpec, Layout, StepProtocol};
use super::{Entries, SIZE, is_size};

/// Thickest sheet, mm, most shrinkage, ppm, and drafts, degrees.
const MOST_SHEET_MM: f64 = 1e3;
const MOST_PPM: f64 = 1e5;
const DRAFTS_DEG: [f64; 2] = [0.1, 60.0];
const MOST_VENTS: f64 = 200.0;

/// `form` of the part, with its place.
pub(super) type FormEntry = Located<Option<ToolForm>>;

/// `part.form`; the part itself without it.
pub(super) fn form(reader: &mut ProfileReader, part: &Section) -> FormEntry {
    let words =
        [("part", None), ("mould", Some(ToolForm::Mould)), ("mandrel", Some(ToolForm::Mandrel))];
    let hint = "mould is the negative of the mirror, mandrel what a sheet is formed over";
    let value = word(reader, part, "form", &words, hint).flatten();
    let at = match reader.value(part, "form", Optional, "", "") {
        Some(value) => value.span().start,
        None => part.at,
    };
    Located { value, at }
}

/// `[forming]` of a tool.
pub(super) fn read(
    reader: &mut ProfileReader,
    root: &Section,
    form: Option<FormEntry>,
    base: Option<&Located<f64>>,
) -> Option<FormingSpec> {
    let section = reader.section(root, "forming", Optional);
    let Some(form) = form.and_then(|form| form.value) else {
        if let Some(section) = section {
            let message = "forming must go with part.form, found it alone".to_owned();
            let hint = "part.form = \"mandrel\" makes what a sheet is formed over, \"mould\" its \
                        negative";
            reader.complain(section.at, message, hint);
        }
        return None;
    };
    let usual = FormingSpec {
        form,
        sheet_mm: 0.0,
        mirror_side: form.seen_side(),
        shrinkage_ppm: 0.0,
        draft_deg: FormingSpec::USUAL_DRAFT_DEG,
        back_mm: base?.value,
        vents: Vents { count: 0, diameter_mm: FormingSpec::USUAL_VENT_MM },
    };
    let Some(section) = section else { return Some(usual) };
    Some(FormingSpec {
        sheet_mm: sheet(reader, &section).unwrap_or(usual.sheet_mm),
        mirror_side: mirror_side(reader, &section).unwrap_or(usual.mirror_side),
        shrinkage_ppm: shrinkage(reader, &section).unwrap_or(usual.shrinkage_ppm),
        draft_deg: draft(reader, &section).unwrap_or(usual.draft_deg),
        back_mm: back(reader, &section, form).unwrap_or(usual.back_mm),
        vents: vents(reader, &section, form).unwrap_or(usual.vents),
        ..usual
    })
}

fn sheet(reader: &mut ProfileReader, section: &Section) -> Option<f64> {
    let must = "a number from 0 to 1000";
    let hint = "the thickness of the formed sheet in millimetres, as in sheet_mm = 1.5";
    let is_sheet = |f: f64| (0.0..=MOST_SHEET_MM).contains(&f);
    Some(number(reader, section, "sheet_mm", Optional, must, hint, is_sheet)?.value)
}

fn mirror_side(reader: &mut ProfileReader, section: &Section) -> Option<MirrorSide> {
    let sides = [("tool", MirrorSide::Tool), ("free", MirrorSide::Free)];
    let hint = "tool is the sheet's side that lies on the tool, free the other one";
    word(reader, section, "mirror_side", &sides, hint)
}

fn shrinkage(reader: &mut ProfileReader, section: &Section) -> Option<f64> {
    let must = "a number from 0 to 100000";
    let hint = "what lengths shrink by when the piece cools, as in shrinkage_ppm = 5000 for 0.5 %";
    let is_shrinkage = |f: f64| (0.0..=MOST_PPM).contains(&f);
    Some(number(reader, section, "shrinkage_ppm", Optional, must, hint, is_shrinkage)?.value)
}

fn draft(reader: &mut ProfileReader, section: &Section) -> Option<f64> {
    let must = "a number from 0.1 to 60";
    let hint = "the angle of the walls to the vertical, as in draft_deg = 3; walls without \
                draft hold the piece";
    let is_draft = |f: f64| (DRAFTS_DEG[0]..=DRAFTS_DEG[1]).contains(&f);
    Some(number(reader, section, "draft_deg", Optional, must, hint, is_draft)?.value)
}

fn back(reader: &mut ProfileReader, section: &Section, form: ToolForm) -> Option<f64> {
    let hint = "millimetres of material behind the deepest place of the mould, as in back_mm = 10";
    let found = number(reader, section, "back_mm", Optional, SIZE, hint, is_size)?;
    if form != ToolForm::Mould {
        let message = format!(
            "forming.back_mm must go with part.form = \"mould\", found {} with \"{}\"",
            found.value,
            form.name()
        );
        let hint = "part.base_mm is the material under a mandrel's face";
        reader.complain(found.at, message, hint);
    }
    Some(found.value)
}

fn vents(reader: &mut ProfileReader, section: &Section, form: ToolForm) -> Option<Vents> {
    let must = "a whole number from 0 to 200";
    let hint = "how many vents there are along the foot of the walls, as in vents = 12";
    let is_count = |f: f64| (0.0..=MOST_VENTS).contains(&f) && f.fract() == 0.0;
    let count = number(reader, section, "vents", Optional, must, hint, is_count);
    let must = "a number from 0.1 to 1000000";
    let hint = "the diameter of the vents in millimetres, as in vent_mm = 0.6";
    let is_wide = |f: f64| (BorderSpec::LEAST_MM..=1e6).contains(&f);
    let wide = number(reader, section, "vent_mm", Optional, must, hint, is_wide);
    if let (None, Some(wide)) = (count, wide)
        && !section.has("vents")
    {
        let message = "forming.vent_mm must go with vents, found it alone".to_owned();
        reader.complain(wide.at, message, "vents = 12 drills twelve, evenly along the walls' foot");
    }
    let count = count?;
    if form != ToolForm::Mandrel && count.value > 0.0 {
        let message = format!(
            "forming.vents must go with part.form = \"mandrel\", found {} with \"{}\"",
            count.value,
            form.name()
        );
        let hint =
            "along a mould's foot the sheet lies first; part.holes_mm drills through its rim";
        reader.complain(count.at, message, hint);
    }
    let diameter_mm = wide.map_or(FormingSpec::USUAL_VENT_MM, |wide| wide.value);
    Some(Vents { count: count.value as usize, diameter_mm })
}

/// Holds the rest of the profile to its tool.
pub(super) fn check(
    reader: &mut ProfileReader,
    parts: &Entries,
    (tool, formats, step): (Option<&FormingSpec>, Option<&[FileFormat]>, Option<StepProtocol>),
    holes: &[Located<HoleSpec>],
) {
    let Some(tool) = tool else { return };
    let at = parts.part.form.map_or(0, |form| form.at);
    let name = tool.form.name();
    let mut must = |what: &str, found: &str, hint: &str| {
        let message = format!("part.form = \"{name}\" must {what}, found {found}");
        reader.complain(at, message, hint);
    };
    let has_border = parts.part.border.has_width();
    if tool.form == ToolForm::Mould && !has_border {
        let hint = "part.border_mm = 8 is the width of the mould's walls around the cavity";
        must("go with part.border_mm", "none", hint);
    }
    if tool.vents.count > 0 && !has_border {
        let hint = "part.border_mm = 8 puts a flat rim around the mandrel, in which vents end";
        must("have part.border_mm for its vents", "none", hint);
    }
    if parts.projection.as_ref().is_some_and(|projection| projection.panels().is_some()) {
        let hint = "no piece leaves a tool past the walls between panels; leave part.form out";
        must("have a mirror of one surface", "panels", hint);
    }
    let folded = parts.layout.as_ref().and_then(|found| found.layout);
    if matches!(folded, Some(Layout::Conquistador { .. })) && tool.offset_mm() != 0.0 {
        let hint = "across the ridge no surface runs everywhere beside the mirror by a sheet's thickness; \
                    let the side on the tool mirror: forming.mirror_side = \"tool\"";
        must("have the mirror of a folded layout on the tool", "it on the free side", hint);
    }
    let suits = |format: &FileFormat| {
        matches!(format, FileFormat::Mesh(_) | FileFormat::Cad(CadFormat::Step))
    };
    if let Some(other) = formats.unwrap_or_default().iter().find(|format| !suits(format)) {
        let hint = "sag tables and drawings are of the part; meshes and step are of the tool";
        must("go with other formats", &format!("\"{}\"", other.name()), hint);
    }
    if step == Some(StepProtocol::Ap242) {
        let hint = "datum features and tolerances are of the part; leave schema out";
        must("go with another schema of export.step", "\"ap242\"", hint);
    }
    if let Some(blind) = holes.iter().find(|hole| hole.value.blind.is_some()) {
        let at = blind.value.hole.at;
        let hint = "leave out depth_mm, or thread_depth_mm: holes go through a tool's flat rim";
        must("have through holes alone", &format!("a blind one at [{}, {}]", at.x, at.y), hint);
    }
}
