//! Settled research: comparisons of searches and fits with what flies. Only `mwd bench` calls it.
//!
//! A folder and not a crate: it needs this crate's simulator, flights, scores and tables, and this crate's
//! program calls it. As a crate it would depend on the crate that depends on it.

pub(crate) mod contaminated;
pub mod contenders;
pub(crate) mod evaluations;
pub(crate) mod inclination;
pub(crate) mod paper;
pub mod pure_integration;
