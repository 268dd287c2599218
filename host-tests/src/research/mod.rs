//! Settled research: what only compares searches and fits with what flies. Nothing but `mwd bench` calls it.

pub(crate) mod contaminated;
pub mod contenders;
pub(crate) mod evaluations;
pub(crate) mod inclination;
pub(crate) mod paper;
pub mod pure_integration;
