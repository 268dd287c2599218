//! The earth at a place: magnetic field and gravity.

pub mod normal_gravity;
pub mod reference_field;
