//! The part of `mwd` that the tests need.

#[path = "../../../src/target/mock_flash.rs"]
pub mod mock_flash;

/// The module under the name that it has in `mwd`.
pub mod target {
    pub use crate::mock_flash;
}
