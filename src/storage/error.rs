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
    /// No erased room is left: prepare the storage as soon as the tool is not drilling.
    Full,
    /// A record is being written: call `step` until it is done. Of images: one is on trial, and confirms itself soon.
    Busy,
    /// The estimator was updated while its state was being written; that state is not stored.
    FilterWentOn,
    /// The model would not be restored, so it is not stored.
    Implausible(Implausible),
    /// The new number is not above the stored one, which only rises.
    CounterGoesBack {
        /// Number that is stored.
        stored: u64,
    },
    /// The flash does not hold the record that was written.
    NotVerified,
    /// The key's bytes cannot have been drawn at random.
    WeakKey,
    /// A factory's record of this kind is there already, or the region is closed: each kind is written only once.
    AlreadyProvisioned,
    /// The factory's region holds no record of this kind.
    NotProvisioned,
    /// The bytes written are not the image's next ones.
    NotTheNext {
        /// Offset of the image's next bytes.
        expected: u32,
    },
}
