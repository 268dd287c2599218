/// Why a part could not be started; `E` is the bus's error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum StartError<E> {
    /// The bus failed.
    Bus(E),
    /// Another part answers, or none.
    WrongIdentity {
        /// What the data sheet says.
        expected: u8,
        /// What was read.
        found: u8,
    },
    /// A register does not hold what was written to it.
    NotTaken {
        /// Its address.
        register: u8,
    },
    /// The part is still busy after the time that its data sheet allows.
    Busy,
}

impl<E> From<E> for StartError<E> {
    fn from(error: E) -> Self {
        Self::Bus(error)
    }
}

/// Why a call to read brought no reading. Nothing has to be done about it but to go on calling: the source re-initialises its part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum ReadError<E> {
    /// The bus failed; readings may be lost, and are counted when the next burst shows how many.
    Bus(E),
    /// A start of the part failed; it is tried again after a pause.
    Start(StartError<E>),
    /// The part had gone back to its default settings: what it had put out is dropped.
    Reset,
    /// The part has put nothing out for many periods.
    Silent,
}
