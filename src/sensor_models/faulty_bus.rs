//! A bus that fails once, at a chosen transaction, around any other.

mod i2c_bus;
mod spi_bus;

use super::fault::Schedule;
use core::cell::Cell;
use embedded_hal::{i2c, spi};

/// Operations that one transaction may have, with the two that a flipped bit adds.
const OPERATIONS: usize = 10;

/// Fault of the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BusFault {
    /// Nobody acknowledges; the part has seen nothing. An SPI bus has no such thing: there its driver reports some
    /// other error.
    Nack,
    /// Another master was quicker (on SPI: a mode fault); the part has seen nothing.
    ArbitrationLoss,
    /// The part has done what was asked, and the answer was not in time: the host waits as long as the fault lasts.
    TimeOut,
    /// The lines are held: nothing goes through as long as the fault lasts.
    Locked,
    /// From this byte on what is read is the idle line, `0xFF`, and the bus driver notices nothing.
    ShortRead {
        /// Bytes that are read rightly.
        whole: u16,
    },
    /// One bit changes sides, of those that are written and read in the transaction, counted in that order; from the
    /// first again where there are not so many.
    BitFlip {
        /// Which.
        bit: u16,
    },
}

/// An error of [`FaultyBus`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InjectedError<E> {
    /// The fault that was injected.
    Injected(BusFault),
    /// The transaction has more operations than this wrapper passes on (8).
    TooManyOperations,
    /// An error of the bus inside.
    Bus(E),
}

impl<E: spi::Error> spi::Error for InjectedError<E> {
    fn kind(&self) -> spi::ErrorKind {
        match self {
            Self::Injected(BusFault::ArbitrationLoss) => spi::ErrorKind::ModeFault,
            Self::Bus(error) => error.kind(),
            Self::Injected(_) | Self::TooManyOperations => spi::ErrorKind::Other,
        }
    }
}

impl<E: i2c::Error> i2c::Error for InjectedError<E> {
    fn kind(&self) -> i2c::ErrorKind {
        match self {
            Self::Injected(BusFault::Nack) => i2c::ErrorKind::NoAcknowledge(i2c::NoAcknowledgeSource::Unknown),
            Self::Injected(BusFault::ArbitrationLoss) => i2c::ErrorKind::ArbitrationLoss,
            Self::Injected(BusFault::Locked) => i2c::ErrorKind::Bus,
            Self::Bus(error) => error.kind(),
            Self::Injected(_) | Self::TooManyOperations => i2c::ErrorKind::Other,
        }
    }
}

/// Counts what is spent in transactions, by whatever counter a board has.
#[derive(Clone, Copy, Debug)]
pub struct WireMeter {
    /// Reads a counter of 24 bits that counts up.
    pub count: fn() -> u32,
    /// Ticks spent so far.
    pub spent: u64,
}

/// A bus with one fault. The schedule is shared with whoever plans it and counts transactions.
pub struct FaultyBus<'a, B> {
    inner: B,
    now_us: &'a Cell<u64>,
    schedule: &'a Cell<Schedule<BusFault>>,
    meter: Option<&'a Cell<Option<WireMeter>>>,
}

/// Course of a transaction.
enum Course {
    /// The bus inside does it, and then this is done to what was read.
    Through(Option<BusFault>),
    /// The bus inside does it, and the host hears of an error.
    Unanswered(BusFault),
    /// Nothing goes through.
    Blocked(BusFault),
}

impl<'a, B> FaultyBus<'a, B> {
    /// Around `inner`; `now_us` is the time of the program that plays, which a time-out moves on.
    #[must_use]
    pub const fn new(inner: B, now_us: &'a Cell<u64>, schedule: &'a Cell<Schedule<BusFault>>) -> Self {
        Self { inner, now_us, schedule, meter: None }
    }

    /// The same, with what its transactions take counted while there is a meter.
    #[must_use]
    pub fn metered(self, meter: &'a Cell<Option<WireMeter>>) -> Self {
        Self { meter: Some(meter), ..self }
    }

    /// Does a transaction and adds what it took.
    fn measured<T>(&mut self, transaction: impl FnOnce(&mut Self) -> T) -> T {
        let Some((cell, meter)) = self.meter.and_then(|cell| Some((cell, cell.get()?))) else {
            return transaction(self);
        };
        let began = (meter.count)();
        let result = transaction(self);
        let spent = (meter.count)().wrapping_sub(began) & ((1 << 24) - 1);
        cell.set(Some(WireMeter { spent: meter.spent + u64::from(spent), ..meter }));
        result
    }

    fn begin(&self, bytes: usize) -> Course {
        let mut schedule = self.schedule.get();
        schedule.moves(bytes);
        schedule.begin(self.now_us.get());
        let acting = schedule.acting(self.now_us.get());
        self.schedule.set(schedule);
        match acting {
            Some(fault @ BusFault::TimeOut) => {
                self.now_us.set(self.now_us.get().saturating_add(schedule.lasting_us()));
                Course::Unanswered(fault)
            }
            Some(fault @ (BusFault::Nack | BusFault::ArbitrationLoss | BusFault::Locked)) => Course::Blocked(fault),
            through => Course::Through(through),
        }
    }
}

/// Where in what is written or read a flipped bit is.
#[derive(Clone, Copy)]
struct Flip {
    /// Byte of the whole transaction.
    byte: usize,
    mask: u8,
}

impl Flip {
    fn of(fault: Option<BusFault>, bytes: usize) -> Option<Self> {
        let Some(BusFault::BitFlip { bit }) = fault else { return None };
        let bit = usize::from(bit).checked_rem(8 * bytes)?;
        // Most significant bit first, as both buses send.
        Some(Self { byte: bit / 8, mask: 0x80 >> (bit % 8) })
    }

    /// The byte's place in an operation that begins at `offset` and has `length` bytes.
    fn within(self, offset: usize, length: usize) -> Option<usize> {
        self.byte.checked_sub(offset).filter(|place| *place < length)
    }
}

/// Spoils the bytes of one read. `offset`: bytes of the transaction before them, written and read; `already_read`:
/// those of them that were read.
fn spoil(bytes: &mut [u8], offset: usize, already_read: usize, fault: Option<BusFault>, flip: Option<Flip>) {
    if let Some(flip) = flip
        && let Some(byte) = flip.within(offset, bytes.len()).and_then(|place| bytes.get_mut(place))
    {
        *byte ^= flip.mask;
    }
    if let Some(BusFault::ShortRead { whole }) = fault {
        bytes.iter_mut().skip(usize::from(whole).saturating_sub(already_read)).for_each(|byte| *byte = 0xFF);
    }
}
