//! The `morion` command.

fn main() -> std::process::ExitCode {
    morion::cli::run()
}
