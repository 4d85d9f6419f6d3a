//! A walk over the parsed tree that notes every complaint and goes on.

use std::collections::BTreeSet;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue, Error};

use super::NamedFiles;
use super::complaint::{Complaint, Complaints};
use super::lines::LineIndex;
use super::schema::{self, Schema};
use super::words::{list, shown, syntax_hint};
use crate::geom::TriMesh;

/// A value and where it stands.
pub(super) type TomlValue<'t> = Spanned<DeValue<'t>>;

const MAX_SYNTAX_COMPLAINTS: usize = 20;
/// Alternatives that a complaint lists as whole tables.
const MAX_BRACKETED: usize = 4;

/// Whether a table may do without a key.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Need {
    Required,
    Optional,
}

/// A table of the file.
pub(super) struct Section<'t> {
    pub(super) path: String,
    pub(super) at: usize,
    entries: &'t DeTable<'t>,
    /// Keys that were meant but misspelt; one complaint is enough for each.
    misspelt: Vec<&'static str>,
}

impl<'t> Section<'t> {
    /// The whole path of one of the table's keys.
    pub(super) fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key) || self.misspelt.contains(&key)
    }
}

/// Collects what is wrong with one file.
pub(super) struct ProfileReader<'a> {
    file: &'a str,
    text: &'a str,
    lines: LineIndex<'a>,
    complaints: Vec<Complaint>,
    /// The lines with an error of syntax.
    syntax: BTreeSet<usize>,
    /// Parts of the file could not be read, so an absent key may well be there.
    torn: bool,
    /// The last error of syntax was of a list or inline table.
    swallowing: bool,
    /// Offsets of lines that are neither a setting nor a table.
    stray: Vec<usize>,
    /// What has the files that the profile names.
    files: NamedFiles<'a>,
    /// The tables that the file may have.
    schema: Schema,
}

impl<'a> ProfileReader<'a> {
    pub(super) fn new(file: &'a str, text: &'a str, files: NamedFiles<'a>) -> Self {
        ProfileReader {
            file,
            text,
            lines: LineIndex::new(text),
            complaints: Vec::new(),
            syntax: BTreeSet::new(),
            torn: false,
            swallowing: false,
            stray: Vec::new(),
            files,
            schema: schema::PROFILE,
        }
    }

    /// A reader of a file of another kind, which names none.
    pub(super) fn of(schema: Schema, file: &'a str, text: &'a str) -> Self {
        Self { schema, ..Self::new(file, text, NamedFiles::NONE) }
    }

    /// The bytes of a file that the profile names, at most so many, or why there are none.
    pub(super) fn file(&self, named: &str, most_bytes: u64) -> Result<Vec<u8>, String> {
        (self.files.bytes)(named, most_bytes)
    }

    /// The triangles of an STL or OBJ that the profile names, or why there are none.
    pub(super) fn mesh(&self, named: &str) -> Result<TriMesh, String> {
        (self.files.mesh)(named)
    }

    /// Line and column of a byte offset, from 1.
    pub(super) fn place(&self, at: usize) -> (usize, usize) {
        self.lines.place(at)
    }

    /// Notes an error of syntax.
    pub(super) fn broken(&mut self, error: &Error) {
        let span = error.span().unwrap_or(0..0);
        let line = self.lines.line(span.start);
        // A slip of syntax often trips the parser several times.
        if !self.syntax.insert(line) {
            return;
        }
        if error.message() == "duplicate key" {
            let key = shown(self.text.get(span.clone()).unwrap_or(""));
            let message = format!("{key} must be given only once, found it again");
            return self.complain(span.start, message, "keep one of them");
        }
        self.torn = true;
        // A list left open swallows the lines below it.
        let swallows = error.message().starts_with("missing comma")
            || error.message().contains("inline table element");
        let swallowed = swallows && self.swallowing;
        self.swallowing = swallows;
        if swallowed {
            return;
        }
        if error.message().starts_with("key with no value") {
            self.stray.push(span.start.min(self.text.len()));
        }
        match self.syntax.len() {
            ..=MAX_SYNTAX_COMPLAINTS => {
                let message = format!("the text must be TOML: {}", error.message());
                let hint = syntax_hint(error.message());
                self.complain(span.start, message, hint);
            }
            n if n == MAX_SYNTAX_COMPLAINTS + 1 => {
                let message = "more lines are not TOML".to_owned();
                self.complain(span.start, message, "is this the right file?");
            }
            _ => {}
        }
    }

