//! The attitude filter through its public interface, against known motion and recordings.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../rig/mod.rs"]
mod rig;
mod accuracy;
mod beside_vqf;
mod faults;
mod recordings;
mod schedules;
mod simulation;
mod troubled;
mod troubles;
