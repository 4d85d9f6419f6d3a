//! Just enough Rust to find the paths in a source file.

use std::ops::Range;

/// Blanks comments and literals, keeping every line break and byte position.
pub fn blank(source: &str) -> String {
    let s = source.as_bytes();
    let mut out = s.to_vec();
    let mut i = 0;
    while i < s.len() {
        let end = match s[i] {
            b'/' if s[i..].starts_with(b"//") => find(s, i, b"\n").unwrap_or(s.len()),
            b'/' if s[i..].starts_with(b"/*") => end_of_block_comment(s, i),
            b'"' => end_of_string(s, i),
            b'r' if i == 0 || !is_word(s[i - 1]) || s[i - 1] == b'b' || s[i - 1] == b'c' => {
                end_of_raw_string(s, i).unwrap_or(i)
            }
            b'\'' => end_of_char(source, i).unwrap_or(i),
            _ => i,
        };
        for byte in &mut out[i..end] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
        i = end.max(i + 1);
    }
    String::from_utf8(out).expect("blanked text is UTF-8 again")
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte >= 0x80
}

fn find(s: &[u8], from: usize, what: &[u8]) -> Option<usize> {
    let at = s[from..].windows(what.len()).position(|w| w == what)?;
    Some(from + at)
}

fn end_of_block_comment(s: &[u8], start: usize) -> usize {
    let (mut i, mut depth) = (start + 2, 1);
    while i < s.len() && depth > 0 {
        match &s[i..] {
            [b'/', b'*', ..] => (i, depth) = (i + 2, depth + 1),
            [b'*', b'/', ..] => (i, depth) = (i + 2, depth - 1),
            _ => i += 1,
        }
    }
    i
}

fn end_of_string(s: &[u8], start: usize) -> usize {
    let mut i = start + 1;
    while i < s.len() && s[i] != b'"' {
        i += if s[i] == b'\\' { 2 } else { 1 };
    }
    (i + 1).min(s.len())
}

fn end_of_raw_string(s: &[u8], start: usize) -> Option<usize> {
    let hashes = s[start + 1..].iter().take_while(|b| **b == b'#').count();
    let quote = start + 1 + hashes;
    if s.get(quote) != Some(&b'"') {
        return None;
    }
    let close = [b"\"".as_slice(), &b"#".repeat(hashes)].concat();
    Some(find(s, quote + 1, &close).map_or(s.len(), |at| at + close.len()))
}

/// `None` for a lifetime.
fn end_of_char(source: &str, start: usize) -> Option<usize> {
    let mut rest = source[start + 1..].char_indices();
    let close = match rest.next()?.1 {
        '\\' => rest.skip(1).find(|(_, c)| *c == '\'')?,
        _ => rest.next().filter(|(_, c)| *c == '\'')?,
    };
    Some(start + 1 + close.0 + 1)
}

#[derive(Debug, PartialEq, Clone)]
pub struct Token<'a> {
    text: &'a str,
    at: usize,
}

/// Words, `::` and single characters of blanked text.
pub fn tokens(code: &str) -> Vec<Token<'_>> {
    let s = code.as_bytes();
    let mut out = Vec::new();
    let mut i = 0;
    while i < s.len() {
        let at = i;
        if is_word(s[i]) {
            while i < s.len() && is_word(s[i]) {
                i += 1;
            }
        } else if s[i..].starts_with(b"::") {
            i += 2;
        } else {
            i += 1;
        }
        if !code[at..i].trim().is_empty() {
            let text = &code[at..i];
            out.push(Token { text, at });
        }
    }
    out
}

/// Index after the group that opens at `open`.
fn after_group(t: &[Token], open: usize) -> usize {
    let mut depth = 0;
    for (i, token) in t.iter().enumerate().skip(open) {
        match token.text {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return i + 1;
        }
    }
    t.len()
}

fn starts_with(t: &[Token], pattern: &[&str]) -> bool {
    t.len() >= pattern.len() && t.iter().zip(pattern).all(|(t, p)| t.text == *p)
}

/// Token ranges of items under `#[cfg(test)]`.
fn test_items(t: &[Token]) -> Vec<Range<usize>> {
    if starts_with(t, &["#", "!", "[", "cfg", "(", "test", ")", "]"]) {
        return std::iter::once(0..t.len()).collect();
    }
    let mut out = Vec::new();
    let mut i = 0;
    while i < t.len() {
        let start = i;
        i += 1;
        if starts_with(&t[start..], &["#", "[", "cfg", "(", "test", ")", "]"]) {
            i = start + 7;
            while i < t.len() && t[i].text != ";" {
                let group = matches!(t[i].text, "{" | "(" | "[");
                let body = t[i].text == "{";
                i = if group { after_group(t, i) } else { i + 1 };
                if body {
                    break;
                }
            }
            if i < t.len() && t[i].text == ";" {
                i += 1;
            }
            out.push(start..i);
        }
    }
    out
}

