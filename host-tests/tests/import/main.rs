//! Foreign recordings: imported they fly as the original does, or they are refused with the fix.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;

mod files;
mod formats;
mod habits;
mod plain_traces;
mod refused;
mod tool;
mod uncalibrated;
