//! An effect of one's own: a gyro whose reading has a part that goes with the square of the rate. It is declared in
//! a library beside two of the project's effects; the probe finds it, with its size, and takes it out.
//!
//! `cargo run --example own_effect`

use meerkat_mwd::{
    Probe,
    compensation::{
        Effect, Parameter, Sensor, Snapshot,
        effect::MAX_PARAMETERS,
        effects::{HardIron, MagLag},
    },
    config::ConfigError,
};
use nalgebra::Vector3;

pub(crate) mod motion;

/// The gyro reads k w^2 more about the tool axis.
struct SquareOfTheRate;

const PARAMETERS: [Parameter; 1] = [Parameter {
    name: "z_s_rad",          // with its unit, as results print it
    in_unit: 1.0,             // from SI to that unit
    usual: 1e-3,              // deviation of its prior, from a data sheet
    largest: 1e-2,            // beyond it something else looks like this effect: it is named, and not taken out
    signed: true,             // may be negative
    only_in_estimator: false, // true for an effect that is not taken from the attitude's readings
}];

const _: () = assert!(PARAMETERS.len() <= MAX_PARAMETERS);

impl Effect for SquareOfTheRate {
    fn name(&self) -> &'static str {
        "square_of_the_rate"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Gyro
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    /// Reading that one unit of parameter `k` adds, rad/s.
    fn term(&self, _k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        Vector3::new(0.0, 0.0, snapshot.rate_rad_s.z * snapshot.rate_rad_s.z)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["scale factor at one rate"]
    }
}

/// The library. Of effects that look alike the likelier comes first; all together may have 44 parameters.
static LIBRARY: [&dyn Effect; 3] = [&MagLag, &HardIron, &SquareOfTheRate];

/// Coefficient of the simulated gyro, s/rad.
pub(crate) const TRUE: f32 = 4e-3;

/// Flies a gyro with the effect. Returns the names of the effects that are taken out at the end, each with its first
/// parameter.
pub(crate) fn found() -> Result<Vec<(&'static str, f32)>, ConfigError> {
    let mut probe = Box::new(Probe::new());
    probe.set_library(&LIBRARY); // takes effect with the next `configure`
    probe.configure(&motion::config())?;
    for sample in motion::samples(120.0, |rate| Vector3::new(0.0, 0.0, TRUE * rate.z * rate.z)) {
        probe.push(&sample);
        probe.poll(probe.poll_budget());
    }
    let mut found = Vec::new();
    while let Some(diagnosis) = probe.take_diagnosis() {
        found = diagnosis
            .found()
            .filter(|report| report.is_taken_out())
            .map(|report| (LIBRARY[usize::from(report.found.index)].name(), report.found.parameters[0]))
            .collect();
    }
    Ok(found)
}

pub(crate) fn main() -> Result<(), ConfigError> {
    for (name, size) in found()? {
        println!("{name}: {size:.5}, simulated {TRUE:.5} s/rad");
    }
    Ok(())
}
