//! Reads the sources and holds them to the direction of dependencies: who may use whom, who may
//! touch files, how long a file may grow.

mod circles;
mod reading;
mod words;

use reading::{blank, names_under, test_files, tokens};
use std::fs;
use std::path::{Path, PathBuf};

/// Stands for every module earlier in the table.
const ALL_ABOVE: &[&str] = &["..."];

/// Each module and what it may use, lowest first.
const TABLE: &[(&str, &[&str])] = &[
    ("parallel", &[]),
    ("num", &["parallel"]),
    ("sheet", &[]),
    ("packed_text", &[]),
    ("tolerance_terms", &["num"]),
    ("geom", &["num", "parallel"]),
    ("raster", &["num"]),
    ("video", &["raster"]),
    ("optics", &["geom", "num", "parallel"]),
    ("profile", &["tolerance_terms", "optics", "geom", "packed_text", "raster", "sheet", "num"]),
    ("publish", &["profile", "parallel"]),
    ("mirror", &["geom", "num", "parallel"]),
    ("brep", &["geom", "num", "parallel"]),
    ("solid", &["geom", "num", "parallel"]),
    ("forming", &["solid", "profile", "mirror", "geom", "num", "parallel"]),
    ("design", &["forming", "profile", "optics", "mirror", "num", "geom", "parallel"]),
    ("mesh", &["mirror", "optics", "geom", "num", "parallel"]),
    ("export", &["forming", "solid", "mirror", "geom", "num", "parallel"]),
    ("trace", &["brep", "geom", "optics", "num", "parallel"]),
    ("align", &["mirror", "optics", "geom", "num", "parallel"]),
    (
        "tolerance",
        &["tolerance_terms", "profile", "mirror", "optics", "trace", "geom", "num", "parallel"],
    ),
    ("program", &["geom", "num", "parallel"]),
    ("inspection", &["tolerance", "align", "mirror", "geom", "num", "parallel"]),
    ("machining", &["mirror", "optics", "trace", "geom", "num", "parallel"]),
    ("milling", &["machining", "profile", "mirror", "geom", "num", "parallel"]),
    ("turning", &["milling", "profile", "mirror", "geom", "num", "parallel"]),
    ("pencil", &["mirror", "optics", "geom", "num", "parallel"]),
    ("render", &["design", "mirror", "trace", "optics", "geom", "raster", "num", "parallel"]),
    ("unwrap", &["mirror", "optics", "video", "raster", "geom", "num", "parallel"]),
    ("lookup", &["raster", "geom", "num", "parallel"]),
    ("results", ALL_ABOVE),
    ("drawing", &["results", "render", "trace", "profile", "solid", "sheet", "geom", "num"]),
    ("part", ALL_ABOVE),
    ("verdict", ALL_ABOVE),
    ("report", ALL_ABOVE),
    ("pipeline", ALL_ABOVE),
    ("bench", ALL_ABOVE),
    ("sweep", ALL_ABOVE),
    ("studio", ALL_ABOVE),
    (
        "cli",
        &[
            "bench",
            "packed_text",
            "parallel",
            "pipeline",
            "profile",
            "report",
            "results",
            "studio",
            "sweep",
        ],
    ),
    ("front", &["pipeline", "profile", "results", "sweep"]),
    ("internals", ALL_ABOVE),
    ("main", &["internals"]),
];

/// The witness knows nothing of the design, in its tests too.
const TRACE_NEVER: &[&str] = &["mirror", "design", "mesh", "solid", "export"];

/// The threads' library, beside `parallel`: the size of the pool.
const MAY_NAME_RAYON: &[&str] = &["parallel", "bench"];
const MAY_TOUCH_THE_SYSTEM: &[&str] = &["publish", "pipeline", "bench", "studio", "cli", "main"];
const MAX_LINES: usize = 500;

/// The sources speak of the project alone.
const BANNED_WORDS: &[&str] = &["issue #", "session", "sessions"];

fn row(module: &str) -> Option<usize> {
    TABLE.iter().position(|(name, _)| *name == module)
}

fn may_use(user: usize, used: usize) -> bool {
    let allowed = TABLE[user].1;
    user == used || allowed.contains(&TABLE[used].0) || (allowed == ALL_ABOVE && used < user)
}

