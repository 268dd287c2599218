//! Board: all that the application needs of a chip.

use super::{Acquired, AcquisitionCounts, ProgramUpdate, Stage};
use crate::{
    storage::FactoryRecord,
    telemetry::{CommandRefusal, ProbeId, ResetReason},
};
use embedded_storage::nor_flash::NorFlash;

/// A board. Its interrupt reads the sensors and fills a queue; everything else happens when the application calls.
pub trait Board {
    /// Flash sectors for stored models.
    type Flash: NorFlash;

    /// Microseconds of the clock that stamps the samples.
    fn now_us(&self) -> u64;

    /// Clock of the processor, Hz; it sets how much work is done beside the samples.
    fn clock_hz(&self) -> u32 {
        168_000_000
    }

    /// Takes the oldest sample that waits in the queue.
    fn sample(&mut self) -> Option<Acquired>;

    /// Counters of the interrupt that reads the sensors.
    fn acquisition(&self) -> &AcquisitionCounts;

    /// Takes as many of the first bytes as the transmitter has room for, and returns their number. Does not wait.
    fn send(&mut self, bytes: &[u8]) -> usize;

    /// Takes the next byte that was received.
    fn receive(&mut self) -> Option<u8>;

    /// Restarts the watchdog's time.
    fn feed_watchdog(&mut self);

    /// Sleeps until an interrupt, unless a sample is waiting.
    fn idle(&mut self);

    /// Reason for which the chip started.
    fn reset_reason(&self) -> ResetReason;

    /// Resets by the watchdog since power came.
    fn watchdog_resets(&self) -> u32;

    /// The chip's unique number.
    fn identity(&self) -> ProbeId;

    /// Bytes of stack: the most used so far, and those that there are.
    fn stack_bytes(&self) -> [u32; 2];

    /// Writes one of the factory's records into its region, once, or compares it: [`provision`](super::provision). A
    /// board whose region is protected, or is written by other means, keeps this default, which refuses.
    ///
    /// # Errors
    /// The reason of the refusal.
    fn provision(&mut self, _record: &FactoryRecord, _only_check: bool) -> Result<(), CommandRefusal> {
        Err(CommandRefusal::NotSupported)
    }

    /// Receiver of another program; `None`, as here, for a board that runs one for ever.
    fn program_update(&mut self) -> Option<&mut dyn ProgramUpdate> {
        None
    }

    /// Starts the chip anew, after a command that is refused unless [`Board::program_update`] gives something.
    fn restart(&mut self) {}

    /// Notes that a stage begins, for boards that simulate a hang in it; the others do nothing.
    fn enter(&mut self, _stage: Stage) {}
}
