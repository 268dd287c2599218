//! A trace through the pipeline on the host.

use meerkat_mwd::{
    Config, Probe, Sample,
    config::ConfigError,
    identification::WindowReport,
    probe::{Counters, Output, POLL_BUDGET},
};

/// What one run of the pipeline over a trace gave, on the host or on the emulated chip.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// One for each sample that was not refused.
    pub outputs: Vec<Output>,
    /// One for each window.
    pub reports: Vec<WindowReport>,
    /// What was counted.
    pub counters: Counters,
}

/// Flies the samples on the host, in the order of calls that the firmware uses. `progress` hears how many are done.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn fly(config: &Config, samples: &[Sample], mut progress: impl FnMut(usize)) -> Result<Flight, ConfigError> {
    let mut probe = Box::new(Probe::new());
    probe.configure(config)?;
    let mut outputs = Vec::with_capacity(samples.len());
    let mut reports = Vec::new();
    for (done, sample) in samples.iter().enumerate() {
        outputs.extend(probe.push(sample));
        reports.extend(probe.poll(POLL_BUDGET));
        progress(done + 1);
    }
    Ok(Flight { outputs, reports, counters: probe.counters() })
}
