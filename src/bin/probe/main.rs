//! The firmware. On a host this is an empty program, so that `cargo test --all-features` works there.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}
