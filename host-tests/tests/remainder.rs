//! Report on a residual whose cause is outside the library, in text and on the page.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod rig;

use std::{fs, process::Command};

use meerkat_mwd::{
    compensation::{
        Effect, Sensor,
        effects::{HardIron, LIBRARY},
    },
    diagnosis::{Correlate, DiagnosisReport, EffectReport, RemainderReport, Verdict},
};
use tempfile::TempDir;
use testbed::{
    flight::{configuration::of_trace, fly_with},
    simulate::{MountRotation, Scenario, Temperature, simulate},
};

use rig::page::{is_whole, unbalanced};

/// A library that lacks nearly every effect.
static HARD_IRON_ALONE: [&dyn Effect; 1] = [&HardIron];

fn scenario(change: impl Fn(&mut Scenario)) -> Scenario {
    let mut scenario = Scenario { duration_s: 120.0, ..Scenario::default() };
    scenario.hole.inclination_deg = 45.0;
    change(&mut scenario);
    scenario.validate().unwrap();
    scenario
}

/// All diagnoses of three seeds.
fn diagnoses(library: &'static [&'static dyn Effect], change: impl Fn(&mut Scenario)) -> [Vec<DiagnosisReport>; 3] {
    [0, 1, 2].map(|seed| {
        let trace = simulate(&scenario(&change), seed).0;
        let all = fly_with(library, &of_trace(&trace), None, &trace.samples).unwrap().diagnoses;
        for report in &all {
            let from_s = report.t_start_us as f64 * 1e-6;
            let names: Vec<_> = names(&report.remainder);
            println!(
                "{seed} from {from_s:.0} s: {:?}, {} found, {names:?}, {:?}",
                report.verdict, report.count, report.remainder.memory
            );
        }
        all
    })
}

/// The last conclusive diagnosis's words on what it cannot explain.
fn remainders(library: &'static [&'static dyn Effect], change: impl Fn(&mut Scenario)) -> [RemainderReport; 3] {
    diagnoses(library, change).map(|all| {
        let last = all.iter().rev().find(|report| report.is_conclusive()).unwrap();
        assert_eq!(last.verdict, Verdict::UnexplainedResidual);
        last.remainder
    })
}

fn names(remainder: &RemainderReport) -> Vec<Correlate> {
    remainder.named().map(|found| found.correlate).collect()
}

/// Over minutes in which temperature comes and goes, so that it is no drift in time. The attitude follows a
/// bias within nodes: what is left of it in the innovations is a sixth, which shows in one window and not in
/// another.
#[test]
fn a_bias_that_goes_with_temperature_goes_with_temperature() {
    let all = diagnoses(&HARD_IRON_ALONE, |scenario| {
        scenario.duration_s = 210.0;
        let swing = Temperature { start_c: 40.0, swing_c: 8.0, swing_period_s: 12.0, ..Temperature::default() };
        scenario.temperature = Some(swing);
        scenario.effects.gyro_bias_temperature_deg_s_c = [0.01, -0.01, 0.02];
    });
    for reports in all {
        let first_named = |report: &DiagnosisReport| names(&report.remainder).first().copied();
        let unexplained = reports.iter().filter(|report| report.verdict == Verdict::UnexplainedResidual).count();
        assert!(2 * unexplained > reports.len(), "{unexplained} of {}", reports.len());
        assert!(reports.iter().any(|report| first_named(report) == Some(Correlate::Temperature)));
    }
}

/// The filter has a column for the lag, whether or not the library has its name: nothing is left of it, and
/// nothing else is blamed for it.
#[test]
fn a_lag_that_the_library_lacks_is_not_laid_on_what_it_has() {
    for reports in diagnoses(&HARD_IRON_ALONE, |scenario| scenario.effects.mag_lag_ms = 12.0) {
        let last = reports.last().unwrap();
        assert_eq!(last.count, 0, "{:?}", last.found().next());
        assert!(last.remainder.is_white(), "{:?}", last.remainder);
    }
}

/// The specific force turns with the tool: neither can be told from the other, and a window names either or both. What
/// else is named is time: three periods of it are half a parabola.
#[test]
fn a_gyro_that_feels_gravity_goes_with_the_specific_force_and_once_per_revolution() {
    let all = diagnoses(&HARD_IRON_ALONE, |scenario| {
        scenario.rotation.mean_rpm = 6.0;
        scenario.effects.g_sensitivity_deg_s_g = [[0.1, 0.1, -0.1], [-0.1, 0.1, 0.1], [0.1, -0.2, 0.1]];
    });
    let allowed = [Correlate::OncePerRevolution, Correlate::Acceleration, Correlate::Time];
    let mut named = 0;
    for reports in &all {
        let windows: Vec<_> = reports.iter().map(|report| names(&report.remainder)).collect();
        assert!(windows.iter().flatten().all(|name| allowed.contains(name)), "{windows:?}");
        named += usize::from(windows.iter().any(|names| allowed[..2].iter().all(|name| names.contains(name))));
        assert!(windows.iter().any(|names| allowed[..2].iter().any(|name| names.contains(name))), "{windows:?}");
    }
    assert!(named >= 2, "both are named in a window of {named} of three runs");
}

