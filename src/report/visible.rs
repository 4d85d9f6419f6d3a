//! Text from outside (names of files, profiles and parts of packages, summaries) as it may be shown:
//! what steers a terminal or turns the direction of text is written out.

/// `text` with each character that steers a terminal or the direction of text as \u{...}; lines stay.
#[must_use]
pub fn visible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if steers(c) {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// Controls but for the line's end, and what Unicode has to end lines and to change directions.
fn steers(c: char) -> bool {
    let turns = matches!(
        c,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    );
    (c.is_control() && c != '\n') || turns || matches!(c, '\u{2028}' | '\u{2029}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_is_written_out() {
        let text = "a\u{1b}[2Jb\u{7}\0\r\u{9b}1m\u{202e}c\nd \u{e9} \u{4e2d}";
        let shown = "a\\u{1b}[2Jb\\u{7}\\u{0}\\u{d}\\u{9b}1m\\u{202e}c\nd \u{e9} \u{4e2d}";
        assert_eq!(visible(text), shown);
    }
}
