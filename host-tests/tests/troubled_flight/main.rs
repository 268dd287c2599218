//! The running pipeline under troubled input: every trouble has its flag, count or reason, and the attitude
//! goes on.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;
mod absurd_readings;
mod clipped;
mod command_line;
mod frozen;
mod garbage;
mod missing;
mod polling;
mod sample_rate;
mod short_trace;
mod time;
