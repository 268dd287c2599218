use super::Grid;
use nalgebra::Vector3;

/// What is taken off the vectors before they are averaged: effects that would otherwise bend P to fit them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VectorEffects {
    /// Lag of the magnetometer behind the gyro, seconds.
    pub mag_lag_s: f32,
    /// Hard iron, microtesla, body frame.
    pub hard_iron_ut: Vector3<f32>,
}

/// A fifth of a second of a window: gravity and field, DE-ROTATED by the gyro (eq 7 the right way round, exactly) into the body frame of the window's beginning (a
/// body-frame low-pass would smear them: the body turns 150 deg/s), and how they depend on the gyro's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    /// Unit vectors of gravity and field, and the norms they had (m/s^2, microtesla); `None` where readings are missing, or a rate is
    /// suspect.
    pub vectors: [Option<(Vector3<f32>, f32)>; 2],
    /// S (3 x 12): a change delta of theta = (P row-major, c) turns the vectors by the rotation vector S delta.
    pub sensitivity: [[f32; 12]; 3],
    /// Mean square of the rate, rad^2/s^2.
    pub square_rate: f32,
    /// What the body saw; `None` where `vectors` has no gravity.
    pub body: Option<BodyMeans>,
    /// A rate was missing since the node before: nothing is known of the rotation in between.
    pub broken: bool,
}

impl Node {
    /// Increments of a node. Nodes of a second lose a third of what the samples hold, of half a second a sixth.
    pub fn length(grid: Grid) -> usize {
        grid.increments_in(0.2)
    }
}

/// Means over a node in the body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BodyMeans {
    /// Raw rate, rad/s.
    pub raw_rad_s: Vector3<f32>,
    /// Gravity, m/s^2.
    pub gravity_m_s2: Vector3<f32>,
    /// Standard error of gravity's direction by its scatter within the node, rad.
    pub sigma_rad: f32,
}
