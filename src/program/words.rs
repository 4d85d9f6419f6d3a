//! Words of a line of a program: a letter and a number each.

use super::ProgramFault;

/// A word, as in `X-12.5`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Word {
    /// Its letter, in upper case.
    pub letter: char,
    /// Its number.
    pub number: f64,
}

/// Longest line that is read, bytes: that of LinuxCNC (`LINELEN`).
const LONGEST: usize = 255;

/// The words of a line without its comments; none from a lone `%` on.
///
/// # Errors
/// [`ProgramFault::Syntax`] where there is something else, by its name, and [`ProgramFault::Long`].
pub(super) fn words(line: u32, text: &str) -> Result<Vec<Word>, ProgramFault> {
    if text.len() > LONGEST {
        return Err(ProgramFault::Long { line, most: LONGEST });
    }
    let mut words = Vec::new();
    let syntax = |found: String| ProgramFault::Syntax { line, found };
    let mut rest = text.trim();
    if rest.starts_with('%') {
        return Ok(words);
    }
    while let Some(first) = rest.chars().next() {
        match first {
            ';' => break,
            '(' => {
                let (_, after) = rest
                    .split_once(')')
                    .ok_or_else(|| syntax("a comment without its closing parenthesis".into()))?;
                rest = after;
            }
            space if space.is_whitespace() => rest = &rest[space.len_utf8()..],
            letter if letter.is_ascii_alphabetic() => {
                let (number, after) = number(rest[1..].trim_start())
                    .ok_or_else(|| syntax(format!("{letter} without a number")))?;
                words.push(Word { letter: letter.to_ascii_uppercase(), number });
                rest = after;
            }
            '#' => return Err(syntax("a parameter, #".into())),
            '[' => return Err(syntax("an expression, [".into())),
            '/' => return Err(syntax("an optional block, /".into())),
            other => return Err(syntax(format!("{other:?}"))),
        }
    }
    Ok(words)
}

/// The decimal number that a text begins with, without an exponent, and the text after it.
fn number(text: &str) -> Option<(f64, &str)> {
    let is_sign = text.starts_with(['+', '-']);
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let end = text[usize::from(is_sign)..].find(|c| !is_part(c));
    let end = end.map_or(text.len(), |end| end + usize::from(is_sign));
    let number: f64 = text[..end].parse().ok()?;
    number.is_finite().then_some((number, &text[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<(char, f64)> {
        words(1, text).unwrap().iter().map(|word| (word.letter, word.number)).collect()
    }

    #[test]
    fn words_are_letters_with_decimal_numbers() {
        assert_eq!(
            read("g1x-1.25 Y+.5(to X9) Z3. ; F2"),
            [('G', 1.0), ('X', -1.25), ('Y', 0.5), ('Z', 3.0)]
        );
        assert_eq!(read("G 90.1"), [('G', 90.1)]);
        assert_eq!((read("%"), read("  ")), (vec![], vec![]));
    }

    #[test]
    fn what_is_no_word_is_named() {
        let named = |text: &str| words(7, text).unwrap_err().to_string();
        assert_eq!(named("G1 X#3"), "line 7: X without a number; decimal numbers alone are read");
        assert_eq!(named("#3 = 5"), "line 7: a parameter, #; decimal numbers alone are read");
        assert!(named("(open").contains("without its closing parenthesis"));
        assert!(named("G1 X1é").contains('é'));
        assert!(named(&"X1".repeat(200)).contains("longer than 255 bytes"));
        assert!(named("X1.2.3").contains("X without a number"));
    }
}
