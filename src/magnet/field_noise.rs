//! Noise of a node's field, from its scatter at rest and in motion.

use super::field_node::FieldNode;
use crate::{change::TURNING_RAD_S, statistics::chi_square::IN_TWENTY};
use nalgebra::Matrix3;

/// Noise of a node's mean at rest, microtesla: that of single readings (LIS3MDL, ultra-high-performance mode:
/// 3.2 mgauss rms on x and y, 4.1 on z, so 0.32 and 0.41 uT), because a magnetometer read 10 times a second
/// hardly averages.
const STILL_NOISE_UT: f32 = 0.5;
/// Time over which the calibration's error follows the rate, seconds. The error turns with the body and
/// changes after about a radian.
const ERROR_TIME_S: f32 = 1.0;
/// Factor of the calibration's variance per node: successive nodes share one error, which counts this often where noise
/// is taken as independent.
pub(super) const CORRELATED: f32 = 3.0;
/// Change of the earth's field along the way of a moving probe, microtesla per root second: walking pace, 1
/// uT in a metre, as inside buildings. [`STILL_WALK_UT_RTS`] is the part that remains at rest.
const WALK_UT_RTS: f32 = 1.0;
const STILL_WALK_UT_RTS: f32 = 0.1;
/// Relative rate error after compensation: the nonlinearity of data sheets (MPU-9250 PS section 3.1: 0.1 %
/// off the best straight line, at 25 degC).
const NONLINEARITY: f32 = 0.001;
/// Averaging time of the variances' factor, seconds of turning, and the factor's limits: the configured error may be
/// wrong by a factor of three either way.
const SCALE_TIME_S: f32 = 10.0;
const SCALE_LIMITS: [f32; 2] = [0.1, 10.0];
/// Mean of chi-square with three degrees of freedom, clipped at [`IN_TWENTY`].
const CLIPPED_MEAN: f32 = 2.89;

/// Noise model of a node: magnetometer noise, calibration error, change of the earth's field, drift of the
/// gyro's frame.
pub(super) struct FieldNoise {
    /// Direction error of the calibrated field, radians.
    error_rad: f32,
    gyro_noise_rad_s_rthz: f32,
    /// Squared angle that the fastest rest turns in [`ERROR_TIME_S`], radians squared. From here on a moving
    /// probe's walk counts whole, below by the squared angle.
    still_rad2: f32,
    /// Angle turned in about the last second, radians.
    recent_rad: f32,
    /// Factor of the variances, estimated from the nodes' innovations.
    scale: f32,
}

impl FieldNoise {
    pub const fn zero() -> Self {
        Self { error_rad: 0.0, gyro_noise_rad_s_rthz: 0.0, still_rad2: 0.0, recent_rad: 0.0, scale: 0.0 }
    }

    /// Creates the model; `still_rad_s` is the largest rate of a probe at rest.
    pub fn new(error_rad: f32, gyro_noise_rad_s_rthz: f32, still_rad_s: f32) -> Self {
        let still_rad = still_rad_s * ERROR_TIME_S;
        Self { error_rad, gyro_noise_rad_s_rthz, still_rad2: still_rad * still_rad, recent_rad: 0.0, scale: 1.0 }
    }

    pub const fn recent_rad(&self) -> f32 {
        self.recent_rad
    }

    /// Calibration error in a field of this strength, microtesla.
    pub fn error_ut(&self, field_ut: f32) -> f32 {
        self.error_rad * field_ut
    }

    /// Updates the angle turned in about the last second by a node.
    pub fn turn(&mut self, node: &FieldNode) {
        let faded = self.recent_rad * (1.0 - node.time_s / ERROR_TIME_S);
        let now = node.angle_rad / node.time_s * ERROR_TIME_S;
        self.recent_rad = if now > faded { now } else { faded };
    }

    /// Variance of a node on each axis, microtesla squared, with the calibration's error counted `often`
    /// times.
    pub fn variance_ut2(&self, error_ut: f32, often: f32) -> f32 {
        let moving = at_most(self.recent_rad * self.recent_rad, 1.0);
        STILL_NOISE_UT * STILL_NOISE_UT * at_most(self.scale, 1.0) + self.scale * often * error_ut * error_ut * moving
    }

    /// Process noise of the earth's field over a node, seen in the gyro's frame, microtesla squared.
    pub fn walk_ut2(&self, node: &FieldNode, field_ut: f32) -> f32 {
        let moving = at_most(self.recent_rad * self.recent_rad / self.still_rad2, 1.0);
        let walk = self.scale * WALK_UT_RTS * WALK_UT_RTS * moving + STILL_WALK_UT_RTS * STILL_WALK_UT_RTS;
        let noise = self.gyro_noise_rad_s_rthz * self.gyro_noise_rad_s_rthz * node.time_s;
        let nonlinear = NONLINEARITY * NONLINEARITY * node.angle_rad * node.angle_rad;
        let unseen = at_most(node.unseen_rad * node.unseen_rad, 1.0);
        walk * node.time_s + field_ut * field_ut * (noise + nonlinear + unseen)
    }

    /// Updates the scale by a node's normalised innovation squared while the probe turns, to the extent that
    /// the innovation is noise (variance `noise` on each axis) and not prediction error.
    pub fn learn(&mut self, squared: f32, noise: f32, predicted: &Matrix3<f32>, time_s: f32) {
        if self.recent_rad < TURNING_RAD_S * ERROR_TIME_S {
            return;
        }
        let share = 3.0 * noise / (3.0 * noise + predicted.trace());
        let excess = at_most(squared, IN_TWENTY) / CLIPPED_MEAN - 1.0;
        let [least, most] = SCALE_LIMITS;
        let scale = self.scale * (1.0 + share * excess * time_s / SCALE_TIME_S);
        self.scale = at_most(if scale > least { scale } else { least }, most);
    }
}

pub(super) fn at_most(x: f32, most: f32) -> f32 {
    if x < most { x } else { most }
}
