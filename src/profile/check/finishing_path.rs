//! The path of the cutter over the mirror in finishing: `program.path`.

use super::super::Layout;
use super::super::program_words::FinishingPath;
use super::super::reader::Need::Optional;
use super::super::values::word;
use super::program_table::ProgramTable;

impl ProgramTable<'_, '_, '_, '_> {
    /// The path; complains of a spiral over a mirror that is not round, and of one with a direction.
    pub(super) fn finishing_path(&mut self, layout: Option<&Layout>) -> Option<FinishingPath> {
        let paths = FinishingPath::ALL.map(|path| (path.name(), path));
        let hint = "straight lines, or turns about the axis of a round mirror";
        let path = word(self.reader, self.section, "path", &paths, hint)?;
        if path == FinishingPath::Spiral {
            self.refuse_corners(layout);
            self.refuse_direction();
        }
        Some(path)
    }

    fn refuse_corners(&mut self, layout: Option<&Layout>) {
        let outline = match layout {
            None | Some(Layout::Disc | Layout::Annulus { .. }) => return,
            Some(Layout::Strip { .. }) => "a strip",
            Some(Layout::Conquistador { .. }) => "a conquistador of two panels",
            Some(Layout::Rectangle { .. }) => "a rectangle",
        };
        let Some(value) = self.reader.value(self.section, "path", Optional, "", "") else { return };
        let message = format!(
            "program.path must be \"lines\" for a mirror that is not round, found \"spiral\" for {outline}"
        );
        let hint = "turns about the axis have the rims of [layout.disc] or [layout.annulus]";
        self.reader.complain(value.span().start, message, hint);
    }

    fn refuse_direction(&mut self) {
        let Some(value) = self.reader.value(self.section, "angle_deg", Optional, "", "") else {
            return;
        };
        let found = self.reader.quote_type(value);
        let message = format!("program.angle_deg must be left out with a spiral, found {found}");
        let hint = "turns about the axis have no direction; path = \"lines\" has one";
        self.reader.complain(value.span().start, message, hint);
    }
}
