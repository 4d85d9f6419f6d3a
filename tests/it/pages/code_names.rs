//! Names and paths of the code that the pages mention, against the sources.

use super::{pages, root};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The words of each Rust source, by its path in the repository.
struct Sources(BTreeMap<PathBuf, BTreeSet<String>>);

impl Sources {
    fn read() -> Self {
        let mut files = BTreeMap::new();
        for folder in ["src", "tests", "benches", "examples", "fuzz", "build.rs"] {
            collect(&root().join(folder), &mut files);
        }
        Self(files)
    }

    /// The sources of a module, of the library or of the tests, or all where there is no such module.
    fn of<'a>(&'a self, module: &str) -> Vec<&'a BTreeSet<String>> {
        let roots = ["src", "tests/it"].map(|root| Path::new(root).join(module));
        let inside = |path: &Path| {
            roots.iter().any(|root| path.starts_with(root) || *path == root.with_extension("rs"))
        };
        let chosen: Vec<_> =
            self.0.iter().filter(|(path, _)| inside(path)).map(|(_, words)| words).collect();
        if chosen.is_empty() { self.0.values().collect() } else { chosen }
    }

    /// What is wrong with a name or path, if anything is: `geom::Chart`, `Chart::ray`, `mesh/mod.rs::mesh`.
    fn fault(&self, code: &str) -> Option<String> {
        if let Some((path, rest)) = code.split_once(".rs") {
            let path = PathBuf::from(format!("{path}.rs"));
            let known: Vec<_> = self.0.iter().filter(|(known, _)| known.ends_with(&path)).collect();
            if known.is_empty() {
                return Some("no such file".into());
            }
            let mut names = rest.split("::").filter(|name| !name.is_empty());
            let absent = |name: &&str| !known.iter().any(|(_, words)| words.contains(*name));
            return names.find(absent).map(|name| format!("no `{name}` in it"));
        }
        let names: Vec<&str> = code.split("::").collect();
        let inside = self.of(names[0]);
        let missing = |name: &&&str| !inside.iter().any(|words| words.contains(**name));
        let named = if inside.len() == self.0.len() { &names[..] } else { &names[1..] };
        named.iter().find(missing).map(|name| format!("no `{name}`"))
    }
}

fn collect(path: &Path, files: &mut BTreeMap<PathBuf, BTreeSet<String>>) {
    if path.is_dir() {
        for entry in std::fs::read_dir(path).unwrap() {
            let path = entry.unwrap().path();
            if path.file_name().is_none_or(|name| name != "target") {
                collect(&path, files);
            }
        }
    } else if path.extension().is_some_and(|e| e == "rs") {
        let text = std::fs::read_to_string(path).unwrap();
        let words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
        let words = words.filter(|word| !word.is_empty()).map(str::to_owned).collect();
        files.insert(path.strip_prefix(root()).unwrap().to_owned(), words);
    }
}

/// The spans of code of a page's text that look like a Rust name or path.
fn rust_names(page: &str) -> Vec<&str> {
    let spans = page.split('`').skip(1).step_by(2);
    let is_name = |code: &&str| {
        let plain = code.chars().all(|c| c.is_alphanumeric() || "_:/.".contains(c));
        let file = code.split("::").next().is_some_and(|first| first.ends_with(".rs"));
        plain && (file || (code.contains("::") && !code.contains(['/', '.'])))
    };
    let outside = |code: &&str| !["std", "cargo"].contains(&code.split("::").next().unwrap());
    spans.filter(is_name).filter(outside).filter(|code| !code.contains("NAME")).collect()
}

#[test]
fn every_name_of_the_code_on_a_page_is_in_the_code() {
    let sources = Sources::read();
    let mut faults = Vec::new();
    let mut names = 0;
    for (path, page) in pages() {
        let page: String = page.split("```").step_by(2).collect();
        for code in rust_names(&page) {
            names += 1;
            let fault = sources.fault(code);
            faults.extend(fault.map(|why| format!("{}: `{code}`: {why}", path.display())));
        }
    }
    assert!(names > 200, "{names} names: the pages are not read");
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

#[test]
fn stale_names_are_found() {
    let sources = Sources::read();
    assert_eq!(sources.fault("geom::Chart"), None);
    assert_eq!(sources.fault("geom/chart.rs::view"), None);
    assert!(sources.fault("geom::Profile").is_some() && sources.fault("geom/charts.rs").is_some());
    assert!(sources.fault(concat!("Chart::no_such_", "thing")).is_some());
    assert_eq!(
        rust_names("`a::b` and `c.d`, `e/f.rs`, `g.rs::h`, `i = 1`, `std::fs`"),
        ["a::b", "e/f.rs", "g.rs::h"]
    );
}
