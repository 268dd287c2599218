//! Queue from the interrupt that reads the sensors to the main loop, lock-free, with counters of lost samples.

use crate::Sample;
use core::sync::atomic::{AtomicU32, Ordering};
use heapless::spsc::{Consumer, Producer, Queue};

/// Size of the queue, samples that can wait and one: 150 ms at 200 Hz, five times the longest piece of work ever
/// measured.
pub const QUEUE: usize = 32;

/// Queue from the interrupt to the loop.
pub type SampleQueue = Queue<Acquired, QUEUE>;
/// The loop's end of the queue.
pub type SampleConsumer<'a> = Consumer<'a, Acquired>;

/// Sample with its number since the start. A number that is left out is a sample that was lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acquired {
    /// Number since the start.
    pub sequence: u32,
    /// Time at which the sample was read, microseconds, low half: that of a polled part is up to a period older.
    pub read_us: u32,
    /// Sample as the adapters gave it.
    pub sample: Sample,
}

/// Counters of the interrupt; only it writes them. They wrap.
#[derive(Debug, Default)]
pub struct AcquisitionCounts {
    acquired: AtomicU32,
    queue_full: AtomicU32,
    missed_ticks: AtomicU32,
    served: AtomicU32,
    faults: AtomicU32,
}

impl AcquisitionCounts {
    /// Creates counters at zero.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            acquired: AtomicU32::new(0),
            queue_full: AtomicU32::new(0),
            missed_ticks: AtomicU32::new(0),
            served: AtomicU32::new(0),
            faults: AtomicU32::new(0),
        }
    }

    /// Samples that were read.
    #[must_use]
    pub fn acquired(&self) -> u32 {
        self.acquired.load(Ordering::Relaxed)
    }

    /// Samples that were read and lost, because the queue had no room.
    #[must_use]
    pub fn queue_full(&self) -> u32 {
        self.queue_full.load(Ordering::Relaxed)
    }

    /// Ticks of the sample clock at which nothing was read, because the reading before had not ended.
    #[must_use]
    pub fn missed_ticks(&self) -> u32 {
        self.missed_ticks.load(Ordering::Relaxed)
    }

    /// Ticks that were served, whether or not the sensors gave a sample.
    #[must_use]
    pub fn served(&self) -> u32 {
        self.served.load(Ordering::Relaxed)
    }

    /// Readings that failed; their samples came later or not at all.
    #[must_use]
    pub fn faults(&self) -> u32 {
        self.faults.load(Ordering::Relaxed)
    }
}

/// Interrupt's side of the queue.
pub struct Acquisition<'a> {
    producer: Producer<'a, Acquired>,
    counts: &'a AcquisitionCounts,
    sequence: u32,
}

impl<'a> Acquisition<'a> {
    /// Creates the interrupt's side, which is to be the only writer of `counts`.
    #[must_use]
    pub const fn new(producer: Producer<'a, Acquired>, counts: &'a AcquisitionCounts) -> Self {
        Self { producer, counts, sequence: 0 }
    }

    /// Hands a sample to the loop. `read_us`: the time at which it was read; its attitude's delay counts from there.
    pub fn put(&mut self, sample: Sample, read_us: u64) {
        if self.producer.enqueue(Acquired { sequence: self.sequence, read_us: read_us as u32, sample }).is_err() {
            add(&self.counts.queue_full, 1);
        }
        self.sequence = self.sequence.wrapping_add(1);
        add(&self.counts.acquired, 1);
    }

    /// Counts a tick that is served, and `missed` ticks before it that were not.
    pub fn served(&mut self, missed: u32) {
        add(&self.counts.missed_ticks, missed);
        add(&self.counts.served, 1);
    }

    /// Counts a reading that failed.
    pub fn fault(&mut self) {
        add(&self.counts.faults, 1);
    }
}

/// Adds by a load and a store: nobody else writes, and the interrupt does not preempt itself.
fn add(counter: &AtomicU32, more: u32) {
    counter.store(counter.load(Ordering::Relaxed).wrapping_add(more), Ordering::Relaxed);
}
