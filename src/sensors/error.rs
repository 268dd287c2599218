//! Errors of a start.

/// Reason for which a part could not be started; `E` is the bus's error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum StartError<E> {
    /// The bus failed.
    Bus(E),
    /// Another part answers, or none.
    WrongIdentity {
        /// Identity by the data sheet.
        expected: u8,
        /// Identity that was read.
        found: u8,
    },
    /// A register does not hold the value written to it.
    NotTaken {
        /// Address of the register.
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

/// Reason for which a call to read brought no reading. Keep calling: the source re-initialises its part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum ReadError<E> {
    /// The bus failed; lost readings are counted when the next burst shows how many.
    Bus(E),
    /// A start of the part failed; it is tried again after a pause.
    Start(StartError<E>),
    /// The part had returned to its default settings: its output is dropped.
    Reset,
    /// The part has put nothing out for more than ten periods.
    Silent,
}
