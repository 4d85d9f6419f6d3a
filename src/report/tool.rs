//! The forming tool in answers.

use super::answer::{AnswerRows, ToRows};
use crate::profile::{MirrorSide, ToolForm};
use crate::results::{ToolFacts, three_digits};

impl ToRows for ToolFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let base = match self.form {
            ToolForm::Mould => {
                "its base at Z = 0, its cavity open to +Z, turned about X by half a turn"
            }
            ToolForm::Mandrel => "its base at Z = 0",
        };
        rows.add(self.form.name(), format!("{}, {base}", self.size()));
        rows.add("forms", self.sheet());
        let [foot_x, foot_y] = self.foot_mm;
        let walls = format!(
            "{:.3} x {:.3} mm at the foot, at Z {:.3} mm, drafted by {} deg",
            foot_x, foot_y, self.flange_mm, self.draft_deg
        );
        rows.details(|rows| rows.add("walls", walls));
        rows.page("tool volume", format!("{:.3} mm^3", self.volume_mm3));
        rows.page("least stretch of the sheet", three_digits(self.least_stretch));
    }
}

impl ToolFacts {
    /// Its name and size in words.
    pub(super) fn made(&self) -> String {
        format!("{}, {}", self.form.name(), self.size())
    }

    fn size(&self) -> String {
        let [x, y, z] = self.size_mm;
        format!("{x:.2} x {y:.2} x {z:.2} mm")
    }

    /// What is formed on it, and where its face is.
    fn sheet(&self) -> String {
        let face = match self.offset_mm {
            0.0 => "the tool's face is the mirror".to_owned(),
            mm if mm < 0.0 => format!("the tool's face is {} mm behind the mirror", -mm),
            mm => format!("the tool's face is {mm} mm before the mirror"),
        };
        let sheet = match self.sheet_mm {
            0.0 => "the mirror itself".to_owned(),
            mm => {
                let side = match self.mirror_side {
                    MirrorSide::Tool => "on the tool",
                    MirrorSide::Free => "away from the tool",
                };
                format!("a sheet of {mm} mm, mirrored on its side {side}")
            }
        };
        let shrinks = match self.shrinkage_ppm {
            0.0 => String::new(),
            ppm => format!("; it shrinks by {ppm} ppm"),
        };
        format!("{sheet}; {face}{shrinks}")
    }
}
