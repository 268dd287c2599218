//! The running pipeline under troubled input: every trouble has its flag, count or reason, and the attitude goes on.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod rig;
mod explore;
