//! Memory that survives: accepted models, the command counter, and apart from them what the factory wrote.
//!
//! # Use
//! ```text
//! factory    Provisioning::write(record)             calibrations, mounting and key, once
//! power-up   FactoryRecords::read(region)            what the factory wrote
//!            ModelStore::open(flash, limits)         reads all sectors, writes nothing
//!            prepare(NotDrilling::PowerUp)           until it says Ready: the only calls that erase
//!            restore(temperature) -> Probe::restore  the nearest temperature's model, or why there is none
//!            learnt_with(number), read_learnt -> Probe::go_on    the filter goes on, or starts from its prior
//! each sample   StabilityGate::sample; step()        32 bytes of a model that is being written
//!               no Probe::poll while holds_filter(); StabilityGate::stored when a model is whole
//! each window   ModelHistory::window                 for the commands alone
//!               Probe::model_worth_storing -> begin_learnt, step_learnt until it is whole, begin_model
//! commands      store_counter before the action; ModelHistory -> store_model; retire_models; store_command
//!               prepare(NotDrilling::Command)
//! ```
//!
//! # Timing budget
//! A single-bank STM32F4 fetches no instruction from its flash while the flash is programmed or erased:
//! reading it then stalls the bus (RM0090 section 3.6, erase and program operations), interrupts included.
//! Data sheet DS8626, memory characteristics, flash memory programming, 32 bits at a time, as the driver
//! erases and programs (2.7 to 3.6 V; a byte at a time takes as long for each byte, and erasing then 400 and
//! 800 ms):
//!
//! | | typical | at most | when |
//! |---|---|---|---|
//! | a word | 16 us | 100 us | the longest stall of a sample's interrupt while drilling |
//! | one [`ModelStore::step`], 8 words | 0.13 ms | 0.8 ms | after a sample, while a model is being written |
//! | a model, 5 to 19 steps | 0.6 to 2.4 ms | 4 to 15 ms | spread over as many samples |
//! | what the filter has learnt, 98 steps | 13 ms | 79 ms | before a model, with the filter's work put off meanwhile |
//! | [`ModelStore::store_counter`], 16 words | 0.26 ms | 1.6 ms | before a command is done |
//! | [`ModelStore::store_command`], up to 160 words | 2.6 ms | 16 ms | before a command is done, at rest |
//! | erasing 16 KiB | 250 ms | 500 ms | not while drilling, one in each call of [`ModelStore::prepare`] |
//! | copying what counts before that, up to 2,000 words | 32 ms | 0.2 s | in the same call |
//! | erasing 128 KiB | 1 s | 2 s | never |
//!
//! So models stand in sectors 1 to 3, 16 KiB each; the factory's records in sector 11, write-protected by the
//! option bytes. `memory.x` keeps code out of both. A power-up after a rollover erases one or two sectors
//! (0.5 to 1 s at most), any other none; the first one of all three. A watchdog has to outlast one call of
//! [`ModelStore::prepare`], 0.7 s, at the fastest that its oscillator may be: 47 kHz of nominal 32 (DS8626,
//! low-speed internal RC oscillator). Of smaller pages (4 KiB on an nRF52840: 85 ms each) several make a
//! sector, and a call erases one.
//!
//! 10,000 erasures are guaranteed (DS8626, endurance): at some 80 models a sector more than two
//! million models.
//!
//! # Why a log of its own
//! `sequential-storage` 8 erases inside `store_item` as soon as a page is full, and inside its repair, which a read can
//! start: half a second without a sample while drilling. Its queue never erases to push where it may not overwrite, but
//! map and queue skip rotten records without counting them, and a page counts as erased when its first and last words
//! read so, as they can after an erasure that was cut off. `ekv` erases as it compacts, too. Erasing kept apart, what
//! is left of the problem is small: records that are only appended, each in whole 32-byte granules with a CRC-32C;
//! copies that are the original to the bit; an erasure counts only with the mark that was written after it. The flash
//! is driven through `embedded-storage`'s blocking trait: on the chip the processor is what blocks, so there is nothing
//! that a future could wait for. An external flash whose driver is asynchronous alone (`embedded-storage-async`) goes
//! through `PolledFlash` (feature `async-storage`), which polls each future until it is ready and so blocks, too: give
//! the storage a task of its own.
//!
//! # What a power cut leaves
//! A record counts when its check holds, so one that was cut off is skipped and counted, and the one before it still
//! stands. A bit of the last word may read as 0 or 1 from then on, and the record be whole at one power-up and not at
//! the next. So a counter, which is written twice, is written anew before anything is erased where only one copy is
//! whole; and the last model that was found is copied before the model that it replaced may be erased. What cannot be
//! read, as torn words of flash with error correction, is damage like any other. A sector without its mark is erased
//! again. What counts is copied before its sector is erased, and a copy is the same record. One ready sector is left
//! alone while drilling, so that there is always room to copy to; when the room ends before that, a model is refused
//! and counted.

mod command_record;
mod dose_record;
mod error;
mod factory;
mod granules;
#[cfg(feature = "image-slots")]
mod image_slots;
mod index;
mod learnt_parts;
mod little_endian;
mod model_history;
mod model_store;
mod newest;
mod newest_records;
mod plausibility;
#[cfg(feature = "async-storage")]
mod polled_flash;
mod preparation;
mod programming;
mod provisioning;
mod record;
mod restoration;
mod room;
mod sector;
mod sector_size;
mod single_values;
mod stability;
mod stored_model;
mod writing_learnt;

pub use command_record::StoredCommand;
pub use error::StorageError;
pub use factory::{FactoryCalibration, FactoryKey, FactoryRecord, FactoryRecords, KEY_BYTES, Mounting, can_be_key};
#[cfg(feature = "image-slots")]
pub use image_slots::{DIGEST_BYTES, Image, ImageSlots, Receiving, Slot, Start};
pub use index::ScanCounts;
pub use learnt_parts::LearntProgress;
pub use model_history::ModelHistory;
pub use model_store::{ModelStore, Progress, StoreCounts};
pub use plausibility::{Implausible, Limits};
#[cfg(feature = "async-storage")]
pub use polled_flash::{PolledError, PolledFlash};
pub use preparation::{NotDrilling, Preparation};
pub use provisioning::Provisioning;
pub use restoration::{Outcome, Restoration};
pub use stability::{BETWEEN_STORES_US, STABLE_WINDOWS, StabilityGate};
pub use stored_model::{StoreReason, StoredModel, fingerprint};
