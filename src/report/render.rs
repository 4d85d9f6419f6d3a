//! A picture that was rendered, in words.

use super::answer::{Answer, AnswerRows, Head};
use crate::results::RenderReport;

impl Answer for RenderReport {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile)
    }

    fn rows(&self) -> AnswerRows {
        let Self { scene, traced, file, pixels: [columns, rows], rays, .. } = self;
        let picture = format!("{file}  {columns} x {rows} pixels, {rays} rays");
        let from = match *traced {
            "design" => "the designed mirror".to_owned(),
            format => format!("the mesh written as {format} and read back"),
        };
        let mut rows = AnswerRows::default();
        rows.terminal("scene", format!("{scene}, from {from}"));
        rows.terminal("picture", picture);
        rows
    }
}
