//! What turns raw readings into compensated ones: the gyro's 12 parameters, and the factory models of the vector sensors.

mod gyro_model;
mod vector_model;

pub use gyro_model::GyroModel;
pub use vector_model::VectorModel;
