//! Rig shared by the tests: runs with known truth, files of the repository, the emulator, reports of windows.
//!
//! A test that declares `mod rig` compiles all of it and uses a part.
#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

pub mod browser;
pub mod emulator;
pub mod files;
pub mod handheld;
pub mod json_fields;
pub mod page;
pub mod picture;
pub mod program;
pub mod report;
pub mod rotation;
pub mod run;