/// Complaints about the paths in one file that lies `depth` modules below the crate root;
/// `all_test`: the whole file is test code.
fn path_complaints(
    file: &str,
    module: &str,
    depth: usize,
    source: &str,
    all_test: bool,
) -> Vec<String> {
    let Some(user) = row(module) else {
        return vec![format!("{file}:1: module `{module}` is not in the table")];
    };
    let mut out = Vec::new();
    for used in names_under(source, &["crate", "morion"], depth) {
        let (name, line) = (used.name.as_str(), used.line);
        let in_test = used.in_test || all_test;
        let blinds_witness = module == "trace" && (name == "*" || TRACE_NEVER.contains(&name));
        let why = match row(name) {
            _ if blinds_witness => "forbidden, even in tests",
            _ if in_test => continue,
            Some(used) if may_use(user, used) => continue,
            Some(_) => "forbidden",
            None => "not a module of the table",
        };
        out.push(format!("{file}:{line}: {module} -> {name}: {why}"));
    }
    if all_test {
        return out;
    }
    if !MAY_NAME_RAYON.contains(&module) {
        let named = names_under(source, &["rayon"], 0).into_iter().filter(|used| !used.in_test);
        out.extend(named.map(|used| format!("{file}:{}: {module} -> rayon: forbidden", used.line)));
    }
    if MAY_TOUCH_THE_SYSTEM.contains(&module) {
        return out;
    }
    for used in names_under(source, &["std"], 0) {
        let system = ["fs", "env", "process", "*"].contains(&used.name.as_str());
        if system && !used.in_test && !used.is_macro {
            let (name, line) = (used.name, used.line);
            out.push(format!("{file}:{line}: {module} -> std::{name}: forbidden"));
        }
    }
    out
}

fn text_complaints(file: &str, source: &str) -> Vec<String> {
    let mut out = Vec::new();
    for (i, line) in source.lines().enumerate() {
        let line = line.to_lowercase();
        for word in BANNED_WORDS.iter().filter(|w| has_word(&line, w)) {
            out.push(format!("{file}:{}: speaks of `{word}`", i + 1));
        }
    }
    let lines = source.lines().count();
    if lines > MAX_LINES {
        out.push(format!("{file}: {lines} lines, more than {MAX_LINES}"));
    }
    out
}

fn has_word(line: &str, word: &str) -> bool {
    let edge = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
    line.match_indices(word).any(|(at, _)| {
        let after = line[at + word.len()..].chars().next();
        edge(line[..at].chars().next_back()) && (word.ends_with('#') || edge(after))
    })
}

