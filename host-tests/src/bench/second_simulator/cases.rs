//! The cases: what is added to a run, and the names that are right for it.

use crate::second_simulator::{Added, Plan};
use testbed::simulate::Random;

pub(super) struct Case {
    pub name: &'static str,
    /// Its own name and those that cannot be told from it; none for a run without an effect.
    pub names: &'static [&'static str],
    pub add: fn(&mut Plan, &mut Added, &mut Random),
}

/// A vector of random direction with a length between half of `largest` and that.
fn vector(random: &mut Random, largest: f64) -> [f64; 3] {
    let length = random.between(0.5 * largest, largest);
    random.direction().map(|x| x * length)
}

fn matrix(random: &mut Random, largest: f64) -> [[f64; 3]; 3] {
    [(); 3].map(|()| vector(random, largest))
}

/// Warms by 25 to 50 K.
fn warm(plan: &mut Plan, random: &mut Random) {
    plan.temperature = Some([random.between(20.0, 60.0), random.between(25.0, 50.0)]);
}

const DEG: f64 = std::f64::consts::PI / 180.0;
const G: f64 = 9.806_65;

/// All of them. Lags of two sensors are one another's aliases: only the difference of two delays shows.
pub(super) const CASES: [Case; 20] = [
    Case { name: "nothing", names: &[], add: |_, _, _| {} },
    Case { name: "nothing, vertical", names: &[], add: |plan, _, _| plan.inclination_deg = [0.0, 2.0] },
    Case { name: "nothing, warming", names: &[], add: |plan, _, random| warm(plan, random) },
    Case {
        name: "gyro_lag",
        names: &["gyro_lag", "mag_lag", "eddy_lag", "accel_lag"],
        add: |_, added, random| added.gyro_lag_s = random.between(0.003, 0.012),
    },
    Case {
        name: "mag_lag",
        names: &["mag_lag", "eddy_lag", "gyro_lag"],
        add: |_, added, random| added.mag_lag_s = random.between(0.004, 0.015),
    },
    Case {
        name: "accel_lag",
        names: &["accel_lag", "gyro_lag"],
        add: |_, added, random| added.accel_lag_s = random.between(0.003, 0.01),
    },
    Case {
        name: "eddy_lag",
        names: &["eddy_lag", "mag_lag", "gyro_lag"],
        add: |_, added, random| added.eddy_lag_s = random.between(0.001, 0.005),
    },
    Case {
        name: "lever_arm",
        names: &["lever_arm"],
        add: |_, added, random| {
            added.lever_arm_m = vector(random, 0.08);
            added.lever_arm_m[2] = 0.0;
        },
    },
    Case {
        name: "g_sensitivity",
        names: &["g_sensitivity"],
        add: |_, added, random| added.g_sensitivity_s_m = matrix(random, 0.3 * DEG / G),
    },
    Case {
        name: "vibration_rectification",
        names: &["vibration_rectification"],
        add: |_, added, random| added.rectification_s3_m2 = vector(random, 1.5 * DEG / (G * G)),
    },
    Case {
        name: "gyro_scale_nonlinearity",
        names: &["gyro_scale_nonlinearity"],
        add: |_, added, random| {
            added.nonlinearity_s2_rad2 = [0.0, 0.0, random.sign() * random.between(2e-5, 1e-4)];
        },
    },
    Case {
        name: "gyro_scale_asymmetry",
        names: &["gyro_scale_asymmetry"],
        add: |plan, added, random| {
            plan.reverses = true;
            added.asymmetry = [0.0, 0.0, random.sign() * random.between(5e-3, 2e-2)];
        },
    },
    Case {
        name: "gyro_bias_temperature",
        names: &["gyro_bias_temperature"],
        add: |plan, added, random| {
            warm(plan, random);
            added.bias_per_k = vector(random, 0.05 * DEG);
        },
    },
    Case {
        name: "gyro_scale_temperature",
        names: &["gyro_scale_temperature"],
        add: |plan, added, random| {
            warm(plan, random);
            added.scale_per_k = vector(random, 6e-4);
        },
    },
    Case {
        name: "gyro_bias_step",
        names: &["gyro_bias_step"],
        add: |plan, added, random| {
            added.bias_step_rad_s = vector(random, 0.6 * DEG);
            added.bias_step_at_s = random.between(60.0, 110.0);
            plan.shock_s = Some(added.bias_step_at_s);
        },
    },
    Case {
        name: "hard_iron",
        names: &["hard_iron", "axial_interference", "soft_iron"],
        add: |_, added, random| added.hard_iron_ut = vector(random, 8.0),
    },
    Case {
        name: "axial_interference",
        names: &["axial_interference", "hard_iron", "soft_iron"],
        add: |_, added, random| added.hard_iron_ut = [0.0, 0.0, random.sign() * random.between(3.0, 10.0)],
    },
    Case {
        name: "soft_iron",
        names: &["soft_iron", "hard_iron", "axial_interference"],
        add: |_, added, random| added.soft_iron = matrix(random, 0.05),
    },
    Case {
        name: "accel_bias",
        names: &["accel_bias"],
        add: |_, added, random| added.accel_bias_m_s2 = vector(random, 0.5),
    },
    Case {
        name: "accel_temperature",
        names: &["accel_temperature", "accel_bias"],
        add: |plan, added, random| {
            warm(plan, random);
            added.accel_bias_per_k = vector(random, 0.015);
        },
    },
];
