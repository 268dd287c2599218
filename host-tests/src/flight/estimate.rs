//! The estimator alone over samples, without the probe around it.

use meerkat_mwd::{
    Sample, SampleFlags,
    compensation::Effect,
    estimator::{Estimator, Posterior, Real, Settings},
    sample::Reading,
};
use nalgebra::Vector3;

/// Interval between updates of the posterior, microseconds: the default of `identification.update_s`.
const UPDATE_US: u64 = 5_000_000;

/// Posterior after the last sample, with an update every 5 s; `None` if there was too little to estimate from.
#[must_use]
pub fn posterior<T: Real>(
    settings: &Settings,
    library: &'static [&'static dyn Effect],
    samples: impl IntoIterator<Item = Sample>,
) -> Option<Posterior> {
    let mut estimator = Box::new(Estimator::<T>::zero());
    estimator.configure(settings, library);
    let mut next_us = 0;
    for sample in samples {
        estimator.push(sample.t_us, readings(&sample), None);
        if sample.t_us >= next_us {
            estimator.close(false);
            next_us = sample.t_us + UPDATE_US;
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
