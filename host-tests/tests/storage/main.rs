//! Records that the probe keeps in flash: there after every power cut, believed only when they are whole and plausible,
//! and written so that the flash wears evenly.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../rig/mod.rs"]
mod rig;
mod commands;
mod continued;
mod dose;
mod factory;
mod flight;
mod history;
mod images;
mod learnt;
mod marginal;
mod nor;
mod power_cuts;
mod room;
mod spoilt;
mod stability;
mod wear;

use mwd::power_cuts::drawn as models;
