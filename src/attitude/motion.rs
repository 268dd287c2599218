//! Motion as the attitude filter judges it, and the process noise that follows.

use super::{
    error_state::ProcessNoise,
    filter_step::FilterStep,
    rest::RestTracker,
    settings::Settings,
    shaking::{Shaking, UNSEEN_FORCE_DENSITY},
    slow_turn::SlowTurn,
    sustained::{SUSTAINED_S, SustainedRotation},
};
use nalgebra::{Matrix3, Vector3};

/// Correlation time of scale and coupling errors in one earth direction while motion reverses, seconds: one radian of
/// phase of a 1.6 Hz swing, about the fastest of a hand.
const SCALE_CORRELATION_S: f32 = 0.1;
/// White noise of the accelerometer, m/s^2 per root hertz: the upper end of MEMS data sheets (1e-3 to 3e-3;
/// MPU-9250 PS section 3.2: 300 ug). Vibration that sampling folds into this noise is measured separately.
const FORCE_NOISE_M_S2_RTHZ: f32 = 0.003;
/// Random walk of the gyro's scale, per root second: 0.6 % in an hour, the change of an MPU-9250 by 15 K (PS section
/// 3.1: 0.04 %/K).
const SCALE_WALK_RTS: f32 = 1e-4;
/// Change of the gyro's bias with the direction of gravity, rad/s: within 0.1 deg/s at 1 g (MPU-6000 PS section 6.1),
/// uniform.
const G_SENSITIVITY_RAD_S: f32 = 1.01e-3;

/// Detectors of rest, slow turns, sustained rotation and slow shaking.
pub(super) struct Motion {
    pub rest: RestTracker,
    pub slow_turn: SlowTurn,
    pub sustained: SustainedRotation,
    pub shaking: Shaking,
    /// Turn in the last [`SUSTAINED_S`], NED, rad.
    turned_rad: Vector3<f32>,
}

impl Motion {
    pub const fn new() -> Self {
        Self {
            rest: RestTracker::new(),
            slow_turn: SlowTurn::new(),
            sustained: SustainedRotation::new(),
            shaking: Shaking::new(),
            turned_rad: Vector3::new(0.0, 0.0, 0.0),
        }
    }

    /// Takes a filter step; returns its process noise. `step_s` is the interval of the samples, `scale_sigma` the
    /// deviation of the gyro's scale factors and couplings.
    pub fn process_noise(
        &mut self,
        step: &FilterStep,
        force_seen: bool,
        step_s: f32,
        scale_sigma: f32,
        Settings { config, goes_round, .. }: &Settings,
    ) -> ProcessNoise {
        let goes_round = *goes_round;
        let squared_rate = step.squared_rate();
        // Correlation time of a body-fixed error across the rotation's axis, seconds: the rotation carries it around.
        let phase = SCALE_CORRELATION_S * SCALE_CORRELATION_S * squared_rate;
        let across_s = SCALE_CORRELATION_S / (1.0 + phase);
        // In a sustained rotation a scale error is constant and belongs to the bias.
        let reversing = 1.0 - self.sustained.part();
        let scale = scale_sigma * scale_sigma * step.time_s * reversing;
        let rate_ned = step.rotation_time * step.angle_rad / (step.time_s * step.time_s);
        let noise = config.gyro_noise_rad_s_rthz * config.gyro_noise_rad_s_rthz * step.time_s;
        let along = rate_ned * rate_ned.transpose() * (scale * (SCALE_CORRELATION_S - across_s));
        // A turn that goes on in one direction has the relative error of the scale, until the rotation is sustained.
        self.turned_rad += (rate_ned - self.turned_rad / SUSTAINED_S) * step.time_s;
        let (rate, turned) = if goes_round {
            (rate_ned, self.turned_rad)
        } else {
            // By hand gravity shows the tilt within a swing: only the turn about the vertical counts.
            (Vector3::new(0.0, 0.0, rate_ned.z), Vector3::new(0.0, 0.0, self.turned_rad.z))
        };
        let square = rate.norm_squared();
        let going_on = 2.0 * turned.dot(&rate) - (SCALE_CORRELATION_S - across_s) * square;
        let is_sustained = self.sustained.axes().is_some();
        let going_on = if going_on > 0.0 && square > 0.0 && !is_sustained { scale * going_on / square } else { 0.0 };
        let (resting, moving) = (self.rest.force_density(step_s), FORCE_NOISE_M_S2_RTHZ * FORCE_NOISE_M_S2_RTHZ);
        let noise_density = if self.rest.detected() && resting < moving { resting } else { moving };
        // Vibration of the tool's own axes at the rotation's frequency is slow in the earth frame. The measured
        // density includes the noise.
        let shaken = self.shaking.density() * self.sustained.part();
        let force_density = if shaken > noise_density { shaken } else { noise_density };
        let density = if force_seen { force_density } else { force_density + UNSEEN_FORCE_DENSITY };
        let white = Matrix3::from_diagonal_element(noise + scale * across_s * squared_rate);
        // A turn by a radian about a horizontal axis changes gravity in the body by its own length. A rotating string
        // averages this out.
        let tilted_rad =
            if goes_round { 0.0 } else { libm::sqrtf(rate_ned.x * rate_ned.x + rate_ned.y * rate_ned.y) * step.time_s };
        let most = G_SENSITIVITY_RAD_S * G_SENSITIVITY_RAD_S;
        ProcessNoise {
            attitude: along + rate * rate.transpose() * going_on + white,
            bias: config.gyro_bias_walk_rad_s_rts * config.gyro_bias_walk_rad_s_rts * step.time_s,
            bounded_bias: [most * tilted_rad, most],
            velocity: density * step.time_s,
            scale: SCALE_WALK_RTS * SCALE_WALK_RTS * step.time_s,
        }
    }
}
