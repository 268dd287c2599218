//! Three sizes of the pipeline, and a run's stations corrected together; and what their images share: start of the
//! chip, samples from a file, a digest of all outputs, the stack that was used.
#![cfg_attr(target_os = "none", no_std)]

mod attitude;
#[cfg(target_os = "none")]
mod chip;
mod full;
mod identify;
mod stations;

pub use attitude::Attitude;
#[cfg(target_os = "none")]
pub use chip::{run, run_stations};
pub use full::{COLUMNS, Full, FullProbe};
pub use identify::{Identify, Small};
pub use stations::{STATION, analysed_run, digest_of, pack_station, unpack_station};

use meerkat_mwd::{Config, Sample, SampleFlags, config::Motion, probe::Output};

/// Bytes of a sample in the file: time (8), gyro, accelerometer, magnetometer (3 x 4 each), temperature (4), flags (4).
pub const RECORD: usize = 52;

/// Work of an image on each sample.
pub trait Tier {
    /// Starts with a configuration. Returns false if it cannot be used.
    fn configure(&mut self, config: &Config) -> bool;
    /// Takes a sample, and does what work there is.
    fn push(&mut self, sample: &Sample) -> Option<Output>;
    /// Number of surveys, models or windows that came of it.
    fn results(&self) -> u32;
}

/// Configuration of a recording of motion by hand.
#[must_use]
pub fn by_hand(sample_period_us: u32) -> Config {
    let mut config = Config { sample_period_us, ..Config::default() };
    config.identification.motion = Motion::Hand;
    config
}

/// Digest of all bits of outputs (FNV-1a).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(u32);

impl Default for Digest {
    fn default() -> Self {
        Self(0x811C_9DC5)
    }
}

impl Digest {
    /// Takes an output.
    pub fn take(&mut self, output: &Output) {
        output.rate_rad_s.iter().for_each(|x| self.word(x.to_bits()));
        if let Some(attitude) = &output.attitude {
            let numbers = [attitude.inclination_rad, attitude.azimuth_rad, attitude.sigma_azimuth_rad];
            attitude.q.iter().chain(&numbers).for_each(|x| self.word(x.to_bits()));
            self.word(attitude.flags.bits().into());
        }
    }

    const fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0193);
    }

    /// The digest's number.
    #[must_use]
    pub const fn number(self) -> u32 {
        self.0
    }
}

/// Reads a sample.
#[must_use]
pub fn unpack(record: &[u8; RECORD]) -> Sample {
    let word = |at: usize| match record.get(at..at + 4) {
        Some(&[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    };
    let vector = |at: usize| [0, 4, 8].map(|offset| f32::from_bits(word(at + offset)));
    Sample {
        t_us: u64::from(word(4)) << 32 | u64::from(word(0)),
        gyro_rad_s: vector(8),
        accel_m_s2: vector(20),
        mag_ut: vector(32),
        temperature_c: f32::from_bits(word(44)),
        flags: SampleFlags::from_bits_truncate(word(48) as u16),
    }
}

/// Writes a sample as [`unpack`] reads it.
#[must_use]
pub fn pack(sample: &Sample) -> [u8; RECORD] {
    let mut record = [0; RECORD];
    let vectors = [sample.gyro_rad_s, sample.accel_m_s2, sample.mag_ut];
    let words = vectors.as_flattened().iter().chain([&sample.temperature_c]).map(|x| x.to_bits());
    let words = words.chain([u32::from(sample.flags.bits())]).flat_map(u32::to_le_bytes);
    for (place, byte) in record.iter_mut().zip(sample.t_us.to_le_bytes().into_iter().chain(words)) {
        *place = byte;
    }
    record
}