/// Names of modules declared `#[cfg(test)] mod name;`: their files are test code.
pub fn test_files<'a>(t: &[Token<'a>]) -> Vec<&'a str> {
    let declared = |item: &Range<usize>| {
        let item = &t[item.clone()];
        let at = item.iter().position(|t| t.text == "mod")?;
        let semicolon = item.get(at + 2)?;
        (semicolon.text == ";").then_some(item[at + 1].text)
    };
    test_items(t).iter().filter_map(declared).collect()
}

/// A path that leaves the file: the first name after its root, and where.
#[derive(Debug, PartialEq, Clone)]
pub struct Named {
    pub name: String,
    pub line: usize,
    pub in_test: bool,
    pub is_macro: bool,
}

fn line_of(code: &str, at: usize) -> usize {
    code.as_bytes()[..at].iter().filter(|b| **b == b'\n').count() + 1
}

/// Names that follow `::` at `i`: one, or each member of a group.
fn members<'a, 'b>(t: &'b [Token<'a>], i: usize) -> Vec<&'b Token<'a>> {
    if t.get(i).is_none_or(|t| t.text != "{") {
        return t.get(i).into_iter().collect();
    }
    let end = after_group(t, i) - 1;
    let mut out = Vec::new();
    let mut j = i + 1;
    while j < end {
        out.push(&t[j]);
        while j < end && t[j].text != "," {
            let group = t[j].text == "{";
            j = if group { after_group(t, j) } else { j + 1 };
        }
        j += 1;
    }
    out
}

/// Every name reached through one of `roots` (`crate`, `std`, ...), and through chains of `super`
/// that climb out of a file lying `depth` modules below the crate root (0: do not follow them).
pub fn names_under(source: &str, roots: &[&str], depth: usize) -> Vec<Named> {
    let code = blank(source);
    let t = tokens(&code);
    let tests = test_items(&t);
    let mut out = Vec::new();
    let mut inline_modules: Vec<usize> = Vec::new();
    for i in 0..t.len() {
        inline_modules.retain(|end| i < *end);
        if starts_with(&t[i..], &["mod"]) && t.get(i + 2).is_some_and(|t| t.text == "{") {
            inline_modules.push(after_group(&t, i + 2));
        }
        let inside_path = i > 0 && t[i - 1].text == "::";
        let after = if roots.contains(&t[i].text) && starts_with(&t[i + 1..], &["::"]) {
            // `::std::x` starts with `::`, `other::std::x` is something else.
            if inside_path && i > 1 && is_word(t[i - 2].text.as_bytes()[0]) {
                continue;
            }
            i + 2
        } else if depth > 0 && t[i].text == "super" && !inside_path {
            let (mut j, mut climbed) = (i, 0);
            while starts_with(&t[j..], &["super", "::"]) {
                (j, climbed) = (j + 2, climbed + 1);
            }
            if climbed < depth + inline_modules.len() {
                continue;
            }
            j
        } else {
            continue;
        };
        for token in members(&t, after) {
            out.push(Named {
                name: token.text.to_owned(),
                line: line_of(&code, token.at),
                in_test: tests.iter().any(|r| r.contains(&i)),
                is_macro: code[token.at + token.text.len()..].starts_with('!'),
            });
        }
    }
    out
}

/// An item that a file defines.
#[derive(Debug, PartialEq, Clone)]
pub struct Definition<'a> {
    pub name: &'a str,
    /// `pub`, with or without a restriction.
    pub is_public: bool,
    /// A struct, enum, trait, union or type alias.
    pub is_type: bool,
    pub in_test: bool,
}

/// All types, functions, constants and modules that a file defines, wherever they stand in it.
pub fn definitions<'a>(t: &[Token<'a>]) -> Vec<Definition<'a>> {
    let tests = test_items(t);
    let mut out = Vec::new();
    for i in 0..t.len() {
        let is_type = ["struct", "enum", "trait", "union", "type"].contains(&t[i].text);
        let is_other = ["fn", "const", "static", "mod"].contains(&t[i].text);
        let name = t.get(i + 1).map_or("", |t| t.text);
        let named = name.starts_with(|c: char| c.is_alphabetic());
        if !(is_type || is_other) || !named || matches!(name, "fn" | "unsafe" | "mut") {
            continue;
        }
        let before = &t[..i];
        let is_public = match before.last().map(|t| t.text) {
            Some("pub") => true,
            Some(")") => before.iter().rev().take(8).any(|t| t.text == "pub"),
            _ => false,
        };
        let in_test = tests.iter().any(|r| r.contains(&i));
        out.push(Definition { name, is_public, is_type, in_test });
    }
    out
}

