//! From the interrupt that reads the sensors to the loop that flies: a lock-free queue, and a count of what did not
//! get through.

use core::sync::atomic::{AtomicU32, Ordering};
use heapless::spsc::{Consumer, Producer, Queue};
use meerkat_mwd::Sample;

/// Samples that can wait, and one: 150 ms at 200 Hz, five times the longest piece of work that was ever measured.
pub const QUEUE: usize = 32;

pub type SampleQueue = Queue<Acquired, QUEUE>;
pub type SampleConsumer = Consumer<'static, Acquired>;

/// A sample and its number since the start. A number that is left out is a sample that was lost.
#[derive(Clone, Copy)]
pub struct Acquired {
    pub sequence: u32,
    pub sample: Sample,
}

/// Counters of the interrupt; only it writes them. Full counters go round.
pub struct AcquisitionCounts {
    acquired: AtomicU32,
    queue_full: AtomicU32,
    missed_ticks: AtomicU32,
    served: AtomicU32,
    faults: AtomicU32,
}

/// Counters of the only acquisition.
pub static COUNTS: AcquisitionCounts = AcquisitionCounts {
    acquired: AtomicU32::new(0),
    queue_full: AtomicU32::new(0),
    missed_ticks: AtomicU32::new(0),
    served: AtomicU32::new(0),
    faults: AtomicU32::new(0),
};

impl AcquisitionCounts {
    /// Samples that were read.
    pub fn acquired(&self) -> u32 {
        self.acquired.load(Ordering::Relaxed)
    }

    /// Samples that were read and found no room.
    pub fn queue_full(&self) -> u32 {
        self.queue_full.load(Ordering::Relaxed)
    }

    /// Ticks of the sample clock at which nothing was read, because the reading before had not ended.
    pub fn missed_ticks(&self) -> u32 {
        self.missed_ticks.load(Ordering::Relaxed)
    }

    /// Ticks that were served, whether or not the sensors gave a sample.
    pub fn served(&self) -> u32 {
        self.served.load(Ordering::Relaxed)
    }

    /// Readings that failed, and what they were to give came later or not at all.
    pub fn faults(&self) -> u32 {
        self.faults.load(Ordering::Relaxed)
    }
}

/// The interrupt's side.
pub struct Acquisition {
    producer: Producer<'static, Acquired>,
    sequence: u32,
}

impl Acquisition {
    pub const fn new(producer: Producer<'static, Acquired>) -> Self {
        Self { producer, sequence: 0 }
    }

    /// Hands a sample to the loop.
    pub fn put(&mut self, sample: Sample) {
        if self.producer.enqueue(Acquired { sequence: self.sequence, sample }).is_err() {
            add(&COUNTS.queue_full, 1);
        }
        self.sequence = self.sequence.wrapping_add(1);
        add(&COUNTS.acquired, 1);
    }

    /// A tick is served; `missed` went by without.
    pub fn served(&mut self, missed: u32) {
        add(&COUNTS.missed_ticks, missed);
        add(&COUNTS.served, 1);
    }

    /// Counts a reading that failed.
    #[cfg(feature = "spi-sensors")]
    pub fn fault(&mut self) {
        add(&COUNTS.faults, 1);
    }
}

/// A load and a store: nobody else writes, and the interrupt does not preempt itself.
fn add(counter: &AtomicU32, more: u32) {
    counter.store(counter.load(Ordering::Relaxed).wrapping_add(more), Ordering::Relaxed);
}
