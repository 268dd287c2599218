//! The whole probe beside VQF on the bundled recordings, in one run.

use meerkat_mwd::Config;
use mwd::bench::attitude::{AKTOS_T, ours, vqf};
use testbed::{
    flight::configuration::of_trace,
    score::{AttitudeRms, Settings, attitude_rms_deg},
    trace::{Trace, recordings::folder},
};

/// Mean over the bundled recordings of total, heading and inclination, degrees rms, one constant heading
/// offset (the reference's north) removed or not.
fn means(scores: &[[AttitudeRms; 2]], offset_removed: bool) -> [f64; 3] {
    let parts: [fn(&AttitudeRms) -> Option<f64>; 3] = [|s| s.total, |s| s.heading, |s| s.inclination];
    parts.map(|part| {
        let values: Vec<f64> = scores.iter().map(|s| part(&s[usize::from(offset_removed)]).unwrap()).collect();
        values.iter().sum::<f64>() / values.len() as f64
    })
}

#[test]
fn with_the_sensors_delays_declared_the_attitude_is_no_worse_than_vqf_and_without_the_inclination_is_not() {
    let (mut of_ours, mut undeclared, mut of_vqf) = (Vec::new(), Vec::new(), Vec::new());
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        // A magnet that comes within the first two seconds, as in that cut, meets a heading that is still
        // settling.
        let name = path.file_name().unwrap().to_string_lossy();
        if !name.starts_with("broad") || !name.ends_with(".csv.gz") || name.contains("magnet") {
            continue;
        }
        let trace = Trace::read(&path).unwrap();
        let config = of_trace(&trace);
        let declared = Config { latency: AKTOS_T, ..config };
        let score = |attitudes: Vec<_>| attitude_rms_deg(&trace, &attitudes, &Settings::default());
        of_ours.push(score(ours(&trace, &declared).unwrap()));
        undeclared.push(score(ours(&trace, &config).unwrap()));
        of_vqf.push(score(vqf(&trace)));
    }
    assert!(!of_ours.is_empty());
    for offset_removed in [false, true] {
        let (a, b) = (means(&of_ours, offset_removed), means(&of_vqf, offset_removed));
        println!(
            "ours {a:.2?}, VQF {b:.2?} deg: total, heading, inclination; constant heading removed: {offset_removed}"
        );
        let inclination = means(&undeclared, offset_removed)[2];
        assert!(inclination <= b[2], "undeclared: {inclination} {b:?}");
        assert!(a.iter().zip(&b).all(|(a, b)| a <= b), "{a:?} {b:?}");
    }
}
