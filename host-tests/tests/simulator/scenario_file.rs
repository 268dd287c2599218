use super::ideal::attitude;
use mwd::{
    commands::simulate::SimulateArgs,
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
