//! Scenarios for tests of effects: no noise and a perfect gyro, so that only the effect is left.

use meerkat_mwd::Sample;
use nalgebra::Vector3;

use super::Effects;
use crate::simulate::{Gyro, Hole, Rotation, Scenario, ShockSettings, Vibration, Wobble, simulate};

/// Drilling for 40 s.
pub(super) fn drilling(effects: &Effects) -> Scenario {
    let mut scenario = Scenario { duration_s: 40.0, effects: effects.clone(), ..Scenario::default() };
    scenario.gyro = Gyro {
        p: Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        bias_deg_s: Some([0.0; 3]),
        noise_deg_s_rthz: 0.0,
        bias_walk_deg_s_rts: 0.0,
        ..Gyro::default()
    };
    scenario.accel.noise_ug_rthz = 0.0;
    scenario.mag.noise_ut = 0.0;
    scenario
}

/// Rotation about z alone, steady from [`STEADY`] on.
pub(super) fn turning(effects: &Effects, mean_rpm: f64) -> Scenario {
    let scenario = drilling(effects);
    Scenario {
        hole: Hole { build_rate_deg_h: 0.0, turn_rate_deg_h: 0.0, ..Hole::default() },
        rotation: Rotation { mean_rpm, stick_slip: 0.0, ..Rotation::default() },
        wobble: Wobble { rms_deg: 0.0, ..Wobble::default() },
        vibration: Vibration::none(),
        shocks: ShockSettings { per_minute: 0.0, ..ShockSettings::default() },
        ..scenario
    }
}

/// First sample of a turning run after rest and ramp.
pub(super) const STEADY: usize = 1_301;

/// Readings while drilling.
pub(super) fn readings(effects: &Effects) -> Vec<Sample> {
    samples(&drilling(effects))
}

/// Readings of a valid scenario.
pub(super) fn samples(scenario: &Scenario) -> Vec<Sample> {
    assert!(scenario.validate().is_ok());
    simulate(scenario, 1).0.samples
}

pub(super) fn vector(v: [f32; 3]) -> Vector3<f64> {
    Vector3::from(v.map(f64::from))
}
