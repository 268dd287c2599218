//! A configuration that cannot be used names its field.

use super::*;
use core::f32::consts::FRAC_PI_2;

#[test]
fn the_default_is_valid_and_a_bad_field_is_named() {
    assert_eq!(Config::default().validate(), Ok(()));
    let mut config = Config::default();
    config.identification.step_s = 1.0;
    assert_eq!(config.validate().map_err(|e| e.field), Err("identification.step_s"));
    config = Config::default();
    config.gyro.p[0][0] = f32::NAN;
    assert_eq!(config.validate().map_err(|e| e.field), Err("gyro"));
    config = Config::default();
    config.latency.mag_s = Some(-0.001);
    assert_eq!(config.validate().map_err(|e| e.field), Err("latency.mag_s"));
    // Degrees in place of radians.
    config = Config::default();
    config.earth.latitude_rad = Some(45.0);
    assert_eq!(config.validate().map_err(|e| e.field), Err("earth.latitude_rad"));
    config.earth.latitude_rad = Some(-FRAC_PI_2);
    config.earth.dip_rad = Some(f32::NAN);
    assert_eq!(config.validate().map_err(|e| e.field), Err("earth.dip_rad"));
    config.earth.dip_rad = Some(FRAC_PI_2);
    assert_eq!(config.validate(), Ok(()));
    config = Config::default();
    config.survey.near_vertical_rad = 0.0;
    assert_eq!(config.validate().map_err(|e| e.field), Err("survey.near_vertical_rad"));
}
