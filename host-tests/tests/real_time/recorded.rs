//! Output of `cargo mwd record` and `monitor` on the emulator's serial line.

use super::{
    drilling::everything,
    live::{KEY, LiveProbe, drilled},
    received::Received,
};
use meerkat_mwd::telemetry::{Command, Outcome};
use mwd::{report::attitude_csv::write_attitude_csv, target::real_time::RealTime};
use std::{fs, path::Path, process};

fn replayed(arguments: &[&str]) -> String {
    let output = process::Command::new(env!("CARGO_BIN_EXE_mwd")).arg("replay").args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read_to_string(arguments[arguments.len() - 1]).unwrap()
}

#[test]
fn a_recording_after_a_restart_replays_with_the_stored_model_that_flew() {
    let Some(mut probe) = LiveProbe::new() else { return };
    let (mut config, samples) = drilled(75.0, 600.0, 6);
    config.identification.window_s = 25.0;
    // A model to be restored.
    probe.power_up(&RealTime { config, key: Some(KEY), ..RealTime::default() }, &samples);
    let mut host = probe.host();
    let window = host.drill(75_000_000);
    let accept = Command::AcceptModel { window_end_us: window.t_end_us };
    assert_eq!(host.signed(&KEY, 1, &accept), Outcome::Accepted);
    drop(host);

    let run = RealTime { config, stream: everything(), recording: true, ..RealTime::default() };
    probe.power_up(&run, &samples[..70 * 200]);
    let [trace, capture] = [probe.at("trace.csv.gz"), probe.at("line.bin")];
    let (status, said) = probe.mwd(&["record", "-o", &trace, "--listen", "--capture", &capture]);
    println!("{said}");
    assert_eq!(status, 0);
    assert!(said.contains("0 damaged, 0 oversize, 0 missing") && !said.contains("note:"), "{said}");
    let received = Received::of(&fs::read(&capture).unwrap());
    assert!(received.boots[0].flies.is_some() && received.outputs.len() > 69 * 200);
    write_attitude_csv(received.outputs.iter().copied(), Path::new(&probe.at("probe.csv"))).unwrap();
    let flown = fs::read_to_string(probe.at("probe.csv")).unwrap();
    let [config, model, out] = [probe.at("trace.toml"), probe.at("trace.model.toml"), probe.at("replay.csv")];
    // The line ends before the last of the samples' attitudes are sent.
    let with_the_model = replayed(&[&trace, "--config", &config, "--model", &model, "--attitude", &out]);
    assert!(with_the_model.starts_with(&flown), "the attitude differs");
    assert!(
        !replayed(&[&trace, "--config", &config, "--attitude", &out]).starts_with(&flown),
        "the model says nothing"
    );

    probe.power_up(&run, &samples);
    let (status, said) = probe.mwd(&["monitor", "--once", "--seconds", "2"]);
    assert_eq!(status, 0, "{said}");
    for text in ["with stored model", "inclination", "raw samples", " 0 damaged"] {
        assert!(said.contains(text), "{text}: {said}");
    }
}
