//! The program's manners: what goes to which stream, exit codes, and disks that refuse.

use crate::support::builds::{SMALL, command, files, folder, morion, save, told};
use crate::support::{refused, small_but};
use morion::internals::pipeline::{
    BlurOptions, BuildOptions, Command, FrameOptions, MachiningOptions, Observer, OutputFile,
    RenderOptions, ReplayOptions, Silent, Stage, ToleranceOptions, TrialsPart, Unwrap,
    UnwrapOptions, Verify, VerifyOptions, load,
};
use morion::internals::profile::Profile;
use morion::internals::results::Aperture;
use std::path::Path;
use std::process::Stdio;
use std::sync::atomic::{AtomicUsize, Ordering};

const ESCAPE: char = '\x1b';
#[rustfmt::skip]
const STAGES: [&str; 12] = [
    "design", "mesh", "solid", "write", "solid", "write",
    "read", "trace", "picture", "read", "trace", "report",
];

/// A profile that builds, with a verdict that must be negative.
fn too_strict() -> String {
    small_but("pixel_error_max_px = 5", "pixel_error_max_px = 0.01")
}

#[test]
fn results_go_to_stdout_and_a_line_a_stage_to_stderr() {
    let folder = folder();
    save(folder.path(), SMALL);
    let (code, out, err) = told(&morion(folder.path(), &["build", "small.toml"]));
    assert_eq!(code, 0);
    assert!(out.starts_with("small  (") && out.ends_with("  verdict  pass\n"), "{out}");
    let stages: Vec<&str> = err.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(stages, STAGES, "{err}");
    assert!(err.lines().all(|line| line.contains(" ms  ")), "{err}");
    for text in [&out, &err] {
        assert!(!text.contains([ESCAPE, '\r']), "{text}");
    }
}

#[test]
fn quiet_leaves_the_result_and_drops_the_progress() {
    let folder = folder();
    save(folder.path(), SMALL);
    let loud = told(&morion(folder.path(), &["build", "small.toml"]));
    let quiet = told(&morion(folder.path(), &["build", "small.toml", "--quiet"]));
    assert_eq!((quiet.0, &quiet.1), (0, &loud.1));
    assert_eq!(quiet.2, "");
    let arguments = ["verify", "-q", "out/small/mirror.stl", "--profile", "small.toml"];
    let (code, out, err) = told(&morion(folder.path(), &arguments));
    assert_eq!((code, &*err), (0, ""));
    assert!(out.ends_with("verdict  pass\n"));
}

#[test]
fn json_on_stdout_is_the_report_file_byte_for_byte() {
    let folder = folder();
    for (text, expected) in [(SMALL, 0), (&too_strict(), 1)] {
        save(folder.path(), text);
        let arguments = ["build", "small.toml", "--format", "json", "--color", "always"];
        let output = morion(folder.path(), &arguments);
        assert_eq!(told(&output).0, expected);
        let report = std::fs::read(folder.path().join("out/small/report.json")).unwrap();
        assert!(output.stdout == report, "{}", told(&output).1);
    }
}

#[test]
fn a_negative_verdict_exits_with_1_and_its_figures() {
    let folder = folder();
    save(folder.path(), &too_strict());
    let (code, out, _) = told(&morion(folder.path(), &["build", "small.toml"]));
    assert_eq!(code, 1);
    assert!(out.ends_with("  verdict  fail\n"), "{out}");
    assert!(out.contains(" px, over the 0.01 px of accept.pixel_error_max_px"), "{out}");
    let made = files(&folder.path().join("out/small"));
    assert_eq!(made.len(), 8, "{:?}", made.keys());
    // One bad part among good ones is enough, whatever the order.
    std::fs::write(folder.path().join("good.toml"), SMALL).unwrap();
    for order in [["good.toml", "small.toml"], ["small.toml", "good.toml"]] {
        let arguments = ["build", order[0], order[1], "--quiet"];
        let (code, out, _) = told(&morion(folder.path(), &arguments));
        assert_eq!((code, out.matches("verdict  ").count()), (1, 2), "{out}");
    }
}

#[test]
fn a_name_that_is_no_profile_exits_with_2_and_a_suggestion() {
    let folder = folder();
    let out = folder.path();
    refused(out, &["build", "conquistadro"], &["conquistadro", "did you mean conquistador?"]);
    refused(out, &["check", "zebra"], &["zebra: no such file", "morion profiles"]);
    refused(out, &["profiles", "--show", "zebra"], &["zebra", "morion profiles"]);
    refused(out, &["build", "."], &["cannot read ."]);
    assert!(files(out).is_empty());
}

