//! What shells and `man` are told of the commands: completions and manual pages, made from the arguments themselves.

use super::args::{Arguments, ShellArg};
use super::failure::CommandFailure;
use clap::{Command, CommandFactory};
use clap_complete::{Shell, generate};
use clap_mangen::Man;

/// The program's name, by which shells know it.
const PROGRAM: &str = "morion";

/// The script that makes a shell complete the program's commands, options and their values.
pub(super) fn completions(shell: ShellArg) -> String {
    let shell = match shell {
        ShellArg::Bash => Shell::Bash,
        ShellArg::Zsh => Shell::Zsh,
        ShellArg::Fish => Shell::Fish,
    };
    let mut script = Vec::new();
    generate(shell, &mut Arguments::command(), PROGRAM, &mut script);
    String::from_utf8_lossy(&script).into_owned()
}

/// The manual page of the program, or of one command, in roff.
///
/// # Errors
/// A sentence that lists the commands, if this is none of them.
pub(super) fn manual(command: Option<&str>) -> Result<String, CommandFailure> {
    let mut program = Arguments::command();
    // Names of commands and the options that all of them have.
    program.build();
    let described = command.map_or(Ok(&program), |name| {
        program.find_subcommand(name).ok_or_else(|| {
            let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
            CommandFailure::unknown("command", name, &names)
        })
    })?;
    let mut page = Vec::new();
    let rendered = Man::new(described.clone()).render(&mut page);
    rendered.map_err(|error| CommandFailure::said(format!("the manual page: {error}")))?;
    Ok(String::from_utf8_lossy(&page).into_owned())
}
