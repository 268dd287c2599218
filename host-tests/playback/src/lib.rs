//! Recordings and simulated drilling, flown through the library and scored; and what all studies of that share.

pub mod command_frame;
pub mod console;
pub mod failure;
pub mod flight;
pub mod progress_bar;
pub mod score;
pub mod simulate;
pub mod study;
pub mod trace;