/// The paths, in full, that a file's code outside tests names from `crate`, `super` or `self` on:
/// each member of a group is one.
pub fn imports(t: &[Token]) -> Vec<Vec<String>> {
    let tests = test_items(t);
    let mut out = Vec::new();
    let mut inline_modules: Vec<usize> = Vec::new();
    for i in 0..t.len() {
        inline_modules.retain(|end| i < *end);
        if t[i].text == "mod" && t.get(i + 2).is_some_and(|t| t.text == "{") {
            inline_modules.push(after_group(t, i + 2));
        }
        let begins = i == 0 || t[i - 1].text != "::";
        let used = i > 0 && t[i - 1].text == "use";
        let rooted = ["crate", "super", "self"].contains(&t[i].text)
            && t.get(i + 1).is_some_and(|t| t.text == "::");
        let in_test = tests.iter().any(|r| r.contains(&i));
        if begins && (rooted || used) && !in_test && inline_modules.is_empty() {
            let prefix = if rooted { Vec::new() } else { vec!["self".to_owned()] };
            full_paths(t, i, &prefix, &mut out);
        }
    }
    out
}

/// The paths that go on from `prefix` at token `i`.
fn full_paths(t: &[Token], mut i: usize, prefix: &[String], out: &mut Vec<Vec<String>>) {
    let mut path = prefix.to_vec();
    loop {
        if t.get(i).is_some_and(|t| t.text == "{") {
            let end = after_group(t, i) - 1;
            let mut at = i + 1;
            while at < end {
                full_paths(t, at, &path, out);
                while at < end && t[at].text != "," {
                    at = if t[at].text == "{" { after_group(t, at) } else { at + 1 };
                }
                at += 1;
            }
            return;
        }
        let Some(name) = t.get(i).filter(|t| is_word(t.text.as_bytes()[0])) else { break };
        if !(name.text == "self" && path.len() > prefix.len().min(1)) || path.is_empty() {
            path.push(name.text.to_owned());
        }
        if t.get(i + 1).is_none_or(|t| t.text != "::") {
            break;
        }
        i += 2;
    }
    out.push(path);
}

#[test]
fn definitions_and_imports_are_read_in_full() {
    let source = "use super::a::{self, B, c::{D, E as F}}; mod m; use m::G;
pub(super) enum H<T> { I } fn j(k: crate::l::M) { let x = self::n::O; }
#[cfg(test)] mod tests { use super::P; pub struct Q; }";
    let code = blank(source);
    let t = tokens(&code);
    let paths: Vec<String> = imports(&t).iter().map(|path| path.join("::")).collect();
    let expected = [
        "super::a",
        "super::a::B",
        "super::a::c::D",
        "super::a::c::E",
        "self::m::G",
        "crate::l::M",
    ];
    assert_eq!(paths[..6], expected);
    assert_eq!(paths[6..], ["self::n::O"]);
    let found: Vec<_> = definitions(&t).iter().map(|d| (d.name, d.is_public, d.is_type)).collect();
    assert_eq!(
        found,
        [
            ("m", false, false),
            ("H", true, true),
            ("j", false, false),
            ("tests", false, false),
            ("Q", true, true)
        ]
    );
}

#[test]
fn comments_and_literals_are_blanked() {
    let source = r###"a /* b /* c */ d */ e // f
"g \" h" 'i' '\'' b'j' '\u{e9}' 'é' &'k l r"m\" r#"n " o"# br##"p"# q"## s"###;
    let words: Vec<String> = blank(source).split_whitespace().map(str::to_owned).collect();
    assert_eq!(words, ["a", "e", "b", "&'k", "l", "b", "s"]);
    assert_eq!(blank(source).len(), source.len());
    assert_eq!(blank(source).find('\n'), source.find('\n'));
}

#[test]
fn names_are_found_wherever_a_path_may_stand() {
    let source = "
use crate::num;
use crate::{geom::{Ray, mesh_like}, optics as o, mirror::*};
pub(crate) fn f() -> crate::design::D { $crate::mesh::new(other::crate_::x) }
// use crate::solid;
fn g() { \"crate::export\"; ::std::fs::read(p); my::std::env::x() }
";
    let found = |roots: &[&str]| -> Vec<(String, usize)> {
        let names = names_under(source, roots, 0).into_iter();
        names.map(|n| (n.name, n.line)).collect()
    };
    let expected =
        [("num", 2), ("geom", 3), ("optics", 3), ("mirror", 3), ("design", 4), ("mesh", 4)];
    assert_eq!(found(&["crate"]), expected.map(|(n, l)| (n.to_owned(), l)));
    assert_eq!(found(&["std"]), [("fs".to_owned(), 6)]);
}

#[test]
fn chains_of_super_are_followed_out_of_the_module() {
    let found = |source: &str, depth| -> Vec<String> {
        let names = names_under(source, &["crate"], depth).into_iter();
        names.map(|n| n.name).collect()
    };
    assert_eq!(found("use super::mesh::M;", 1), ["mesh"]);
    assert_eq!(found("use super::sibling::S;", 2), [""; 0]);
    assert_eq!(found("use super::super::{mesh, solid};", 2), ["mesh", "solid"]);
    assert_eq!(found("mod inner { use super::own; } use super::mesh;", 1), ["mesh"]);
    assert_eq!(found("pub(super) fn f() {}", 1), [""; 0]);
}
