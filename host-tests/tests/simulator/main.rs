//! The simulator against physics: what its columns say about each other, in closed forms and by an
//! independent integration.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;
mod full_scale;
mod gyro;
mod ideal;
mod motion;
mod scenario_file;
mod seeds;
mod vectors;