    /// Notes a complaint at a byte offset. An empty hint is none.
    pub(super) fn complain(&mut self, at: usize, message: String, hint: &str) {
        let (line, column) = self.lines.place(at);
        self.complaints.push(Complaint {
            file: self.file.to_owned(),
            line,
            column,
            message,
            hint: (!hint.is_empty()).then(|| hint.to_owned()),
        });
    }

    /// Notes that something is missing from a table, unless it may have been lost to an error of
    /// syntax.
    pub(super) fn missing(&mut self, section: &Section, message: String, hint: &str) {
        if !self.torn {
            self.complain(section.at, message, hint);
        }
    }

    /// The text without its lines that are neither a setting nor a table, which end the parser's
    /// reading. Every other byte keeps its place.
    pub(super) fn mended(&self) -> Option<String> {
        if self.stray.is_empty() {
            return None;
        }
        let mut bytes = self.text.as_bytes().to_vec();
        for &at in &self.stray {
            let start = bytes[..at].iter().rposition(|&b| b == b'\n');
            let start = start.map_or(0, |newline| newline + 1);
            let end = bytes[at..].iter().position(|&b| b == b'\n');
            let end = end.map_or(bytes.len(), |length| at + length);
            let line = &mut bytes[start..end];
            if !line.iter().any(|b| b"[]{}\"'\r".contains(b)) {
                line.fill(b' ');
            }
        }
        String::from_utf8(bytes).ok()
    }

    /// Whether parts of the file could not be read.
    pub(super) fn is_torn(&self) -> bool {
        self.torn
    }

    pub(super) fn is_clean(&self) -> bool {
        self.complaints.is_empty()
    }

    pub(super) fn into_complaints(mut self) -> Complaints {
        self.complaints.sort_by_key(|c| (c.line, c.column));
        Complaints(self.complaints)
    }

    /// The source of a value, short enough to quote.
    pub(super) fn quote(&self, value: &TomlValue) -> String {
        shown(self.text.get(value.span()).unwrap_or(""))
    }

    /// The source of a value of the wrong type, and its type.
    pub(super) fn quote_type(&self, value: &TomlValue) -> String {
        match value.get_ref() {
            DeValue::Table(_) => "a table".to_owned(),
            found if is_list_of_tables(found) => "a list of tables".to_owned(),
            DeValue::Array(_) => format!("the list {}", self.quote(value)),
            DeValue::String(_) => format!("the text {}", self.quote(value)),
            DeValue::Datetime(_) => format!("the date or time {}", self.quote(value)),
            DeValue::Integer(_) | DeValue::Float(_) | DeValue::Boolean(_) => self.quote(value),
        }
    }

    /// The table that is the whole file.
    pub(super) fn root<'t>(&mut self, entries: &'t DeTable<'t>) -> Section<'t> {
        self.open(String::new(), 0, entries, "")
    }

