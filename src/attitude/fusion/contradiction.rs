//! Gravity and field that agree with each other and not with the attitude: it is the attitude that is wrong.

use super::{AttitudeFilter, BIAS, HEADING, LOST_RAD, PI};
use crate::{
    config::{AttitudeConfig, Earth},
    rotation::sine_and_cosine,
};
use nalgebra::Vector3;

/// Smoothing of what is compared, seconds: some swings of a vibration, which begins at some 10 Hz.
const SMOOTHING_S: f32 = 0.1;
/// Of the direction of such a force, radians: half a m/s^2 of acceleration.
const FORCE_SIGMA_RAD: f32 = 0.05;
/// A specific force that is gravity is as long within this part: five of those deviations.
const NORM_TOLERANCE: f32 = 0.25;
/// What is so many deviations off contradicts: by chance once in 400.
const GATE: f32 = 3.0;
/// However little is known, what is off by more than 60 deg (the square of its chord) contradicts.
const MOST: f32 = 1.0;
/// A gyro that was seen to be wrong by this, rad/s, is not to be trusted: the largest bias that is taken for one
/// (`IdentificationConfig::max_bias_rad_s`), rounded up.
const LEAST_MISTRUST_RAD_S: f32 = 0.1;
/// For so long a gyro that was wrong may be wrong again, seconds: as long as one is frozen before that is flagged.
const MISTRUST_S: f32 = 1.0;

/// What is known of how well gravity, field and attitude agree.
pub(super) struct Agreement {
    /// Force, NED, smoothed.
    force_m_s2: Vector3<f32>,
    /// Force times field, and the square of each, smoothed: numbers that a wrong attitude does not change.
    product: f32,
    square_force: f32,
    square_field: f32,
    /// By how much the gyro seems to be wrong, rad/s.
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

    /// Takes in the means of a step, NED; of the field where there is one.
    pub(super) fn observe(&mut self, force: &Vector3<f32>, field: Option<&Vector3<f32>>, time_s: f32) {
        let weight = time_s / (SMOOTHING_S + time_s);
        self.force_m_s2 += (force - self.force_m_s2) * weight;
        let Some(field) = field else { return };
        self.product += (force.dot(field) - self.product) * weight;
        self.square_force += (force.norm_squared() - self.square_force) * weight;
        self.square_field += (field.norm_squared() - self.square_field) * weight;
    }

    /// Variance by which the attitude spreads in a step, rad^2, because the gyro was seen to be wrong.
    pub(super) fn spread(&mut self, time_s: f32) -> f32 {
        self.mistrust_rad_s *= MISTRUST_S / (MISTRUST_S + time_s);
        self.mistrust_rad_s * self.mistrust_rad_s * time_s * MISTRUST_S
    }

    /// Sine of the dip between force and field, if both are as long as they have to be.
    fn sine_of_dip(&self, norm_ut: f32, tolerance: f32, gravity_m_s2: f32) -> Option<f32> {
        let (force, field) = (libm::sqrtf(self.square_force), libm::sqrtf(self.square_field));
        let long = (force - gravity_m_s2).abs() < NORM_TOLERANCE * gravity_m_s2;
        (long && (field - norm_ut).abs() < tolerance * norm_ut).then(|| -self.product / (force * field))
    }
}

impl AttitudeFilter {
    /// Judges the attitude by force and field (NED), the second of which does not agree with it, or is missing.
    ///
    /// The angle between the two does not depend on the attitude. If it is the reference's, and both are as long as they have to be, then
    /// neither an acceleration nor a magnet is the cause, unless both at once feign a turn. The attitude is off by as much as they are,
    /// and the gyro was wrong by as much as that took. Of a gyro that has been wrong the force alone says it too;
    /// of an attitude that is in doubt only by how much it may be off, since it may be the hand.
    pub(super) fn contradict(&mut self, field: Option<&Vector3<f32>>, config: &AttitudeConfig, earth: &Earth) {
        let gate = |variance: f32| if GATE * GATE * variance < MOST { GATE * GATE * variance } else { MOST };
        let force = &self.agreement.force_m_s2;
        let tilt = self.errors.variance(0) + self.errors.variance(1) + FORCE_SIGMA_RAD * FORCE_SIGMA_RAD;
        // squares of chords
        let tilted = 2.0 + 2.0 * force.z / libm::sqrtf(force.norm_squared());
        if tilted < gate(tilt) {
            return;
        }
        let turned = match field {
            Some(field) => {
                let turn = tilt + self.errors.variance(HEADING) + config.mag_sigma_rad * config.mag_sigma_rad;
                // where no heading is known the field's direction says nothing
                let headed = self.errors.variance(HEADING) < LOST_RAD * LOST_RAD;
                match self.turned(field, config, earth) {
                    Some(turned) if turned > gate(turn) || !headed => turned,
                    _ => return,
                }
            }
            None if self.agreement.mistrust_rad_s > LEAST_MISTRUST_RAD_S => 0.0,
            None => {
                self.turned_field.doubt_at_least(tilted);
                return;
            }
        };
        let off = if tilted > turned { tilted } else { turned };
        for state in 0..BIAS {
            self.errors.widen(state, off, PI * PI);
        }
        let rate = libm::sqrtf(off) / (SMOOTHING_S + self.unagreed_s);
        let agreement = &mut self.agreement;
        agreement.mistrust_rad_s = if rate > agreement.mistrust_rad_s { rate } else { agreement.mistrust_rad_s };
    }
    /// By how much a field's direction is off, the square of its chord, if force and field agree with each other.
    fn turned(&self, field: &Vector3<f32>, config: &AttitudeConfig, earth: &Earth) -> Option<f32> {
        let (norm_ut, sine_of_dip, cosine_of_dip) = self.reference.dip();
        let seen = self.agreement.sine_of_dip(norm_ut, config.mag_norm_tolerance, earth.gravity_m_s2)?;
        // the slope of a sine is the cosine, and no less than the tolerance itself
        let slope =
            if cosine_of_dip > config.mag_dip_tolerance_rad { cosine_of_dip } else { config.mag_dip_tolerance_rad };
        let (sine, cosine) = sine_and_cosine(earth.declination_rad.unwrap_or(0.0));
        let expected = Vector3::new(cosine_of_dip * cosine, cosine_of_dip * sine, sine_of_dip);
        let agree = (seen - sine_of_dip).abs() < config.mag_dip_tolerance_rad * slope;
        agree.then(|| (field / libm::sqrtf(field.norm_squared()) - expected).norm_squared())
    }
}
