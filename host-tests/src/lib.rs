//! What stands around `meerkat-mwd` on a desk: traces in, results and scores out.

pub mod deadline;
pub mod emulate;
pub mod flight;
pub mod image;
pub mod toolchain;
pub mod wire;
