//! Share of the motion without the field: a magnetometer that needs a calibration first.

use meerkat_mwd::{Config, SampleFlags, attitude::AttitudeFlags};

use testbed::{flight::Flight, trace::Trace};

/// Least motion with a field to read that is judged, seconds: the attitude waits for half a second of agreement before
/// it uses a field, and averages its reference over 20 s.
const LEAST_MOTION_S: f64 = 10.0;

/// Percentage of the motion that went without the field although it was read; `None` if it is not most of it. Motion is
/// a rate that no bias of the gyro explains.
#[must_use]
pub fn field_unused_percent(trace: &Trace, config: &Config, flight: &Flight) -> Option<f64> {
    let least = config.identification.max_bias_rad_s;
    let (mut read, mut unused) = (0_u32, 0_u32);
    for (sample, output) in trace.samples().zip(flight.by_sample()) {
        let Some(output) = output.filter(|_| !sample.flags.contains(SampleFlags::MAG_MISSING)) else { continue };
        let Some(attitude) = output.attitude else { continue };
        if output.rate_rad_s.iter().map(|x| x * x).sum::<f32>() > least * least {
            read += 1;
            unused += u32::from(attitude.flags.contains(AttitudeFlags::MAG_UNUSED));
        }
    }
    let motion_s = f64::from(read) * f64::from(config.sample_period_us) * 1e-6;
    (motion_s > LEAST_MOTION_S && unused > read / 2).then(|| 100.0 * f64::from(unused) / f64::from(read))
}
