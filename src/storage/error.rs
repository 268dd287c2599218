use super::Implausible;

/// Why something was not stored, read or prepared. `E` is the flash driver's error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum StorageError<E> {
    /// The flash failed; what was being written is not stored.
    Flash(E),
    /// The flash cannot be used: what it must be.
    Geometry(&'static str),
    /// No room is left that is erased already: prepare the storage as soon as the tool is not drilling.
    Full,
    /// A model is being written: step until it is done.
    Busy,
    /// The filter went on while what it had learnt was being written, which is then not stored.
    FilterWentOn,
    /// The model would not be restored.
    Implausible(Implausible),
    /// The counter only rises.
    CounterGoesBack {
        /// Where it stands.
        stored: u64,
    },
    /// The flash does not hold what was written.
    NotVerified,
    /// These bytes cannot be a key that was drawn at random.
    WeakKey,
    /// It is there already, and is written only once.
    AlreadyProvisioned,
}
