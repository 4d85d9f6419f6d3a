//! From byte offsets to the lines and columns an editor shows.

/// The lines of a text.
pub(super) struct LineIndex<'t> {
    text: &'t str,
    starts: Vec<usize>,
}

impl<'t> LineIndex<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        // A byte order mark takes no column.
        let first = text.len() - text.strip_prefix('\u{feff}').unwrap_or(text).len();
        let mut starts = vec![first];
        starts.extend(text.match_indices('\n').map(|(i, _)| i + 1));
        LineIndex { text, starts }
    }

    /// Line and column of a byte offset, both from 1, the column in characters. Offsets past the
    /// end mean the end.
    pub(super) fn place(&self, offset: usize) -> (usize, usize) {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let line = self.line(offset);
        let before = self.text.get(self.starts[line - 1]..offset).unwrap_or("");
        (line, before.chars().count() + 1)
    }

    /// The line of a byte offset, from 1.
    pub(super) fn line(&self, offset: usize) -> usize {
        self.starts.partition_point(|&s| s <= offset).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_characters_not_bytes() {
        let lines = LineIndex::new("é = 1\nb = ±2\n");
        assert_eq!(lines.place(0), (1, 1));
        assert_eq!(lines.place("é =".len()), (1, 4));
        assert_eq!(lines.place("é = 1\nb = ±".len()), (2, 6));
        assert_eq!(lines.place(1), (1, 1), "inside a character");
        assert_eq!(lines.place(1000), (3, 1));
    }

    #[test]
    fn carriage_returns_end_lines_and_a_mark_takes_no_column() {
        let lines = LineIndex::new("\u{feff}a = 1\r\nb = 2\r\n");
        assert_eq!(lines.place(0), (1, 1));
        assert_eq!(lines.place(3), (1, 1));
        assert_eq!(lines.place(7), (1, 5));
        assert_eq!(lines.place(10), (2, 1));
        assert_eq!(lines.place(14), (2, 5));
    }

    #[test]
    fn empty_text_has_one_place() {
        assert_eq!(LineIndex::new("").place(0), (1, 1));
        assert_eq!(LineIndex::new("").place(5), (1, 1));
    }
}
