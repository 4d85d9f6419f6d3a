//! Answers of commands: rows of facts, each worded once, and the renderers of all answers as text and JSON.

use super::TextLayout;
use super::visible::visible;
use crate::results::{FileFacts, ProfileId, Verdict, file_size};
use serde::Serialize;

/// What an answer is about, and what it comes to.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Head<'a> {
    /// The profile; none of an answer about several.
    pub profile: Option<&'a ProfileId>,
    /// Pass or fail; none where nothing is judged.
    pub verdict: Option<Verdict>,
    /// Reasons of a fail, each with figures.
    pub reasons: Vec<String>,
    /// Nuisances to come, and what to do about them; no part of the verdict.
    pub warnings: &'a [String],
}

impl<'a> Head<'a> {
    /// The head of an answer that judges nothing.
    #[must_use]
    pub fn of(profile: &'a ProfileId) -> Self {
        Self { profile: Some(profile), ..Self::default() }
    }

    /// The head of an answer with a verdict.
    #[must_use]
    pub fn judged(profile: &'a ProfileId, verdict: Verdict, reasons: &[impl ToString]) -> Self {
        let reasons = reasons.iter().map(ToString::to_string).collect();
        Self { verdict: Some(verdict), reasons, ..Self::of(profile) }
    }

    /// The same with warnings.
    #[must_use]
    pub fn with_warnings(self, warnings: &'a [String]) -> Self {
        Self { warnings, ..self }
    }
}

/// The result of a command: figures with keys, which are its JSON, and the same in words.
pub trait Answer: Serialize {
    /// What it is about, and what it comes to.
    fn head(&self) -> Head<'_>;

    /// Its facts, in the order of the terminal.
    fn rows(&self) -> AnswerRows;

    /// The answer as JSON of several lines.
    fn json(&self) -> String {
        json_text(self)
    }

    /// The answer as JSON on one line.
    fn json_line(&self) -> String {
        let mut text = on_one_line(&self.json());
        text.push('\n');
        text
    }

    /// A readable summary: a line a fact, the reasons, and the verdict last. Plain text, in which what
    /// would steer a terminal is written out.
    fn text(&self) -> String {
        self.laid_out(&TextLayout::default())
    }

    /// The summary for a reader.
    fn laid_out(&self, layout: &TextLayout) -> String {
        let Head { profile, verdict, reasons, .. } = self.head();
        let mut out = String::new();
        if let Some(ProfileId { name, sha256, .. }) = profile {
            out += &visible(&format!("{name}  ({})\n", &sha256[..sha256.len().min(8)]));
        }
        let mut rows = self.rows();
        if let Some(folder) = layout.folder {
            rows.terminal("folder", folder);
        }
        out += &rows.text(layout);
        for reason in reasons {
            out += &layout.lines("  - ", &reason, 4);
        }
        if let Some(verdict) = verdict {
            out += &format!("  verdict  {}\n", verdict.word());
        }
        out
    }
}

/// `result` as JSON of several lines.
pub(crate) fn json_text(result: &(impl Serialize + ?Sized)) -> String {
    let mut text = serde_json::to_string_pretty(result).expect("string keys and plain values only");
    text.push('\n');
    text
}

/// JSON of several lines without the blanks between its words: a second writer of all reports is a hundred kilobytes of program.
fn on_one_line(json: &str) -> String {
    let (mut is_text, mut is_escaped) = (false, false);
    let keep = |c: &char| {
        if is_text {
            is_text = is_escaped || *c != '"';
            is_escaped = *c == '\\' && !is_escaped;
            return true;
        }
        is_text = *c == '"';
        !c.is_ascii_whitespace()
    };
    json.chars().filter(keep).collect()
}

/// What has facts to add to an answer.
pub trait ToRows {
    /// Adds them.
    fn add_to(&self, rows: &mut AnswerRows);
}

/// A fact in words.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Row {
    /// Its name at the left of the terminal's line, empty where it goes on with the fact above; none of a
    /// fact for the page alone.
    label: Option<&'static str>,
    /// Its name in the page's table; none of a fact for the terminal alone.
    heading: Option<String>,
    sentence: String,
    /// Whether the terminal shows it only to those who ask for details.
    is_detail: bool,
    /// Whether it is a line as it stands: one of a table.
    is_fixed: bool,
}

/// Facts in words, for the terminal, for the page, or for both.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AnswerRows {
    rows: Vec<Row>,
    /// Letters that a name in the terminal takes.
    label_width: usize,
}

impl Default for AnswerRows {
    fn default() -> Self {
        Self::labelled(8)
    }
}

impl AnswerRows {
    /// No facts yet; names in the terminal take so many letters.
    #[must_use]
    pub fn labelled(label_width: usize) -> Self {
        Self { rows: Vec::new(), label_width }
    }

    /// The facts of `parts`, in their order.
    #[must_use]
    pub fn of(parts: &[&dyn ToRows]) -> Self {
        let mut rows = Self::default();
        parts.iter().for_each(|part| part.add_to(&mut rows));
        rows
    }

    fn push(&mut self, label: Option<&'static str>, heading: Option<String>, sentence: String) {
        self.rows.push(Row { label, heading, sentence, ..Row::default() });
    }

