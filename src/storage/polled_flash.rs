//! An asynchronous NOR flash, for the storage, whose calls are functions and not futures.

use core::{
    future::Future,
    pin::pin,
    task::{Context, Poll, Waker},
};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use embedded_storage_async::nor_flash::{NorFlash as AsyncNorFlash, ReadNorFlash as AsyncReadNorFlash};

/// Asynchronous NOR flash whose futures are polled until they are ready: a call takes as long as the flash does, and no
/// longer than `most_polls`.
///
/// Give the storage a task of its own, of a lower priority than the one that pushes samples: while a call lasts, the
/// tasks of the same executor wait. A driver that shares its bus by a mutex of that executor is therefore never ready
/// if another task holds the bus; one whose transfers end in an interrupt is.
#[derive(Debug)]
pub struct PolledFlash<F> {
    flash: F,
    most_polls: u32,
}

/// Reason for which a call failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum PolledError<E> {
    /// The flash failed.
    Flash(E),
    /// The flash was not ready after all polls; what it was doing was dropped.
    NotReady,
}

impl<E: NorFlashError> NorFlashError for PolledError<E> {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Flash(error) => error.kind(),
            Self::NotReady => NorFlashErrorKind::Other,
        }
    }
}

impl<F> PolledFlash<F> {
    /// Takes the flash. Each call polls it at most `most_polls` times.
    pub const fn new(flash: F, most_polls: u32) -> Self {
        Self { flash, most_polls }
    }

    /// Returns the flash.
    pub fn into_inner(self) -> F {
        self.flash
    }
}

/// Polls a future until it is ready.
fn ready<T, E>(future: impl Future<Output = Result<T, E>>, most_polls: u32) -> Result<T, PolledError<E>> {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    for _ in 0..most_polls {
        if let Poll::Ready(done) = future.as_mut().poll(&mut context) {
            return done.map_err(PolledError::Flash);
        }
    }
    Err(PolledError::NotReady)
}

impl<F: AsyncReadNorFlash> ErrorType for PolledFlash<F> {
    type Error = PolledError<F::Error>;
}

impl<F: AsyncReadNorFlash> ReadNorFlash for PolledFlash<F> {
    const READ_SIZE: usize = F::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        ready(self.flash.read(offset, bytes), self.most_polls)
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl<F: AsyncNorFlash> NorFlash for PolledFlash<F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        ready(self.flash.erase(from, to), self.most_polls)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        ready(self.flash.write(offset, bytes), self.most_polls)
    }
}
