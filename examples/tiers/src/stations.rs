//! A run's stations corrected together on the chip: a full multi-station analysis, with a digest of all that it says.

use meerkat_mwd::{
    config::SurveyErrors,
    survey::{
        Uncertain,
        multi_station::{Decision, MultiStation, MultiStationReport, MultiStationSettings, Station, StationReference},
    },
};

use crate::Digest;

/// Bytes of a station in the file: depth, force, field, and the reference's gravity, field and dip; floats of four
/// bytes.
pub const STATION: usize = 40;

/// Reads a station.
#[must_use]
pub fn unpack_station(record: &[u8; STATION]) -> Station {
    let mut words = record.chunks_exact(4).map(|bytes| match bytes {
        &[a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
        _ => 0.0,
    });
    let mut next = || words.next().unwrap_or(0.0);
    Station {
        depth_m: next(),
        force_m_s2: [next(), next(), next()],
        field_ut: [next(), next(), next()],
        reference: StationReference { gravity_m_s2: next(), field_ut: next(), dip_rad: next() },
    }
}

/// Writes a station as [`unpack_station`] reads it.
#[must_use]
pub fn pack_station(station: &Station) -> [u8; STATION] {
    let Station { depth_m, force_m_s2: [a, b, c], field_ut: [x, y, z], reference } = *station;
    let StationReference { gravity_m_s2, field_ut, dip_rad } = reference;
    let mut record = [0; STATION];
    let words = [depth_m, a, b, c, x, y, z, gravity_m_s2, field_ut, dip_rad];
    for (place, byte) in record.iter_mut().zip(words.into_iter().flat_map(f32::to_le_bytes)) {
        *place = byte;
    }
    record
}

/// The analysis with the error model's sizes. A call of its own, so that its cost can be counted.
#[inline(never)]
#[must_use]
pub fn analysed_run(stations: &MultiStation) -> Option<MultiStationReport> {
    stations.analyse(&SurveyErrors::default(), &MultiStationSettings::default())
}

/// Digest of all bits that a report says: of the run, of its errors and of every station.
#[inline(never)]
#[must_use]
pub fn digest_of(report: &MultiStationReport, stations: &[Station]) -> u32 {
    let mut digest = Digest::default();
    digest.word(report.left_out as u32);
    digest.word((report.left_out >> 32) as u32);
    for decision in [report.azimuth, report.inclination] {
        digest.word(u32::from(decision == Decision::Corrected));
    }
    for x in [report.noise_ratio, report.residual_uncorrected, report.residual_left_out] {
        digest.word(x.to_bits());
    }
    let mut take = |x: Uncertain| [x.value, x.sigma].iter().for_each(|x| digest.word(x.to_bits()));
    report.estimates().iter().for_each(|estimate| take(estimate.estimate));
    for station in stations.iter().filter_map(|station| report.corrected(station)) {
        take(station.inclination_rad);
        take(station.magnetic_azimuth_rad);
        take(station.measured_azimuth_rad);
        take(station.measured_inclination_rad);
    }
    digest.number()
}
