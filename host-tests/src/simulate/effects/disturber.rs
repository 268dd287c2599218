//! All effects of a run together.

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

/// The effects of a run, sample by sample, in the order in which a sample meets them:
///
/// - gyro: turn of the mount, delay; then `P^-1 w`, what is added to it, bias;
/// - accelerometer: lever arm (which is in the truth already), delay, matrix, offset;
/// - magnetometer: bursts (in the truth already), eddy currents, delay, matrix, hard iron.
///
/// Nothing random is drawn for an effect that is off.
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
            // Drawn in this order.
            bursts: Bursts::new(&effects.magnetic_bursts, duration_s, random),
            dropouts: DrawnDropouts::new(&effects.dropouts, duration_s, random),
        }
    }

    /// The disturbance of the field at `t_s`, earth frame, microtesla.
    pub(in crate::simulate) fn burst_ut(&self, t_s: f64) -> Vector3<f64> {
        self.bursts.at(t_s)
    }

    /// What the sensors sense at `t_s` instead of the truth; once for each sample, in order.
    pub(in crate::simulate) fn sensed(&mut self, t_s: f64, ideal: &Ideal) -> Ideal {
        Ideal {
            rate_rad_s: self.gyro.sensed(t_s, ideal.rate_rad_s),
            specific_force_m_s2: self.accel.sensed(ideal.specific_force_m_s2),
            field_ut: self.mag.sensed(t_s, ideal.field_ut, &ideal.rate_rad_s),
            ..*ideal
        }
    }

    /// What is added to the gyro's bias at `t_s`, when it is so much warmer than at the start of the run, rad/s.
    pub(in crate::simulate) fn bias_change_rad_s(&self, t_s: f64, warmer_c: f64) -> Vector3<f64> {
        bias_change_rad_s(self.effects, t_s, warmer_c)
    }

    /// What the gyro reads at `t_s`, so much warmer than at the start of the run, beside its bias and a scaled rate `P^-1 w`, rad/s.
    pub(in crate::simulate) fn gyro_additions_rad_s(
        &self,
        (t_s, warmer_c): (f64, f64),
        ideal: &Ideal,
        scaled_rad_s: &Vector3<f64>,
    ) -> Vector3<f64> {
        let scale = Vector3::from(self.effects.gyro_scale_temperature_percent_c) * (0.01 * warmer_c);
        self.gyro.additions_rad_s(t_s, ideal, scaled_rad_s) + scale.component_mul(scaled_rad_s)
    }

    /// Takes out the readings that drop out.
    pub(in crate::simulate) fn drop_out(&self, sample: &mut Sample) {
        self.dropouts.drop_out(sample);
    }
}
