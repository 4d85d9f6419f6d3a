//! Styles of results in terminals: a summary's name is bold, its verdict coloured.

use anstyle::{AnsiColor, Style};

/// A summary with styles; a writer that knows its terminal strips them elsewhere.
pub(super) fn styled(text: &str) -> String {
    let bold = Style::new().bold();
    let coloured = |colour: AnsiColor| bold.fg_color(Some(colour.into()));
    let mut out = String::with_capacity(text.len() + 32);
    for (k, line) in text.split_inclusive('\n').enumerate() {
        match (k, line.split_once("  (")) {
            (0, Some((name, rest))) => out.extend([&format!("{bold}{name}{bold:#}"), "  (", rest]),
            _ => match line {
                "  verdict  pass\n" => verdict(&mut out, "pass", coloured(AnsiColor::Green)),
                "  verdict  fail\n" => verdict(&mut out, "fail", coloured(AnsiColor::Red)),
                line => out.push_str(line),
            },
        }
    }
    out
}

fn verdict(out: &mut String, word: &str, style: Style) {
    out.push_str(&format!("  verdict  {style}{word}{style:#}\n"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_bold_and_verdicts_coloured() {
        let found = styled("one  (abc)\n  part  1 (2)\n  verdict  fail\n");
        assert!(found.starts_with("\u{1b}[1mone\u{1b}[0m  (abc)\n  part  1 (2)\n"), "{found:?}");
        assert!(found.contains("\u{1b}[31m") && found.ends_with("fail\u{1b}[0m\n"), "{found:?}");
        assert_eq!(styled("plain\n"), "plain\n");
    }
}
