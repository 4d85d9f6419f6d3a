//! Completions and manual pages: a shell completes by the script, and every command has its page.

use crate::support::builds::{folder, morion, told};
use std::process::Command;

/// What the program prints, with exit code 0.
fn printed(arguments: &[&str]) -> String {
    let folder = folder();
    let (code, out, err) = told(&morion(folder.path(), arguments));
    assert_eq!((code, &*err), (0, ""), "{arguments:?}");
    out
}

/// The commands that `morion help` lists.
fn commands() -> Vec<String> {
    let help = printed(&["help"]);
    let (_, listed) = help.split_once("Commands:\n").unwrap();
    let listed = listed.split("\n\n").next().unwrap();
    let names = listed.lines().filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    names.filter(|name| !["", "help"].contains(name)).map(str::to_owned).collect()
}

#[test]
fn bash_completes_commands_options_and_their_values() {
    let folder = folder();
    std::fs::write(folder.path().join("morion.bash"), printed(&["completions", "bash"])).unwrap();
    let cases = [
        (&["morion", "mach"][..], "machining"),
        (&["morion", "build", "--dry"], "--dry-run"),
        (&["morion", "--format", "j"], "json"),
        (&["morion", "completions", "f"], "fish"),
        (&["morion", "nonsense", "--dry"], ""),
    ];
    for (words, expected) in cases {
        let script = "source ./morion.bash && COMP_WORDS=(\"$@\") COMP_CWORD=$(($# - 1)) && \
                      _morion morion \"${!#}\" \"${@: -2:1}\" && echo \"${COMPREPLY[*]}\"";
        let mut bash = Command::new("bash");
        bash.args(["--norc", "-c", script, "bash"]).args(words).current_dir(folder.path());
        let out = bash.output().unwrap();
        let errors = String::from_utf8_lossy(&out.stderr);
        assert_eq!(String::from_utf8_lossy(&out.stdout).trim(), expected, "{words:?} {errors}");
    }
}

#[test]
fn zsh_and_fish_are_told_of_every_command() {
    let commands = commands();
    assert!(commands.len() > 16, "{commands:?}");
    for (shell, begins) in [("zsh", "#compdef morion"), ("fish", "# Print an optspec")] {
        let script = printed(&["completions", shell]);
        assert!(script.starts_with(begins), "{shell}");
        for command in &commands {
            assert!(
                script.contains(&format!("\"{command}\""))
                    || script.contains(&format!("'{command}:")),
                "{shell} {command}"
            );
        }
    }
}

#[test]
fn the_program_and_every_command_have_a_manual_page() {
    let program = printed(&["man"]);
    assert!(program.contains(".TH morion 1"), "{program}");
    for command in commands() {
        assert!(program.contains(&format!("morion\\-{command}(1)")), "{command}");
        let page = printed(&["man", &command]);
        let title = format!(".TH morion-{command} 1");
        assert!(page.contains(&title), "{command}: {page}");
        assert!([".SH NAME", ".SH SYNOPSIS", ".SH OPTIONS"].iter().all(|part| page.contains(part)));
    }
    let (code, _, err) = told(&morion(folder().path(), &["man", "biuld"]));
    assert_eq!(code, 2);
    assert!(err.contains("no command is called \"biuld\"; did you mean build?"), "{err}");
    // Options for tests are not told.
    assert!(!printed(&["man", "build"]).contains("skip"));
}
