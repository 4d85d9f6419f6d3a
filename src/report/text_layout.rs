//! How text is laid out for its reader.

use super::visible::visible;

/// The lines of a summary: how long they may be, and what is in them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TextLayout<'a> {
    /// Letters in a line, but for words that are longer; none: facts stay on their line.
    pub columns: Option<usize>,
    /// Whether details are told that few ask for.
    pub details: bool,
    /// The folder of the files, if it is to be named.
    pub folder: Option<&'a str>,
}

impl TextLayout<'_> {
    /// Least columns: on a narrower terminal a fact would be a column of words.
    const LEAST: usize = 40;

    /// `first` and `text` in lines of which those after the first begin under the end of `first`, or of as
    /// many of its letters as `indent`. What would steer a terminal is written out.
    #[must_use]
    pub fn lines(&self, first: &str, text: &str, indent: usize) -> String {
        let whole = visible(&format!("{first}{text}"));
        let Some(columns) = self.columns else { return whole + "\n" };
        let spaces = " ".repeat(indent);
        let options = textwrap::Options::new(columns.max(Self::LEAST))
            .subsequent_indent(&spaces)
            .break_words(false)
            .word_splitter(textwrap::WordSplitter::NoHyphenation);
        textwrap::fill(&whole, options) + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_keep_to_the_columns_and_hang_under_their_fact() {
        let layout = TextLayout { columns: Some(40), ..TextLayout::default() };
        let text = "one two three four five six seven eight nine ten";
        let found = layout.lines("  part     ", text, 11);
        assert_eq!(
            found,
            "  part     one two three four five six\n           seven eight nine ten\n"
        );
        // A word that is longer stays whole: names of files are copied.
        let path = "a/".repeat(40);
        assert_eq!(layout.lines("  ", &path, 2).trim(), path);
        let unlimited = TextLayout::default().lines("  part     ", text, 11);
        assert_eq!(unlimited, format!("  part     {text}\n"));
    }
}
