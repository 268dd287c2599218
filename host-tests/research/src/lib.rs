//! Settled research: comparisons of searches and fits with what flies, which `mwd bench` prints.

pub mod contaminated;
pub mod contenders;
pub mod evaluations;
pub mod inclination;
pub mod paper;
pub mod pure_integration;
