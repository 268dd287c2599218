//! Text that `--through-sensors` prints below the flight.

use super::{Difference, Played, QuantisationBound};
use crate::flight::fly_frozen;
use meerkat_mwd::{Config, Sample, SampleFlags, config::ConfigError};
use std::io::{self, Write};

/// Flies recorded and played samples with the factory's model throughout, and prints their attitude
/// difference beside the bound.
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
        "         readings flagged on the way: gyro {gyro}, accelerometer {accel}, magnetometer {mag}; inertial frames lost {}, restarts {}",
        inertial.lost_frames,
        inertial.restarts.saturating_add(magnetic.restarts)
    )?;
    match differences(config, recorded, &played.samples) {
        Ok(Differences { quantisation, all }) => {
            let bound = QuantisationBound::new(config, recorded.len());
            writeln!(
                out,
                "         attitude against the recording handed over, one model throughout, the same readings believed: {:.3} deg at \
                 most, {:.3} rms; all readings believed there: {:.3} and {:.3}",
                quantisation.largest_deg, quantisation.rms_deg, all.largest_deg, all.rms_deg
            )?;
            if quantisation.undecided > 0 {
                writeln!(
                    out,
                    "         but for {} samples where only one of the two had decided something, a rest for instance: {:.3} deg, {:.1} stated deviations",
                    quantisation.undecided, quantisation.undecided_deg, quantisation.undecided_deviations
                )?;
            }
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

/// Attitude differences between the two flights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// Difference made by quantisation alone: readings that the adapters refused are taken out of the
    /// recording too.
    pub quantisation: Difference,
    /// Difference including the refused readings.
    pub all: Difference,
}

/// Flies both without identification and compares them.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn differences(config: &Config, recorded: &[Sample], through: &[Sample]) -> Result<Differences, ConfigError> {
    let from_us = recorded.first().map_or(0, |sample| sample.t_us);
    let missing = SampleFlags::GYRO_MISSING | SampleFlags::ACCEL_MISSING | SampleFlags::MAG_MISSING;
    let believed: Vec<Sample> = (recorded.iter().zip(through))
        .map(|(sample, came)| Sample { flags: sample.flags | (came.flags & missing), ..*sample })
        .collect();
    let played = fly_frozen(config, from_us, through)?;
    Ok(Differences {
        quantisation: Difference::between(&fly_frozen(config, from_us, &believed)?, &played),
        all: Difference::between(&fly_frozen(config, from_us, recorded)?, &played),
    })
}
