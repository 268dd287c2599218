//! Selection of the storage's tests: flash that a cut left between two states, and pages smaller than a sector.

#[path = "../../../tests/storage/marginal.rs"]
mod marginal;
#[path = "../../../tests/storage/models.rs"]
mod models;
#[path = "../../../tests/storage/room.rs"]
mod room;
