//! Files between host and firmware, in postcard's encoding: `trace.bin` in, `flight.bin` out.

use meerkat_mwd::{
    Config, Sample,
    emulation::{Record, Recording, Summary},
};
use testbed::flight::Flight;

/// Content of a whole `flight.bin`.
#[derive(Clone, Debug, PartialEq)]
pub struct Landed {
    /// Outputs, reports and counters.
    pub flight: Flight,
    /// Instructions spent in `Probe::poll` for each report.
    pub poll_instructions: Vec<u64>,
    /// Costs of the run.
    pub summary: Summary,
}

/// Reasons why bytes are not a whole flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// A record cannot be decoded.
    #[error("record {record} (byte {byte}) cannot be decoded")]
    Malformed {
        /// Number of records before it.
        record: usize,
        /// Offset of its first byte.
        byte: usize,
    },
    /// The last record is not the summary.
    #[error("the flight breaks off after {records} records, without a summary")]
    NoSummary {
        /// Number of records.
        records: usize,
    },
    /// Records follow the summary.
    #[error("{bytes} bytes follow the summary")]
    AfterSummary {
        /// Number of bytes.
        bytes: usize,
    },
}

/// Encodes the configuration, the instant from which nothing new takes effect, how the recording is played to the
/// sensor models (`None`: given directly), then each sample.
///
/// # Errors
/// Never in practice: every field has an encoding.
pub fn encode_trace(
    config: &Config,
    freeze_at_us: Option<u64>,
    recording: Option<Recording>,
    samples: impl IntoIterator<Item = Sample>,
) -> Result<Vec<u8>, postcard::Error> {
    let bytes = postcard::to_extend(config, Vec::with_capacity(512))?;
    let bytes = postcard::to_extend(&(freeze_at_us, recording), bytes)?;
    samples.into_iter().try_fold(bytes, |bytes, sample| postcard::to_extend(&sample, bytes))
}

/// Decodes records up to the summary.
///
/// # Errors
/// The bytes stop being records.
pub fn decode_flight(bytes: &[u8]) -> Result<Landed, WireError> {
    let mut outputs = Vec::new();
    let mut reports = Vec::new();
    let (mut diagnoses, mut magnets) = (Vec::new(), Vec::new());
    let mut poll_instructions = Vec::new();
    let mut rest = bytes;
    loop {
        let records = outputs.len() + reports.len() + diagnoses.len() + magnets.len();
        if rest.is_empty() {
            return Err(WireError::NoSummary { records });
        }
        let malformed = WireError::Malformed { record: records, byte: bytes.len() - rest.len() };
        let (record, after) = postcard::take_from_bytes(rest).map_err(|_| malformed)?;
        rest = after;
        match record {
            Record::Output(output) => outputs.push(output),
            Record::Window { report, poll_instructions: instructions } => {
                reports.push(report);
                poll_instructions.push(instructions);
            }
            Record::Diagnosis(report) => diagnoses.push(report),
            Record::HardIron(interval) => magnets.push(interval),
            Record::End(summary) if rest.is_empty() => {
                let counters = summary.counters;
                let flight = Flight { outputs, reports, diagnoses, magnets, counters, ..Flight::default() };
                return Ok(Landed { flight, poll_instructions, summary });
            }
            Record::End(_) => return Err(WireError::AfterSummary { bytes: rest.len() }),
            _ => return Err(malformed),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use meerkat_mwd::probe::Output;

    fn records(end: bool) -> Vec<u8> {
        let output = Output { t_us: 1_000_000, rate_rad_s: [0.1, -0.0, 3.0], attitude: None };
        let mut bytes = postcard::to_stdvec(&Record::Output(output)).unwrap();
        bytes.extend(postcard::to_stdvec(&Record::Output(Output { t_us: 2_000_000, ..output })).unwrap());
        if end {
            bytes.extend(postcard::to_stdvec(&Record::End(Summary::default())).unwrap());
        }
        bytes
    }

    #[test]
    fn every_cut_through_a_flight_is_noticed() {
        let whole = records(true);
        let landed = decode_flight(&whole).unwrap();
        assert_eq!(landed.flight.outputs.iter().map(|o| o.t_us).collect::<Vec<_>>(), [1_000_000, 2_000_000]);
        for length in 0..whole.len() {
            assert!(decode_flight(&whole[..length]).is_err(), "cut at {length}");
        }
        assert_eq!(decode_flight(&records(false)), Err(WireError::NoSummary { records: 2 }));
    }

    #[test]
    fn bytes_behind_the_summary_and_unknown_records_are_errors() {
        let mut bytes = records(true);
        bytes.push(0);
        assert_eq!(decode_flight(&bytes), Err(WireError::AfterSummary { bytes: 1 }));
        assert_eq!(decode_flight(&[200]), Err(WireError::Malformed { record: 0, byte: 0 }));
    }

    #[test]
    fn a_trace_is_the_configuration_a_freeze_and_then_the_samples() {
        let config = Config { seed: 77, ..Config::default() };
        let sample =
            Sample { t_us: u64::MAX, gyro_rad_s: [f32::MIN_POSITIVE, f32::INFINITY, -0.0], ..Sample::default() };
        let recording = Recording { inertial_us: 5_000, magnetic_us: 10_000 };
        let bytes = encode_trace(&config, Some(7), Some(recording), [sample; 3]).unwrap();
        let (decoded, mut rest): ((Config, Option<u64>, Option<Recording>), _) =
            postcard::take_from_bytes(&bytes).unwrap();
        assert_eq!(decoded, (config, Some(7), Some(recording)));
        for _ in 0..3 {
            let (decoded, after): (Sample, _) = postcard::take_from_bytes(rest).unwrap();
            assert_eq!(decoded, sample);
            assert!(rest.len() - after.len() <= 53);
            rest = after;
        }
        assert!(rest.is_empty());
    }
}
