//! Scenarios without some of their errors, and readings from their traces.

use crate::rig::{files::scenario, rotation::rotation};
use nalgebra::{UnitQuaternion, Vector3};
use testbed::{
    simulate::{Scenario, ShockSettings, Vibration, Wobble},
    trace::Trace,
};

pub const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub fn files() -> [Scenario; 2] {
    ["drilling_vertical", "drilling_45deg"].map(scenario)
}

/// A perfect gyro, accelerometer and magnetometer.
pub fn without_sensor_errors(mut scenario: Scenario) -> Scenario {
    scenario.gyro.p = Some(IDENTITY);
    scenario.gyro.bias_deg_s = Some([0.0; 3]);
    scenario.gyro.noise_deg_s_rthz = 0.0;
    scenario.gyro.bias_walk_deg_s_rts = 0.0;
    scenario.accel.noise_ug_rthz = 0.0;
    scenario.mag.noise_ut = 0.0;
    scenario
}

/// Rotation alone: no vibration, no shocks, no wobble.
pub fn smooth(scenario: Scenario) -> Scenario {
    Scenario {
        vibration: Vibration::none(),
        shocks: ShockSettings { per_minute: 0.0, ..scenario.shocks },
        wobble: Wobble { rms_deg: 0.0, ..scenario.wobble },
        ..scenario
    }
}

pub fn attitude(trace: &Trace, i: usize) -> UnitQuaternion<f64> {
    rotation(trace.reference[i].unwrap())
}

pub fn vector(v: [f32; 3]) -> Vector3<f64> {
    Vector3::from(v.map(f64::from))
}
