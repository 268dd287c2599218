use super::{
    block::Block,
    error_state::{BIAS, ErrorState, HEADING, STATES, VELOCITY},
    field_reference::FieldReference,
    propagation::Propagation,
    rest::Rest,
    toolface::{ToolAngleSigmas, ToolAngles},
};
use crate::{
    config::{AttitudeConfig, Earth},
    rotation::{IDENTITY, matrix, rotate_back, sine_and_cosine},
};
use core::f32::consts::PI;
use nalgebra::{Matrix3, Vector2, Vector3};

mod alignment;
mod contradiction;
mod correction;
mod field;
mod gravity;
mod interruption;
mod output;
mod sensors;
mod shaking;
mod sustained;
mod turned_field;
mod uncertainty;

use contradiction::Agreement;
use shaking::Shaking;
use sustained::SustainedRotation;
use turned_field::TurnedField;

/// Earth's rotation, rad/s (WGS 84).
const EARTH_RATE_RAD_S: f32 = 7.292_115e-5;
/// Duration of one filter step, seconds: half the shortest correlation time among the modelled errors (0.1
/// s). Shorter steps add no information, because rotation within a step is removed sample by sample.
const BLOCK_S: f32 = 0.05;
/// Uncertainty of a tilt taken from a force of gravity's norm, radians: 0.1 g of acceleration, as of a hand.
const ALIGNMENT_SIGMA_RAD: f32 = 0.1;
/// Attitude uncertainty beyond which gravity and field align the filter again, radians: beyond it the linear
/// equations err by more than 1.5 %, the sine's third order.
const LOST_RAD: f32 = 0.3;

/// Attitude filter: strapdown integration at the sample rate, corrected 20 times a second.
///
/// An error-state Kalman filter over attitude, residual gyro bias and horizontal velocity. The accelerometer
/// is integrated to a velocity, and the filter assumes only that velocity is bounded: a wrong tilt makes the
/// integral of gravity run away; vibration, shocks and a moving hand do not. So no single reading counts as
/// gravity, and the averaging is as long as the gyro allows. The field corrects the heading and the bias,
/// never the tilt, and only while its norm and dip agree with an undisturbed reference. Errors correlated in
/// time enter as white noise of the same density at low frequency.
///
/// All zero until [`AttitudeFilter::start`], so that a `static` of it takes no flash.
pub struct AttitudeFilter {
    // Not in an `Option`, whose `None` would be stored in a niche that is not zero.
    config: AttitudeConfig,
    earth: Earth,
    started: bool,
    /// Rotation of the earth, NED, rad/s; zero if the latitude is unknown.
    earth_rate_ned_rad_s: Vector3<f32>,
    propagation: Propagation,
    /// Attitude as a matrix, body to NED.
    rotation: Matrix3<f32>,
    errors: ErrorState,
    /// Sigmas of the angles at the last filter step.
    sigmas: ToolAngleSigmas,
    sigmas_stale: bool,
    reference: FieldReference,
    rest: Rest,
    sustained: SustainedRotation,
    shaking: Shaking,
    agreement: Agreement,
    turned_field: TurnedField,
    block: Block,
    bias_rad_s: Vector3<f32>,
    /// Deviation of the gyro's scale factors and couplings after compensation.
    scale_sigma: f32,
    /// Variance of the magnetometer's delay against the gyro.
    timing_variance_s2: f32,
    /// Variance of the gyro's delay, in squared sample periods.
    gyro_timing_variance: f32,
    velocity_m_s: Vector2<f32>,
    rate_rad_s: Vector3<f32>,
    step_s: f32,
    smooth_force_m_s2: Vector3<f32>,
    /// Mean square of the force over about a second, relative to gravity's.
    mean_square_force: f32,
    /// Time since the tilt was last taken from the force, at most [`CONTRADICTION_S`], seconds.
    aligned_s: f32,
    contradiction_s: f32,
    velocity_contradiction_s: f32,
    heading_contradiction_s: f32,
    /// Time since a specific force was used, seconds.
    unseen_force_s: f32,
    /// Time since the field agreed with the attitude, seconds.
    unagreed_s: f32,
    heading_blocks: u16,
    /// Variance of the heading that averaging does not reduce, rad^2.
    heading_floor: f32,
    /// Angle between the tilt and a mean force that is not used, about north and about east, radians.
    tilt_doubt_rad: Vector2<f32>,
    /// Squared angle between the heading and an undisturbed field that is not used, rad^2.
    heading_doubt: f32,
    aligned: bool,
    lost: bool,
    near_vertical: bool,
    after_gap: bool,
    accel_used: bool,
    mag_used: bool,
    accel_seen: bool,
    mag_seen: bool,
}

impl AttitudeFilter {
    /// Returns a filter that has not been started.
    #[must_use]
    pub const fn new() -> Self {
        const ZERO: Vector3<f32> = Vector3::new(0.0, 0.0, 0.0);
        Self {
            config: AttitudeConfig::UNSET,
            earth: Earth::UNSET,
            started: false,
            earth_rate_ned_rad_s: ZERO,
            propagation: Propagation::new(),
            rotation: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            errors: ErrorState::new(),
            sigmas: ToolAngleSigmas::UNSET,
            sigmas_stale: false,
            reference: FieldReference::new(),
            rest: Rest::new(),
            sustained: SustainedRotation::new(),
            shaking: Shaking::new(),
            agreement: Agreement::new(),
            turned_field: TurnedField::new(),
            block: Block::new(),
            bias_rad_s: ZERO,
            scale_sigma: 0.0,
            timing_variance_s2: 0.0,
            gyro_timing_variance: 0.0,
            velocity_m_s: Vector2::new(0.0, 0.0),
            rate_rad_s: ZERO,
            step_s: 0.0,
            smooth_force_m_s2: ZERO,
            mean_square_force: 0.0,
            aligned_s: 0.0,
            contradiction_s: 0.0,
            velocity_contradiction_s: 0.0,
            heading_contradiction_s: 0.0,
            unseen_force_s: 0.0,
            unagreed_s: 0.0,
            heading_blocks: 0,
            heading_floor: 0.0,
            tilt_doubt_rad: Vector2::new(0.0, 0.0),
            heading_doubt: 0.0,
            aligned: false,
            lost: false,
            near_vertical: false,
            after_gap: false,
            accel_used: false,
            mag_used: false,
            accel_seen: false,
            mag_seen: false,
        }
    }

