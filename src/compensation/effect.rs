//! Effects: terms, linear in their parameters, that a sensor reads beside the truth.

pub use crate::sample::Sensor;
use nalgebra::Vector3;

/// Largest number of parameters of one effect.
pub const MAX_PARAMETERS: usize = 9;

/// Sensor values at one instant, body frame, compensated and calibrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot {
    /// Angular rate, rad/s.
    pub rate_rad_s: Vector3<f32>,
    /// Angular acceleration, rad/s^2.
    pub acceleration_rad_s2: Vector3<f32>,
    /// Specific force, m/s^2.
    pub force_m_s2: Vector3<f32>,
    /// Mean square of the specific force over about the last fifth of a second, m^2/s^4: gravity's and the
    /// vibration's.
    pub square_force_m2_s4: f32,
    /// Field, microtesla.
    pub field_ut: Vector3<f32>,
    /// Temperature over [`REFERENCE_TEMPERATURE_C`], kelvin; 0 where there is none.
    pub warming_k: f32,
}

/// Temperature at which a temperature-dependent bias equals b, degrees Celsius: room temperature, at which
/// gyros are calibrated.
pub const REFERENCE_TEMPERATURE_C: f32 = 25.0;

/// Parameter of an effect, in SI units except for the field (microtesla).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name with its unit, as in results.
    pub name: &'static str,
    /// Factor from SI to the unit in the name.
    pub in_unit: f32,
    /// Usual size of the value: the deviation of the parameter's prior.
    pub usual: f32,
    /// Largest believable value, of either sign if `signed`; a larger one shows that something else looks like this
    /// effect.
    pub largest: f32,
    /// True if the parameter may be negative.
    pub signed: bool,
    /// True if the parameter's term is taken out for the identification of P but not for attitude. Turns of a vector
    /// sensor's axes are of this kind: the heading counts from the magnetometer's axes as calibrated, and which of two
    /// sensors' axes have turned cannot be told. So is the accelerometer's scale, because hand-held motion shows
    /// gravity's size rather than its direction.
    pub only_in_estimator: bool,
}

impl Parameter {
    /// Returns true if this effect can have the value.
    #[must_use]
    pub fn believes(&self, value: f32) -> bool {
        libm::fabsf(value) <= self.largest && (self.signed || value >= 0.0)
    }
}

/// Error of a vector sensor that the estimator always identifies beside P and the bias, in unknowns of its own: an
/// effect of this kind needs no others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum VectorError {
    /// Shape and turn of the magnetometer's matrix, eight unknowns: the five of [`SoftIron`](super::effects::SoftIron)
    /// in its order, then the antisymmetric elements xy, xz, yz.
    MagMatrix,
    /// Antisymmetric elements xy, xz, yz of the magnetometer's matrix.
    MagTurn,
    /// Hard iron on three axes, in units of the field.
    HardIron,
    /// Hard iron along the tool axis.
    AxialIron,
    /// Delay of the magnetometer behind the gyro, seconds.
    MagLag,
    /// Delay of the accelerometer behind the gyro, seconds.
    AccelLag,
    /// Accelerometer's matrix, nine unknowns: xx, yy, zz, then the symmetric and the antisymmetric parts of xy, xz, yz.
    AccelMatrix,
    /// Accelerometer's bias on three axes, m/s^2.
    AccelBias,
}

/// Physical effect: `reading = truth + sum of x_k term_k`, with its parameters x_k.
///
/// The term defines the effect completely: its trace in a residual and its removal follow from it.
pub trait Effect: Sync {
    /// Name in results.
    fn name(&self) -> &'static str;
    /// Sensor whose reading the effect changes.
    fn sensor(&self) -> Sensor;
    /// Parameters, at most [`MAX_PARAMETERS`].
    fn parameters(&self) -> &'static [Parameter];
    /// Term of parameter `k`: what one unit of it adds to the sensor's reading, in the reading's unit.
    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32>;
    /// Sets the terms of the effect's first parameters, as many as `terms` holds, in one call.
    fn set_terms(&self, snapshot: &Snapshot, terms: &mut [Vector3<f32>]) {
        for (k, term) in terms.iter_mut().enumerate() {
            *term = self.term(k, snapshot);
        }
    }
    /// Delay of the whole gyro, seconds; 0 for any other effect. The delay is not taken out of the rate, because the
    /// rate's derivative would add noise; the vectors are turned back to the time at which the rate is valid.
    fn gyro_delay_s(&self, _parameters: &[f32; MAX_PARAMETERS]) -> f32 {
        0.0
    }
    /// Returns true if the effect's first parameter is a delay, seconds, of every reading of its sensor.
    fn is_delay(&self) -> bool {
        false
    }
    /// Returns true if the effect is a step of the gyro's bias: parameter `k` adds to axis `k` from a shock on. The
    /// flown bias includes the step.
    fn is_bias_step(&self) -> bool {
        false
    }
    /// Error of a vector sensor that the effect is, if the estimator always identifies it.
    fn vector_error(&self) -> Option<VectorError> {
        None
    }
    /// Converts the estimator's unknowns of this error to the effect's parameters; `field_ut` is the unit of the field,
    /// microtesla.
    fn parameters_of(&self, unknowns: &[f32; MAX_PARAMETERS], _field_ut: f32) -> [f32; MAX_PARAMETERS] {
        *unknowns
    }
    /// Other causes that these sensors cannot tell from the effect.
    fn aliases(&self) -> &'static [&'static str];
}

/// Unit vector of a body axis by number; zero beyond the third.
pub(super) fn axis(k: usize) -> Vector3<f32> {
    Vector3::from_fn(|row, _| if row == k { 1.0 } else { 0.0 })
}

/// Negates and scales unknowns: the estimator adds to a reading, an effect states the excess of a reading.
pub(super) fn negated(unknowns: &[f32; MAX_PARAMETERS], factor: f32) -> [f32; MAX_PARAMETERS] {
    unknowns.map(|x| -x * factor)
}

/// Component `k` of a vector; 0 beyond the third.
pub(super) fn component(v: &Vector3<f32>, k: usize) -> f32 {
    v.get(k).copied().unwrap_or(0.0)
}
