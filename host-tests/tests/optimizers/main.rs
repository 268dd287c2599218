//! The optimisers through the public API: what holds for every one of them, and which is best on a window's
//! cost.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;
mod bottom;
mod imoa_operators;
mod not_finite;
mod searches;
mod settings;
mod slices;
mod window_cost;
