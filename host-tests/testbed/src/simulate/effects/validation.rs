//! Checks of the effects' settings.

use super::{Effects, HardIronInterval, MountRotation};
use crate::simulate::{
    error::ScenarioError,
    limits::{all_within, check, within},
};

impl Effects {
    /// Checks every value.
    pub(in crate::simulate) fn validate(&self) -> Result<(), ScenarioError> {
        check(all_within(self.mag_matrix.as_flattened(), 0.2), "effects.mag_matrix", "-0.2 to 0.2")?;
        check(all_within(&self.hard_iron_ut, 1e3), "effects.hard_iron_ut", "-1000 to 1000")?;
        self.hard_iron_intervals.iter().try_for_each(HardIronInterval::validate)?;
        check(within(self.mag_lag_ms, 0.0, 1e3), "effects.mag_lag_ms", "0 to 1000")?;
        check(within(self.eddy_lag_ms, 0.0, 100.0), "effects.eddy_lag_ms", "0 to 100")?;
        self.magnetic_bursts.validate()?;
        check(all_within(self.accel_matrix.as_flattened(), 0.2), "effects.accel_matrix", "-0.2 to 0.2")?;
        check(all_within(&self.accel_bias_m_s2, 100.0), "effects.accel_bias_m_s2", "-100 to 100")?;
        check(within(self.accel_lag_ms, 0.0, 1e3), "effects.accel_lag_ms", "0 to 1000")?;
        check(all_within(&self.lever_arm_mm, 1e4), "effects.lever_arm_mm", "-10000 to 10000")?;
        let g_sensitivity = self.g_sensitivity_deg_s_g.as_flattened();
        check(all_within(g_sensitivity, 100.0), "effects.g_sensitivity_deg_s_g", "-100 to 100")?;
        let rectification = all_within(&self.vibration_rectification_deg_s_g2, 10.0);
        check(rectification, "effects.vibration_rectification_deg_s_g2", "-10 to 10")?;
        check(within(self.gyro_lag_ms, 0.0, 1e3), "effects.gyro_lag_ms", "0 to 1000")?;
        let nonlinearity = all_within(&self.gyro_scale_nonlinearity_s2_rad2, 0.1);
        check(nonlinearity, "effects.gyro_scale_nonlinearity_s2_rad2", "-0.1 to 0.1")?;
        check(all_within(&self.gyro_scale_asymmetry, 0.2), "effects.gyro_scale_asymmetry", "-0.2 to 0.2")?;
        check(all_within(&self.bias_step_deg_s, 100.0), "effects.bias_step_deg_s", "-100 to 100")?;
        check(within(self.bias_step_after_s, 0.0, 86_400.0), "effects.bias_step_after_s", "0 to 86400")?;
        let with_temperature = all_within(&self.gyro_bias_temperature_deg_s_c, 10.0);
        check(with_temperature, "effects.gyro_bias_temperature_deg_s_c", "-10 to 10")?;
        let with_temperature = all_within(&self.gyro_scale_temperature_percent_c, 10.0);
        check(with_temperature, "effects.gyro_scale_temperature_percent_c", "-10 to 10")?;
        check(all_within(&self.periodic_bias_deg_s, 100.0), "effects.periodic_bias_deg_s", "-100 to 100")?;
        let no_sine = self.periodic_bias_deg_s == [0.0; 3] && self.periodic_bias_period_s == 0.0;
        let period = no_sine || within(self.periodic_bias_period_s, 0.01, 86_400.0);
        check(period, "effects.periodic_bias_period_s", "0.01 to 86400")?;
        self.mount_rotation.as_ref().map_or(Ok(()), MountRotation::validate)?;
        self.dropouts.validate()
    }
}

#[cfg(test)]
mod tests {
    use crate::simulate::Scenario;

    #[test]
    fn a_value_out_of_bounds_is_refused_by_name() {
        let magnet = "[[effects.hard_iron_intervals]]\noffset_ut = [1.0, 0.0, 0.0]\n";
        for (text, field) in [
            ("[effects]\naccel_lag_ms = -1.0".to_owned(), "effects.accel_lag_ms"),
            ("[effects]\neddy_lag_ms = nan".to_owned(), "effects.eddy_lag_ms"),
            ("[effects]\nlever_arm_mm = [0.0, 2e4, 0.0]".to_owned(), "effects.lever_arm_mm"),
            (
                "[effects]\nvibration_rectification_deg_s_g2 = [0.0, 0.0, 11.0]".to_owned(),
                "effects.vibration_rectification_deg_s_g2",
            ),
            (
                "[effects]\ngyro_scale_nonlinearity_s2_rad2 = [1.0, 0.0, 0.0]".to_owned(),
                "effects.gyro_scale_nonlinearity_s2_rad2",
            ),
            ("[effects]\ngyro_scale_asymmetry = [1.0, 0.0, 0.0]".to_owned(), "effects.gyro_scale_asymmetry"),
            ("[effects]\nperiodic_bias_deg_s = [0.1, 0.0, 0.0]".to_owned(), "effects.periodic_bias_period_s"),
            (
                "[effects]\ngyro_bias_temperature_deg_s_c = [0.1, 0.0, 0.0]".to_owned(),
                "effects.gyro_bias_temperature_deg_s_c",
            ),
            ("[temperature]\nend_c = 1000.0".to_owned(), "temperature.end_c"),
            ("[temperature]\nswing_period_s = 0.0".to_owned(), "temperature.swing_period_s"),
            (format!("{magnet}from_s = 20.0\nto_s = 10.0"), "effects.hard_iron_intervals.to_s"),
            (format!("{magnet}from_s = 20.0\nto_s = 21.0\nramp_s = 2.0"), "effects.hard_iron_intervals.ramp_s"),
            (
                "[effects.mount_rotation]\nfrom_s = 1.0\nrotation_deg = [200.0, 0.0, 0.0]".to_owned(),
                "effects.mount_rotation.rotation_deg",
            ),
        ] {
            let scenario = toml::from_str::<Scenario>(&text).unwrap_or_default();
            let error = scenario.validate().err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.starts_with(&format!("scenario: {field} must be")), "{text}: {error}");
        }
    }
}