/// Outside of any library: what comes back is said to, and half a period later it is the opposite of itself.
/// A window holds three periods, of which a parabola in time takes a part; no other quantity is blamed.
#[test]
fn a_bias_that_comes_back_has_a_memory_and_no_name() {
    let with_period = |scenario: &mut Scenario, period_s: f64| {
        scenario.effects.periodic_bias_deg_s = [0.1, -0.07, 0.13];
        scenario.effects.periodic_bias_period_s = period_s;
    };
    for remainder in remainders(&LIBRARY, |scenario| with_period(scenario, 8.0)) {
        let memory = &remainder.memory;
        assert!(remainder.has_memory && memory.correlation < -0.25, "{remainder:?}");
        assert!((3.0..5.0).contains(&memory.apart_s), "{remainder:?}");
        assert!(names(&remainder).iter().all(|name| *name == Correlate::Time), "{remainder:?}");
    }
    // A slow one shows in one window and not in another, and a step of the bias may be taken for a part of
    // it.
    for reports in diagnoses(&LIBRARY, |scenario| with_period(scenario, 13.0)) {
        assert!(reports.iter().any(|report| report.verdict == Verdict::UnexplainedResidual));
    }
}

/// A turn by 2 deg leaves 3 deg/s across the axis. The window in which it happens does not say that all is
/// well; no quantity is blamed for it but time and the rate, and no effect of the library but one of the magnetometer,
/// then or later. In the window with the turn a part has another P, so that what is left is no linear function of the
/// rate: there the rate's square may be blamed, too.
#[test]
fn a_gyro_that_turned_in_its_mount_goes_with_time_or_rate_at_most() {
    let turned_s = 89.0;
    let all = diagnoses(&LIBRARY, |scenario| {
        scenario.duration_s = 210.0;
        let rotation_deg = [1.2, -0.8, 1.0];
        scenario.effects.mount_rotation = Some(MountRotation { from_s: turned_s, rotation_deg, ramp_s: 1.0 });
    });
    for (seed, reports) in all.iter().enumerate() {
        for report in reports {
            let [from_s, to_s] = [report.t_start_us, report.t_end_us].map(|us| us as f64 * 1e-6);
            let has_turn = (from_s..to_s).contains(&turned_s);
            let is_of_turn = |name: &Correlate| match name {
                Correlate::Time | Correlate::Rate => true,
                Correlate::RateSquared => has_turn,
                _ => false,
            };
            assert!(names(&report.remainder).iter().all(is_of_turn), "{seed}: {report:?}");
            // Which of two sensors has turned against the other cannot be told.
            let is_of_field =
                |found: &EffectReport| LIBRARY[usize::from(found.found.index)].sensor() == Sensor::Magnetometer;
            assert!(report.found().all(is_of_field), "{seed}, {from_s:.0} to {to_s:.0} s: {:?}", report.found().next());
            if from_s < turned_s && turned_s + 5.0 < to_s {
                assert_ne!(report.verdict, Verdict::ModelSufficient, "{seed}, {from_s:.0} to {to_s:.0} s");
            }
        }
    }
}

#[test]
fn the_page_is_well_formed_and_tells_every_effect() {
    let directory = TempDir::new().unwrap();
    let trace_path = directory.path().join("a <b> & 'c'.csv.gz");
    let with_lag = scenario(|scenario| scenario.effects.mag_lag_ms = 12.0);
    let outside = scenario(|scenario| {
        scenario.effects.periodic_bias_deg_s = [0.1, -0.07, 0.13];
        scenario.effects.periodic_bias_period_s = 8.0;
    });
    for (scenario, expected) in [(with_lag, "Late magnetometer, over the diagnoses"), (outside, "What is left is")] {
        simulate(&scenario, 1).0.write(&trace_path).unwrap();
        let [page_path, json_path] = ["page.html", "result.json"].map(|name| directory.path().join(name));
        let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
        command.arg("diagnose").arg(&trace_path).arg("--html").arg(&page_path).arg("--json").arg(&json_path);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let page = fs::read_to_string(&page_path).unwrap();
        assert_eq!(unbalanced(&page), Vec::<String>::new());
        assert!(page.contains("a &lt;b&gt; &amp; &#39;c&#39;.csv.gz") && !page.contains("<b> &"));
        assert!(is_whole(&page));
        assert!(LIBRARY.iter().all(|effect| page.contains(&format!("({})</td>", effect.name()))));
        assert!(page.contains(expected) && page.matches("<svg").count() >= 2, "{expected}");
        let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(&json_path).unwrap()).unwrap();
        let remainder = &json["diagnosis"]["remainder"];
        assert_eq!(remainder["goes_with"].is_array(), expected == "What is left is", "{remainder}");
        let account = String::from_utf8(output.stdout).unwrap();
        assert_eq!(
            account.contains("what is left is the opposite of itself"),
            expected == "What is left is",
            "{account}"
        );
    }
}
