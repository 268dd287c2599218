//! Stored model: its content, and its layout in a record.

use super::little_endian::{Reader, Writer};
use crate::{
    compensation::{ActiveEffects, Effect, FoundEffect, GyroModel, MAX_ACTIVE},
    config::Config,
    fingerprint::Fingerprint,
};

/// Version of the payload's layout that this firmware writes. It also reads version 1, which has two numbers more.
pub(super) const VERSION: u8 = 2;

/// Model that flew and was worth keeping, as it stands in flash.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StoredModel {
    /// P and b.
    pub gyro: GyroModel,
    /// 1-sigma of P (row-major, 9) then b (rad/s, 3), when it was accepted.
    pub sigma: [f32; 12],
    /// Effects that were taken out beside it.
    pub effects: ActiveEffects,
    /// [`fingerprint`] of what `effects` are relative to.
    pub library: u32,
    /// Lowest and highest temperature of the samples that it comes from, degrees Celsius; `None` without a reading.
    pub temperature_c: Option<[f32; 2]>,
    /// Time at which it was stored, microseconds of the session's own time.
    pub t_us: u64,
    /// Reason for storing it.
    pub reason: StoreReason,
}

/// Reason for storing a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum StoreReason {
    /// This many windows in succession confirmed the model.
    Stable {
        /// Number of windows.
        windows: u8,
    },
    /// A command asked for it.
    Command,
}

/// Returns the fingerprint of all that stored effects are relative to: the library in which each is a place, the
/// calibrations of accelerometer and magnetometer, and the declared latencies. With another calibration what an effect
/// says of its sensor would be taken out twice.
#[must_use]
#[inline(never)]
pub fn fingerprint(library: &[&dyn Effect], config: &Config) -> u32 {
    let mut print = Fingerprint::new();
    for effect in library {
        print.bytes(effect.name().as_bytes());
        print.bytes(&[0]);
    }
    let (accel, mag, latency) = (&config.accel, &config.mag, &config.latency);
    for model in [accel, mag] {
        print.numbers(model.matrix.as_flattened());
        print.numbers(&model.offset);
    }
    // Minus one is no latency: one that is not known is another than zero.
    print.numbers(&[latency.gyro_s, latency.accel_s, latency.mag_s].map(|late_s| late_s.unwrap_or(-1.0)));
    print.value()
}

impl StoredModel {
    pub(super) fn encode(&self, writer: &mut Writer<'_>) {
        self.gyro.p.iter().for_each(|row| writer.f32s(row));
        writer.f32s(&self.gyro.b_rad_s);
        writer.f32s(&self.sigma);
        let [low, high] = self.temperature_c.map_or([None; 2], |range| range.map(Some));
        writer.optional(low);
        writer.optional(high);
        writer.u64(self.t_us);
        let (code, windows) = match self.reason {
            StoreReason::Stable { windows } => (1, windows),
            StoreReason::Command => (2, 0),
        };
        writer.u8(code);
        writer.u8(windows);
        writer.u32(self.library);
        writer.u8(self.effects.iter().count() as u8);
        for found in self.effects.iter() {
            let pairs = found.parameters.iter().zip(&found.sigma);
            // The bits are compared, so that a negative zero is stored, too.
            let used = |(value, sigma): (&f32, &f32)| value.to_bits() | sigma.to_bits() != 0;
            let count = pairs.clone().rposition(used).map_or(0, |last| last + 1);
            writer.u8(found.index);
            writer.u8(count as u8);
            pairs.take(count).for_each(|(value, sigma)| writer.f32s(&[*value, *sigma]));
        }
    }

    /// Decodes a payload; `None` for bytes that [`StoredModel::encode`] of that version does not write, or of a later
    /// version.
    pub(super) fn decode(version: u8, payload: &[u8]) -> Option<Self> {
        if !(1..=VERSION).contains(&version) {
            return None;
        }
        let mut reader = Reader(payload);
        let p = [reader.f32s()?, reader.f32s()?, reader.f32s()?];
        let gyro = GyroModel { p, b_rad_s: reader.f32s()? };
        let sigma = reader.f32s()?;
        let temperature_c = match (reader.optional()?, reader.optional()?) {
            (Some(low), Some(high)) => Some([low, high]),
            _ => None,
        };
        let t_us = reader.u64()?;
        let reason = match (reader.u8()?, reader.u8()?) {
            (1, windows) => StoreReason::Stable { windows },
            (2, _) => StoreReason::Command,
            _ => return None,
        };
        if version == 1 {
            // Two numbers of version 1, not used any more: how clearly the model was accepted.
            let _: [Option<f32>; 2] = [reader.optional()?, reader.optional()?];
        }
        let library = reader.u32()?;
        let mut effects = ActiveEffects::none();
        let count = reader.u8()?;
        if usize::from(count) > MAX_ACTIVE {
            return None;
        }
        for _ in 0..count {
            let mut found = FoundEffect { index: reader.u8()?, ..FoundEffect::default() };
            let parameters = usize::from(reader.u8()?);
            if parameters > found.parameters.len() {
                return None;
            }
            for (value, sigma) in found.parameters.iter_mut().zip(&mut found.sigma).take(parameters) {
                [*value, *sigma] = reader.f32s()?;
            }
            effects.add(found);
        }
        reader.0.is_empty().then_some(Self { gyro, sigma, effects, library, temperature_c, t_us, reason })
    }
}

#[cfg(test)]
mod tests;