    /// Adds a fact that has one name in the terminal and on the page.
    pub fn add(&mut self, name: &'static str, sentence: impl Into<String>) {
        self.named(name, name, sentence);
    }

    /// Adds a fact with one name for the terminal and one for the page.
    pub fn named(&mut self, label: &'static str, heading: &str, sentence: impl Into<String>) {
        self.push(Some(label), Some(heading.into()), sentence.into());
    }

    /// Adds a fact for the terminal alone.
    pub fn terminal(&mut self, label: &'static str, sentence: impl Into<String>) {
        self.push(Some(label), None, sentence.into());
    }

    /// Adds a fact for the page alone.
    pub fn page(&mut self, heading: impl Into<String>, sentence: impl Into<String>) {
        self.push(None, Some(heading.into()), sentence.into());
    }

    /// Adds a line of the terminal's tables, which stays as it is.
    pub fn line(&mut self, text: impl Into<String>) {
        let sentence = text.into();
        self.rows.push(Row { sentence, is_fixed: true, ..Row::default() });
    }

    /// Adds a remark for the terminal, which has no name.
    pub fn remark(&mut self, text: impl Into<String>) {
        self.push(None, None, text.into());
    }

    /// What `add` adds is for those in the terminal who ask for details.
    pub fn details(&mut self, add: impl FnOnce(&mut Self)) {
        let first = self.rows.len();
        add(self);
        self.rows[first..].iter_mut().for_each(|row| row.is_detail = true);
    }

    /// Adds all of `others`.
    pub fn append(&mut self, others: Self) {
        self.rows.extend(others.rows);
    }

    /// The terminal's lines, the names of facts in a column.
    fn text(&self, layout: &TextLayout) -> String {
        let width = self.label_width;
        let line = |row: &Row| match (row.label, &row.heading) {
            (Some(label), _) => {
                Some(layout.lines(&format!("  {label:width$} "), &row.sentence, width + 3))
            }
            (None, None) if row.is_fixed => Some(visible(&row.sentence) + "\n"),
            (None, None) => Some(layout.lines("  ", &row.sentence, 4)),
            (None, Some(_)) => None,
        };
        self.rows.iter().filter(|row| layout.details || !row.is_detail).filter_map(line).collect()
    }

    /// Names and sentences of the facts that the terminal shows without being asked for details.
    pub fn plain(&self) -> impl Iterator<Item = (&str, &str)> {
        let plain = self.rows.iter().filter(|row| !row.is_detail && !row.is_fixed);
        plain.filter_map(|row| Some((row.label?, &*row.sentence)))
    }

    /// The details alone.
    #[must_use]
    pub fn into_details(mut self) -> Self {
        self.rows.retain(|row| row.is_detail);
        self
    }

    /// Lines of the terminal's tables.
    pub fn table_lines(&self) -> impl Iterator<Item = &str> {
        self.rows.iter().filter(|row| row.is_fixed).map(|row| &*row.sentence)
    }

    /// Names and sentences of the page's facts.
    pub fn of_page(&self) -> impl Iterator<Item = (&str, &str)> {
        self.rows.iter().filter_map(|row| Some((row.heading.as_deref()?, &*row.sentence)))
    }
}

impl<T: ToRows> ToRows for Option<T> {
    fn add_to(&self, rows: &mut AnswerRows) {
        self.iter().for_each(|part| part.add_to(rows));
    }
}

impl<T: ToRows> ToRows for Vec<T> {
    fn add_to(&self, rows: &mut AnswerRows) {
        self.iter().for_each(|part| part.add_to(rows));
    }
}

impl ToRows for FileFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        rows.add("file", format!("{}  {}", self.name, file_size(self.bytes)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blanks, quotes and backslashes of texts stay, and what is read is the same.
    #[test]
    fn a_line_is_what_the_writer_of_lines_makes() {
        let value = serde_json::json!({
            "a \\": ["b \" c, \\\" : d", "\n\t", "", {}, []], "e": [1.5e-7, -2, null, true],
        });
        let line = on_one_line(&json_text(&value));
        assert_eq!(line, serde_json::to_string(&value).unwrap());
    }

    #[test]
    fn each_reader_gets_its_facts_under_its_names() {
        let mut rows = AnswerRows::default();
        rows.add("part", "1 mm");
        rows.named("form", "best-fit sphere", "2 mm");
        rows.terminal("", "seen from above");
        rows.page("area", "3 mm^2");
        rows.line("a table");
        rows.remark("a remark");
        rows.details(|rows| rows.add("mesh", "7 triangles"));
        let text =
            "  part     1 mm\n  form     2 mm\n           seen from above\na table\n  a remark\n";
        assert_eq!(rows.text(&TextLayout::default()), text);
        let all = TextLayout { details: true, ..TextLayout::default() };
        assert_eq!(rows.text(&all), format!("{text}  mesh     7 triangles\n"));
        let page: Vec<_> = rows.of_page().collect();
        assert_eq!(
            page,
            [
                ("part", "1 mm"),
                ("best-fit sphere", "2 mm"),
                ("area", "3 mm^2"),
                ("mesh", "7 triangles")
            ]
        );
    }
}
