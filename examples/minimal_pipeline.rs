//! The whole pipeline on a minute and a half of motion: attitude at every sample, and the gyro's errors as soon
//! as there is enough motion.
//!
//! `cargo run --example minimal_pipeline`

use meerkat_mwd::{Probe, compensation::GyroModel, config::ConfigError};

pub(crate) mod motion;

/// Flies the samples and returns the model that flies at the end.
pub(crate) fn fly() -> Result<GyroModel, ConfigError> {
    // A `static` on a chip: all buffers are inside.
    let mut probe = Box::new(Probe::new());
    probe.configure(&motion::config())?;
    for (k, sample) in motion::samples(90.0, |_| nalgebra::Vector3::zeros()).enumerate() {
        // Every sample has an output, unless its time does not increase.
        let Some(output) = probe.push(&sample) else { continue };
        if let Some(attitude) = output.attitude.filter(|_| k % 1_000 == 0) {
            println!(
                "{:4.0} s: inclination {:6.2} +- {:.2} deg, azimuth {:6.2} +- {:.2} deg",
                output.t_us as f64 * 1e-6,
                attitude.inclination_rad.to_degrees(),
                attitude.sigma_inclination_rad.to_degrees(),
                attitude.azimuth_rad.to_degrees(),
                attitude.sigma_azimuth_rad.to_degrees()
            );
        }
        // Spare time: a bounded piece of identification.
        if let Some(report) = probe.poll(probe.poll_budget()) {
            println!("window to {:.0} s: {:?}", report.t_end_us as f64 * 1e-6, report.decision);
        }
    }
    Ok(*probe.gyro_model())
}

pub(crate) fn main() -> Result<(), ConfigError> {
    let flown = fly()?;
    for (row, truth) in flown.p.iter().zip(motion::TRUE.p) {
        println!("P {row:7.4?}, true {truth:7.4?}");
    }
    println!("b {:.4?}, true {:.4?} rad/s", flown.b_rad_s, motion::TRUE.b_rad_s);
    Ok(())
}
