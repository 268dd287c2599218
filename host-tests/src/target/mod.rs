//! The firmware on the emulated chip: toolchain, images, the emulator, and the files in and out.

pub mod call_costs;
pub mod deadline;
pub mod emulate;
pub mod error;
pub mod firmware;
pub mod image;
pub mod machine;
pub mod missing;
pub mod module_sizes;
pub mod real_time;
pub mod toolchain;
pub mod wire;
