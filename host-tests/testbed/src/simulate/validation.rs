//! Checks of a scenario's values.

use super::{
    error::ScenarioError,
    limits::{check, within},
    scenario::Scenario,
    sensors::matrix,
    temperature::Temperature,
};

impl Scenario {
    /// Checks every value.
    ///
    /// # Errors
    /// The first field that cannot be used.
    pub fn validate(&self) -> Result<(), ScenarioError> {
        let optional = |x: Option<f64>, low: f64, high: f64| x.is_none_or(|x| within(x, low, high));
        let band = |[low, high]: [f64; 2], highest: f64| low > 0.0 && low <= high && high <= highest;
        let nyquist_hz = 0.5e6 / f64::from(self.sample_period_us.max(1));
        check(within(self.duration_s, 0.1, 86_400.0), "duration_s", "0.1 to 86400")?;
        check((100..=50_000).contains(&self.sample_period_us), "sample_period_us", "100 to 50000")?;
        check(
            (2..=64).contains(&self.oversampling) && self.oversampling.is_multiple_of(2),
            "oversampling",
            "even, 2 to 64",
        )?;
        check(within(self.rest_s, 0.0, 86_400.0), "rest_s", "0 to 86400")?;
        check(self.stop_s.is_none_or(|x| within(x, 0.0, 86_400.0)), "stop_s", "0 to 86400")?;
        check(within(self.ramp_s, 0.1, 3_600.0), "ramp_s", "0.1 to 3600")?;
        check(within(self.hole.inclination_deg, 0.0, 180.0), "hole.inclination_deg", "0 to 180")?;
        check(within(self.hole.azimuth_deg, -360.0, 360.0), "hole.azimuth_deg", "-360 to 360")?;
        check(within(self.hole.build_rate_deg_h, -1e4, 1e4), "hole.build_rate_deg_h", "-10000 to 10000")?;
        check(within(self.hole.turn_rate_deg_h, -1e4, 1e4), "hole.turn_rate_deg_h", "-10000 to 10000")?;
        check(within(self.rotation.toolface_deg, -360.0, 360.0), "rotation.toolface_deg", "-360 to 360")?;
        check(within(self.rotation.mean_rpm, -1e3, 1e3), "rotation.mean_rpm", "-1000 to 1000")?;
        check(within(self.rotation.stick_slip, 0.0, 1.0), "rotation.stick_slip", "0 to 1")?;
        check(within(self.rotation.stick_slip_hz, 0.001, 10.0), "rotation.stick_slip_hz", "0.001 to 10")?;
        check(within(self.wobble.rms_deg, 0.0, 20.0), "wobble.rms_deg", "0 to 20")?;
        check(band(self.wobble.band_hz, nyquist_hz), "wobble.band_hz", "positive, rising, below half the sample rate")?;
        let vibration = &self.vibration;
        check(within(vibration.lateral_m_s2, 0.0, 1e3), "vibration.lateral_m_s2", "0 to 1000")?;
        check(within(vibration.axial_m_s2, 0.0, 1e3), "vibration.axial_m_s2", "0 to 1000")?;
        check(within(vibration.lowest_hz, 0.0, nyquist_hz), "vibration.lowest_hz", "0 to half the sample rate")?;
        check(within(vibration.chatter_m_s2, 0.0, 1e3), "vibration.chatter_m_s2", "0 to 1000")?;
        check((1..=1000).contains(&vibration.chatter_order), "vibration.chatter_order", "1 to 1000")?;
        check(within(vibration.angular_deg_s, 0.0, 1e3), "vibration.angular_deg_s", "0 to 1000")?;
        let below_nyquist = "positive, rising, below half the sample rate";
        check(band(vibration.angular_band_hz, nyquist_hz), "vibration.angular_band_hz", below_nyquist)?;
        let shocks = &self.shocks;
        check(within(shocks.per_minute, 0.0, 6_000.0), "shocks.per_minute", "0 to 6000")?;
        check(band(shocks.peak_g, 1e4), "shocks.peak_g", "positive, rising, at most 10000")?;
        check(band(shocks.length_ms, 1e3), "shocks.length_ms", "positive, rising, at most 1000")?;
        check(within(shocks.rebound_ms, 0.0, 1e3), "shocks.rebound_ms", "0 to 1000")?;
        let earth = &self.earth;
        check(within(earth.gravity_m_s2, 9.0, 10.5), "earth.gravity_m_s2", "9.0 to 10.5")?;
        check(within(earth.magnetic_field_ut, 0.0, 1e3), "earth.magnetic_field_ut", "0 to 1000")?;
        check(within(earth.dip_deg, -90.0, 90.0), "earth.dip_deg", "-90 to 90")?;
        check(optional(earth.latitude_deg, -90.0, 90.0), "earth.latitude_deg", "-90 to 90")?;
        let declination = optional(earth.magnetic_declination_deg, -180.0, 180.0);
        check(declination, "earth.magnetic_declination_deg", "-180 to 180")?;
        let gyro = &self.gyro;
        check(within(gyro.diagonal_sigma, 0.0, 0.2), "gyro.diagonal_sigma", "0 to 0.2")?;
        check(within(gyro.off_diagonal_sigma, 0.0, 0.1), "gyro.off_diagonal_sigma", "0 to 0.1")?;
        check(within(gyro.bias_sigma_deg_s, 0.0, 100.0), "gyro.bias_sigma_deg_s", "0 to 100")?;
        let invertible = |p: [[f64; 3]; 3]| matrix(p).determinant() > 1e-3;
        check(gyro.p.is_none_or(invertible), "gyro.p", "a matrix with a positive determinant")?;
        let small = |b: [f64; 3]| b.iter().all(|&x| within(x, -1e3, 1e3));
        check(gyro.bias_deg_s.is_none_or(small), "gyro.bias_deg_s", "-1000 to 1000")?;
        check(within(gyro.noise_deg_s_rthz, 0.0, 100.0), "gyro.noise_deg_s_rthz", "0 to 100")?;
        check(within(gyro.bias_walk_deg_s_rts, 0.0, 100.0), "gyro.bias_walk_deg_s_rts", "0 to 100")?;
        check(optional(gyro.resolution_deg_s, 1e-9, 100.0), "gyro.resolution_deg_s", "positive, at most 100")?;
        check(optional(gyro.full_scale_deg_s, 1.0, 1e6), "gyro.full_scale_deg_s", "1 to 1000000")?;
        let accel = &self.accel;
        check(within(accel.noise_ug_rthz, 0.0, 1e6), "accel.noise_ug_rthz", "0 to 1000000")?;
        check(optional(accel.resolution_m_s2, 1e-9, 100.0), "accel.resolution_m_s2", "positive, at most 100")?;
        check(optional(accel.full_scale_g, 0.1, 1e6), "accel.full_scale_g", "0.1 to 1000000")?;
        check(within(self.mag.noise_ut, 0.0, 1e3), "mag.noise_ut", "0 to 1000")?;
        check(optional(self.mag.resolution_ut, 1e-9, 100.0), "mag.resolution_ut", "positive, at most 100")?;
        check(optional(self.mag.full_scale_ut, 0.1, 1e6), "mag.full_scale_ut", "0.1 to 1000000")?;
        self.temperature.as_ref().map_or(Ok(()), Temperature::validate)?;
        let steady = self.effects.gyro_bias_temperature_deg_s_c == [0.0; 3];
        let field = "effects.gyro_bias_temperature_deg_s_c";
        check(steady || self.temperature.is_some(), field, "zero where the scenario has no [temperature]")?;
        let steady = self.effects.gyro_scale_temperature_percent_c == [0.0; 3];
        let field = "effects.gyro_scale_temperature_percent_c";
        check(steady || self.temperature.is_some(), field, "zero where the scenario has no [temperature]")?;
        self.effects.validate()
    }
}
