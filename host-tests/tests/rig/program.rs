//! The `mwd` program as a user calls it.

use std::process::{Command, Output};

pub fn mwd(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mwd")).args(arguments).output().unwrap()
}
