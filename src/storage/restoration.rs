//! Restoration: the choice of the stored model that flies after power-up, by temperature and within the limits of
//! `plausibility.rs`.

use super::{
    Implausible, ModelStore, ScanCounts, StorageError, StoredModel,
    granules::{Place, walk},
    index::KEPT,
    record::Kind,
    sector::State,
    sector_size::granules_of,
};
use embedded_storage::nor_flash::NorFlash;

/// Model to fly after power-up, and the reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restoration {
    /// Model to be restored, or the reason for none.
    pub outcome: Outcome,
    /// Number of models to choose from, one for each temperature band.
    pub choice: u8,
    /// Findings when the storage was opened.
    pub counts: ScanCounts,
}

/// Model to be restored, or the reason for none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[expect(
    clippy::large_enum_variant,
    reason = "nothing here can be boxed, and it lives only until the model is restored"
)]
#[non_exhaustive]
pub enum Outcome {
    /// The model.
    Chosen {
        /// Model for `Probe::restore`.
        model: StoredModel,
        /// Number of the model: later models have higher ones.
        number: u32,
        /// Distance of the present temperature from the model's range, kelvin; `None` if either is not known.
        distance_k: Option<f32>,
    },
    /// No model was ever stored here, or none that is whole.
    NothingStored,
    /// All stored models have been retired.
    AllRetired,
    /// The stored models have a layout that a later firmware wrote.
    FromTheFuture,
    /// Every stored model is implausible; the reason for the first of them.
    Implausible(Implausible),
}

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// Chooses the model for the present temperature: the one with the nearest temperatures, and of equally near ones
    /// (to 10 K) the newest. Without a temperature it chooses the newest.
    ///
    /// # Errors
    /// A model is being written.
    #[inline(never)]
    pub fn restore(&mut self, temperature_c: Option<f32>) -> Result<Restoration, StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        let choice = self.index.flyable().count() as u8;
        for _ in 0..2 * KEPT {
            let Some(slot) = self.index.nearest(temperature_c) else { break };
            let header = self.read_record(slot.place).filter(|header| header.kind == Kind::MODEL);
            let model = header.and_then(|header| StoredModel::decode(header.version, header.payload(&self.buffer)?));
            if let Some(model) = model {
                let distance_k = slot.distance_k(temperature_c);
                let outcome = Outcome::Chosen { model, number: slot.number, distance_k };
                return Ok(Restoration { outcome, choice, counts: self.index.counts });
            }
            self.forget_rotten(slot.place);
        }
        let counts = self.index.counts;
        let outcome = match counts.first_implausible {
            Some((_, reason)) => Outcome::Implausible(reason),
            None if counts.from_the_future > 0 => Outcome::FromTheFuture,
            None if counts.retired > 0 || self.index.retired.value().is_some() => Outcome::AllRetired,
            None => Outcome::NothingStored,
        };
        Ok(Restoration { outcome, choice, counts })
    }

    /// Reads all sectors anew. Returns true if the flash holds the records that count, no more and no less.
    ///
    /// # Errors
    /// A model is being written.
    pub fn verify(&mut self) -> Result<bool, StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        let found = self.scan(None);
        Ok(found.holds_all_of(&self.index) && self.index.holds_all_of(&found))
    }

    /// Returns the newest model of a lower number that may fly, whatever its temperature. Such a model can be read
    /// until its sector is erased.
    ///
    /// # Errors
    /// A model is being written.
    #[inline(never)]
    pub fn model_before(&mut self, number: u32) -> Result<Option<StoredModel>, StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        let retired = self.index.retired.value().unwrap_or(0);
        let mut found: Option<(u32, StoredModel)> = None;
        for (sector, state) in (0..).zip(self.sectors.map(|sector| sector.state)) {
            if state != State::Used {
                continue;
            }
            let (limits, base) = (&self.limits, Place { sector, granule: 0 }.address::<F>());
            walk(&mut self.flash, base, (1, granules_of::<F>()), &mut self.buffer, &mut |header, payload, _| {
                let newest = found.map_or(0, |(newest, _)| newest);
                let older = header.number < number && header.number > newest && u64::from(header.number) > retired;
                if older
                    && header.kind == Kind::MODEL
                    && let Some(model) = StoredModel::decode(header.version, payload)
                    && limits.check(&model).is_ok()
                {
                    found = Some((header.number, model));
                }
            });
        }
        Ok(found.map(|(_, model)| model))
    }
}