    /// Opens a table and complains of the keys it should not have.
    fn open<'t>(
        &mut self,
        path: String,
        at: usize,
        entries: &'t DeTable<'t>,
        hint: &str,
    ) -> Section<'t> {
        let known = self.schema.keys(&path);
        let mut misspelt = Vec::new();
        for (key, _) in entries {
            let word = key.get_ref().as_ref();
            let garbled = self.torn && self.syntax.contains(&self.lines.line(key.span().start));
            if known.contains(&word) || garbled {
                continue;
            }
            let hint = match (self.schema.home(word), schema::nearest(word, known)) {
                // (A table without keys has a note that says where to look.)
                (Some(home), _) if hint.is_empty() || !known.is_empty() => {
                    format!("{word} belongs in {}", self.schema.heading(home))
                }
                (None, Some(meant)) => {
                    misspelt.push(meant);
                    format!("did you mean {meant}?")
                }
                _ => hint.to_owned(),
            };
            let holder = match path.as_str() {
                "" => self.schema.whole,
                path => path,
            };
            let only = if known.is_empty() { "" } else { "only " };
            let known = list(known, "and");
            let message = format!("{holder} must hold {only}{known}, found {}", shown(word));
            self.complain(key.span().start, message, &hint);
        }
        Section { path, at, entries, misspelt }
    }

    /// A table inside a table.
    pub(super) fn section<'t>(
        &mut self,
        parent: &Section<'t>,
        key: &str,
        need: Need,
    ) -> Option<Section<'t>> {
        let path = parent.path_of(key);
        let hint = match self.schema.usual_keys(&path).as_slice() {
            [] => format!("write [{path}]"),
            keys => format!("write [{path}] and below it {}", list(keys, "and")),
        };
        if need == Need::Required && !parent.has(key) {
            self.missing(parent, format!("{path} must be a table, found nothing"), &hint);
        }
        self.table(parent, key, &hint, schema::note(&path))
    }

    /// A table inside a table, with one hint if it is something else and one for unknown keys.
    fn table<'t>(
        &mut self,
        parent: &Section<'t>,
        key: &str,
        form: &str,
        unknown: &str,
    ) -> Option<Section<'t>> {
        let path = parent.path_of(key);
        let value = parent.entries.get(key)?;
        let at = value.span().start;
        match value.get_ref() {
            DeValue::Table(table) => return Some(self.open(path, at, table, unknown)),
            _ if self.is_filler(value) => {}
            found => {
                let message = format!("{path} must be a table, found {}", self.quote_type(value));
                let doubled = format!("write [{path}] with single brackets");
                let form = if is_list_of_tables(found) { &doubled } else { form };
                self.complain(at, message, form);
            }
        }
        None
    }

    /// The alternatives that a table holds; a complaint unless it is exactly one.
    pub(super) fn alternatives<'t>(
        &mut self,
        root: &Section<'t>,
        key: &str,
        hint: &str,
    ) -> Vec<(&'static str, Section<'t>)> {
        let (must, form) = exactly_one(key, &self.schema.below(key));
        if !root.has(key) {
            self.missing(root, format!("{must}, found nothing"), hint);
            return Vec::new();
        }
        let Some(parent) = self.table(root, key, &form, hint) else {
            return Vec::new();
        };
        self.one_of(&parent, hint)
    }

    /// The tables inside a table that is open; a complaint unless it is exactly one.
    pub(super) fn one_of<'t>(
        &mut self,
        parent: &Section<'t>,
        hint: &str,
    ) -> Vec<(&'static str, Section<'t>)> {
        let names = self.schema.below(&parent.path);
        let (must, _) = exactly_one(&parent.path, &names);
        let mut found: Vec<_> = names
            .iter()
            .filter_map(|name| Some((*name, self.section(parent, name, Need::Optional)?)))
            .collect();
        found.sort_by_key(|(_, section)| section.at);
        if let [_, .., (_, last)] = found.as_slice() {
            let message = format!("{must}, found {}", found.len());
            self.complain(last.at, message, "remove all but one");
        }
        let is_any = |(key, _): (&Spanned<DeString>, &TomlValue)| {
            let key = key.get_ref().as_ref();
            names.contains(&key) || !self.schema.keys(&parent.path).contains(&key)
        };
        if !parent.entries.iter().any(is_any) {
            self.missing(parent, format!("{must}, found nothing"), hint);
        }
        found
    }

    /// The tables of a list of tables, `most` at the most; none if the key is absent.
    pub(super) fn sections<'t>(
        &mut self,
        parent: &Section<'t>,
        key: &str,
        most: usize,
        [hint, too_many]: [&str; 2],
    ) -> Vec<Section<'t>> {
        let path = parent.path_of(key);
        let must = format!("a list of tables [[{path}]], at most {most}");
        let Some(value) = self.value(parent, key, Need::Optional, &must, hint) else {
            return Vec::new();
        };
        let tables: Option<Vec<_>> = value.get_ref().as_array().and_then(|list| {
            list.iter().map(|v| Some((v.span().start, v.get_ref().as_table()?))).collect()
        });
        let (found, hint) = match tables {
            Some(tables) if tables.len() <= most => {
                let open = |(at, table)| self.open(path.clone(), at, table, "");
                return tables.into_iter().map(open).collect();
            }
            Some(tables) => (tables.len().to_string(), too_many.to_owned()),
            None => {
                (self.quote_type(value), format!("write [[{path}]] with double brackets; {hint}"))
            }
        };
        self.complain(value.span().start, format!("{path} must be {must}, found {found}"), &hint);
        Vec::new()
    }

    /// The value of a key. If it is required and absent, a complaint.
    pub(super) fn value<'t>(
        &mut self,
        section: &Section<'t>,
        key: &str,
        need: Need,
        must: &str,
        hint: &str,
    ) -> Option<&'t TomlValue<'t>> {
        let value = section.entries.get(key);
        if value.is_none() && need == Need::Required && !section.has(key) {
            let path = section.path_of(key);
            self.missing(section, format!("{path} must be {must}, found nothing"), hint);
        }
        value.filter(|value| !self.is_filler(value))
    }

    /// Whether a value stands for one that could not be read; its lines have a complaint already.
    fn is_filler(&self, value: &TomlValue) -> bool {
        let span = value.span();
        let lines = self.lines.line(span.start)..=self.lines.line(span.end);
        self.torn && (span.is_empty() || self.syntax.range(lines).next().is_some())
    }
}

