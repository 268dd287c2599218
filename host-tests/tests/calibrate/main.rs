//! `calibrate`: sensors with errors drawn at random are recovered within their own stated deviations, and
//! what the motion does not determine is refused by name.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;
mod bad_input;
mod recorded;
mod recovery;
mod record;
mod too_little;
mod turned_by_hand;
mod turntable;
