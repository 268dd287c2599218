//! C interface of `meerkat-mwd`. `include/meerkat_mwd.h` is made of this crate by cbindgen, and docs/c.md is its guide.
//!
//! Every function takes memory from its caller, allocates nothing, blocks on nothing and returns an [`MwdStatus`] or a
//! plain number. Structs are flat: a value that is not known is NaN, and a choice is a number with a macro. A NULL or
//! misaligned pointer is an error code. Nothing here can panic; on a host, where the compiler cannot see to it, a
//! panic would end the program at the border and not unwind into C.
#![cfg_attr(target_os = "none", no_std)]
// The border to C is raw pointers and names that the linker sees. Each use says what it rests on.
#![allow(unsafe_code)]
#![deny(clippy::indexing_slicing)]

mod attitude;
mod choices;
mod config;
mod config_fault;
mod effects;
mod frames;
mod magnet;
mod mounting;
mod output;
mod pointer;
mod probe;
mod sample;
mod sizes;
mod status;
mod survey;
mod text;
mod window;

pub use attitude::*;
pub use choices::*;
pub use config::*;
pub use effects::*;
pub use frames::*;
pub use magnet::*;
pub use mounting::*;
pub use output::*;
pub use probe::*;
pub use sample::*;
pub use sizes::*;
pub use status::*;
pub use survey::*;
pub use window::*;

/// Panic handler of a bare target. A test looks for functions of `core::panicking` in the linked image and finds none.
#[cfg(all(target_os = "none", feature = "panic-handler"))]
#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
