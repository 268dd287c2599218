//! Scores against closed forms: motions whose error is known by construction.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;
mod attitude;
mod delay;
mod missing;
mod motions;
mod rate_error;
mod rests;
mod two_seconds;
