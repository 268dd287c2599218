//! The estimator's unknowns: one table, in the order of the matrix. P is last, so that the root's last rows are P's
//! marginal without further work.

use crate::config::IdentificationConfig;
use core::ops::Range;

/// States of a node: attitude error (earth frame, rad), velocity (m/s), position (m), earth field (of the norm).
pub const NODE: usize = 12;
/// Attitude error within a node's states.
pub(super) const ATTITUDE: usize = 0;
/// Velocity.
pub(super) const VELOCITY: usize = 3;
/// Position.
pub(super) const POSITION: usize = 6;
/// Earth field.
pub(super) const FIELD: usize = 9;

/// Number of globals: unknowns that outlive a node.
pub const GLOBALS: usize = 37;
/// Number of nuisances: all globals before the gyro's bias.
pub const NUISANCES: usize = 25;

/// A run of columns that belong together.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// Name of the group.
    pub name: &'static str,
    /// Unit of its columns.
    pub unit: &'static str,
    /// First column.
    pub from: usize,
    /// Number of columns.
    pub count: usize,
    /// Deviation of the prior of each column, in the group's unit, as configured.
    pub width: fn(&IdentificationConfig, usize) -> f32,
    /// Where the default of that deviation comes from.
    pub source: &'static str,
}

impl Group {
    /// Columns of the group.
    #[must_use]
    pub const fn columns(&self) -> Range<usize> {
        self.from..self.from + self.count
    }
}

/// Source of the widths of both parts of the magnetometer matrix.
const OF_MAGNETOMETER: &str =
    "data sheets: sensitivity and cross-axis 1 to 3 % (BMM150, IIS2MDC); real sensors of the recordings 1 to 3 %";
/// Symmetric, trace-free part of the magnetometer matrix: soft iron and differences of scale; the common scale belongs
/// to the field's norm. Columns: (1, -1, 0) / sqrt 2 and (1, 1, -2) / sqrt 6 of the diagonal, then xy xz yz, over sqrt
/// 2 as those of the next group.
pub const MAG_SHAPE: Group = Group {
    name: "magnetometer shape",
    unit: "1",
    from: 0,
    count: 5,
    width: |id, _| id.vector_errors.mag_matrix,
    source: OF_MAGNETOMETER,
};
/// Index, within the magnetometer's shape, of the second diagonal term: a larger gain across the tool's axis and a
/// smaller one along it.
pub(super) const ALONG: usize = 1;
/// Antisymmetric part of the magnetometer matrix: a turn of its axes. xy xz yz, over sqrt 2, so that a prior of equal
/// widths is one of independent elements of the matrix.
pub const MAG_TURN: Group = Group {
    name: "magnetometer misalignment",
    unit: "1",
    from: 5,
    count: 3,
    width: |id, _| id.vector_errors.mag_matrix,
    source: OF_MAGNETOMETER,
};
/// Both parts of the magnetometer matrix.
pub const MAG_MATRIX: Group = Group {
    name: "magnetometer matrix",
    unit: "1",
    from: 0,
    count: 8,
    width: |id, _| id.vector_errors.mag_matrix,
    source: OF_MAGNETOMETER,
};
/// Hard iron, of the field's norm.
pub const HARD_IRON: Group = Group {
    name: "hard iron",
    unit: "of the field's norm",
    from: 8,
    count: 3,
    width: |id, _| id.vector_errors.hard_iron,
    source: "zero-field offset of data sheets: 5 uT (IIS2MDC), and the probe's own magnetism",
};
/// By how much the magnetometer is later than the gyro.
pub const MAG_LAG: Group = Group {
    name: "magnetometer lag",
    unit: "s",
    from: 11,
    count: 1,
    width: |id, _| id.vector_errors.mag_lag_s,
    source: "conversion and hold at 100 Hz, 15 ms",
};
/// By how much the accelerometer is later than the gyro.
pub const ACCEL_LAG: Group = Group {
    name: "accelerometer lag",
    unit: "s",
    from: 12,
    count: 1,
    width: |id, _| id.vector_errors.accel_lag_s,
    source: "difference of low-passes, 5 ms",
};
/// Accelerometer matrix: xx yy zz, then the symmetric and the antisymmetric parts of xy xz yz, each over sqrt 2 so
/// that a prior of equal widths is one of independent elements. The antisymmetric part turns the frame.
pub const ACCEL_MATRIX: Group = Group {
    name: "accelerometer matrix",
    unit: "1",
    from: 13,
    count: 9,
    width: |id, _| id.vector_errors.accel_matrix,
    source: "sensitivity 0.5 %, cross-axis 1 % (LSM6DSO, ICM-42688-P)",
};
/// Accelerometer bias.
pub const ACCEL_BIAS: Group = Group {
    name: "accelerometer bias",
    unit: "m/s^2",
    from: 22,
    count: 3,
    width: |id, _| id.vector_errors.accel_bias_m_s2,
    source: "zero-g level 20 mg (LSM6DSO, ICM-42688-P)",
};
/// Gyro bias, raw frame.
pub const BIAS: Group = Group {
    name: "gyro bias",
    unit: "rad/s",
    from: 25,
    count: 3,
    width: |id, _| id.prior_sigma_bias_rad_s,
    source: "zero-rate level of data sheets, 1 deg/s (LSM6DSO), and its change over temperature",
};
/// Gyro matrix P: the nine unknowns that make it of the prior's centre, row-major (`gyro_matrix`).
pub const P: Group = Group {
    name: "gyro matrix",
    unit: "1",
    from: 28,
    count: 9,
    width: |id, k| if k % 4 == 0 { id.prior_sigma_diagonal } else { id.prior_sigma_off_diagonal },
    source: "an uncalibrated gyro, 6 % and 3 %; the posterior averages over scales of this prior",
};

/// The whole table.
pub const TABLE: [Group; 9] = [MAG_SHAPE, MAG_TURN, HARD_IRON, MAG_LAG, ACCEL_LAG, ACCEL_MATRIX, ACCEL_BIAS, BIAS, P];

#[cfg(test)]
mod tests;
