//! Memory that survives: accepted models, the command counter, and apart from them what the factory wrote.
//!
//! # Use
//! ```text
//! power-up   FactoryRecords::read(region)            calibrations and key; nothing here can write them
//!            ModelStore::open(flash, limits)         reads all sectors, writes nothing
//!            prepare(NotDrilling::PowerUp)           until it says Ready: the only calls that erase
//!            restore(temperature) -> Probe::restore  the nearest temperature's model, or why there is none
//! each sample   StabilityGate::sample; step()        32 bytes of a model that is being written
//! each window   Probe::model_worth_storing -> begin_model
//! commands      store_counter before the action; retire_models; prepare(NotDrilling::Command)
//! ```
//!
//! # Timing budget
//! A single-bank STM32F4 fetches no instruction from its flash while the flash is programmed or erased: reading it then stalls the bus (RM0090
//! section 3.6), interrupts included. Data sheet DS8626, section 5.3.12, flash memory programming, 32 bits at a time (2.7 to 3.6 V):
//!
//! | | typical | at most | when |
//! |---|---|---|---|
//! | a word | 16 us | 100 us | the longest stall of a sample's interrupt while drilling |
//! | one [`ModelStore::step`], 8 words | 0.13 ms | 0.8 ms | after a sample, while a model is being written |
//! | a model, 5 to 19 steps | 0.6 to 2.4 ms | 4 to 15 ms | spread over as many samples |
//! | [`ModelStore::store_counter`], 16 words | 0.26 ms | 1.6 ms | before a command is done |
//! | erasing 16 KiB | 250 ms | 500 ms | not while drilling, one in each call of [`ModelStore::prepare`] |
//! | erasing 128 KiB | 1 s | 2 s | never |
//!
//! So models stand in sectors 1 to 3, 16 KiB each; the factory's records in sector 11, write-protected by the option bytes. `memory.x` keeps
//! code out of both. A power-up after a rollover erases one or two sectors (0.5 to 1 s at most), any other none; the first one of all three.
//! A watchdog has to outlast one erasure. 10,000 erasures are guaranteed (the same section, endurance): at some 80 models a sector more
//! than two million models.
//!
//! # Why a log of its own
//! `sequential-storage` 8 erases inside `store_item` as soon as a page is full, and inside its repair, which a read can start: half a second
//! without a sample while drilling. Its queue erases only in `push`, but skips what has rotted without counting it, and neither tells an
//! erasure that was cut off from one that was completed. Both are asynchronous, which a blocking flash never needs. `ekv` erases as
//! it compacts, too. What is left of the problem when erasing is kept apart is small: records that are only appended, each in whole
//! 32-byte granules with a CRC-32; copies that are the original to the bit; an erasure is believed by the mark that was written after it.
//!
//! # What a power cut leaves
//! A record counts when its check holds, so one that was cut off is skipped and counted, and the one before it still stands. A
//! sector without its mark is erased again. What counts is copied before its sector is erased, and a copy is the same record. One ready
//! sector is left alone while drilling, so that there is always room to copy to; when the room ends before that, a model is refused and
//! counted.

mod error;
mod factory;
mod granules;
mod index;
mod little_endian;
mod model_store;
mod plausibility;
mod preparation;
mod record;
mod restoration;
mod sector;
mod stability;
mod stored_model;

pub use error::StorageError;
pub use factory::{FactoryCalibration, FactoryRecords, KEY_BYTES, Provisioning};
pub use index::ScanCounts;
pub use model_store::{ModelStore, Progress, StoreCounts};
pub use plausibility::{Implausible, Limits};
pub use preparation::{NotDrilling, Preparation};
pub use restoration::{Outcome, Restoration};
pub use stability::{BETWEEN_STORES_US, STABLE_WINDOWS, StabilityGate};
pub use stored_model::{StoreReason, StoredModel, fingerprint};
