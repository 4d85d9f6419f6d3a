//! README against the program.

use crate::support::shipped_builds;
use morion::internals::export::read_stl;
use morion::internals::report::{Answer, TextLayout};

const README: &str = include_str!("../../README.md");

/// The first block of code in README after `heading`, fenced as `language`.
fn block<'a>(heading: &str, language: &str) -> &'a str {
    let (_, after) = README.split_once(heading).unwrap_or_else(|| panic!("no {heading:?}"));
    let fence = format!("```{language}\n");
    let (_, block) = after.split_once(&fence).unwrap_or_else(|| panic!("no {language} block"));
    block.split_once("```").expect("the block ends").0
}

#[test]
fn the_output_that_readme_shows_is_the_program_s() {
    let layout = TextLayout { columns: Some(80), details: false, folder: Some("out/conquistador") };
    let made = shipped_builds::report("conquistador").laid_out(&layout);
    assert_eq!(
        block("## Two commands", "text"),
        made,
        "README shows other output than this:\n{made}"
    );
}

#[test]
fn the_size_that_readme_tells_is_the_part_s() {
    let path = shipped_builds::folder().join("conquistador/mirror.stl");
    let part = read_stl(&std::fs::read(path).unwrap()).unwrap().mesh;
    let (lowest, highest) = part.bounds().unwrap();
    let size = highest - lowest;
    let told = format!("a part of {} x {} x {:.1} mm", size.x, size.y, size.z);
    assert!(README.contains(&told), "{told}");
}

#[test]
fn readme_is_two_pages() {
    let lines = README.lines().count();
    assert!(lines <= 150, "{lines} lines");
}
