//! Corrections of surveys, paths and files on a desk.

#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

mod cluster_shots;
mod corrected_runs;
mod files;
mod forty_stations;
mod independent_analysis;
mod published_examples;
mod refused;
mod sag;
mod standard_wells;
mod traces;
