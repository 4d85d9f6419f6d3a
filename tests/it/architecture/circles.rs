//! No two files of the library use each other, straight or through others. The face of a folder,
//! its `mod.rs`, hands names on and is left out: a name that it hands on counts as its maker's.

use super::reading::{blank, imports, tokens};
use super::{module_path, sources};
use std::collections::{BTreeMap, BTreeSet};

type Path = Vec<String>;

/// The library's files by their module paths, and where names come from that a face hands on.
struct House {
    files: BTreeMap<Path, Vec<Path>>,
    /// Files that others lie below.
    faces: BTreeSet<Path>,
}

impl House {
    /// From the paths that each file's imports name, those of `crate` alone, in full.
    fn new<'a>(sources: impl IntoIterator<Item = (Path, &'a str)>) -> Self {
        let read = |(path, text): (Path, &str)| {
            let named = imports(&tokens(&blank(text))).into_iter();
            let absolute = named.filter_map(|import| absolute(&path, import)).collect();
            (path, absolute)
        };
        let files: BTreeMap<Path, Vec<Path>> = sources.into_iter().map(read).collect();
        let above = |file: &Path| (1..file.len()).map(|n| file[..n].to_vec()).collect::<Vec<_>>();
        let faces = files.keys().flat_map(above).collect();
        Self { files, faces }
    }

    /// The file that `name`, a path from the crate's root, is defined in, as far as imports tell.
    fn home(&self, name: &[String]) -> Option<Path> {
        let depth = (1..=name.len()).rev().find(|&n| self.files.contains_key(&name[..n]))?;
        let module = name[..depth].to_vec();
        let Some(item) = name.get(depth) else { return Some(module) };
        let handed_on = |from: &&Path| from.last() == Some(item) && from[..] != name[..=depth];
        match self.files[&module].iter().find(handed_on) {
            Some(from) if self.faces.contains(&module) => self.home(from).or(Some(module)),
            _ => Some(module),
        }
    }

    /// Which file uses which, faces left out.
    fn arrows(&self) -> BTreeMap<&Path, BTreeSet<Path>> {
        let mut arrows = BTreeMap::new();
        for (file, names) in self.files.iter().filter(|(file, _)| !self.faces.contains(*file)) {
            let homes = names.iter().filter_map(|name| self.home(name));
            let used = homes.filter(|home| home != file && !self.faces.contains(home));
            arrows.insert(file, used.collect());
        }
        arrows
    }

    /// A circle of files, if there is one: each uses the next, and the last the first.
    fn circle(&self) -> Option<Vec<String>> {
        let arrows = self.arrows();
        let mut done = BTreeSet::new();
        for start in arrows.keys() {
            let mut way = Vec::new();
            if let Some(circle) = walk(&arrows, start, &mut way, &mut done) {
                return Some(circle.iter().map(|file| file.join("/")).collect());
            }
        }
        None
    }
}

/// `import`, as file `path` writes it, from the crate's root; none for other crates' names.
fn absolute(path: &[String], import: Path) -> Option<Path> {
    let climbed = import.iter().take_while(|part| *part == "super").count();
    match import[0].as_str() {
        "crate" => Some(import[1..].to_vec()),
        "self" => Some([path, &import[1..]].concat()),
        "super" => {
            let base = path.len().checked_sub(climbed)?;
            Some([&path[..base], &import[climbed..]].concat())
        }
        _ => None,
    }
}

/// Goes on from `file` along the arrows; the circle that is closed first.
fn walk(
    arrows: &BTreeMap<&Path, BTreeSet<Path>>,
    file: &Path,
    way: &mut Vec<Path>,
    done: &mut BTreeSet<Path>,
) -> Option<Vec<Path>> {
    if let Some(at) = way.iter().position(|seen| seen == file) {
        return Some(way[at..].to_vec());
    }
    if !done.insert(file.clone()) {
        return None;
    }
    way.push(file.clone());
    let found = arrows[file].iter().find_map(|next| walk(arrows, next, way, done));
    way.pop();
    found
}

#[test]
fn no_files_use_each_other() {
    let sources = sources();
    let plain = sources.iter().filter(|source| !source.all_test && source.path != ["lib"]);
    let house = House::new(plain.map(|source| (source.path.clone(), source.text.as_str())));
    let arrows: usize = house.arrows().values().map(BTreeSet::len).sum();
    assert!(arrows > 500, "{arrows} arrows: imports are not read");
    assert_eq!(house.circle(), None);
}

#[test]
fn circles_are_found_through_the_face_of_their_folder() {
    let circle = |files: &[(&str, &str)]| {
        let path = |file: &str| module_path(std::path::Path::new(file));
        House::new(files.iter().map(|(file, text)| (path(file), *text))).circle()
    };
    let face = ("a/mod.rs", "mod b; mod c; pub use b::B; pub use self::c::{C, D};");
    let b = ("a/b.rs", "use super::{C, d::E};");
    assert_eq!(circle(&[face, b, ("a/c.rs", "use std::fmt;")]), None);
    let found = Some(vec!["a/b".to_owned(), "a/c".to_owned()]);
    assert_eq!(circle(&[face, b, ("a/c.rs", "use crate::a::B;")]), found);
    assert_eq!(circle(&[face, b, ("a/c.rs", "fn f(b: &super::b::B) {}")]), found);
    let in_test = ("a/c.rs", "#[cfg(test)] mod tests { use crate::a::B; }");
    assert_eq!(circle(&[face, b, in_test]), None);
}
