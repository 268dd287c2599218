//! What is said of a residual whose cause is outside the library, and the page that says it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "well_formed/mod.rs"]
mod well_formed;

use std::{fs, process::Command};

use meerkat_mwd::{
    compensation::{
        Effect,
        effects::{HardIron, LIBRARY},
    },
    diagnosis::{Correlate, RemainderReport, Verdict},
};
use mwd::{
    configuration::of_trace,
    flight::fly_with,
    simulate::{MountRotation, Scenario, Temperature, simulate},
};
use tempfile::TempDir;
use well_formed::unbalanced;

/// A library that lacks nearly everything.
static HARD_IRON_ALONE: [&dyn Effect; 1] = [&HardIron];

fn scenario(change: impl Fn(&mut Scenario)) -> Scenario {
    let mut scenario = Scenario { duration_s: 120.0, ..Scenario::default() };
    scenario.hole.inclination_deg = 45.0;
    change(&mut scenario);
    scenario.validate().unwrap();
    scenario
}

/// What the last diagnosis that tells anything says of what it cannot explain, for three seeds.
fn remainders(library: &'static [&'static dyn Effect], change: impl Fn(&mut Scenario)) -> [RemainderReport; 3] {
    [0, 1, 2].map(|seed| {
        let trace = simulate(&scenario(&change), seed).0;
        let flight = fly_with(library, &of_trace(&trace), &trace.samples, |_| {}).unwrap();
        let last = *flight.diagnoses.iter().rev().find(|report| report.is_conclusive()).unwrap();
        assert_eq!(last.verdict, Verdict::UnexplainedResidual, "{seed}");
        last.remainder
    })
}

fn names(remainder: &RemainderReport) -> Vec<Correlate> {
    remainder.named().map(|found| found.correlate).collect()
}

#[test]
fn a_bias_that_goes_with_temperature_goes_with_temperature() {
    let all = remainders(&HARD_IRON_ALONE, |scenario| {
        let swing = Temperature { start_c: 40.0, swing_c: 8.0, swing_period_s: 30.0, ..Temperature::default() };
        scenario.temperature = Some(swing);
        scenario.effects.gyro_bias_temperature_deg_s_c = [0.02, -0.02, 0.04];
    });
    for remainder in all {
        assert_eq!(names(&remainder).first(), Some(&Correlate::Temperature), "{remainder:?}");
        assert!(remainder.goes_with[0].share > 0.3, "{remainder:?}");
    }
}

/// A part that goes with the cube of the rate: with the square, beside the rate.
#[test]
fn a_scale_that_bends_goes_with_the_square_of_the_rate() {
    let all = remainders(&HARD_IRON_ALONE, |scenario| {
        (scenario.rotation.stick_slip, scenario.rotation.stick_slip_hz) = (1.0, 0.13);
        scenario.effects.gyro_scale_nonlinearity_s2_rad2 = [0.0, 0.0, 2e-3];
    });
    for remainder in all {
        assert_eq!(names(&remainder).first(), Some(&Correlate::RateSquared), "{remainder:?}");
    }
}

#[test]
fn a_field_that_is_late_goes_with_lag() {
    for remainder in remainders(&HARD_IRON_ALONE, |scenario| scenario.effects.mag_lag_ms = 12.0) {
        assert_eq!(names(&remainder).first(), Some(&Correlate::Lag), "{remainder:?}");
    }
}

/// The specific force turns with the tool: neither can be told from the other, and both are named.
#[test]
fn a_gyro_that_feels_gravity_goes_with_the_specific_force_and_once_per_revolution() {
    let all = remainders(&HARD_IRON_ALONE, |scenario| {
        scenario.rotation.mean_rpm = 6.0;
        scenario.effects.g_sensitivity_deg_s_g = [[0.1, 0.1, -0.1], [-0.1, 0.1, 0.1], [0.1, -0.2, 0.1]];
    });
    for remainder in all {
        let names = names(&remainder);
        let both = [Correlate::OncePerRevolution, Correlate::Acceleration];
        assert!(both.iter().all(|name| names.contains(name)), "{remainder:?}");
    }
}

/// Outside of any library: what comes back is said to, and goes with nothing; half a period later it is the opposite of itself.
#[test]
fn a_bias_that_comes_back_has_a_memory_and_no_name() {
    let with_period = |period_s: f64| {
        remainders(&LIBRARY, |scenario| {
            scenario.effects.periodic_bias_deg_s = [0.3, -0.2, 0.4];
            scenario.effects.periodic_bias_period_s = period_s;
        })
    };
    for remainder in with_period(8.0) {
        let memory = &remainder.memory;
        assert!(remainder.has_memory && memory.correlation < -0.4, "{remainder:?}");
        assert!((3.0..5.0).contains(&memory.apart_s), "{remainder:?}");
        assert!(names(&remainder).is_empty(), "{remainder:?}");
    }
    assert!(with_period(13.0).iter().all(|remainder| names(remainder).is_empty()));
}

/// A step: the half before it is unlike the half after it. No quantity is blamed for it but time.
#[test]
fn a_gyro_that_turned_in_its_mount_goes_with_time_at_most() {
    let all = remainders(&LIBRARY, |scenario| {
        let turned = MountRotation { from_s: 89.0, rotation_deg: [1.2, -0.8, 1.0], ramp_s: 1.0 };
        scenario.effects.mount_rotation = Some(turned);
    });
    for remainder in all {
        assert!(names(&remainder).iter().all(|name| *name == Correlate::Time), "{remainder:?}");
    }
}

#[test]
fn the_page_is_well_formed_and_tells_every_effect() {
    let directory = TempDir::new().unwrap();
    let trace_path = directory.path().join("a <b> & 'c'.csv.gz");
    let with_lag = scenario(|scenario| scenario.effects.mag_lag_ms = 12.0);
    let outside = scenario(|scenario| {
        scenario.effects.periodic_bias_deg_s = [0.3, -0.2, 0.4];
        scenario.effects.periodic_bias_period_s = 8.0;
    });
    for (scenario, expected) in [(with_lag, "mag_lag over the diagnoses"), (outside, "What is left")] {
        simulate(&scenario, 1).0.write(&trace_path).unwrap();
        let [page_path, json_path] = ["page.html", "result.json"].map(|name| directory.path().join(name));
        let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
        command.arg("diagnose").arg(&trace_path).arg("--html").arg(&page_path).arg("--json").arg(&json_path);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let page = fs::read_to_string(&page_path).unwrap();
        assert_eq!(unbalanced(&page), Vec::<String>::new());
        assert!(page.contains("a &lt;b&gt; &amp; &#39;c&#39;.csv.gz") && !page.contains("<b> &"));
        assert!(!page.contains("http") && !page.contains("NaN") && !page.contains("inf"), "{page}");
        assert!(LIBRARY.iter().all(|effect| page.contains(&format!("<td>{}</td>", effect.name()))));
        assert!(page.contains(expected) && page.matches("<svg").count() >= 2);
        let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(&json_path).unwrap()).unwrap();
        let remainder = &json["diagnosis"]["remainder"];
        assert_eq!(remainder["goes_with"].is_array(), expected == "What is left", "{remainder}");
        let account = String::from_utf8(output.stdout).unwrap();
        assert_eq!(account.contains("what is left is the opposite of itself"), expected == "What is left", "{account}");
    }
}
