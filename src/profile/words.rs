//! Words for complaints: text quoted, lists in prose, hints on syntax.

const MAX_QUOTED: usize = 40;

/// Text safe to print on one line: nothing invisible, not too long.
pub(super) fn shown(text: &str) -> String {
    if text.is_empty() {
        return "an empty key".to_owned();
    }
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    let mut line = String::new();
    for (i, c) in words.join(" ").chars().enumerate() {
        if i == MAX_QUOTED {
            line.push_str("...");
            break;
        }
        match c {
            '"' | '\'' | '\\' => line.push(c),
            c => line.extend(c.escape_debug()),
        }
    }
    line
}

/// "a, b and c".
pub(super) fn list(words: &[&str], and: &str) -> String {
    match words {
        [] => "nothing".to_owned(),
        [only] => (*only).to_owned(),
        [first @ .., last] => format!("{} {and} {last}", first.join(", ")),
    }
}

/// Hint at the remedy of an error of syntax; empty if there is none.
pub(super) fn syntax_hint(message: &str) -> &'static str {
    const HINTS: [(&str, &str); 7] = [
        ("must be quoted", "words need quotes, as in ridge = \"crest\""),
        ("key with no value", "write key = value"),
        ("array elements", "is the list before this closed with ]?"),
        ("inline table element", "is the table before this closed with }?"),
        ("unclosed table", "close it with ]"),
        ("invalid multi-line", "a text in triple quotes runs to the end of the file; close it"),
        ("invalid basic string", "close the text with \""),
    ];
    HINTS.iter().find(|(sign, _)| message.contains(sign)).map_or("", |(_, hint)| hint)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_are_short_and_visible() {
        assert_eq!(shown("[1,\n  2]"), "[1, 2]");
        assert_eq!(shown("'\u{1b}[31m'"), "'\\u{1b}[31m'");
        assert_eq!(shown("\"±30°\""), "\"±30°\"");
        assert_eq!(shown(&"x".repeat(50)), format!("{}...", "x".repeat(40)));
        assert_eq!(shown(&"x".repeat(40)), "x".repeat(40));
    }

    #[test]
    fn lists_read_as_prose() {
        assert_eq!(list(&["a"], "or"), "a");
        assert_eq!(list(&["a", "b", "c"], "or"), "a, b or c");
    }
}
