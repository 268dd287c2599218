//! The attitude filter alone: rates that something else has compensated, gravity and field in; inclination, azimuth
//! and toolface out. Nothing is identified.
//!
//! `cargo run --example attitude_only`

use meerkat_mwd::attitude::{Attitude, AttitudeFilter, AttitudeFlags};
use nalgebra::Vector3;

pub(crate) mod motion;

/// Filters half a minute of motion and returns the last attitude.
pub(crate) fn filter() -> Option<Attitude> {
    let mut filter = AttitudeFilter::new();
    let config = motion::config();
    filter.start(&config.attitude, &config.earth, config.identification.motion);
    let period_s = config.sample_period_us as f32 * 1e-6;
    let mut last = None;
    for sample in motion::samples(30.0, |_| Vector3::zeros()) {
        let rate = Vector3::from(motion::TRUE.compensate(sample.gyro_rad_s));
        filter.propagate(period_s, &(rate - filter.earth_rate_rad_s()));
        filter.observe(Some(&sample.accel_m_s2.into()), Some(&sample.mag_ut.into()));
        last = filter.attitude(AttitudeFlags::empty());
    }
    last
}

pub(crate) fn main() {
    match filter() {
        Some(attitude) => println!(
            "inclination {:.2} deg, azimuth {:.2} deg, highside toolface {:.2} deg",
            attitude.inclination_rad.to_degrees(),
            attitude.azimuth_rad.to_degrees(),
            attitude.gravity_toolface_rad.to_degrees()
        ),
        None => println!("no attitude"),
    }
}
