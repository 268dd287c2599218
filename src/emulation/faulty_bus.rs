//! Bus wrapper that injects one fault, at a chosen transaction, into any bus.

mod i2c_bus;
mod spi_bus;

use super::fault::Schedule;
use core::cell::Cell;
use embedded_hal::{i2c, spi};

/// Largest number of operations in a transaction: 8, and the two that a flipped bit adds.
const OPERATIONS: usize = 10;

/// Fault of the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BusFault {
    /// The part does not acknowledge; it has seen nothing. SPI has no acknowledge: the error there is `Other`.
    Nack,
    /// Another master was quicker (on SPI: a mode fault); the part has seen nothing.
    ArbitrationLoss,
    /// The part does the transaction, but its answer is not in time: the host waits as long as the fault lasts.
    TimeOut,
    /// The lines are held: nothing goes through as long as the fault lasts.
    Locked,
    /// Bytes after the first `whole` are read as the idle line, `0xFF`, and the bus driver notices nothing.
    ShortRead {
        /// Bytes that are read correctly.
        whole: u16,
    },
    /// One bit of the bytes written and read in the transaction is inverted. Bits are counted in the order of
    /// transfer, modulo their number.
    BitFlip {
        /// Number of the bit, from 0; a byte's most significant bit comes first.
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
    /// An error of the wrapped bus.
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

/// Meter of the ticks that transactions take, by a counter of the board.
#[derive(Clone, Copy, Debug)]
pub struct WireMeter {
    /// Function that reads the chip's tick counter, which has 24 bits and counts up.
    pub count: fn() -> u32,
    /// Ticks spent so far.
    pub spent: u64,
}

/// Bus with one planned fault. The schedule is shared with the program that plans the fault and counts transactions.
pub struct FaultyBus<'a, B> {
    inner: B,
    now_us: &'a Cell<u64>,
    schedule: &'a Cell<Schedule<BusFault>>,
    meter: Option<&'a Cell<Option<WireMeter>>>,
}

/// Course of a transaction.
enum Course {
    /// The wrapped bus does the transaction, with this fault in its bytes.
    Through(Option<BusFault>),
    /// The wrapped bus does the transaction, and the host gets this error.
    Unanswered(BusFault),
    /// The wrapped bus sees nothing, and the host gets this error.
    Blocked(BusFault),
}

impl<'a, B> FaultyBus<'a, B> {
    /// Wraps `inner`; `now_us` is the time of the simulation, which a time-out advances.
    #[must_use]
    pub const fn new(inner: B, now_us: &'a Cell<u64>, schedule: &'a Cell<Schedule<BusFault>>) -> Self {
        Self { inner, now_us, schedule, meter: None }
    }

    /// Adds a meter, which counts the ticks of transactions while its cell holds one.
    #[must_use]
    pub fn metered(self, meter: &'a Cell<Option<WireMeter>>) -> Self {
        Self { meter: Some(meter), ..self }
    }

    /// Does a transaction and adds its ticks to the meter.
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

/// Place of a flipped bit in the bytes written and read.
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

    /// Returns the byte's index in an operation that begins at `offset` and has `length` bytes; `None` if it is
    /// outside.
    fn within(self, offset: usize, length: usize) -> Option<usize> {
        self.byte.checked_sub(offset).filter(|place| *place < length)
    }
}

/// Applies a fault to the bytes of one read. `offset`: the transaction's bytes before these, written and read;
/// `already_read`: how many of those were read.
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
