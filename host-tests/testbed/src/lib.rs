//! Recordings and simulated drilling, flown through the library and scored; what all studies of that share; and what a
//! command needs for it: the files and streams that it names, its progress, and why it fails.

pub mod command_frame;
pub mod console;
pub mod failure;
pub mod flight;
pub mod process_memory;
pub mod progress_bar;
pub mod score;
pub mod simulate;
pub mod study;
pub mod trace;
