//! The estimator alone over samples, without the probe around it.

use meerkat_mwd::{
    Sample, SampleFlags,
    compensation::Effect,
    config::IdentificationConfig,
    estimator::{Estimator, Posterior, Real, Settings},
    sample::Reading,
};
use nalgebra::Vector3;

/// Posterior after the last sample, updated on the way as often as by default; `None` if there was too little to
/// estimate from.
#[must_use]
pub fn posterior<T: Real>(
    settings: &Settings,
    library: &'static [&'static dyn Effect],
    samples: impl IntoIterator<Item = Sample>,
) -> Option<Posterior> {
    let mut estimator = Box::new(Estimator::<T>::zero());
    estimator.configure(settings, library);
    let update_us = (1e6 * IdentificationConfig::default().update_s) as u64;
    let mut next_us = None;
    for sample in samples {
        estimator.push(sample.t_us, readings(&sample), None);
        if sample.t_us >= *next_us.get_or_insert(sample.t_us + update_us) {
            estimator.close(false);
            next_us = Some(sample.t_us + update_us);
        }
        while estimator.step() > 0 {}
    }
    estimator.close(false);
    while estimator.step() > 0 {}
    estimator.posterior().copied()
}

fn readings(sample: &Sample) -> [Reading; 3] {
    let gyro = SampleFlags::GYRO_MISSING | SampleFlags::GYRO_CLIPPED;
    let of = |without: SampleFlags, v: [f32; 3]| {
        if sample.flags.intersects(without) { Reading::Missing } else { Reading::Usable(Vector3::from(v)) }
    };
    [
        of(gyro, sample.gyro_rad_s),
        of(SampleFlags::ACCEL_MISSING, sample.accel_m_s2),
        of(SampleFlags::MAG_MISSING, sample.mag_ut),
    ]
}