#[test]
fn wrong_usage_exits_with_2() {
    let folder = folder();
    for arguments in [
        &[][..],
        &["bild"],
        &["build"],
        &["build", "conquistador", "--threads", "0"],
        &["build", "conquistador", "--format", "yaml"],
        &["verify", "mirror.stl"],
        &["check", "conquistador", "--nonsense"],
    ] {
        let (code, out, err) = told(&morion(folder.path(), arguments));
        assert_eq!((code, &*out), (2, ""), "{arguments:?}");
        assert!(err.contains("Usage: ") || err.contains("--help"), "{arguments:?}: {err}");
        assert!(!err.contains(ESCAPE));
    }
    for arguments in [["--help"], ["--version"]] {
        let (code, out, err) = told(&morion(folder.path(), &arguments));
        assert_eq!((code, &*err), (0, ""), "{arguments:?}");
        assert!(out.contains("morion"), "{out}");
    }
    assert!(files(folder.path()).is_empty());
}

#[test]
fn faults_in_any_profile_stop_all_work() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    save(&home.join("other"), SMALL);
    let twice = ["build", "small.toml", "other/small.toml"];
    refused(home, &twice, &["other/small.toml: another profile is called small too"]);
    std::fs::write(home.join("faulty.toml"), small_but("degree = 8", "degree = 80")).unwrap();
    refused(home, &["build", "small.toml", "faulty.toml"], &["faulty.toml:16:10: ", "80"]);
    assert!(!home.join("out").exists());
}

#[test]
fn a_place_that_cannot_be_written_to_is_named_and_nothing_is_written() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    std::fs::write(home.join("file"), "mine").unwrap();
    std::fs::create_dir(home.join("out")).unwrap();
    std::fs::write(home.join("out/small"), "mine too").unwrap();
    for (out, named) in
        [("file", "file/small"), ("file/below", "file/below/small"), ("out", "out/small")]
    {
        let arguments = ["build", "small.toml", "--quiet", "--out", out];
        refused(home, &arguments, &["cannot create the folder ", named]);
    }
    assert_eq!(std::fs::read(home.join("file")).unwrap(), b"mine");
    assert_eq!(std::fs::read(home.join("out/small")).unwrap(), b"mine too");
    assert_eq!(std::fs::read_dir(home).unwrap().count(), 3);
}

/// An observer that counts the stages that begin.
#[derive(Default)]
struct Begun(AtomicUsize);

impl Observer for Begun {
    fn begin(&self, _stage: Stage) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// A command in a folder that is a file: refused before any stage, with nothing left.
#[track_caller]
fn refused_at_once<C: Command>(what: &str, command: &C, source: &Profile, home: &Path) {
    let begun = Begun::default();
    let before = std::fs::read_dir(home).unwrap().count();
    let error = command.publish(source, &home.join("file"), &begun).err();
    let error = error.unwrap_or_else(|| panic!("{what}: done")).to_string();
    assert!(error.starts_with("cannot create the folder "), "{what}: {error}");
    assert_eq!(begun.0.into_inner(), 0, "{what}: a stage began");
    assert_eq!(std::fs::read(home.join("file")).unwrap(), b"mine", "{what}");
    assert_eq!(std::fs::read_dir(home).unwrap().count(), before, "{what}");
}

#[test]
fn every_command_finds_out_before_any_work_that_it_cannot_write() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    std::fs::write(home.join("file"), "mine").unwrap();
    // No photo and no mesh, but neither is looked at.
    let [photo, mesh] = ["photo.png", "mesh.stl"].map(|name| home.join(name));
    let source = &load(home.join("small.toml").to_str().unwrap()).unwrap();
    let trials = ToleranceOptions { range: 0..3, ..ToleranceOptions::default() };
    let blur = BlurOptions { aperture: Some(Aperture::Na { na: 0.01 }), focus_mm: None };
    let verify = VerifyOptions { align: true, ..VerifyOptions::default() };
    refused_at_once("build", &BuildOptions::default(), source, home);
    refused_at_once("frame", &FrameOptions::default(), source, home);
    refused_at_once("blur", &blur, source, home);
    refused_at_once("render", &RenderOptions::default(), source, home);
    let unwrap = Unwrap { photo: &photo, options: UnwrapOptions::default() };
    refused_at_once("unwrap", &unwrap, source, home);
    refused_at_once("machining", &MachiningOptions::default(), source, home);
    refused_at_once("tolerance", &trials, source, home);
    refused_at_once("tolerance --part", &TrialsPart(trials), source, home);
    refused_at_once("tolerance --replay", &ReplayOptions::default(), source, home);
    refused_at_once("verify --align", &Verify { path: &mesh, options: verify }, source, home);
}

