//! Errors of the storage, named by what the caller should do.

use super::Implausible;

/// Reason for which something was not stored, read or prepared. `E` is the flash driver's error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum StorageError<E> {
    /// The flash failed; the record being written is not stored.
    Flash(E),
    /// The flash cannot be used: the requirement that it misses.
    Geometry(&'static str),
    /// No room is left that is erased already: prepare the storage as soon as the tool is not drilling.
    Full,
    /// A model is being written: step until it is done.
    Busy,
    /// The filter went on while its state was being written; that state is not stored.
    FilterWentOn,
    /// The model would not be restored.
    Implausible(Implausible),
    /// The counter only rises.
    CounterGoesBack {
        /// Counter that is stored.
        stored: u64,
    },
    /// The flash does not hold the record that was written.
    NotVerified,
    /// These bytes cannot be a key that was drawn at random.
    WeakKey,
    /// It is there already, or the region is closed: it is written only once.
    AlreadyProvisioned,
    /// It is not there.
    NotProvisioned,
    /// These are not the image's next bytes.
    NotTheNext {
        /// Offset of the next ones.
        expected: u32,
    },
}
