//! The pages of docs/ against the program: links, profiles, and the tables of keys.

mod code_names;
mod report_keys;
mod schema_keys;

use morion::internals::profile::Profile;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// README, CONTRIBUTING and the pages of docs/, by their paths.
fn pages() -> BTreeMap<PathBuf, String> {
    let docs = std::fs::read_dir(root().join("docs")).unwrap();
    let docs = docs.map(|entry| entry.unwrap().path());
    let pages = docs.filter(|path| path.extension().is_some_and(|e| e == "md"));
    let others = ["README.md", "CONTRIBUTING.md"].map(|name| root().join(name));
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        (path, text)
    };
    pages.chain(others).map(read).collect()
}

/// What a forge makes of a heading in the address of a page.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

/// The headings of a page, outside of its blocks of code.
fn headings(page: &str) -> Vec<String> {
    let mut code = false;
    let mut found = Vec::new();
    for line in page.lines() {
        code ^= line.starts_with("```");
        if !code && line.starts_with('#') {
            found.push(anchor(line.trim_start_matches('#')));
        }
    }
    found
}

/// The targets of a page's links and pictures.
fn links(page: &str) -> impl Iterator<Item = &str> {
    page.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target)
}

#[test]
fn every_link_between_pages_leads_somewhere() {
    let pages = pages();
    let mut dead = Vec::new();
    for (path, page) in &pages {
        for link in links(page).filter(|link| !link.contains("://")) {
            let (file, place) = link.split_once('#').unwrap_or((link, ""));
            let target = match file {
                "" => path.clone(),
                file => path.parent().unwrap().join(file),
            };
            let Ok(target) = target.canonicalize() else {
                dead.push(format!("{}: {link}", path.display()));
                continue;
            };
            let heading = || headings(&pages[&target]).iter().any(|heading| heading == place);
            if !place.is_empty() && !heading() {
                dead.push(format!("{}: {link}: no such heading", path.display()));
            }
        }
    }
    assert!(dead.is_empty(), "{}", dead.join("\n"));
}

#[test]
fn every_picture_is_shown_on_a_page() {
    let pages = pages();
    let shown: Vec<&str> = pages.values().flat_map(|page| links(page)).collect();
    for entry in std::fs::read_dir(root().join("docs/images")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(shown.iter().any(|link| link.ends_with(&format!("images/{name}"))), "{name}");
    }
}

#[test]
fn every_page_is_in_the_summary() {
    let summary = std::fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let listed: Vec<&str> = links(&summary).collect();
    for path in pages().keys().filter(|path| path.parent() == Some(&root().join("docs"))) {
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(name == "SUMMARY.md" || listed.contains(&name), "{name} is not in SUMMARY.md");
    }
}

/// The blocks of a page in a language.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    page.split(&fence).skip(1).filter_map(|rest| rest.split_once("```")).map(|b| b.0).collect()
}

/// A profile begins with its summary; other blocks of TOML are a part of one.
#[test]
fn every_profile_on_a_page_is_valid() {
    let mut profiles = 0;
    for (path, page) in pages() {
        for block in blocks(&page, "toml").into_iter().filter(|b| b.starts_with("summary = ")) {
            let name = path.display().to_string();
            let read = Profile::parse("page", &name, block.as_bytes());
            read.unwrap_or_else(|error| panic!("{name}:\n{error}\n{block}"));
            profiles += 1;
        }
    }
    assert!(profiles >= 6, "{profiles} profiles");
}