    /// Starts anew from a configuration that [`crate::Config::validate`] has accepted.
    pub fn start(&mut self, config: &AttitudeConfig, earth: &Earth) {
        *self = Self::new();
        (self.config, self.earth, self.started) = (*config, *earth, true);
        self.propagation.q = IDENTITY;
        self.rotation = Matrix3::identity();
        self.reference = FieldReference::start(earth);
        if let Some(latitude_rad) = earth.latitude_rad {
            let (sine, cosine) = sine_and_cosine(latitude_rad);
            self.earth_rate_ned_rad_s = Vector3::new(cosine, 0.0, -sine) * EARTH_RATE_RAD_S;
        }
        self.scale_sigma = config.gyro_scale_sigma;
        self.mean_square_force = 1.0;
        self.turned_field.start();
        self.mag_delay_known(None);
        self.gyro_delay_known(true);
        self.open_all();
    }

    /// Rotation of the earth in the body frame at the last sample, rad/s, to subtract from the gyro's
    /// reading. Zero without a latitude or before the alignment; its vertical part alone while there is no
    /// heading.
    #[must_use]
    pub fn earth_rate_rad_s(&self) -> Vector3<f32> {
        let rate = self.earth_rate_ned_rad_s;
        let known = if self.heading_blocks > 0 { rate } else { Vector3::new(0.0, 0.0, rate.z) };
        if self.aligned { rotate_back(&self.propagation.q, &known) } else { Vector3::zeros() }
    }

    /// Advances over the `dt_s` seconds that end with this sample, by its compensated body rate relative to
    /// the earth (or the last rate held).
    pub fn propagate(&mut self, dt_s: f32, rate_rad_s: &Vector3<f32>) {
        if !self.started {
            return;
        }
        // Beyond any gyro (57,000 deg/s): a defective reading, which says nothing.
        let plausible = rate_rad_s.norm_squared() < 1e6;
        self.rate_rad_s = if plausible { *rate_rad_s } else { Vector3::zeros() };
        self.step_s = dt_s;
        if !self.aligned {
            return;
        }
        if !plausible {
            let config = self.config;
            self.stop(&config);
            self.doubt(PI);
        }
        let rate = self.rate_rad_s - self.bias_rad_s;
        self.propagation.step(dt_s, &rate);
        self.rotation = matrix(&self.propagation.q);
        self.block.turn(&self.rotation, &rate, dt_s);
    }

    /// Takes the sample's calibrated vectors in the body frame: specific force (m/s^2, up at rest) and field
    /// (microtesla); `None` for one that is missing, clipped or known to be wrong. Call it after every
    /// [`AttitudeFilter::propagate`].
    pub fn observe(&mut self, accel_m_s2: Option<&Vector3<f32>>, mag_ut: Option<&Vector3<f32>>) {
        if !self.started {
            return;
        }
        // Accelerometers end at some 200 g, magnetometers at some 5 mT.
        let accel = accel_m_s2.filter(|a| a.norm_squared() < 1e8);
        let mag = mag_ut.filter(|m| (1e-2..1e8).contains(&m.norm_squared()));
        (self.accel_seen, self.mag_seen) = (accel.is_some(), mag.is_some());
        self.rest.observe(&self.rate_rad_s, accel, self.step_s);
        if !self.aligned || self.lost {
            // Free fall has no direction.
            let least = 0.01 * self.earth.gravity_m_s2 * self.earth.gravity_m_s2;
            if let Some(force) = accel.filter(|a| a.norm_squared() > least) {
                let (config, earth) = (self.config, self.earth);
                let first = !self.aligned;
                self.align(&(self.rotation * force), &config, &earth);
                if first && let Some(field) = mag {
                    self.face_north(field);
                }
                (self.aligned_s, self.contradiction_s) = (0.0, 0.0);
                return;
            }
            if !self.aligned {
                return;
            }
        }
        if let Some(force) = accel {
            self.block.force(&(self.rotation * force));
        }
        if let Some(field) = mag {
            let field = self.rotation * field;
            self.block.field(&field);
            self.sigmas_stale |= self.turned_field.observe(&field, self.step_s);
        }
        if self.block.time_s + 0.5 * self.step_s >= BLOCK_S {
            let (config, earth) = (self.config, self.earth);
            self.close_block(&config, &earth);
        }
    }

    /// Residual gyro bias that the filter found, body frame, rad/s, to subtract from the compensated rate.
    #[must_use]
    pub const fn residual_bias_rad_s(&self) -> Vector3<f32> {
        self.bias_rad_s
    }

    fn settings(&self) -> Option<(AttitudeConfig, Earth)> {
        self.started.then_some((self.config, self.earth))
    }
}

impl Default for AttitudeFilter {
    fn default() -> Self {
        Self::new()
    }
}
