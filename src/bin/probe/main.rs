//! The firmware. On a host this is an empty program, so that `cargo test --all-features` works there.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(target_os = "none", feature = "board-bare"))]
mod bare;
#[cfg(all(target_os = "none", feature = "board-emulated"))]
mod emulated;

#[cfg(all(target_os = "none", not(any(feature = "board-bare", feature = "board-emulated"))))]
compile_error!("choose a board: --features board-emulated");
#[cfg(all(target_os = "none", feature = "board-bare", feature = "board-emulated"))]
compile_error!("choose one board only: an image runs on one");

#[cfg(not(target_os = "none"))]
fn main() {}
