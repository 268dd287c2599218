//! Selection of the storage's tests: flash that a cut left between two states, and pages smaller than a sector.

#[path = "../../../tests/storage/marginal.rs"]
mod marginal;
#[path = "../../../src/power_cuts/drawn.rs"]
mod models;
#[path = "../../../tests/storage/room.rs"]
mod room;