#[test]
fn a_folder_that_cannot_be_made_exits_with_2_for_every_command() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    std::fs::write(home.join("file"), "mine").unwrap();
    let part = ["tolerance", "small.toml", "--trials", "0..3", "--part"];
    assert_eq!(told(&morion(home, &part)).0, 0);
    for arguments in [
        &["build", "small.toml"][..],
        &["frame", "small.toml"],
        &["blur", "small.toml", "--na", "0.01"],
        &["render", "small.toml", "--scene", "grid"],
        &["unwrap", "photo.png", "--profile", "small.toml"],
        &["machining", "small.toml", "--ball-mm", "3"],
        &["tolerance", "small.toml"],
        &part,
        &["tolerance", "small.toml", "--replay", "1"],
        &["tolerance", "--merge", "out/small/trials-0-3.csv"],
        &["verify", "mesh.stl", "--profile", "small.toml", "--align"],
        &["bench", "small.toml", "--quick"],
    ] {
        let all = [arguments, &["--out", "file"]].concat();
        refused(home, &all, &["cannot create the folder file/"]);
        let (_, _, err) = told(&morion(home, &all));
        assert_eq!(err.lines().count(), 1, "{all:?}: a stage began: {err}");
    }
    assert_eq!(std::fs::read(home.join("file")).unwrap(), b"mine");
}

#[test]
fn files_in_memory_are_those_of_a_folder() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    let source = load(home.join("small.toml").to_str().unwrap()).unwrap();
    let options = BuildOptions::default();
    let (report, made) = options.in_memory(&source, &Silent).unwrap();
    assert_eq!(options.publish(&source, home, &Silent).unwrap(), report);
    let published = files(&home.join("small"));
    assert_eq!(made.len(), published.len());
    for OutputFile { name, bytes } in made.iter().filter(|file| file.name != "timings.json") {
        assert!(published[name] == *bytes, "{name}");
    }
}

#[test]
fn a_folder_in_the_place_of_a_file_is_named_and_the_other_files_stay() {
    for taken in ["mirror.obj", "report.json", "timings.json"] {
        let folder = folder();
        let home = folder.path();
        save(home, SMALL);
        let made = home.join("out/small");
        std::fs::create_dir_all(made.join(taken)).unwrap();
        std::fs::write(made.join("mirror.stl"), "an earlier one").unwrap();
        refused(home, &["build", "small.toml", "--quiet"], &["cannot write ", taken]);
        assert!(std::fs::read(made.join("mirror.stl")).unwrap() == b"an earlier one", "{taken}");
        assert_eq!(std::fs::read_dir(&made).unwrap().count(), 2, "{taken}");
    }
}

#[test]
fn colour_is_for_terminals_and_those_who_ask() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    let coloured = |arguments: &[&str], variables: &[(&str, &str)]| {
        let mut command = command(home);
        command.args(["verify", "out/small/mirror.stl", "--profile", "small.toml"]);
        let (code, out, err) =
            told(&command.args(arguments).envs(variables.iter().copied()).output().unwrap());
        assert_eq!(code, 0, "{err}");
        assert!(!err.contains(ESCAPE), "{err}");
        out.contains(ESCAPE)
    };
    assert_eq!(told(&morion(home, &["build", "small.toml"])).0, 0);
    let always = ["--color", "always"];
    let never = ["--color", "never"];
    assert!(!coloured(&[], &[]));
    assert!(!coloured(&["--color", "auto"], &[("NO_COLOR", "1")]));
    assert!(coloured(&always, &[]));
    assert!(coloured(&always, &[("NO_COLOR", "1")]), "the flag beats the variable");
    assert!(!coloured(&never, &[]));
    assert!(!coloured(&never, &[("CLICOLOR_FORCE", "1")]), "the flag beats the variable");

    let error = |when: &str| told(&morion(home, &["check", "zebra", "--color", when])).2;
    assert!(error("always").contains(ESCAPE) && !error("never").contains(ESCAPE));
    assert!(error("auto").starts_with("error: zebra: "));
}

#[test]
fn shipped_profiles_can_be_listed_shown_and_checked() {
    let folder = folder();
    let (code, listed, err) = told(&morion(folder.path(), &["profiles"]));
    assert_eq!((code, &*err), (0, ""));
    let names: Vec<&str> = listed.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert!(names.contains(&"conquistador") && names.contains(&"panoramic"), "{listed}");
    for name in names {
        let (code, text, err) = told(&morion(folder.path(), &["profiles", "--show", name]));
        assert_eq!((code, &*err), (0, ""));
        let file = format!("{name}.toml");
        std::fs::write(folder.path().join(&file), text).unwrap();
        let [shown, shipped] =
            [&*file, name].map(|profile| told(&morion(folder.path(), &["check", profile])));
        assert_eq!((shown.0, &*shown.2), (0, ""));
        assert!(shown.1.starts_with(&format!("{name}: valid (")), "{}", shown.1);
        assert_eq!(shown, shipped);
    }
}

