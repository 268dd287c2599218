//! Store of the command counter, which the gate needs to refuse replayed commands. `storage/single_values.rs`
//! implements it in flash.

/// Memory of the latest counter of an authenticated command, which survives a loss of power.
pub trait CounterStore {
    /// Reason for which the counter could not be read or stored.
    type Error;

    /// Reads the latest counter that was stored; 0 when none ever was.
    ///
    /// # Errors
    /// The counter cannot be known: no command is then accepted.
    fn read(&mut self) -> Result<u64, Self::Error>;

    /// Stores the counter. When this returns, [`CounterStore::read`] gives it, even after a loss of power.
    ///
    /// # Errors
    /// The counter may not have been stored: the command is then not carried out.
    fn store(&mut self, counter: u64) -> Result<(), Self::Error>;
}
