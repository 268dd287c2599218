//! The line to a probe: bytes, keys, recorded samples, and the view of what it reports.

pub mod key_file;
pub mod line;
pub mod monitor;
pub mod recording;
