//! The `mwd` program.
fn main() {}
