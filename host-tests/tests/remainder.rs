//! What is said of a residual whose cause is outside the library.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use meerkat_mwd::{
    compensation::{
        Effect,
        effects::{HardIron, LIBRARY},
    },
    diagnosis::{DiagnosisReport, Verdict},
};
use mwd::{
    configuration::of_trace,
    diagnose::{remainder_text, verdict_name},
    flight::fly_with,
    simulate::{Effects, MountRotation, Scenario, Temperature, simulate},
};

static SMALL: [&dyn Effect; 1] = [&HardIron];

fn reports(scenario: &Scenario, library: &'static [&'static dyn Effect], seed: u64) -> Vec<DiagnosisReport> {
    scenario.validate().unwrap();
    let trace = simulate(scenario, seed).0;
    fly_with(library, &of_trace(&trace), &trace.samples, |_| {}).unwrap().diagnoses
}

fn show(name: &str, library: &'static [&'static dyn Effect], make: impl Fn(&mut Scenario, u64)) {
    for seed in 0..4 {
        let mut scenario = Scenario { duration_s: 150.0, ..Scenario::default() };
        scenario.hole.inclination_deg = 45.0;
        make(&mut scenario, seed);
        for report in reports(&scenario, library, seed).iter().filter(|r| r.is_conclusive()) {
            let text = if report.verdict == Verdict::UnexplainedResidual {
                remainder_text(&report.remainder)
            } else {
                String::new()
            };
            println!(
                "{name} {seed} {:.0}-{:.0} {} nis {:.1} found {} {:?}: {text}",
                report.t_start_us as f64 * 1e-6,
                report.t_end_us as f64 * 1e-6,
                verdict_name(report.verdict),
                report.nis[1],
                report.count,
                report.remainder.memory
            );
        }
    }
}

#[test]
fn explore() {
    show("periodic", &LIBRARY, |s, seed| {
        s.effects.periodic_bias_deg_s = [0.3, -0.2, 0.4];
        s.effects.periodic_bias_period_s = 5.0 + 3.0 * seed as f64;
    });
    show("mount", &LIBRARY, |s, seed| {
        s.effects.mount_rotation =
            Some(MountRotation { from_s: 75.0 + 7.0 * seed as f64, rotation_deg: [1.2, -0.8, 1.0], ramp_s: 1.0 });
    });
    show("temperature", &SMALL, |s, _| {
        s.temperature = Some(Temperature {
            start_c: 40.0,
            end_c: Some(45.0),
            swing_c: 8.0,
            swing_period_s: 30.0,
            ..Temperature::default()
        });
        s.effects.gyro_bias_temperature_deg_s_c = [0.02, -0.02, 0.04];
    });
    show("nonlinearity, stick-slip", &SMALL, |s, _| {
        s.rotation.stick_slip = 1.0;
        s.rotation.stick_slip_hz = 0.13;
        s.effects.gyro_scale_nonlinearity_s2_rad2 = [0.0, 0.0, 2e-3];
    });
    show("mag lag", &SMALL, |s, _| s.effects.mag_lag_ms = 12.0);
    show("mag lag, stick-slip", &SMALL, |s, _| {
        s.effects.mag_lag_ms = 12.0;
        s.rotation.stick_slip = 1.0;
        s.rotation.stick_slip_hz = 0.13;
    });
    show("g", &SMALL, |s, _| {
        s.rotation.mean_rpm = 6.0;
        s.effects.g_sensitivity_deg_s_g = [[0.1, 0.1, -0.1], [-0.1, 0.1, 0.1], [0.1, -0.2, 0.1]];
    });
    show("nothing", &LIBRARY, |_, _| {});
    let _ = Effects::default();
}
