//! The `mwd` program.

use std::process::ExitCode;

use mimalloc::MiMalloc;

/// A recording's arrays come and go: the system's allocator gives them back each time.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    mwd::commands::main()
}
