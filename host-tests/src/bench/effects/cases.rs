//! Cases of the simulator's effects, with the names that count as right.

use std::sync::LazyLock;

use meerkat_mwd::{
    compensation::{
        Effect,
        effects::{
            AccelBias, AccelLag, AccelScale, AxialInterference, EddyLag, GSensitivity, GyroBiasStep,
            GyroBiasTemperature, GyroLag, GyroScaleAsymmetry, GyroScaleNonlinearity, GyroScaleTemperature, HardIron,
            LIBRARY, LeverArm, MagLag, SoftIron, VibrationRectification,
        },
    },
    diagnosis::Verdict,
};

use super::{
    observable::Observability,
    trial::{Library, Outcome},
};
use testbed::simulate::{MountRotation, Random, Scenario, Temperature};

/// The library without soft iron.
static WITHOUT_SOFT_IRON: LazyLock<Vec<&dyn Effect>> =
    LazyLock::new(|| LIBRARY.into_iter().filter(|effect| effect.name() != SoftIron.name()).collect());

/// Errors of accelerometer and magnetometer, of which every part has some within its data sheet.
const OF_VECTORS: [&dyn Effect; 5] = [&HardIron, &SoftIron, &AxialInterference, &AccelBias, &AccelScale];

/// Returns true if a name is that of an error of accelerometer or magnetometer which every part has.
pub(in crate::bench) fn is_of_vectors(name: &str) -> bool {
    OF_VECTORS.iter().any(|effect| effect.name() == name)
}

/// One case.
pub(in crate::bench) struct Case {
    pub name: &'static str,
    /// Effects that are accepted for each effect of the case: itself, and those it cannot be told from. Empty if
    /// there is no effect, or none like the library's.
    pub effects: &'static [&'static [&'static dyn Effect]],
    /// Adds the effects, with sizes drawn from the range of data sheets.
    pub add: fn(&mut Scenario, &mut Random),
}

const SOFT_IRON_OUTSIDE: &str = "outside: soft iron of 1 %, not in the library";
const SYMMETRIC_OUTSIDE: &str = "outside: the same, symmetric";

impl Case {
    /// The library of effects to fly the case with.
    pub(super) fn library(&self) -> Library {
        if self.is_outside() { &WITHOUT_SOFT_IRON } else { &LIBRARY }
    }
    /// Returns true if the case is one effect of the library.
    pub(in crate::bench) fn is_alone(&self) -> bool {
        self.effects.len() == 1 && !self.is_outside()
    }
    /// Returns true if the case is a soft iron that the library lacks.
    fn is_outside(&self) -> bool {
        [SOFT_IRON_OUTSIDE, SYMMETRIC_OUTSIDE].contains(&self.name)
    }
    /// Name of the case's effect; of the first if there are several.
    pub(super) fn own_name(&self) -> Option<&'static str> {
        self.effects.first()?.first().map(|effect| effect.name())
    }
    /// True if what was drawn can be seen and matters; `None` unless it is one effect. Soft iron equals turned
    /// axes and a hard iron, apart from its symmetric part across the tool axis: if the library lacks it,
    /// that part must turn the field by more than the tolerated residual.
    pub(super) fn is_observable(&self, scenario: &Scenario, seed: u64) -> Option<bool> {
        if self.is_outside() {
            let [[xx, xy, _], [yx, yy, _], _] = scenario.effects.mag_matrix;
            let turned_rad = (xx - yy).hypot(xy + yx) / 2.0 * share_across(scenario);
            return Some(turned_rad > LEAST_LEFT_DEG.to_radians());
        }
        let effect = LIBRARY.iter().find(|effect| self.is_alone() && Some(effect.name()) == self.own_name())?;
        Some(Observability::of(scenario, seed).is_expected(effect.parameters().len()))
    }
    /// Returns true if the outcome is right: the effect named, or the residual unexplained if the library lacks it.
    pub(super) fn is_met(&self, outcome: &Outcome) -> bool {
        if self.is_outside() {
            outcome.verdict == Some(Verdict::UnexplainedResidual)
        } else {
            self.is_named_by(&outcome.names)
        }
    }
    /// Returns true if a name is that of one of the effects, or of one that cannot be told from it.
    pub(in crate::bench) fn allows(&self, name: &str) -> bool {
        self.effects.iter().copied().flatten().any(|effect| effect.name() == name)
    }
    /// Returns true if all effects are among the names found.
    pub(super) fn is_named_by(&self, found: &[&str]) -> bool {
        self.effects.iter().all(|alike| alike.iter().any(|effect| found.contains(&effect.name())))
    }
}

