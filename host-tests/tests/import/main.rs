//! Foreign recordings: imported they fly as the original does, or they are refused with the fix.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;

mod files;
mod habits;
mod mat;
mod mcap;
mod own_times;
mod parquet;
mod plain_traces;
mod refused;
mod text_tables;
mod tool;
mod ulog;
mod uncalibrated;
