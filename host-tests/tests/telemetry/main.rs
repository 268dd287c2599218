//! Frames, queue, survey word, commands and the programs at the other end of the line.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;
mod commands;
mod corruption;
mod flown;
mod frames;
mod line_share;
mod live_page;
mod messages;
mod played_probe;
mod ports;
mod queue;
mod recorded;
mod survey_receiver;
mod survey_word;