fn rust_files(folder: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = fs::read_dir(folder)
        .expect("readable folder")
        .map(|e| e.expect("readable entry").path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            rust_files(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

/// Module path of a file below `src`: `a/b.rs` and `a/b/mod.rs` are both `["a", "b"]`.
fn module_path(relative: &Path) -> Vec<String> {
    let mut parts: Vec<String> =
        relative.with_extension("").iter().map(|p| p.to_string_lossy().into_owned()).collect();
    if parts.last().is_some_and(|p| p == "mod") {
        parts.pop();
    }
    parts
}

/// A file of the library and the program.
struct SourceFile {
    /// Its path in the repository.
    file: String,
    /// Its module path.
    path: Vec<String>,
    text: String,
    /// Whether all of it is test code.
    all_test: bool,
}

/// All files below `src`.
fn sources() -> Vec<SourceFile> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut paths = Vec::new();
    rust_files(&src, &mut paths);
    let read = |path: &PathBuf| {
        let relative = path.strip_prefix(&src).expect("below src");
        let text = fs::read_to_string(path).expect("readable source");
        let file = format!("src/{}", relative.display());
        SourceFile { file, path: module_path(relative), text, all_test: false }
    };
    let mut files: Vec<SourceFile> = paths.iter().map(read).collect();
    let mut test_modules: Vec<Vec<String>> = Vec::new();
    for SourceFile { path, text, .. } in &files {
        for name in test_files(&tokens(&blank(text))) {
            let root = if path == &["lib"] { &[][..] } else { path };
            test_modules.push([root, &[name.to_owned()]].concat());
        }
    }
    for source in &mut files {
        source.all_test = test_modules.iter().any(|m| source.path.starts_with(m));
    }
    files
}

#[test]
fn sources_keep_the_direction_of_dependencies() {
    let files = sources();
    assert!(files.iter().any(|source| source.path == ["lib"]), "no src/lib.rs");
    let mut failures = Vec::new();
    for SourceFile { file, path, text, all_test } in &files {
        failures.extend(text_complaints(file, text));
        let root = path == &["lib"] || (*all_test && path.len() == 1);
        if !root {
            failures.extend(path_complaints(file, &path[0], path.len(), text, *all_test));
        }
    }
    assert!(failures.is_empty(), "\n{}\n", failures.join("\n"));
}

fn complaints_in(module: &str, source: &str) -> Vec<String> {
    path_complaints("f.rs", module, 1, source, false)
}

#[test]
fn the_table_points_downward() {
    for (user, (name, allowed)) in TABLE.iter().enumerate() {
        for used in allowed.iter().filter(|u| **u != ALL_ABOVE[0]) {
            let below = row(used).is_some_and(|r| r < user);
            assert!(below, "{name} -> {used} does not point to an earlier row");
        }
    }
    let trace = row("trace").unwrap();
    for never in TRACE_NEVER {
        assert!(!may_use(trace, row(never).unwrap()), "trace -> {never}");
    }
}

#[test]
fn forbidden_edges_are_reported_with_their_line() {
    let found = complaints_in("optics", "use crate::geom;\nuse crate::mesh::M;\n");
    assert_eq!(found, ["f.rs:2: optics -> mesh: forbidden"]);
    let found = complaints_in("cli", "fn f() { crate::geom::g() }");
    assert_eq!(found, ["f.rs:1: cli -> geom: forbidden"]);
    assert_eq!(complaints_in("main", "use morion::{internals, num};").len(), 1);
    assert_eq!(complaints_in("num", "use crate::*;").len(), 1);
    assert_eq!(complaints_in("num", "use crate::stray::S;").len(), 1);
    assert_eq!(complaints_in("stray", "").len(), 1);
    assert_eq!(complaints_in("report", "use crate::{mesh, num, report};"), [""; 0]);
    assert_eq!(complaints_in("report", "use crate::pipeline;").len(), 1);
}

#[test]
fn tests_may_look_wider_but_not_those_of_the_witness() {
    let source = "fn f() {}\n#[cfg(test)]\nmod tests {\nuse super::*;\nuse crate::design::D;\n}\n";
    assert_eq!(complaints_in("geom", source), [""; 0]);
    let found = complaints_in("trace", source);
    assert_eq!(found, ["f.rs:5: trace -> design: forbidden, even in tests"]);
    let after = format!("{source}use crate::solid;");
    assert_eq!(complaints_in("geom", &after), ["f.rs:7: geom -> solid: forbidden"]);
    let one_use = "#[cfg(test)]\nuse crate::design;\nuse crate::mesh;";
    assert_eq!(complaints_in("geom", one_use).len(), 1);
    assert_eq!(test_files(&tokens("#[cfg(test)] mod sweep; mod plain;")), ["sweep"]);
}

#[test]
fn the_system_is_for_the_pipeline_and_the_command_line() {
    for source in
        ["use std::fs;", "use std::{io, env};", "fn f() { std::process::exit(1) }", "use std::*;"]
    {
        assert_eq!(complaints_in("export", source).len(), 1, "{source}");
        assert_eq!(complaints_in("pipeline", source), [""; 0]);
    }
    let harmless = "const A: &str = env!(\"A\"); const B: &str = std::env!(\"B\"); use std::io;";
    assert_eq!(complaints_in("export", harmless), [""; 0]);
    let test = "#[cfg(test)] mod tests { use std::fs; }";
    assert_eq!(complaints_in("export", test), [""; 0]);
}

#[test]
fn long_files_and_stray_words_are_reported() {
    let found = text_complaints("f.rs", &"\n".repeat(501));
    assert_eq!(found, ["f.rs: 501 lines, more than 500"]);
    assert_eq!(text_complaints("f.rs", &"\n".repeat(500)), [""; 0]);
    let found = text_complaints("f.rs", "ok\n// see Issue #12\n// this session\n");
    assert_eq!(found, ["f.rs:2: speaks of `issue #`", "f.rs:3: speaks of `session`"]);
    assert_eq!(text_complaints("f.rs", "obsession, tissue #1, issued"), [""; 0]);
}
