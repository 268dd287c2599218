//! What the simulator adds in each case, and by what names it counts as named right.

use crate::simulate::{Random, Scenario};

/// One case.
pub(super) struct Case {
    pub name: &'static str,
    /// Its own name, and those that it cannot be told from. Empty: outside the library, or nothing.
    pub names: &'static [&'static str],
    /// Adds it, with a size drawn at random in the range that data sheets give.
    pub add: fn(&mut Scenario, &mut Random),
}

/// A vector of random direction whose length is between half of `largest` and it.
fn vector(random: &mut Random, largest: f64) -> [f64; 3] {
    let length = random.between(0.5 * largest, largest);
    random.direction().map(|x| x * length)
}

fn matrix(random: &mut Random, largest: f64) -> [[f64; 3]; 3] {
    [(); 3].map(|()| [(); 3].map(|()| random.sign() * random.between(0.5 * largest, largest)))
}

/// All of them.
pub(super) const CASES: &[Case] = &[
    Case { name: "nothing", names: &[], add: |_, _| {} },
    Case { name: "mag_lag", names: &["mag_lag", "eddy_lag"], add: |s, r| s.effects.mag_lag_ms = r.between(4.0, 15.0) },
    Case {
        name: "gyro_lag",
        names: &["gyro_lag", "mag_lag", "eddy_lag"],
        add: |s, r| s.effects.gyro_lag_ms = r.between(3.0, 8.0),
    },
    Case {
        name: "hard_iron",
        names: &["hard_iron", "axial_interference", "soft_iron"],
        add: |s, r| s.effects.hard_iron_ut = vector(r, 8.0),
    },
    Case {
        name: "soft_iron",
        names: &["soft_iron", "hard_iron", "axial_interference"],
        add: |s, r| s.effects.mag_matrix = matrix(r, 0.03),
    },
    Case { name: "accel_bias", names: &["accel_bias"], add: |s, r| s.effects.accel_bias_m_s2 = vector(r, 0.5) },
    Case {
        name: "lever_arm",
        names: &["lever_arm"],
        add: |s, r| s.accel.lever_arm_m = vector(r, 0.05),
    },
    Case {
        name: "g_sensitivity",
        names: &["g_sensitivity"],
        add: |s, r| s.effects.g_sensitivity_deg_s_g = matrix(r, 0.1),
    },
];