/// Residual of the field that is tolerated, degrees.
const LEAST_LEFT_DEG: f64 = 0.06;

/// Share of the field that lies across the tool axis.
fn share_across(scenario: &Scenario) -> f64 {
    let (down, north) = scenario.earth.dip_deg.to_radians().sin_cos();
    let (across, along) = scenario.hole.inclination_deg.to_radians().sin_cos();
    let axial = north * across * scenario.hole.azimuth_deg.to_radians().cos() + down * along;
    (1.0 - axial * axial).sqrt()
}

/// A vector of random direction with a length between `largest` / 2 and `largest`.
fn vector(random: &mut Random, largest: f64) -> [f64; 3] {
    let length = random.between(0.5 * largest, largest);
    random.direction().map(|x| x * length)
}

fn matrix(random: &mut Random, largest: f64) -> [[f64; 3]; 3] {
    [(); 3].map(|()| [(); 3].map(|()| random.sign() * random.between(0.5 * largest, largest)))
}

/// All cases.
pub(in crate::bench) const CASES: &[Case] = &[
    Case { name: "nothing", effects: &[], add: |_, _| {} },
    Case { name: "mag_lag", effects: &[&[&MagLag, &EddyLag]], add: |s, r| s.effects.mag_lag_ms = r.between(4.0, 15.0) },
    Case { name: "gyro_lag", effects: &[&[&GyroLag]], add: |s, r| s.effects.gyro_lag_ms = r.between(3.0, 8.0) },
    Case {
        name: "hard_iron",
        effects: &[&[&HardIron, &AxialInterference, &SoftIron]],
        add: |s, r| s.effects.hard_iron_ut = vector(r, 8.0),
    },
    Case {
        name: "soft_iron",
        effects: &[&[&SoftIron, &HardIron, &AxialInterference]],
        add: |s, r| s.effects.mag_matrix = matrix(r, 0.03),
    },
    Case { name: "accel_bias", effects: &[&[&AccelBias]], add: |s, r| s.effects.accel_bias_m_s2 = vector(r, 0.5) },
    Case { name: "lever_arm", effects: &[&[&LeverArm]], add: |s, r| s.effects.lever_arm_mm = vector(r, 50.0) },
    Case {
        name: "accel_lag",
        effects: &[&[&AccelLag, &GyroLag]],
        add: |s, r| s.effects.accel_lag_ms = 10.0 * (1.0 + r.between(0.0, 2.0).floor()),
    },
    Case {
        name: "eddy_lag",
        effects: &[&[&EddyLag, &MagLag]],
        add: |s, r| s.effects.eddy_lag_ms = r.between(1.0, 4.0),
    },
    Case {
        name: "axial_interference",
        effects: &[&[&AxialInterference, &HardIron, &SoftIron]],
        add: |s, r| s.effects.hard_iron_ut = [0.0, 0.0, r.sign() * r.between(3.0, 8.0)],
    },
    Case {
        name: "g_sensitivity",
        effects: &[&[&GSensitivity]],
        add: |s, r| s.effects.g_sensitivity_deg_s_g = matrix(r, 0.1),
    },
    Case {
        name: "g_sensitivity, three times as large",
        effects: &[&[&GSensitivity]],
        add: |s, r| s.effects.g_sensitivity_deg_s_g = matrix(r, 0.3),
    },
    Case {
        name: "gyro_bias_temperature",
        effects: &[&[&GyroBiasTemperature]],
        add: |s, r| {
            s.temperature = Some(Temperature { start_c: 40.0, end_c: Some(80.0), ..Temperature::default() });
            s.effects.gyro_bias_temperature_deg_s_c = vector(r, 0.05);
        },
    },
    Case {
        name: "gyro_scale_temperature",
        effects: &[&[&GyroScaleTemperature]],
        add: |s, r| {
            s.temperature = Some(Temperature { start_c: 40.0, end_c: Some(80.0), ..Temperature::default() });
            s.effects.gyro_scale_temperature_percent_c = vector(r, 0.05);
        },
    },
    Case {
        name: "gyro_bias_step",
        effects: &[&[&GyroBiasStep]],
        add: |s, r| {
            (s.effects.bias_step_deg_s, s.effects.bias_step_after_s) = (vector(r, 0.5), r.between(76.0, 100.0));
            s.shocks.peak_g = [15.0, 20.0];
        },
    },
    Case {
        name: "vibration_rectification",
        effects: &[&[&VibrationRectification]],
        add: |s, r| s.effects.vibration_rectification_deg_s_g2 = vector(r, 1.0),
    },
    Case {
        name: "gyro_scale_nonlinearity",
        effects: &[&[&GyroScaleNonlinearity]],
        // Within a data sheet's 0.5 % of full scale, with a range that the tool's speed asks for.
        add: |s, r| s.effects.gyro_scale_nonlinearity_s2_rad2 = vector(r, 2e-4),
    },
    Case {
        name: "gyro_scale_asymmetry",
        effects: &[&[&GyroScaleAsymmetry]],
        add: |s, r| {
            s.rotation.stick_slip = 1.4;
            s.effects.gyro_scale_asymmetry = vector(r, 0.01);
        },
    },
    Case {
        name: "outside: periodic bias",
        effects: &[],
        add: |s, r| {
            s.effects.periodic_bias_deg_s = vector(r, 0.5);
            s.effects.periodic_bias_period_s = r.between(5.0, 15.0);
        },
    },
    Case {
        name: "outside: a gyro that turns in its mount",
        effects: &[],
        add: |s, r| {
            s.effects.mount_rotation =
                Some(MountRotation { from_s: r.between(70.0, 95.0), rotation_deg: vector(r, 2.0), ramp_s: 1.0 });
        },
    },
    Case {
        name: SOFT_IRON_OUTSIDE,
        effects: &[&[&HardIron, &AxialInterference]],
        // Mean 1 %.
        add: |s, r| s.effects.mag_matrix = matrix(r, 0.0133),
    },
    Case {
        name: SYMMETRIC_OUTSIDE,
        effects: &[&[&HardIron, &AxialInterference]],
        // Iron magnetised along the field: the axes have not turned.
        add: |s, r| {
            let drawn = matrix(r, 0.0133);
            s.effects.mag_matrix = [0, 1, 2].map(|i: usize| [0, 1, 2].map(|j: usize| drawn[i.min(j)][i.max(j)]));
        },
    },
    Case {
        name: "mag_lag and hard_iron",
        effects: &[&[&MagLag, &EddyLag], &[&HardIron, &AxialInterference]],
        add: |s, r| {
            s.effects.mag_lag_ms = r.between(4.0, 15.0);
            s.effects.hard_iron_ut = vector(r, 8.0);
        },
    },
    Case {
        name: "mag_lag, lever_arm and g_sensitivity",
        effects: &[&[&MagLag, &EddyLag], &[&LeverArm], &[&GSensitivity]],
        add: |s, r| {
            s.effects.mag_lag_ms = r.between(4.0, 15.0);
            s.effects.lever_arm_mm = vector(r, 50.0);
            s.effects.g_sensitivity_deg_s_g = matrix(r, 0.1);
        },
    },
];
