//! Same profile, same bytes: on any number of threads, from any folder, into any folder.

use crate::panels::small_panels;
use crate::support::builds::{self, SMALL, edited, files, folder, lasting, morion, save, told};
use crate::support::{placeless, small_but, small_strip};
use std::collections::BTreeMap;
use std::path::Path;

/// What a build leaves behind: exit code, summary and lasting files.
type Made = (i32, String, BTreeMap<String, Vec<u8>>);

/// Builds `text` in folder `at` on `threads` threads.
fn build(at: &Path, text: &str, threads: &str) -> Made {
    save(at, text);
    let arguments = ["build", "small.toml", "--out", "made", "--threads", threads];
    let (code, out, err) = told(&morion(at, &arguments));
    assert!(code < 2, "{err}");
    (code, out, lasting(files(&at.join("made/small"))))
}

#[track_caller]
fn assert_same(a: &Made, b: &Made, what: &str) {
    assert_eq!((a.0, &a.1), (b.0, &b.1), "{what}");
    builds::assert_same(&a.2, &b.2, what);
}

/// Builds `text`, which comes to `code`, on several numbers of threads.
#[track_caller]
fn the_thread_count_leaves_no_trace(text: &str, code: i32) {
    let folder = folder();
    let text =
        edited(text, &[("[\"stl\", \"obj\"]", "[\"stl\", \"obj\", \"3mf\", \"glb\", \"csv\"]")]);
    let one = build(&folder.path().join("1"), &text, "1");
    assert_eq!(one.0, code, "{}", one.1);
    let names: Vec<&str> = one.2.keys().map(String::as_str).collect();
    let meshes =
        ["curl.png", "design_error.png", "mirror.3mf", "mirror.glb", "mirror.obj", "mirror.stl"];
    let pages = ["preview.png", "report.html", "report.json", "sag.csv"];
    assert_eq!(names, [&meshes[..], &pages].concat());
    for threads in ["2", "7"] {
        let more = build(&folder.path().join(threads), &text, threads);
        assert_same(&one, &more, &format!("1 thread and {threads}"));
    }
}

#[test]
fn a_strip_is_the_same_on_any_number_of_threads() {
    // With coarser facets the panorama's ends shadow each other.
    let fine = edited(&small_strip(), &[("facet_px = 3", "facet_px = 1")]);
    the_thread_count_leaves_no_trace(&fine, 0);
}

#[test]
fn a_refit_crest_is_the_same_on_any_number_of_threads() {
    the_thread_count_leaves_no_trace(SMALL, 0);
}

#[test]
fn what_obstacles_hide_is_the_same_on_any_number_of_threads() {
    let bodies = "
[[obstacle]]
cylinder = { from_mm = [0, 20, -9], to_mm = [1, 20, 30], radius_mm = 2 }
[[obstacle]]
box = { centre_mm = [4, 2, 9], size_mm = [1, 3, 1] }
";
    // Fewer pixels are filled than are asked for.
    the_thread_count_leaves_no_trace(&format!("{SMALL}{bodies}"), 1);
}

#[test]
fn a_refit_valley_is_the_same_on_any_number_of_threads() {
    // Its panels shadow each other, which fails, and must fail the same way.
    the_thread_count_leaves_no_trace(&small_but("\"crest\"", "\"valley\""), 1);
}

#[test]
fn a_section_is_the_same_on_any_number_of_threads() {
    the_thread_count_leaves_no_trace(&small_but("\"refit\"", "\"section\""), 0);
}

#[test]
fn a_mercator_picture_off_the_middle_is_the_same_on_any_number_of_threads() {
    let edits = [("cylindrical", "mercator"), ("[-30, 30]", "[-35, 25]")];
    the_thread_count_leaves_no_trace(&edited(SMALL, &edits), 0);
}

#[test]
fn panels_and_their_budget_are_the_same_on_any_number_of_threads() {
    let text = edited(
        &small_panels("\"stl\", \"obj\""),
        &[("mesh.facet_px = 3", "mesh.max_triangles = 12000")],
    );
    the_thread_count_leaves_no_trace(&text, 0);
}

#[test]
fn a_mesh_shared_out_in_many_pieces_is_the_same_on_any_number_of_threads() {
    the_thread_count_leaves_no_trace(&small_but("facet_px = 3", "facet_px = 1"), 0);
}

#[test]
fn where_it_is_built_leaves_no_trace() {
    let folder = folder();
    let home = folder.path();
    let path = save(home, SMALL);
    let path = path.to_str().unwrap();
    let away = home.join("away/from here");
    std::fs::create_dir_all(&away).unwrap();
    let far = home.join("far");
    let runs = [
        (home, path, "near", home.join("near")),
        (home, "small.toml", "deep/er/out", home.join("deep/er/out")),
        (&away, "../../small.toml", far.to_str().unwrap(), far.clone()),
    ];
    let made = runs.map(|(from, profile, out, to)| {
        let (code, text, err) = told(&morion(from, &["build", profile, "--out", out]));
        assert_eq!(code, 0, "{err}");
        (placeless(&text), lasting(files(&to.join("small"))))
    });
    for (text, files) in &made[1..] {
        assert_eq!(text, &made[0].0);
        builds::assert_same(&made[0].1, files, "two places");
    }
}

#[test]
fn a_second_build_over_the_first_changes_nothing() {
    let folder = folder();
    let first = build(folder.path(), SMALL, "2");
    let second = build(folder.path(), SMALL, "2");
    assert_same(&first, &second, "first and second build");
}
