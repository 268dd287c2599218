//! The earth at a place: magnetic field and gravity.

pub mod coefficient_file;
pub mod field_at_depth;
pub mod gravity_at_depth;
pub mod grid;
pub mod normal_gravity;
pub mod reference_field;
