//! Effects that a scenario can ask for, each off by default.

use serde::Deserialize;

use super::{
    dropouts::Dropouts, hard_iron_interval::HardIronInterval, magnetic_bursts::MagneticBursts,
    mount_rotation::MountRotation,
};

/// Effects on what the sensors sense, tool axes. A reading is `(I + matrix) v(t - lag) + offset`; the gyro's
/// is `P^-1 w + b` with these effects.
///
/// The typical sizes are those of MEMS sensors and magnetometers in a rotating probe.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Effects {
    /// Soft iron and misalignment of the magnetometer, row by row, added to the identity. Typical 0.01 to
    /// 0.05. Default zero.
    pub mag_matrix: [[f64; 3]; 3],
    /// Hard iron, microtesla; along z it is the axial interference of the string. Typical 1 to 10. Default
    /// zero.
    pub hard_iron_ut: [f64; 3],
    /// Hard iron that comes and goes, on top of `hard_iron_ut`. Default: none.
    pub hard_iron_intervals: Vec<HardIronInterval>,
    /// Delay of the magnetometer, milliseconds. Typical 5 to 15. Default 0.
    pub mag_lag_ms: f64,
    /// Time constant of the eddy currents in a conductive collar that turns with the sensor, milliseconds.
    /// The field h that they let through lags behind: `h + tau w_z (z x h)` with the axial rate w_z, so only
    /// the part across the tool axis is changed, as by a `mag_lag_ms` under axial rotation, to first order.
    /// Typical 0.5 to 3.5: 0.1 to 0.6 deg at 30 rpm. Default 0.
    pub eddy_lag_ms: f64,
    /// Magnetic bursts, as casing joints make them.
    pub magnetic_bursts: MagneticBursts,
    /// Scale factors and misalignment of the accelerometer, row by row, added to the identity. Typical 0.005
    /// to 0.02. Default zero.
    pub accel_matrix: [[f64; 3]; 3],
    /// Zero offset of the accelerometer, m/s^2. Typical 0.05 to 0.3. Default zero.
    pub accel_bias_m_s2: [f64; 3],
    /// Delay of the accelerometer, milliseconds. Typical 2 to 5. Default 0.
    pub accel_lag_ms: f64,
    /// From the centre of rotation to the accelerometer, tool axes, millimetres: it adds `w x (w x r) + w' x
    /// r`, the mean over the sample interval, with the rate and its derivative from the truth. Typical 10 to
    /// 50 (20 mm off the axis: 0.02 g at 30 rpm). Default zero.
    pub lever_arm_mm: [f64; 3],
    /// Sensitivity of the gyro to specific force along its own axes, deg/s per g, row by row. Typical 0.01 to
    /// 0.1. Default zero.
    pub g_sensitivity_deg_s_g: [[f64; 3]; 3],
    /// Rectified vibration in the gyro: `k |a|^2` on each axis, deg/s per g^2, where a is specific force of
    /// the same sample (without its lag and errors) minus gravity's: vibration, shocks and the lever arm's
    /// part. Typical 0.0001 to 0.01, more near a resonance of the sensor. Default zero.
    pub vibration_rectification_deg_s_g2: [f64; 3],
    /// Delay of the gyro's rate, not of what is added to it, milliseconds. Typical 2 to 5. Default 0.
    pub gyro_lag_ms: f64,
    /// Nonlinearity of the gyro's scale: `k u^3` is added to the rate `u = P^-1 w` of each axis, s^2/rad^2.
    /// Typical 1e-5 to 1e-3,
    /// 0.01 to 1 % at 180 deg/s. Default zero.
    pub gyro_scale_nonlinearity_s2_rad2: [f64; 3],
    /// Half the difference of the gyro's scales for positive and negative rates: `k |u|` is added to the rate
    /// `u = P^-1 w` of each axis, no unit. Typical 1e-4 to 5e-3. Default zero.
    pub gyro_scale_asymmetry: [f64; 3],
    /// A step of the gyro's bias, deg/s. Typical 0.1 to 1. Default zero.
    pub bias_step_deg_s: [f64; 3],
    /// Time of the step, seconds: the first shock after it, or this time if no shock follows. Default 0.
    pub bias_step_after_s: f64,
    /// Change of the gyro's bias with the temperature since the start of the run, deg/s per degree Celsius;
    /// needs `[temperature]`. Typical 0.005 to 0.05. Default zero.
    pub gyro_bias_temperature_deg_s_c: [f64; 3],
    /// Change of the gyro's scale on each axis with the temperature since the start of the run, percent per
    /// degree Celsius; needs `[temperature]`. Typical 0.005 to 0.02. Default zero.
    pub gyro_scale_temperature_percent_c: [f64; 3],
    /// Amplitude of a sine in the gyro's bias that begins at zero and rises, deg/s. Not in the library of
    /// effects. Typical 0.05 to 0.5, as of a regulator or a pump near by. Default zero.
    pub periodic_bias_deg_s: [f64; 3],
    /// Period of that sine, seconds. Required if there is an amplitude. Default 0.
    pub periodic_bias_period_s: f64,
    /// Turn of the gyro in its mount. Not in the library of effects. Default: none.
    pub mount_rotation: Option<MountRotation>,
    /// Dropouts: times without a reading of one sensor.
    pub dropouts: Dropouts,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::{Scenario, Temperature};

    const EVERY_EFFECT: &str = "
        [temperature]
        start_c = 30.0
        end_c = 70.0
        swing_c = 2.0
        swing_period_s = 120.0

        [effects]
        mag_matrix = [[0.01, 0.0, 0.0], [0.0, -0.01, 0.0], [0.0, 0.0, 0.0]]
        hard_iron_ut = [1.0, 2.0, 3.0]
        mag_lag_ms = 11.0
        eddy_lag_ms = 2.0
        accel_matrix = [[0.01, 0.0, 0.0], [0.0, -0.01, 0.0], [0.0, 0.0, 0.0]]
        accel_bias_m_s2 = [0.1, 0.0, 0.0]
        accel_lag_ms = 2.5
        lever_arm_mm = [12.0, 0.0, 3.0]
        g_sensitivity_deg_s_g = [[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.05]]
        vibration_rectification_deg_s_g2 = [0.001, 0.0, 0.002]
        gyro_lag_ms = 4.0
        gyro_scale_nonlinearity_s2_rad2 = [1e-4, 0.0, -1e-4]
        gyro_scale_asymmetry = [0.001, 0.0, 0.0]
        bias_step_deg_s = [0.5, 0.0, 0.0]
        bias_step_after_s = 100.0
        gyro_bias_temperature_deg_s_c = [0.01, 0.0, -0.02]
        gyro_scale_temperature_percent_c = [0.01, 0.0, 0.02]
        periodic_bias_deg_s = [0.1, 0.0, 0.0]
        periodic_bias_period_s = 20.0

        [[effects.hard_iron_intervals]]
        from_s = 60.0
        to_s = 90.0
        offset_ut = [20.0, -5.0, 0.0]

        [[effects.hard_iron_intervals]]
        from_s = 120.0
        to_s = 130.0
        offset_ut = [0.0, 0.0, 8.0]
        ramp_s = 2.0

        [effects.magnetic_bursts]
        per_minute = 1.0
        length_s = 3.0
        peak_ut = 4.0

        [effects.mount_rotation]
        from_s = 200.0
        rotation_deg = [1.0, 0.0, -2.0]

        [effects.dropouts]
        per_minute = 2.0
        length_s = 0.2
    ";

    #[test]
    fn a_file_can_ask_for_every_effect() {
        let scenario: Scenario = toml::from_str(EVERY_EFFECT).unwrap_or_default();
        assert!(scenario.validate().is_ok());
        let warming = Temperature { start_c: 30.0, end_c: Some(70.0), swing_c: 2.0, swing_period_s: 120.0 };
        assert_eq!(scenario.temperature, Some(warming));
        let lopsided = [[0.01, 0.0, 0.0], [0.0, -0.01, 0.0], [0.0; 3]];
        // Every field by name, so that a new effect does not build until it is added here.
        let expected = Effects {
            mag_matrix: lopsided,
            hard_iron_ut: [1.0, 2.0, 3.0],
            hard_iron_intervals: vec![
                HardIronInterval { from_s: 60.0, to_s: 90.0, offset_ut: [20.0, -5.0, 0.0], ramp_s: 0.3 },
                HardIronInterval { from_s: 120.0, to_s: 130.0, offset_ut: [0.0, 0.0, 8.0], ramp_s: 2.0 },
            ],
            mag_lag_ms: 11.0,
            eddy_lag_ms: 2.0,
            magnetic_bursts: MagneticBursts { per_minute: 1.0, length_s: 3.0, peak_ut: 4.0 },
            accel_matrix: lopsided,
            accel_bias_m_s2: [0.1, 0.0, 0.0],
            accel_lag_ms: 2.5,
            lever_arm_mm: [12.0, 0.0, 3.0],
            g_sensitivity_deg_s_g: [[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.05]],
            vibration_rectification_deg_s_g2: [0.001, 0.0, 0.002],
            gyro_lag_ms: 4.0,
            gyro_scale_nonlinearity_s2_rad2: [1e-4, 0.0, -1e-4],
            gyro_scale_asymmetry: [0.001, 0.0, 0.0],
            bias_step_deg_s: [0.5, 0.0, 0.0],
            bias_step_after_s: 100.0,
            gyro_bias_temperature_deg_s_c: [0.01, 0.0, -0.02],
            gyro_scale_temperature_percent_c: [0.01, 0.0, 0.02],
            periodic_bias_deg_s: [0.1, 0.0, 0.0],
            periodic_bias_period_s: 20.0,
            mount_rotation: Some(MountRotation { from_s: 200.0, rotation_deg: [1.0, 0.0, -2.0], ramp_s: 1.0 }),
            dropouts: Dropouts { per_minute: 2.0, length_s: 0.2 },
        };
        assert_eq!(scenario.effects, expected);
    }

    #[test]
    fn what_no_effect_has_is_refused_by_name() {
        for (text, unknown) in [
            ("[effects]\nmag_lag_s = 0.01", "mag_lag_s"),
            ("[temperature]\nramp_c = 3.0", "ramp_c"),
            ("[[effects.hard_iron_intervals]]\nfrom_s = 1.0\nto_s = 2.0\noffset = [1.0, 0.0, 0.0]", "offset"),
            ("[effects.mount_rotation]\nfrom_s = 1.0\nrotation_rad = [1.0, 0.0, 0.0]", "rotation_rad"),
        ] {
            let error = toml::from_str::<Scenario>(text).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.contains(&format!("unknown field `{unknown}`")), "{error}");
        }
        let without_times = "[[effects.hard_iron_intervals]]\noffset_ut = [1.0, 0.0, 0.0]";
        assert!(toml::from_str::<Scenario>(without_times).is_err());
    }
}
