use super::{ideal::attitude, rig::program::mwd};
use mwd::commands::simulate::SimulateArgs;
use testbed::{
    simulate::{Scenario, ScenarioError, simulate},
    trace::Trace,
};

#[test]
fn the_command_writes_a_trace_that_reads_back() {
    let directory = tempfile::tempdir().unwrap();
    let (scenario, output) = (directory.path().join("short.toml"), directory.path().join("short.csv.gz"));
    std::fs::write(&scenario, "duration_s = 15.0\n[rotation]\nmean_rpm = 60\n").unwrap();
    mwd::commands::simulate::run(&SimulateArgs {
        scenario: scenario.clone(),
        output: Some(output.clone()),
        seed: Some(4),
        plot_error: None,
        plot_rate: None,
    })
    .unwrap();
    let read = Trace::read(&output).unwrap();
    let simulated = simulate(&Scenario::read(&scenario).unwrap(), 4).0;
    assert_eq!(read.samples.len(), 1_501);
    for (a, b) in read.samples.iter().zip(&simulated.samples) {
        assert_eq!((a.t_us, a.gyro_rad_s, a.accel_m_s2, a.mag_ut), (b.t_us, b.gyro_rad_s, b.accel_m_s2, b.mag_ut));
    }
    assert!(attitude(&read, 1_400).angle_to(&attitude(&simulated, 1_400)) < 1e-6);
}

#[test]
fn no_output_overwrites_the_scenario_or_another_one() {
    const SCENARIO: &str = "duration_s = 15.0\n[rotation]\nmean_rpm = 60\n";
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (scenario, trace, picture) = (at("short.toml"), at("short.csv"), at("short.svg"));
    std::fs::create_dir(at("inner")).unwrap();
    std::fs::write(&scenario, SCENARIO).unwrap();
    let same = at("inner/../short.toml");
    for (outputs, told) in [
        (vec!["-o", &same], "would overwrite what is read"),
        (vec!["-o", &trace, "--plot-rate", &scenario], "would overwrite what is read"),
        (vec!["-o", &trace, "--plot-error", &scenario], "would overwrite what is read"),
        (vec!["-o", &trace, "--plot-rate", &trace], "would overwrite another one"),
        (vec!["-o", &trace, "--plot-rate", &picture, "--plot-error", &picture], "would overwrite another one"),
    ] {
        let output = mwd(&[&["simulate", &scenario][..], &outputs].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(told), "{outputs:?}: {said}");
        assert_eq!(std::fs::read_to_string(&scenario).unwrap(), SCENARIO);
        assert!(!std::path::Path::new(&trace).exists(), "{outputs:?}");
    }
    let output = mwd(&["simulate", &scenario, "-o", "/dev/null", "--plot-rate", "/dev/null"]);
    assert!(output.status.success(), "no file is overwritten: {output:?}");
}

#[test]
fn a_scenario_that_cannot_be_used_says_why() {
    let directory = tempfile::tempdir().unwrap();
    let message = |text: &str| {
        let path = directory.path().join("bad.toml");
        std::fs::write(&path, text).unwrap();
        Scenario::read(&path).unwrap_err().to_string()
    };
    assert!(message("[rotation]\nrpm = 30").contains("unknown field `rpm`"));
    assert!(message("duration_s = \"long\"").contains("line 1"));
    assert!(message("duration_s = nan").contains("duration_s must be"));
    assert!(message("oversampling = 3").contains("oversampling must be even"));
    assert!(message("[gyro]\np = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]").contains("gyro.p must be"));
    let missing = Scenario::read(&directory.path().join("none.toml")).unwrap_err();
    assert!(matches!(missing, ScenarioError::Read { .. }) && missing.to_string().contains("none.toml"));
    let path = directory.path().join("empty.toml");
    std::fs::write(&path, "").unwrap();
    assert_eq!(Scenario::read(&path).unwrap(), Scenario::default());
}
