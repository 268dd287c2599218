//! Compensation of raw readings: the gyro's 12 parameters, the factory models of the vector sensors, and the
//! physical effects that were found.

pub mod effect;
pub mod effects;
mod correction;
mod gyro_model;
mod vector_model;

pub use correction::{ActiveEffects, FoundEffect, MAX_ACTIVE};
pub use effect::{Effect, Parameter, Sensor, Snapshot, VectorError};
pub use gyro_model::{GyroModel, Theta};
pub use vector_model::VectorModel;
