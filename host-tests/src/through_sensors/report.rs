//! What `--through-sensors` says beside the flight.

use super::{Played, QuantisationBound, largest_difference_deg};
use crate::flight::fly;
use meerkat_mwd::{Config, Sample, SampleFlags, config::ConfigError};
use std::io::{self, Write};

/// Flies both with the factory's model throughout, and says how far apart they are beside the bound.
///
/// # Errors
/// The output cannot be written.
pub fn report(out: &mut impl Write, config: &Config, recorded: &[Sample], played: &Played) -> io::Result<()> {
    let [inertial, magnetic] = played.counters;
    writeln!(
        out,
        "sensors  {} of {} samples came through register models and adapters (ISM330DHCX, RM3100), stamped within {} us",
        played.counts.samples - played.counts.lost,
        played.counts.samples,
        played.counts.stamp_error_us
    )?;
    let [gyro, accel, mag] = played.flagged;
    writeln!(
        out,
        "         readings flagged on the way: gyro {gyro}, accelerometer {accel}, magnetometer {mag}; frames lost {}, restarts {}",
        inertial.lost_frames.saturating_add(magnetic.lost_frames),
        inertial.restarts.saturating_add(magnetic.restarts)
    )?;
    match differences(config, recorded, &played.samples) {
        Ok(Differences { quantisation_deg: (largest_deg, rms_deg), all_deg: (all_deg, all_rms_deg) }) => {
            let bound = QuantisationBound::new(config, recorded.len());
            writeln!(
                out,
                "         attitude against the recording handed over, one model throughout, the same readings believed: {largest_deg:.3} deg at \
                 most, {rms_deg:.3} rms; all readings believed there: {all_deg:.3} and {all_rms_deg:.3}"
            )?;
            writeln!(
                out,
                "         quantisation bound {:.3} deg: gyro {:.3} moving and {:.3} at rest, accelerometer {:.3}, magnetometer {:.3}",
                bound.total_deg(),
                bound.gyro_walk_deg,
                bound.gyro_rest_deg,
                bound.accel_deg,
                bound.mag_deg
            )
        }
        Err(error) => writeln!(out, "         no comparison: {error}"),
    }
}

/// How far apart the attitudes are, largest and root mean square, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// What quantisation does: the recording that is handed over lacks the readings that the adapters did not believe.
    pub quantisation_deg: (f64, f64),
    /// With what their lack does.
    pub all_deg: (f64, f64),
}

/// Flies both with nothing identified.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn differences(config: &Config, recorded: &[Sample], through: &[Sample]) -> Result<Differences, ConfigError> {
    let config = Config { freeze_at_us: recorded.first().map(|sample| sample.t_us), ..*config };
    let missing = SampleFlags::GYRO_MISSING | SampleFlags::ACCEL_MISSING | SampleFlags::MAG_MISSING;
    let believed: Vec<Sample> = (recorded.iter().zip(through))
        .map(|(sample, came)| Sample { flags: sample.flags | (came.flags & missing), ..*sample })
        .collect();
    let played = fly(&config, through, |_| {})?;
    Ok(Differences {
        quantisation_deg: largest_difference_deg(&fly(&config, &believed, |_| {})?, &played),
        all_deg: largest_difference_deg(&fly(&config, recorded, |_| {})?, &played),
    })
}
