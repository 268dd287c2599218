//! What an effect is: a term, linear in its parameters, that a sensor reads beside the truth.

use core::ops::Range;
use nalgebra::Vector3;

/// Most parameters of one effect.
pub const MAX_PARAMETERS: usize = 9;

/// Whose reading an effect changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Sensor {
    /// The compensated rate, rad/s (after P and b).
    Gyro,
    /// The calibrated specific force, m/s^2.
    Accelerometer,
    /// The calibrated field, microtesla.
    Magnetometer,
}

/// What the sensors read around one instant, body frame, compensated and calibrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Angular rate, rad/s.
    pub rate_rad_s: Vector3<f32>,
    /// Its derivative, rad/s^2.
    pub acceleration_rad_s2: Vector3<f32>,
    /// Specific force, m/s^2.
    pub force_m_s2: Vector3<f32>,
    /// Mean square of the specific force over the last fifth of a second or so, m^2/s^4: gravity's and the vibration's.
    pub square_force_m2_s4: f32,
    /// Field, microtesla.
    pub field_ut: Vector3<f32>,
    /// Temperature over [`REFERENCE_TEMPERATURE_C`], kelvin; 0 where there is none.
    pub warming_k: f32,
}

/// Where a bias that goes with temperature is what b says, degrees Celsius: room temperature, at which gyros are calibrated.
pub const REFERENCE_TEMPERATURE_C: f32 = 25.0;

/// One parameter of an effect, in SI units but for the field (microtesla).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name with its unit, as results print it.
    pub name: &'static str,
    /// What a value is multiplied by to be in that unit.
    pub in_unit: f32,
    /// How large it usually is: the deviation of its prior.
    pub usual: f32,
    /// The largest that is believed, of either sign where `signed`: beyond it something else looks like this effect.
    pub largest: f32,
    /// Whether it may be negative.
    pub signed: bool,
    /// Whether it is taken out where P is identified, and not from the attitude: what turns a vector sensor's axes, as the heading counts from the
    /// magnetometer's as they were calibrated, and which of two sensors' axes have turned cannot be told; and the accelerometer's scale, of
    /// which hand-held motion shows the size of gravity rather than its direction.
    pub only_in_estimator: bool,
}

impl Parameter {
    /// Whether a value can be this effect's.
    #[must_use]
    pub fn believes(&self, value: f32) -> bool {
        libm::fabsf(value) <= self.largest && (self.signed || value >= 0.0)
    }
}

/// A physical effect: `reading = truth + sum of x_k term_k`, x_k its parameters.
///
/// The term is all that a candidate needs: what a residual shows of it, and how it is taken out again, follow from it.
pub trait Effect: Sync {
    /// Its name in results.
    fn name(&self) -> &'static str;
    /// Whose reading it changes.
    fn sensor(&self) -> Sensor;
    /// Its parameters, at most [`MAX_PARAMETERS`].
    fn parameters(&self) -> &'static [Parameter];
    /// What one unit of parameter `k` adds to the sensor's reading, in the reading's unit.
    fn term(&self, k: usize, moment: &Moment) -> Vector3<f32>;
    /// Of a delay of the whole gyro, seconds: it is not taken out of the rate, whose noise its derivative would raise, but the vectors are
    /// brought back to the time that the rate is valid at. 0 for any other effect.
    fn gyro_delay_s(&self, _parameters: &[f32; MAX_PARAMETERS]) -> f32 {
        0.0
    }
    /// Whether it is a step of the gyro's bias, of 1 on axis `k` from a shock on for parameter `k`: the bias that flies holds it.
    fn is_bias_step(&self) -> bool {
        false
    }
    /// The columns of the estimator that stand for it, where it is an error of a vector sensor that the estimator always knows: see
    /// [`columns`](crate::estimator::columns).
    fn nuisance(&self) -> Option<Range<usize>> {
        None
    }
    /// Its parameters, from the estimator's unknowns in these columns; `field_ut`: the unit of the field, microtesla.
    fn parameters_of(&self, unknowns: &[f32; MAX_PARAMETERS], _field_ut: f32) -> [f32; MAX_PARAMETERS] {
        *unknowns
    }
    /// What else looks like it with these sensors.
    fn aliases(&self) -> &'static [&'static str];
}

/// An axis of the body by number; zero beyond the third.
pub(super) fn axis(k: usize) -> Vector3<f32> {
    Vector3::from_fn(|row, _| if row == k { 1.0 } else { 0.0 })
}

/// Of what is added to a reading, what the reading has too much.
pub(super) fn negated(unknowns: &[f32; MAX_PARAMETERS], factor: f32) -> [f32; MAX_PARAMETERS] {
    unknowns.map(|x| -x * factor)
}

/// Component `k` of a vector; 0 beyond the third.
pub(super) fn component(v: &Vector3<f32>, k: usize) -> f32 {
    v.get(k).copied().unwrap_or(0.0)
}
