//! A probe at the end of a line: what it says, and what is said to it.

pub mod command_frame;
pub mod key_file;
pub mod line;
pub mod monitor;
pub mod recording;
