//! What one run of the pipeline over a trace gave. (Provisional copy of the shared type.)
use meerkat_mwd::{
    Config, Probe, Sample,
    config::ConfigError,
    identification::WindowReport,
    probe::{Counters, Output},
};

/// What one run of the pipeline over a trace gave, on the host or on the emulated chip.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// One output for each sample taken.
    pub outputs: Vec<Output>,
    /// One report for each window.
    pub reports: Vec<WindowReport>,
    /// Events counted.
    pub counters: Counters,
}

/// Runs the pipeline over samples on the host.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn fly(config: &Config, samples: &[Sample], mut progress: impl FnMut(usize)) -> Result<Flight, ConfigError> {
    let mut probe = Box::new(Probe::new());
    probe.configure(config)?;
    let mut flight = Flight::default();
    for (i, sample) in samples.iter().enumerate() {
        flight.outputs.extend(probe.push(sample));
        flight.reports.extend(probe.poll(64));
        progress(i);
    }
    flight.counters = probe.counters();
    Ok(flight)
}
