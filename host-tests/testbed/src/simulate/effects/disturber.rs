//! All effects of a run, applied sample by sample.

use meerkat_mwd::Sample;
use nalgebra::Vector3;

use super::{
    super::{random::Random, sensors::Ideal},
    accelerometer::AccelEffects,
    dropouts::DrawnDropouts,
    gyro::GyroEffects,
    gyro_bias::bias_change_rad_s,
    magnetic_bursts::Bursts,
    magnetometer::MagEffects,
    settings::Effects,
};

/// All effects of a run, in the order in which they act on a sample:
///
/// - gyro: turn of the mount, delay; then `P^-1 w`, additions to it, bias;
/// - accelerometer: lever arm (which is in the truth already), delay, matrix, offset;
/// - magnetometer: bursts (in the truth already), eddy currents, delay, matrix, hard iron.
///
/// An effect that is off draws no random numbers.
pub(in crate::simulate) struct Disturber<'a> {
    effects: &'a Effects,
    gyro: GyroEffects<'a>,
    accel: AccelEffects,
    mag: MagEffects<'a>,
    bursts: Bursts,
    dropouts: DrawnDropouts,
}

impl<'a> Disturber<'a> {
    pub(in crate::simulate) fn new(effects: &'a Effects, period_s: f64, duration_s: f64, random: &mut Random) -> Self {
        Self {
            effects,
            gyro: GyroEffects::new(effects, period_s),
            accel: AccelEffects::new(effects, period_s),
            mag: MagEffects::new(effects, period_s),
            // Keep this order of draws: it fixes the trace of a seed.
            bursts: Bursts::new(&effects.magnetic_bursts, duration_s, random),
            dropouts: DrawnDropouts::new(&effects.dropouts, duration_s, random),
        }
    }

    /// Disturbance of the field at `t_s`, earth frame, microtesla.
    pub(in crate::simulate) fn burst_ut(&self, t_s: f64) -> Vector3<f64> {
        self.bursts.at(t_s)
    }

    /// Quantities that the sensors sense at `t_s` instead of the truth; call once for each sample, in order.
    pub(in crate::simulate) fn sensed(&mut self, t_s: f64, ideal: &Ideal) -> Ideal {
        Ideal {
            rate_rad_s: self.gyro.sensed(t_s, ideal.rate_rad_s),
            specific_force_m_s2: self.accel.sensed(ideal.specific_force_m_s2),
            field_ut: self.mag.sensed(t_s, ideal.field_ut, &ideal.rate_rad_s),
            ..*ideal
        }
    }

    /// Change of the gyro's bias at `t_s` and `warmer_c` above the temperature of the start, rad/s.
    pub(in crate::simulate) fn bias_change_rad_s(&self, t_s: f64, warmer_c: f64) -> Vector3<f64> {
        bias_change_rad_s(self.effects, t_s, warmer_c)
    }

    /// Additions to the gyro's reading at `t_s` and `warmer_c`, beside its bias and the scaled rate `P^-1 w`,
    /// rad/s.
    pub(in crate::simulate) fn gyro_additions_rad_s(
        &self,
        (t_s, warmer_c): (f64, f64),
        ideal: &Ideal,
        scaled_rad_s: &Vector3<f64>,
    ) -> Vector3<f64> {
        let scale = Vector3::from(self.effects.gyro_scale_temperature_percent_c) * (0.01 * warmer_c);
        self.gyro.additions_rad_s(t_s, ideal, scaled_rad_s) + scale.component_mul(scaled_rad_s)
    }

    /// Flags the readings that drop out as missing.
    pub(in crate::simulate) fn drop_out(&self, sample: &mut Sample) {
        self.dropouts.drop_out(sample);
    }
}
