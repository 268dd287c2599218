//! Increment of the watch for magnets.

use nalgebra::Vector3;

/// Means over one interval of the grid, valid at its middle.
///
/// The mean of a body vector over 20 ms differs from the vector at the middle by an error of second order in
/// the angle turned (0.05 % of its length at 300 deg/s); direction errors are odd in time and cancel for a
/// steady rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Increment {
    /// Mean raw rate, rad/s; `None` if a sample of the interval was clipped or the interval is empty.
    pub rate: Option<Vector3<f32>>,
    /// Mean calibrated field, microtesla.
    pub field: Option<Vector3<f32>>,
}
