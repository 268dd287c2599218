//! Agreement of gravity, field and attitude. Where the first two agree with each other and not with the
//! attitude, the attitude is wrong.

use super::{
    error_state::HEADING,
    heading::{Heading, LOST_RAD},
    settings::Settings,
    state::State,
    tilt::FORCE_SIGMA_RAD,
    turned_field::TurnedField,
};
use crate::rotation::sine_and_cosine;
use nalgebra::Vector3;

/// Smoothing of force and field, seconds: several periods of a vibration of 10 Hz and more.
const SMOOTHING_S: f32 = 0.1;
/// Tolerance of the force's norm against gravity, relative: five times [`FORCE_SIGMA_RAD`].
const NORM_TOLERANCE: f32 = 0.25;
/// Limit of the angle between gravity or field as read and as the attitude predicts it, in standard deviations: chance
/// exceeds it once in 400.
const GATE: f32 = 3.0;
/// Largest squared chord that a gate allows: an attitude off by more than 60 deg counts as wrong, however uncertain it
/// is.
const MOST: f32 = 1.0;
/// Rate error above which the gyro is mistrusted, rad/s: 6 deg/s, above the zero-rate output of common parts
/// (LSM6DSO: 1 deg/s).
const LEAST_MISTRUST_RAD_S: f32 = 0.1;
/// Time constant of the mistrust, seconds: as long as a frozen gyro goes unflagged.
const MISTRUST_S: f32 = 1.0;

/// Agreement of gravity, field and attitude.
pub(super) struct Agreement {
    /// Smoothed force, NED.
    force_m_s2: Vector3<f32>,
    /// Smoothed dot product of force and field, and the square of each: none of the three depends on the attitude.
    product: f32,
    square_force: f32,
    square_field: f32,
    /// Apparent error of the gyro, rad/s.
    mistrust_rad_s: f32,
}

impl Agreement {
    pub(super) const fn new() -> Self {
        Self {
            force_m_s2: Vector3::new(0.0, 0.0, 0.0),
            product: 0.0,
            square_force: 0.0,
            square_field: 0.0,
            mistrust_rad_s: 0.0,
        }
    }

    /// Takes the mean force and field of a filter step, NED; the field may be missing.
    pub(super) fn update(&mut self, force: &Vector3<f32>, field: Option<&Vector3<f32>>, time_s: f32) {
        let weight = time_s / (SMOOTHING_S + time_s);
        self.force_m_s2 += (force - self.force_m_s2) * weight;
        let Some(field) = field else { return };
        self.product += (force.dot(field) - self.product) * weight;
        self.square_force += (force.norm_squared() - self.square_force) * weight;
        self.square_field += (field.norm_squared() - self.square_field) * weight;
    }

    /// Process noise of the attitude over a step, rad^2, while the gyro is mistrusted.
    pub(super) fn process_noise(&mut self, time_s: f32) -> f32 {
        self.mistrust_rad_s *= MISTRUST_S / (MISTRUST_S + time_s);
        self.mistrust_rad_s * self.mistrust_rad_s * time_s * MISTRUST_S
    }

    /// Sine of the field's dip below the level that the force shows; `None` if either has not the expected norm.
    fn sine_of_dip(&self, norm_ut: f32, tolerance: f32, gravity_m_s2: f32) -> Option<f32> {
        let (force, field) = (libm::sqrtf(self.square_force), libm::sqrtf(self.square_field));
        let long = (force - gravity_m_s2).abs() < NORM_TOLERANCE * gravity_m_s2;
        (long && (field - norm_ut).abs() < tolerance * norm_ut).then(|| -self.product / (force * field))
    }

    /// Judges the attitude by force and field (NED), after a step whose field disagrees with the attitude or is
    /// missing.
    ///
    /// The angle between the two vectors does not depend on the attitude. If this angle is the reference's and both
    /// norms are right, neither an acceleration nor a magnet explains the disagreement (unless both at once imitate a
    /// turn): the attitude is wrong by as much as the vectors say, and the gyro was wrong by this angle over the time
    /// since the field agreed. While the gyro is mistrusted the force suffices without a field. Otherwise a hand's
    /// acceleration could be the cause, so the force only raises the doubt about the attitude.
    pub(super) fn contradict(
        &mut self,
        state: &mut State,
        heading: &Heading,
        turned_field: &mut TurnedField,
        field: Option<&Vector3<f32>>,
        settings: &Settings,
    ) {
        let gate = |variance: f32| if GATE * GATE * variance < MOST { GATE * GATE * variance } else { MOST };
        let force = &self.force_m_s2;
        let tilt = state.errors.variance(0) + state.errors.variance(1) + FORCE_SIGMA_RAD * FORCE_SIGMA_RAD;
        // Squared chord between the force and straight up.
        let tilted = 2.0 + 2.0 * force.z / libm::sqrtf(force.norm_squared());
        if tilted < gate(tilt) {
            return;
        }
        let turned = match field {
            Some(field) => {
                let mag_sigma_rad = settings.config.mag_sigma_rad;
                let turn = tilt + state.errors.variance(HEADING) + mag_sigma_rad * mag_sigma_rad;
                // Without a known heading the field's direction cannot contradict the attitude.
                let headed = state.errors.variance(HEADING) < LOST_RAD * LOST_RAD;
                match self.turned(field, heading, settings) {
                    Some(turned) if turned > gate(turn) || !headed => turned,
                    _ => return,
                }
            }
            None if self.mistrust_rad_s > LEAST_MISTRUST_RAD_S => 0.0,
            None => {
                turned_field.doubt_at_least(tilted);
                return;
            }
        };
        let off = if tilted > turned { tilted } else { turned };
        state.inflate_attitude(off);
        let rate = libm::sqrtf(off) / (SMOOTHING_S + heading.disagreed_s());
        self.mistrust_rad_s = if rate > self.mistrust_rad_s { rate } else { self.mistrust_rad_s };
    }

    /// Squared chord between a field's direction and the expected one, if force and field agree with each
    /// other.
    fn turned(&self, field: &Vector3<f32>, heading: &Heading, settings: &Settings) -> Option<f32> {
        let (config, earth) = (&settings.config, &settings.earth);
        let (norm_ut, sine_of_dip, cosine_of_dip) = heading.reference().dip();
        let seen = self.sine_of_dip(norm_ut, config.mag_norm_tolerance, earth.gravity_m_s2)?;
        // The slope of the dip's sine is its cosine, here no less than the dip's tolerance.
        let slope =
            if cosine_of_dip > config.mag_dip_tolerance_rad { cosine_of_dip } else { config.mag_dip_tolerance_rad };
        let (sine, cosine) = sine_and_cosine(earth.declination_rad.unwrap_or(0.0));
        let expected = Vector3::new(cosine_of_dip * cosine, cosine_of_dip * sine, sine_of_dip);
        let agree = (seen - sine_of_dip).abs() < config.mag_dip_tolerance_rad * slope;
        agree.then(|| (field / libm::sqrtf(field.norm_squared()) - expected).norm_squared())
    }
}
