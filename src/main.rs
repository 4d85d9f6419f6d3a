//! The `morion` command.

// A build makes and drops arrays of tens of megabytes, stage after stage; an allocator that keeps
// their pages saves a quarter of its run time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    morion::internals::cli::run()
}
