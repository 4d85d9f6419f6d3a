//! Names and texts of others: shown as text, and leading nowhere that the user did not name.

use crate::support::builds::{SMALL, edited, files, folder, morion, save, told};
use crate::support::package::{TYPES, package};
use crate::support::refused;

/// What of a text would steer a terminal.
fn steers(text: &str) -> bool {
    text.chars().any(|c| (c.is_control() && c != '\n') || ('\u{202a}'..='\u{202e}').contains(&c))
}

const TRIANGLE: &str = "v 0 0 0\nv 9 0 0\nv 0 9 0\nusemtl a\nf 1 2 3\n";

#[test]
fn names_and_summaries_are_shown_as_text() {
    let folder = folder();
    let home = folder.path();
    let name = "a\u{1b}[2J\u{7}\u{202e}b";
    let profile = edited(SMALL, &[("A small conquistador", "A \\u001b[31m\\u202ered \\u0007one")]);
    std::fs::write(home.join(format!("{name}.toml")), profile).unwrap();
    save(home, SMALL);
    std::fs::write(home.join(format!("{name}.stl")), "solid \u{1b}[2J\n").unwrap();
    std::fs::write(home.join(format!("{name}.obj")), TRIANGLE).unwrap();
    let library = format!("mtllib gone\u{1b}[2J.mtl\n{TRIANGLE}");
    std::fs::write(home.join("library.obj"), library).unwrap();
    let picture = format!("mtllib picture.mtl\n{TRIANGLE}");
    std::fs::write(home.join("picture.obj"), picture).unwrap();
    std::fs::write(home.join("picture.mtl"), "newmtl a\nmap_Kd gone\u{1b}[2J.png\n").unwrap();
    let (toml, stl, obj) =
        (&*format!("{name}.toml"), &*format!("{name}.stl"), &*format!("{name}.obj"));
    for (arguments, expected) in [
        (&["build", toml][..], 0),
        (&["build", toml], 0),
        (&["build", toml, "--dry-run"], 0),
        (&["check", toml], 0),
        (&["frame", toml], 0),
        (&["render", toml, "--scene", "grid"], 0),
        (&["render", "small.toml", "--smooth", "--scene", obj], 0),
        (&["render", "small.toml", "--smooth", "--scene", "library.obj"], 2),
        (&["render", "small.toml", "--smooth", "--scene", "picture.obj"], 2),
        (&["verify", stl, "--profile", "small.toml"], 1),
        (&["verify", obj, "--profile", "small.toml"], 1),
        (&["build", "gone\u{1b}[2J.toml"], 2),
        (&["build", "small.toml", "--out", "small.toml/\u{1b}[2J"], 2),
    ] {
        let (code, out, err) = told(&morion(home, arguments));
        assert_eq!(code, expected, "{arguments:?}: {out}{err}");
        assert!(!steers(&out) && !steers(&err), "{arguments:?}: {out:?} {err:?}");
    }
    let made = files(&home.join("out").join(name));
    let page = String::from_utf8(made["report.html"].clone()).unwrap();
    assert!(!steers(&page) && page.contains("\\u{1b}[31m\\u{202e}red \\u{7}one"), "{page}");
}

#[test]
fn what_a_3mf_calls_its_tags_is_shown_as_text() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    for model in [
        "<model unit=\"\u{1b}[2J\"><resources/></model>",
        "<model><resources><object id=\"1\"><mesh><a:vertex\u{1b}[2J/></mesh></object></resources></model>",
        "<model></\u{1b}[2J\u{202e}>",
    ] {
        package(&home.join("odd.3mf"), Some(TYPES), &[model]);
        let (code, out, err) =
            told(&morion(home, &["verify", "odd.3mf", "--profile", "small.toml", "--quiet"]));
        assert_eq!(code, 1, "{model:?}: {out}{err}");
        assert!(!steers(&out) && !steers(&err), "{model:?}: {out:?} {err:?}");
    }
}

#[test]
fn a_model_names_files_in_its_folder_alone_unless_it_may_name_others() {
    let folder = folder();
    let home = folder.path();
    let put = |name: &str, text: &str| std::fs::write(home.join(name), text).unwrap();
    std::fs::create_dir_all(home.join("models/parts")).unwrap();
    put("secret.mtl", "newmtl a\nKd 1 0 0\n");
    put("models/near.obj", &format!("mtllib parts/near.mtl\n{TRIANGLE}"));
    put("models/parts/near.mtl", "newmtl a\nKd 1 0 0\n");
    put("models/far.obj", &format!("mtllib ../secret.mtl\n{TRIANGLE}"));
    let whole = home.join("secret.mtl").display().to_string();
    put("models/whole.obj", &format!("mtllib {whole}\n{TRIANGLE}"));
    put("models/seen.obj", &format!("mtllib seen.mtl\n{TRIANGLE}"));
    put("models/seen.mtl", "newmtl a\nmap_Kd ../../gone.png\n");
    let render = ["render", "conformal", "--smooth", "--scene"];
    assert_eq!(told(&morion(home, &[&render[..], &["models/near.obj"]].concat())).0, 0);
    for model in ["models/far.obj", "models/whole.obj", "models/seen.obj"] {
        let words = ["is outside that file's folder; move it there, or give --allow-outside"];
        refused(home, &[&render[..], &[model]].concat(), &words);
    }
    for model in ["models/far.obj", "models/whole.obj"] {
        let arguments = [&render[..], &[model, "--allow-outside"]].concat();
        assert_eq!(told(&morion(home, &arguments)).0, 0, "{model}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../secret.mtl", home.join("models/link.mtl")).unwrap();
        put("models/link.obj", &format!("mtllib link.mtl\n{TRIANGLE}"));
        let words = ["link.mtl", "is outside that file's folder"];
        refused(home, &[&render[..], &["models/link.obj"]].concat(), &words);
    }
}

/// Opening a pipe waits until somebody writes: nobody does.
#[cfg(unix)]
#[test]
fn pipes_and_devices_that_a_file_names_are_not_opened() {
    let folder = folder();
    let home = folder.path();
    let made = std::process::Command::new("mkfifo").arg(home.join("pipe")).status().unwrap();
    assert!(made.success());
    let given = |file: &str| {
        let text = format!(
            "camera.orthographic.pixels = [64, 48]\nmirror.grid.file = \"{file}\"\n\
             part = {{ width_mm = 3, height_mm = 3, base_mm = 5 }}\nmesh.chord_um = 2\n\
             export.formats = [\"stl\"]\n"
        );
        std::fs::write(home.join("given.toml"), text).unwrap();
    };
    let words = ["a file names it, and it is a pipe or a device; name a regular file there"];
    for file in ["pipe", "/dev/zero"] {
        given(file);
        refused(home, &["build", "given.toml", "--quiet"], &words);
    }
    std::fs::write(home.join("pipe.obj"), format!("mtllib pipe\n{TRIANGLE}")).unwrap();
    refused(home, &["render", "conformal", "--smooth", "--scene", "pipe.obj"], &words);
}
