//! Watch for magnets that come and go: body-fixed offsets of the field, told apart from disturbances fixed in
//! the earth.

mod accumulator;
mod field_filter;
mod field_node;
mod field_noise;
mod grid;
mod hard_iron_interval;
mod hard_iron_watch;
mod hypothesis;
mod increment;
pub mod rest;
mod rest_bias;

pub use hard_iron_interval::{FieldUse, HardIronCounts, HardIronInterval};
pub(crate) use hard_iron_watch::{HardIronWatch, UsableField};
