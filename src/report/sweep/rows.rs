//! Points of a study as tables: CSV as spreadsheets read it, and a line of JSON for each.

use crate::results::{SweepRow, SweepTable};
use serde_json::Value as Json;

impl SweepTable {
    /// A line of names, and one for each point (RFC 4180, but lines end by a line feed): its number, its values of the
    /// axes, what became of it, whether it is on the front, its figures, and why it has none. What has no value is empty.
    #[must_use]
    pub fn csv(&self) -> String {
        let names = ["point"].into_iter().chain(self.axes.iter().map(String::as_str));
        let names = names.chain(["status", "front"]).chain(self.columns.iter().map(String::as_str));
        let mut out = names.chain(["error"]).map(field).collect::<Vec<_>>().join(",") + "\n";
        for (point, row) in self.rows.iter().enumerate() {
            let cells = self.cells(point, row).into_iter().map(|(_, value)| cell(&value));
            out += &(cells.collect::<Vec<_>>().join(",") + "\n");
        }
        out
    }

    /// An object of one line for each point, all with the same keys in the same order; null where there is no value.
    #[must_use]
    pub fn ndjson(&self) -> String {
        let mut out = String::new();
        for (point, row) in self.rows.iter().enumerate() {
            // (An object of serde_json would sort its keys.)
            let pairs = self.cells(point, row).into_iter();
            let pairs = pairs.map(|(key, value)| format!("{}:{value}", Json::from(key)));
            out += &format!("{{{}}}\n", pairs.collect::<Vec<_>>().join(","));
        }
        out
    }

    /// Names and values of a row, in their order.
    fn cells<'a>(&'a self, point: usize, row: &'a SweepRow) -> Vec<(&'a str, Json)> {
        let values = &row.outcome.values;
        let axes = self.axes.iter().map(String::as_str).zip(row.axes.iter().cloned());
        let columns = self.columns.iter().enumerate();
        let columns = columns.map(|(k, key)| (&**key, values.get(k).cloned().unwrap_or_default()));
        let error = row.outcome.error.as_deref().map_or(Json::Null, Json::from);
        [("point", Json::from(point))]
            .into_iter()
            .chain(axes)
            .chain([
                ("status", row.outcome.status.word().into()),
                ("front", row.is_on_front.into()),
            ])
            .chain(columns)
            .chain([("error", error)])
            .collect()
    }
}

/// A value as a field of CSV.
fn cell(value: &Json) -> String {
    match value {
        Json::Null => String::new(),
        Json::String(text) => field(text),
        Json::Array(_) | Json::Object(_) => field(&value.to_string()),
        Json::Bool(_) | Json::Number(_) => value.to_string(),
    }
}

/// A text as a field of CSV. One that a spreadsheet would run as a formula has an apostrophe before it.
fn field(text: &str) -> String {
    let guarded = if text.starts_with(['=', '+', '-', '@', '\t', '\r']) { "'" } else { "" };
    match text.contains(['"', ',', '\n', '\r']) {
        true => format!("\"{guarded}{}\"", text.replace('"', "\"\"")),
        false => format!("{guarded}{text}"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::study;
    use super::*;
    use serde_json::Map;

    #[test]
    fn commas_quotes_and_formulas_stay_in_their_fields() {
        let lines = "point,part.width_mm,part.form,status,front,error_px,depth_mm,error\n\
            0,1,\"a, \"\"b\"\"\",made,true,0.5,2.0,\n\
            1,1,'=1+1,made,false,1.0,3.0,\n\
            2,2.5,\"[1,2]\",made,true,1.5,1.0,\n\
            3,2.5,true,refused,false,,,\"too wide, by 3\"\n";
        assert_eq!(study().1.csv(), lines);
        assert_eq!(cell(&Json::from(-1.5)), "-1.5");
        assert_eq!(field("two\nlines"), "\"two\nlines\"");
    }

    #[test]
    fn every_line_is_an_object_with_all_keys() {
        let (_, table) = study();
        let text = table.ndjson();
        let lines: Vec<Map<String, Json>> =
            text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(lines.len(), table.rows.len());
        for (k, line) in lines.iter().enumerate() {
            assert_eq!(line.len(), 8);
            assert_eq!(line["point"], k);
            assert_eq!(line["part.form"], table.rows[k].axes[1]);
        }
        assert_eq!((&lines[3]["error_px"], &lines[3]["status"]), (&Json::Null, &"refused".into()));
        assert_eq!(lines[3]["error"], "too wide, by 3");
    }
}