/// What a table of alternatives must hold, and how that is written.
fn exactly_one(path: &str, names: &[&'static str]) -> (String, String) {
    let tables: Vec<String> = names.iter().map(|name| format!("[{path}.{name}]")).collect();
    let tables: Vec<&str> = tables.iter().map(String::as_str).collect();
    // A long list is easier to read without brackets.
    match tables.as_slice() {
        [first, .., _] if tables.len() > MAX_BRACKETED => (
            format!("{path} must hold exactly one of {}", list(names, "and")),
            format!("write {first} or another table of [{path}]"),
        ),
        tables => (
            format!("{path} must hold exactly one of {}", list(tables, "and")),
            format!("write {}", list(tables, "or")),
        ),
    }
}

fn is_list_of_tables(value: &DeValue) -> bool {
    value.as_array().is_some_and(|list| list.iter().any(|v| v.get_ref().is_table()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bad_line_is_named_once() {
        let text = "a = = = 1\nb = x\nc 3\n";
        let mut reader = ProfileReader::new("p.toml", text, NamedFiles::NONE);
        for error in &DeTable::parse_recoverable(text).1 {
            reader.broken(error);
        }
        let places: Vec<_> = reader.into_complaints().0.iter().map(|c| c.line).collect();
        assert_eq!(places, [1, 2, 3]);
    }

    #[test]
    fn a_flood_of_bad_lines_is_cut_short() {
        let text = "a = = 1\n".repeat(1000);
        let mut reader = ProfileReader::new("p.toml", &text, NamedFiles::NONE);
        for error in &DeTable::parse_recoverable(&text).1 {
            reader.broken(error);
        }
        assert_eq!(reader.into_complaints().0.len(), MAX_SYNTAX_COMPLAINTS + 1);
    }
}
