/// Where the latest counter of an authenticated command survives a loss of power.
pub trait CounterStore {
    /// Why it could not be read or stored.
    type Error;

    /// The latest that was stored; 0 when none ever was.
    ///
    /// # Errors
    /// It cannot be known: no command is then accepted.
    fn read(&mut self) -> Result<u64, Self::Error>;

    /// Stores it; when this returns, [`CounterStore::read`] gives it, even after a loss of power.
    ///
    /// # Errors
    /// It is not certain that it was stored: the command is then not carried out.
    fn store(&mut self, counter: u64) -> Result<(), Self::Error>;
}
