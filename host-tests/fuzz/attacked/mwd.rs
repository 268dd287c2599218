//! The part of `mwd` that the fuzz targets need, so that with sanitizers or counters it is built in a minute.
#![allow(unused_imports, reason = "the other parts use them")]

#[path = "../../src/console.rs"]
pub mod console;
#[path = "../../src/failure.rs"]
pub mod failure;
#[path = "../../src/fuzzed/mod.rs"]
pub mod fuzzed;
#[path = "../../src/target/mock_flash.rs"]
pub mod mock_flash;
#[path = "../../src/trace/mod.rs"]
pub mod trace;

/// The module under the name that it has in `mwd`.
pub mod target {
    pub use crate::mock_flash;
}
