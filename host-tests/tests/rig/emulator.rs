//! The emulator, if there is one.

use mwd::target::toolchain::{self, Toolchain};
use std::io::Write;

/// The toolchain; `None`, with the reason printed, if it cannot be had, and then the test passes. With
/// `MWD_REQUIRE_EMULATOR=1` it fails.
pub fn toolchain() -> Option<Toolchain> {
    match toolchain::prepare() {
        Ok(toolchain) => Some(toolchain),
        Err(missing) if std::env::var_os("MWD_REQUIRE_EMULATOR").is_some_and(|v| v == "1") => panic!("{missing}"),
        Err(missing) => {
            // The test runner swallows what the macros print.
            std::io::stderr().write_all(format!("SKIPPED: {missing}\n").as_bytes()).unwrap();
            None
        }
    }
}
