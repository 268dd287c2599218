//! The flown run: drilling at 45 deg, 200 samples a second.

use crate::rig::files::scenario;
use meerkat_mwd::{
    Config, Sample,
    probe::Output,
    telemetry::{AttitudeFormat, StreamConfig},
};
use std::time::Duration;
use testbed::{
    flight::{self, configuration},
    simulate::{Scenario, simulate},
};

/// Longest that an emulated run may take.
pub const LIMIT: Duration = Duration::from_secs(1_800);

pub const PERIOD_US: u64 = 5_000;

/// A configuration and samples with the times that the probe's sample clock gives them.
pub fn drilling(duration_s: f64, seed: u64) -> (Config, Vec<Sample>) {
    drilling_at(PERIOD_US, duration_s, seed)
}

/// The same at another sample rate.
pub fn drilling_at(period_us: u64, duration_s: f64, seed: u64) -> (Config, Vec<Sample>) {
    let scenario = Scenario { duration_s, sample_period_us: period_us as u32, ..scenario("drilling_45deg") };
    let (trace, _) = simulate(&scenario, seed);
    let config = configuration::of_trace(&trace);
    let samples = trace.samples.iter().zip(1..).map(|(sample, k)| Sample { t_us: k * period_us, ..*sample });
    (config, samples.collect())
}

/// Every output with all its bits, over a line of 921,600 baud.
pub fn everything() -> StreamConfig {
    let mut stream = StreamConfig { bytes_per_s: 92_160, attitude_every: 1, ..StreamConfig::default() };
    stream.attitude_format = AttitudeFormat::Exact;
    stream
}

/// Checks that each output of a probe equals the host's for the same samples, bit for bit. Returns how many
/// are missing.
pub fn missing_of_the_host(config: &Config, samples: &[Sample], probe: &[Output]) -> u64 {
    missing_of(&flight::fly(config, samples, |_| ()).unwrap().outputs, probe)
}

/// The same check with the host's outputs given.
pub fn missing_of(host: &[Output], probe: &[Output]) -> u64 {
    // `==` would take -0 for 0.
    let bytes = |output: &Output| postcard::to_stdvec(output).unwrap();
    let mut rest = host.iter();
    for output in probe {
        let same = rest.find(|host| host.t_us == output.t_us);
        let same = same.unwrap_or_else(|| panic!("an output of no sample, or one again: {output:?}"));
        assert_eq!(bytes(same), bytes(output), "host {same:?}\nprobe {output:?}");
    }
    (host.len() - probe.len()) as u64
}
