//! Board: all that the application needs of a chip.

use super::{Acquired, AcquisitionCounts, Stage};
use crate::{
    storage::FactoryRecord,
    telemetry::{CommandRefusal, ProbeId, ResetReason},
};
use embedded_storage::nor_flash::NorFlash;

/// A board. Its interrupt reads the sensors and fills a queue; everything else happens when the application calls.
pub trait Board {
    /// The sectors of stored models.
    type Flash: NorFlash;

    /// Microseconds of the clock that stamps the samples.
    fn now_us(&self) -> u64;

    /// Clock of the processor, Hz: how much work beside samples there is time for.
    fn clock_hz(&self) -> u32 {
        168_000_000
    }

    /// The oldest sample that waits in the queue.
    fn sample(&mut self) -> Option<Acquired>;

    /// Counts of the interrupt.
    fn acquisition(&self) -> &AcquisitionCounts;

    /// Takes as many of the first bytes as the transmitter has room for, and says how many. Does not wait.
    fn send(&mut self, bytes: &[u8]) -> usize;

    /// The next byte that was received.
    fn receive(&mut self) -> Option<u8>;

    /// Gives the watchdog another round.
    fn feed_watchdog(&mut self);

    /// Sleeps until an interrupt, unless a sample is waiting.
    fn idle(&mut self);

    /// Why the chip started.
    fn reset_reason(&self) -> ResetReason;

    /// Resets by the watchdog since power came.
    fn watchdog_resets(&self) -> u32;

    /// The chip's unique number.
    fn identity(&self) -> ProbeId;

    /// Most bytes of stack used so far, and how many there are.
    fn stack_bytes(&self) -> [u32; 2];

    /// Writes one of the factory's records into its region, once, or compares it: [`provision`](super::provision). A
    /// board whose region is protected, or is written by other means, keeps this.
    ///
    /// # Errors
    /// Why it did not.
    fn provision(&mut self, _record: &FactoryRecord, _only_check: bool) -> Result<(), CommandRefusal> {
        Err(CommandRefusal::NotSupported)
    }

    /// A stage begins. For boards that play a defect; the others do nothing.
    fn enter(&mut self, _stage: Stage) {}
}