#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    let folder = folder();
    save(folder.path(), SMALL);
    for arguments in [
        &["profiles"][..],
        &["profiles", "--show", "conquistador"],
        &["check", "conquistador"],
        &["--help"],
        &["build", "small.toml", "--quiet"],
        &["build", "small.toml", "--quiet", "--format", "json"],
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = command(folder.path());
        let child = command.args(arguments).stdout(writer).stderr(Stdio::piped()).spawn().unwrap();
        let (code, _, err) = told(&child.wait_with_output().unwrap());
        assert_eq!((code, &*err), (0, ""), "{arguments:?}");
    }
    // Nor is it one when nobody listens to the progress.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut command = command(folder.path());
    let output = command.args(["build", "small.toml"]).stderr(writer).output().unwrap();
    assert_eq!(told(&output).0, 0);
}

#[cfg(target_os = "linux")]
#[test]
fn results_that_cannot_be_printed_exit_with_2() {
    let folder = folder();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = command(folder.path());
    let child = command.arg("profiles").stdout(full).stderr(Stdio::piped()).spawn().unwrap();
    let (code, _, err) = told(&child.wait_with_output().unwrap());
    assert_eq!(code, 2);
    assert!(err.starts_with("error: cannot write to standard output: "), "{err}");
}

#[test]
fn files_of_formats_no_longer_asked_for_do_not_stay_beside_a_new_report() {
    let folder = folder();
    let home = folder.path();
    for (formats, stays, goes) in
        [("[\"stl\"]", "mirror.stl", "mirror.obj"), ("[\"obj\"]", "mirror.obj", "mirror.stl")]
    {
        save(home, &small_but("[\"stl\", \"obj\"]", formats));
        assert_eq!(told(&morion(home, &["build", "small.toml", "--quiet"])).0, 0);
        let made = files(&home.join("out/small"));
        assert!(made.contains_key(stays) && !made.contains_key(goes), "{:?}", made.keys());
    }
}

#[test]
fn a_file_called_like_a_shipped_profile_does_not_spoil_the_list() {
    let folder = folder();
    std::fs::write(folder.path().join("panoramic"), "not a profile").unwrap();
    let (code, out, err) = told(&morion(folder.path(), &["profiles"]));
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("panoramic") && out.contains("conformal"), "{out}");
}

#[test]
fn checks_and_lists_answer_in_json_when_asked() {
    let folder = folder();
    for arguments in [&["check", "conformal"][..], &["profiles"]] {
        let all = [arguments, &["--format", "json", "--quiet"]].concat();
        let (code, out, _) = told(&morion(folder.path(), &all));
        assert_eq!(code, 0);
        for line in out.lines() {
            let value: serde_json::Value = serde_json::from_str(line).unwrap();
            assert!(value["name"].is_string(), "{line}");
        }
        assert!(out.contains("\"conformal\""), "{out}");
    }
}

#[test]
fn errors_are_json_where_that_is_asked_for() {
    let folder = folder();
    save(folder.path(), &SMALL.replace("degree = ", "degree = -"));
    let asked = |arguments: &[&str]| {
        let (code, out, err) = told(&morion(folder.path(), arguments));
        let lines =
            out.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
        assert_eq!(code, 2, "{out}{err}");
        assert!(!err.is_empty());
        lines.map(|mut line| line["error"].take()).collect::<Vec<_>>()
    };
    let errors = asked(&["build", "small.toml", "nowhere", "--format", "json"]);
    let [faulty, unknown] = &errors[..] else { panic!("{errors:?}") };
    assert!(faulty["file"] == "small.toml" && faulty["line"].as_u64().unwrap() > 1, "{faulty}");
    assert!(faulty["message"].as_str().unwrap().contains("degree"), "{faulty}");
    assert!(unknown["line"].is_null() && unknown["message"].is_string(), "{unknown}");
    let usage = asked(&["build", "small.toml", "--format=json", "--nonsense"]);
    assert!(usage[0]["message"].as_str().unwrap().contains("--nonsense"), "{usage:?}");
}

#[test]
fn several_answers_are_a_line_of_json_each() {
    let folder = folder();
    for name in ["one.toml", "two.toml"] {
        std::fs::write(folder.path().join(name), SMALL).unwrap();
    }
    let arguments = ["build", "one.toml", "two.toml", "--dry-run", "--format", "json"];
    let (code, out, err) = told(&morion(folder.path(), &arguments));
    assert_eq!(code, 0, "{err}");
    let names: Vec<String> = out
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap())
        .map(|answer| answer["profile"]["name"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(names, ["one", "two"]);
}
