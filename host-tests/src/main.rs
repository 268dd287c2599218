//! The `mwd` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    mwd::commands::main()
}
