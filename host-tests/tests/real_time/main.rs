//! The probe's program in real time on the emulated chip.
//!
//! Where the emulator cannot be had these tests say SKIPPED and pass; with `MWD_REQUIRE_EMULATOR=1` they
//! fail.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../rig/mod.rs"]
mod rig;
mod boards;
mod commands;
mod drilling;
mod every_sample;
mod live;
mod logged;
mod memory;
mod overload;
mod provisioning;
mod received;
mod recorded;
mod slow_line;
mod update;
mod watchdog;
